"""The terminal UI at a large catalogue: times to rows, of sorts and filters, of keys meanwhile; memory.

Run it as ``python tests/benchmarks/bench_browse.py CATALOGUE`` with orbitdb and Textual installed. The app is
driven without a terminal. Seconds are as they pass and of the processor, all threads together.
"""

import asyncio
import resource
import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

from textual import events

from orbitdb.cli.tui.app import BrowseApp
from orbitdb.cli.tui.main_screen import MainScreen
from orbitdb.cli.tui.table.paged_table import PagedTable
from orbitdb.cli.tui.table.pages import Ordering, Pages
from orbitdb.orbits.orbit import Status
from orbitdb.store.asking.selection import Selection

_PAUSE = 0.05
_LONGEST = 120.0
_ORBITS = Selection(statuses=(Status.ORBIT,))

STEPS = [
    ("p falling", Selection(), Ordering("p", True)),
    ("length", Selection(), Ordering("length")),
    ("length falling", Selection(), Ordering("length", True)),
    ("lambda_c", Selection(), Ordering("lambda_c")),
    ("margin", Selection(), Ordering("margin")),
    ("status", Selection(), Ordering("status")),
    ("symmetry falling", Selection(), Ordering("symmetry", True)),
    ("code falling", Selection(), Ordering("code", True)),
    ("orbits", _ORBITS, Ordering()),
    ("orbits by length", _ORBITS, Ordering("length")),
    ("reversal self", Selection(time_reversal="self"), Ordering()),
    ("where lambda_c < 0.4", Selection(where="lambda_c < 0.4"), Ordering()),
    ("where class_size < 8", Selection(where="class_size < 8"), Ordering()),
    ("where code like '%1313%'", Selection(where="code like '%1313%'"), Ordering()),
    ("contains 13, by length", Selection(contains="13"), Ordering("length")),
    ("code like and lambda_c", Selection(where="code like '13%' and lambda_c < 0.4"), Ordering()),
]
"""What is asked for one after the other: its name, a subset, and its order."""


async def _measure(path: Path, steps: list[tuple[str, Selection, Ordering]]) -> None:
    begun, worked = time.perf_counter(), time.process_time()

    def tell(name: str, keys: list[float], rows: int) -> None:
        nonlocal begun, worked
        now, work = time.perf_counter() - begun, time.process_time() - worked
        slow = sorted(keys)
        median, worst = (1000 * slow[len(slow) // 2], 1000 * slow[-1]) if slow else (0.0, 0.0)
        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
        print(f"{name:28}{rows:>12,}{now:8.2f}{work:8.2f}{median:8.0f}{worst:8.0f}{peak:7.0f}", flush=True)

    app = BrowseApp(path, Selection())
    async with app.run_test(size=(160, 48)) as pilot:
        main, table = app.screen, app.screen.query_one(PagedTable)
        assert isinstance(main, MainScreen)
        await _until(lambda: len(table.source) > 0)
        tell("first rows", [], len(table.source))
        await pilot.pause()  # the first picture of the screen keeps keys waiting, too
        for name, selection, ordering in steps:
            begun, worked = time.perf_counter(), time.process_time()
            before = table.source
            main.selection, main.ordering = selection, ordering
            keys = await _keys_until(app, partial(_shows_others, table, before))
            tell(name, keys, len(table.source))
            await pilot.pause()


def _shows_others(table: PagedTable, source: Pages) -> bool:
    return table.source is not source


def _has_moved(table: PagedTable, source: Pages, cursor: int) -> bool:
    return table.cursor != cursor or table.source is not source


async def _until(done: Callable[[], bool]) -> None:
    end = time.monotonic() + _LONGEST
    while not done() and time.monotonic() < end:
        await asyncio.sleep(0.005)


async def _keys_until(app: BrowseApp, done: Callable[[], bool]) -> list[float]:
    """Press keys until something is done; return how long each took until the cursor had moved."""
    table = app.screen.query_one(PagedTable)
    taken: list[float] = []
    end = time.monotonic() + _LONGEST
    while not done() and time.monotonic() < end:
        before, source, key = table.cursor, table.source, "k" if table.cursor else "j"
        begun = time.perf_counter()
        app.post_message(events.Key(key, key))
        await _until(partial(_has_moved, table, source, before))
        taken.append(time.perf_counter() - begun)
        await asyncio.sleep(_PAUSE)
    return taken


def main() -> None:
    print(f"{'':28}{'rows':>12}{'s':>8}{'cpu s':>8}{'key ms':>8}{'worst':>8}{'MB':>7}")
    wanted = sys.argv[2:]
    steps = [step for step in STEPS if not wanted or step[0] in wanted]
    asyncio.run(_measure(Path(sys.argv[1]), steps))


if __name__ == "__main__":
    main()
