"""End the screen within two seconds of a signal, whatever is running; with one line after a failure."""

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
from types import FrameType

from rich.console import RenderableType
from textual.app import App
from textual.worker import WorkerFailed

from orbitdb.cli.interrupts import SIGNALLED, TERMINATING, Terminated
from orbitdb.errors import StoreError, WorkError

_SECONDS_TO_PUT_AWAY = 1.0
_MOST_AT_ONCE = 64
"""Number of threads, more than held keys can leave behind."""

_PATIENCE = 1.8
"""Seconds after which the process ends even if the screen is not closed."""


class LooseThreads(ThreadPoolExecutor):
    """Threads that the end of the screen does not wait for; most of them only read."""

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Begin nothing more, and wait for nothing."""
        super().shutdown(wait=False, cancel_futures=True)


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


class OrderlyApp(App[None]):
    """An application that leaves in good order, whatever ends it.

    While it is leaving, what still works is to stop. A failure is what ended the screen before its time.
    """

    def __init__(self) -> None:
        super().__init__()
        self._in_hand: list[threading.Thread] = []
        self.leaving = False
        self.failure: BaseException | None = None

    def on_load(self) -> None:
        """Begin no thread that the end of the process would wait for."""
        asyncio.get_running_loop().set_default_executor(LooseThreads(_MOST_AT_ONCE))

    def on_mount(self) -> None:
        """Restore the terminal, too, when a signal says to end."""
        gc.freeze()  # to go through all that stands by now keeps every key waiting for long
        if threading.current_thread() is threading.main_thread():
            listen_to_signals(self._end)

    def _end(self, number: int) -> None:
        if not self.is_web:  # the server gets the signal as well, and says so
            self.failure = KeyboardInterrupt() if number == signal.SIGINT else Terminated(number)
        self.leave()

    def leave(self) -> None:
        """Leave, and let what still works stop."""
        self.leaving = True
        self.exit()

    def take_in_hand(self) -> None:
        """Let the process not end before this thread, which has something to put away."""
        self._in_hand.append(threading.current_thread())

    def close(self) -> None:
        """Wait for what is in hand once the screen has gone, for a moment only if a signal said to end.

        Raise whatever ended the screen before its time.
        """
        told = isinstance(self.failure, Terminated | KeyboardInterrupt)
        for thread in self._in_hand:
            thread.join(_SECONDS_TO_PUT_AWAY if told else None)
        if self.failure is not None:
            raise self.failure if told or isinstance(self.failure, StoreError) else written_down(self.failure)

    def _handle_exception(self, error: Exception) -> None:
        """Leave in good order if something fails; the command says what."""
        self.failure = self.failure or error
        if isinstance(error, StoreError):
            self._close_messages_no_wait()
        else:
            super()._handle_exception(error)

    def _fatal_error(self) -> None:
        """Leave, without a traceback on the terminal."""
        self._close_messages_no_wait()

    def panic(self, *renderables: RenderableType) -> None:
        """Leave when keys can no longer be read: the terminal is gone."""
        self._end(TERMINATING[-1])


def written_down(error: BaseException) -> WorkError:
    """Write the traceback of an error that nobody has foreseen to a file, and say where that is."""
    if isinstance(error, WorkerFailed):
        error = error.error
    number, path = tempfile.mkstemp("-traceback.txt", "orbitdb-browse-")
    with os.fdopen(number, "w", encoding="utf-8") as file:
        traceback.print_exception(error, file=file)
    what = f"{type(error).__name__}: {error}".partition("\n")[0]
    return WorkError(
        f"the screen failed ({what}), its traceback is in {path}; nothing that was stored is lost"
    )
