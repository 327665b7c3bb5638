"""How the screen ends: within two seconds of a signal, whatever is at work; with one line if it fails."""

import asyncio
import os
import signal
import tempfile
import threading
import traceback
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
from pathlib import Path
from types import FrameType
from typing import Any

from textual.worker import WorkerFailed

from orbitdb.cli.interrupts import SIGNALLED, TERMINATING, LooseThread
from orbitdb.errors import WorkError

_PATIENCE = 1.8
"""Seconds behind which the process ends whether or not the screen has been closed."""


class LooseThreads(ThreadPoolExecutor):
    """Threads that the end of the process does not wait for: most of them only read, for nobody then."""

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Begin work in a thread of its own."""
        future: Future[Any] = Future()

        def run() -> None:
            if future.set_running_or_notify_cancel():
                try:
                    future.set_result(fn(*args, **kwargs))
                except BaseException as error:
                    future.set_exception(error)

        LooseThread(target=run).start()
        return future

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Wait for nothing."""


def listen_to_signals(end: Callable[[int], None]) -> None:
    """Call a function in the event loop that runs when a signal says to end.

    The loop may hear nothing: writing to a terminal that is gone, or stopped, it waits for ever. Then the
    process ends without it.
    """
    loop = asyncio.get_running_loop()

    def told(number: int, frame: FrameType | None) -> None:
        signal.signal(number, signal.SIG_IGN)
        last = threading.Timer(_PATIENCE, os._exit, [SIGNALLED + number])
        last.daemon = True
        last.start()
        with suppress(RuntimeError):  # the loop has come to its end
            loop.call_soon_threadsafe(end, number)

    for number in (signal.SIGINT, *TERMINATING):
        signal.signal(number, told)


def written_down(error: BaseException, folder: Path) -> WorkError:
    """Write the traceback of an error that nobody has foreseen to a file, and say where that is."""
    if isinstance(error, WorkerFailed):
        error = error.error
    text = "".join(traceback.format_exception(error))
    path = folder / "browse-traceback.txt"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    except OSError:
        number, name = tempfile.mkstemp("-traceback.txt", "orbitdb-browse-")
        path = Path(name)
        with os.fdopen(number, "w", encoding="utf-8") as file:
            file.write(text)
    what = f"{type(error).__name__}: {error}".partition("\n")[0]
    return WorkError(
        f"the screen failed ({what}), its traceback is in {path}; nothing that was stored is lost"
    )
