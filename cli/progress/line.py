"""What shows on stderr how far a command is, if somebody watches there.

One line, drawn by a thread of its own, so that it lives through long steps. The cursor stays visible and
at the line's beginning: however a command ends or is stopped, nothing of the terminal has to be restored,
and what the system echoes into the line, or a narrower window makes of it, is erased together with it.
"""

import os
import signal
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext, suppress
from typing import TextIO

from orbitdb.cli.interrupts import go_on
from orbitdb.cli.progress.pace import Pace, frame, in_ascii

PATIENCE = 0.5
"""Seconds until the line appears: shorter work needs none."""

BETWEEN_FRAMES = 0.2
_ERASE = "\r\x1b[J"


class Progress:
    """Takes note of how far the work is, and shows it to nobody."""

    def tell(self, text: str, done: float = 0.0, total: float = 0.0, counted: bool = True) -> None:
        """Take note of how far the work is, as in `Pace`, unless it is to end here (`go_on`)."""
        go_on()


@contextmanager
def progress(text: str, to_stdout: bool = False) -> Iterator[Progress]:
    """Show how far the work is while the context lasts, if it takes long and somebody watches.

    Parameters
    ----------
    text : str
        What is at work, until a step says more.
    to_stdout : bool, optional
        Whether rows go to stdout meanwhile: where these are seen, or go to a pager, no line may stand
        among them.
    """
    global _on_screen
    if not _watched(sys.stderr) or (to_stdout and _seen(sys.stdout)):
        yield Progress()
        return
    _on_screen = line = _Line(sys.stderr, text)
    try:
        with line.shown():
            yield line
    finally:
        _on_screen = None


def aside() -> AbstractContextManager[None]:
    """Keep the line off the screen while something else is written there."""
    return nullcontext() if _on_screen is None else _on_screen.away()


class _Line(Progress):
    """The line, on a terminal."""

    def __init__(self, terminal: TextIO, text: str) -> None:
        self._terminal = terminal
        self._pace = Pace(text)
        self._began = time.monotonic()
        self._drawn = False
        self._mine = threading.RLock()
        self._over = threading.Event()

    def tell(self, text: str, done: float = 0.0, total: float = 0.0, counted: bool = True) -> None:
        """Take note of how far the work is; the next frame shows it."""
        super().tell(text, done, total, counted)
        self._pace.tell(time.monotonic(), text, done, total, counted)

    @contextmanager
    def shown(self) -> Iterator[None]:
        """Show the line while the context lasts, however it ends."""
        painter = threading.Thread(target=self._paint, daemon=True)
        painter.start()
        try:
            yield
        finally:
            self._over.set()
            with self.away():
                pass
            painter.join()

    @contextmanager
    def away(self) -> Iterator[None]:
        """Take the line off the screen, and keep it off while the context lasts."""
        with self._mine:
            if self._drawn:
                self._drawn = False
                self._write(_ERASE)
            yield

    def _paint(self) -> None:
        if hasattr(signal, "pthread_sigmask"):  # signals are for the main thread, which they are to wake
            signal.pthread_sigmask(signal.SIG_BLOCK, signal.valid_signals())
        wait = PATIENCE
        while not self._over.wait(wait):
            wait = BETWEEN_FRAMES
            with self._mine:
                if not self._over.is_set() and _in_foreground(self._terminal):
                    self._draw()

    def _draw(self) -> None:
        now = time.monotonic()
        shown = frame(self._pace, now, now - self._began, _columns(self._terminal) - 1)
        try:
            shown.encode(self._terminal.encoding)
        except UnicodeEncodeError:
            shown = in_ascii(shown)
        self._drawn = True
        self._write(f"{_ERASE}{shown}\r")

    def _write(self, text: str) -> None:
        with suppress(OSError):  # the terminal may have been closed
            self._terminal.write(text)
            self._terminal.flush()


_on_screen: _Line | None = None


def _watched(stream: TextIO) -> bool:
    """Tell whether a stream is a terminal that can erase a line."""
    return stream.isatty() and os.environ.get("TERM", "dumb") != "dumb"


def _seen(stream: TextIO) -> bool:
    """Tell whether what a stream is given may be seen at once: on a terminal, or behind a pipe."""
    import stat

    if stream.isatty():
        return True
    try:
        return stat.S_ISFIFO(os.fstat(stream.fileno()).st_mode)
    except (OSError, ValueError):  # no file at all
        return False


def _in_foreground(terminal: TextIO) -> bool:
    """Tell whether the terminal is this process's to write on: not with ``&``, or behind Ctrl-Z and bg."""
    try:
        return os.tcgetpgrp(terminal.fileno()) == os.getpgrp()
    except (AttributeError, OSError):  # Windows, or a terminal that controls nobody
        return True


def _columns(terminal: TextIO) -> int:
    try:
        return os.get_terminal_size(terminal.fileno()).columns or 80
    except OSError:
        return 80
