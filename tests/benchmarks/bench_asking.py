"""Measure the time and memory of questions to a large catalogue, by commands and in the terminal UI.

Run it as ``python tests/benchmarks/bench_asking.py DATABASE [asking | exports | verify | browse] [OPTIONS]``
with orbitdb installed, on Linux or macOS. Options such as ``--p 13`` are passed to every command. The
processor time is the sum over all processes of a command; the memory is the peak of the largest process. The
UI is driven without a terminal: keys are pressed until a question is answered. The last columns are the
elapsed time and the time of the slowest key.
"""

import asyncio
import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

MAIN = [sys.executable, "-P", "-c", "from orbitdb.cli.main import run; run()"]
MEGABYTE = 1e6 if sys.platform == "darwin" else 1e6 / 1024
"""A megabyte in the unit in which the system reports memory."""

FIRST = ["query", "--json", "--limit", "40"]
ASKING = {
    "in the order of the table": FIRST,
    "after 8 000 000 others": [*FIRST, "--offset", "8000000"],
    "orbits after 3 000 000": [*FIRST, "--offset", "3000000", "--status", "orbit"],
    "--contains, rare": [*FIRST, "--contains", "11111113444444"],
    "--contains, rare, by length": [*FIRST, "--contains", "11111113444444", "--order", "length"],
    "--contains, after 3 000 000": [*FIRST, "--contains", "13", "--offset", "3000000"],
    "--contains, by length": [*FIRST, "--contains", "0123", "--order", "length"],
    "--where element": [*FIRST, "--where", "element = 7"],
    "--where element, by lambda_c": [*FIRST, "--where", "element = 7", "--order", "lambda_c"],
    "--where code like": [*FIRST, "--where", "code like '%31'"],
    "--where of word and class": [
        *FIRST, "--where", "element = 3 and lambda_c < 0.38", "--order", "length desc",
    ],
    "by lambda_c": [*FIRST, "--order", "lambda_c"],
    "by length after 1 000 000": [*FIRST, "--order", "length", "--offset", "1000000"],
    "by code": [*FIRST, "--order", "code"],
    "by status": [*FIRST, "--order", "status"],
    "by element": [*FIRST, "--order", "element desc"],
    "how many contain 13": ["query", "--contains", "13"],
    "how many orbits end with 31": ["query", "--where", "code like '%31'", "--status", "orbit"],
}  # fmt: skip
EXPORTS = {
    "csv": ["export", "all.csv"],
    "jsonl": ["export", "all.jsonl"],
    "json": ["export", "all.json"],
    "parquet": ["export", "all.parquet"],
    "parquet with coordinates": ["export", "orbits.parquet", "--status", "orbit", "--coordinates"],
}
VERIFY = {"one process": ["verify", "--jobs", "1"], "two processes": ["verify", "--jobs", "2"]}
PARTS = {"asking": ASKING, "exports": EXPORTS, "verify": VERIFY}


def measure(command: list[str], folder: str) -> tuple[float, float]:
    """Return the processor time of a command in seconds, and its peak memory in MB."""
    process = subprocess.Popen(
        [*MAIN, *command], cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )
    _, status, used = os.wait4(process.pid, 0)
    assert os.waitstatus_to_exitcode(status) == 0, command
    return used.ru_utime + used.ru_stime, used.ru_maxrss / MEGABYTE


BROWSE: dict[str, tuple[dict[str, Any], str]] = {
    "p falling": ({}, "-p"),
    "length": ({}, "length"),
    "length falling": ({}, "-length"),
    "margin": ({}, "margin"),
    "status": ({}, "status"),
    "symmetry falling": ({}, "-symmetry"),
    "code falling": ({}, "-code"),
    "orbits by length": ({"status": "orbit"}, "length"),
    "reversal self": ({"time_reversal": "self"}, "p"),
    "where lambda_c < 0.4": ({"where": "lambda_c < 0.4"}, "p"),
    "where code like": ({"where": "code like '%1313%'"}, "p"),
    "contains 13, by length": ({"contains": "13"}, "length"),
    "code like and lambda_c": ({"where": "code like '13%' and lambda_c < 0.4"}, "p"),
}


async def browse(path: Path) -> None:
    """Ask the terminal UI the questions one after another; print the processor time and the elapsed time."""
    from textual import events

    from orbitdb.cli.tui.app import BrowseApp
    from orbitdb.cli.tui.paged_table import PagedTable
    from orbitdb.cli.tui.stored import Ordering
    from orbitdb.store.selection import Selection, chosen_by

    app = BrowseApp(path, Selection())
    async with app.run_test(size=(160, 48)) as pilot:
        main: Any = app.screen
        table = main.query_one(PagedTable)
        while not len(table.source):
            await asyncio.sleep(0.005)
        await pilot.pause()  # the first screen must be drawn, or keys are delayed
        for name, (criteria, order) in BROWSE.items():
            begun, worked, before, slowest = time.perf_counter(), time.process_time(), table.source, 0.0
            main.choices.selection = chosen_by(**criteria)
            main.rows.ordering = Ordering(order.strip("-"), "-" in order)
            while table.source is before:
                pressed, cursor, key = time.perf_counter(), table.cursor, "k" if table.cursor else "j"
                app.post_message(events.Key(key, key))
                while table.cursor == cursor and table.source is before:
                    await asyncio.sleep(0.005)
                slowest = max(slowest, 1000 * (time.perf_counter() - pressed))
                await asyncio.sleep(0.05)
            seconds, passed = time.process_time() - worked, time.perf_counter() - begun
            memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / MEGABYTE
            print(f"{name:32} {seconds:7.1f} s {memory:6.0f} MB {passed:7.1f} s {slowest:6.0f} ms")
            await pilot.pause()


def main() -> None:
    database, *rest = sys.argv[1:]
    part, *options = rest or ["asking"]
    if part == "browse":
        asyncio.run(browse(Path(database)))
        return
    for name, command in PARTS[part].items():
        with tempfile.TemporaryDirectory() as folder:
            seconds, memory = measure([*command, *options, "--db", str(Path(database).resolve())], folder)
        print(f"{name:32} {seconds:7.1f} s {memory:6.0f} MB", flush=True)


if __name__ == "__main__":
    main()
