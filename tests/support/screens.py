"""Drive the terminal UI by keys, without a terminal."""

import asyncio
import time
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager, suppress
from pathlib import Path
from typing import Any

import textual.app
import textual.pilot
from textual import events
from textual._context import active_app
from textual.pilot import Pilot
from textual.screen import Screen
from textual.widgets import Input
from textual.worker import WorkerCancelled
from there import there

from orbitdb.cli.advice import remember
from orbitdb.cli.tui.app import BrowseApp
from orbitdb.cli.tui.panels.paged_table import PagedTable
from orbitdb.cli.tui.stored import Row
from orbitdb.selection import Selection


async def _handled(*_: float) -> None:
    """Wait until no message is left in the app.

    Textual waits until its process is idle: that takes 20 ms each time, and a busy machine seems idle.
    """
    app = active_app.get()
    while True:
        await Pilot(app).pause(0)
        if getattr(app, "_resize_event", None) is not None:  # a new size takes effect a moment later
            await asyncio.sleep(0.005)
        elif all(pump._message_queue.empty() for pump in (app, *app._registry) if pump.is_running):
            return


textual.app.wait_for_idle = textual.pilot.wait_for_idle = _handled  # type: ignore[attr-defined, assignment]

SMALL, LARGE, TINY = (80, 24), (160, 48), (60, 20)


@asynccontextmanager
async def browsing(
    path: Path,
    size: tuple[int, int] = SMALL,
    selection: Selection | None = None,
    code: str | None = None,
    notifications: bool = False,
    state: Path | None = None,
) -> AsyncIterator[tuple[Any, Pilot[Any]]]:
    """Run the app without a terminal; yield it with its pilot."""
    remember([])  # advice of an earlier command in this process
    app: Any = BrowseApp(path, selection or Selection(), code, state)
    app.NOTIFICATION_TIMEOUT = 600.0  # a slow machine must still find them
    async with app.run_test(size=size, notifications=notifications) as pilot:
        await settle(pilot)
        yield app, pilot


async def settle(pilot: Pilot[Any]) -> None:
    """Wait for the workers and their messages."""
    await pilot.pause()  # a closing dialog may start a worker, which sends a message
    while pilot.app.workers:
        with suppress(WorkerCancelled):  # another one replaced it
            await pilot.app.workers.wait_for_complete()
        await pilot.pause()


async def press(pilot: Pilot[Any], *keys: str) -> None:
    """Press keys, each after the work of the one before."""
    await settle(pilot)
    for key in keys:
        await pilot.press(key)
        await settle(pilot)


async def write(pilot: Pilot[Any], text: str, *keys: str, field: str = "Input") -> None:
    """Replace the text of a field, then press keys."""
    pilot.app.screen.query_one(field, Input).value = text
    await press(pilot, *keys)


async def ask(pilot: Pilot[Any], key: str, text: str) -> None:
    """Open a dialog by its key, and enter a line."""
    await pilot.press(key)
    await write(pilot, text, "enter")


async def send(app: BrowseApp, key: str, shows: type[Screen[Any]]) -> None:
    """Send a key and wait for a screen; during a fill the process is never idle."""
    app.post_message(events.Key(key, key if len(key) == 1 else None))
    await until(lambda: isinstance(app.screen, shows))


async def until(told: Callable[[], object]) -> None:
    end = time.monotonic() + 120
    while not told():
        assert time.monotonic() < end
        await asyncio.sleep(0.01)


def table_of(app: BrowseApp) -> PagedTable:
    return app.screen_stack[0].query_one(PagedTable)


def row_of(app: BrowseApp) -> Row:
    """Return the row under the cursor."""
    return there(table_of(app).row)


def screen_lines(app: BrowseApp) -> list[str]:
    """Return the lines of the screen."""
    strips = app.screen._compositor.render_strips()
    return ["".join(segment.text for segment in strip) for strip in strips]


def shown(app: BrowseApp) -> str:
    """Return the screen as text."""
    return "\n".join(screen_lines(app))
