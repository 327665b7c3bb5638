"""End the screen within two seconds of a signal, whatever is running; report a failure in one line."""

import asyncio
import gc
import os
import signal
import tempfile
import threading
import traceback
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from functools import partial
from types import FrameType

from rich.console import RenderableType
from textual.app import App
from textual.worker import WorkerFailed

from orbitdb.cli.interrupts import SIGNALLED, TERMINATING, Terminated
from orbitdb.errors import StoreError, WorkError

_SECONDS_TO_PUT_AWAY = 1.0
_SECONDS_BETWEEN_LOOKS = 2.0
_MOST_AT_ONCE = 64
"""Maximum number of threads, which is more than held-down keys can occupy."""

_PATIENCE = 1.8
"""Seconds from a signal until the process ends even if the screen has not closed."""


class LooseThreads(ThreadPoolExecutor):
    """A thread pool that the screen does not wait for when it closes; most of the threads only read."""

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Cancel work that has not begun, and do not wait for work that has."""
        super().shutdown(wait=False, cancel_futures=True)


def listen_to_signals(end: Callable[[int], None]) -> None:
    """Call a function in the running event loop when a signal asks the program to end.

    If the terminal is gone or stopped, the loop can block forever in a write. A timer then ends the process.
    """
    loop = asyncio.get_running_loop()

    def told(number: int, frame: FrameType | None) -> None:
        signal.signal(number, signal.SIG_IGN)
        last = threading.Timer(_PATIENCE, os._exit, [SIGNALLED + number])
        last.daemon = True
        last.start()
        with suppress(RuntimeError):  # the loop is already closed
            loop.call_soon_threadsafe(end, number)

    for number in (signal.SIGINT, *TERMINATING):
        signal.signal(number, told)


class OrderlyApp(App[None]):
    """An application that shuts down cleanly, whatever ends it.

    Running work stops once `leaving` is set. `failure` is the exception that ended the screen early, if any.
    """

    def __init__(self) -> None:
        super().__init__()
        self._in_hand: list[threading.Thread] = []
        self.leaving = False
        self.failure: BaseException | None = None

    def on_load(self) -> None:
        """Run work in threads that do not delay the end of the process."""
        asyncio.get_running_loop().set_default_executor(LooseThreads(_MOST_AT_ONCE))

    def on_mount(self) -> None:
        """Handle signals, so that the terminal is restored before one of them ends the program."""
        gc.freeze()  # otherwise garbage collection of everything loaded so far would delay keys
        if threading.current_thread() is threading.main_thread():
            listen_to_signals(self._end)
        if self.is_web:
            self.set_interval(_SECONDS_BETWEEN_LOOKS, partial(self._leave_without, os.getppid()))

    def _leave_without(self, server: int) -> None:
        """Leave if the server was killed, and could end nothing."""
        if os.getppid() != server:
            self.leave()

    def _end(self, number: int) -> None:
        if not self.is_web:  # the server gets the signal too, and reports it
            self.failure = KeyboardInterrupt() if number == signal.SIGINT else Terminated(number)
        self.leave()

    def leave(self) -> None:
        """Close the screen, and tell running work to stop."""
        self.leaving = True
        self.exit()

    def take_in_hand(self) -> None:
        """Make `close` wait for the current thread."""
        self._in_hand.append(threading.current_thread())

    def close(self) -> None:
        """Wait for the threads of `take_in_hand` once the screen has closed, but only briefly after a signal.

        Then raise the exception that ended the screen early, if any; `written_down` replaces unexpected ones.
        """
        told = isinstance(self.failure, Terminated | KeyboardInterrupt)
        for thread in self._in_hand:
            thread.join(_SECONDS_TO_PUT_AWAY if told else None)
        if self.failure is not None:
            raise self.failure if told or isinstance(self.failure, StoreError) else written_down(self.failure)

    def _handle_exception(self, error: Exception) -> None:
        """Close the screen cleanly after a failure, which the command reports."""
        self.failure = self.failure or error
        if isinstance(error, StoreError):
            self._close_messages_no_wait()
        else:
            super()._handle_exception(error)

    def _fatal_error(self) -> None:
        """Close the screen without a traceback on the terminal."""
        self._close_messages_no_wait()

    def panic(self, *renderables: RenderableType) -> None:
        """Close the screen when keys can no longer be read because the terminal is gone."""
        self._end(TERMINATING[-1])


def written_down(error: BaseException) -> WorkError:
    """Write the traceback of an unexpected error to a file, and return an error that names the file."""
    if isinstance(error, WorkerFailed):
        error = error.error
    number, path = tempfile.mkstemp("-traceback.txt", "orbitdb-browse-")
    with os.fdopen(number, "w", encoding="utf-8") as file:
        traceback.print_exception(error, file=file)
    what = f"{type(error).__name__}: {error}".partition("\n")[0]
    return WorkError(f"the screen failed ({what}); the traceback is in {path}; stored data are safe")
