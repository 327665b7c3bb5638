"""Progress of long computations: the reports, and the line that shows them in a terminal or a notebook.

A separate thread writes the line, so that it stays alive during long steps. The cursor stays visible at the
beginning of the line. Therefore the terminal needs no restoring, however a command ends, and keys echoed by
the terminal are erased together with the line, even if it was wrapped.
"""

import os
import shutil
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext, suppress
from datetime import timedelta
from typing import TextIO, TypeAlias

from orbitdb.text import printable

Tell: TypeAlias = Callable[[float, float, str], object]
"""Called with the amount done, the total (0 if unknown), and a text."""

PATIENCE = 0.5
"""Seconds until the line appears; shorter work shows none."""

BETWEEN_FRAMES = 0.2
_ERASE = "\r\x1b[J"
_MEASURED, _EXPECTED = 0.01, 0.1
"""Fraction of the work after which the remaining time follows from the rate, without and with an earlier
estimate. A fill begins with short periods, whose rate would suggest hours."""
_BAR, _LONGEST_BAR = 8, 40
"""Columns of the bar; facts are left out to make room for it."""
_NOTEBOOK = 79
"""Columns of the line in a notebook."""


def nobody(done: float, total: float, text: str) -> None:
    """Ignore a progress report."""


@contextmanager
def telling(progress: Tell | None, text: str) -> Iterator[Tell]:
    """Yield the function that receives progress reports: the given one, a line in a notebook, or `nobody`."""
    if progress is not None or not _in_notebook():
        yield progress or nobody
    else:
        with shown(text) as tell:
            yield tell


def _in_notebook() -> bool:
    ipython = sys.modules.get("IPython")
    return ipython is not None and type(ipython.get_ipython()).__name__ == "ZMQInteractiveShell"


@contextmanager
def shown(text: str, expected: float | None = None) -> Iterator[Tell]:
    """Show the progress of long work on stderr while the context lasts; yield a function that reports it.

    `text` is shown until the first report, and `expected`, the total time in seconds, gives the remaining
    time until enough work is done to measure its rate.
    """
    global _on_screen
    _on_screen = line = _Line(sys.stderr, text, expected)
    painter = threading.Thread(target=line.paint, daemon=True)
    painter.start()
    try:
        yield line.tell
    finally:
        line.over.set()
        with line.away():
            pass
        painter.join()
        _on_screen = None


def aside() -> AbstractContextManager[None]:
    """Hide the progress line while something else is written."""
    return nullcontext() if _on_screen is None else _on_screen.away()


class _Line:
    """The progress line of a terminal or notebook, and the report that it shows."""

    def __init__(self, terminal: TextIO, text: str, expected: float | None) -> None:
        self._terminal, self._work = terminal, Work(text, expected)
        self._drawn = ""
        self._mine = threading.RLock()
        self.over = threading.Event()

    def tell(self, done: float, total: float, text: str) -> None:
        """Accept a report, which the next frame shows."""
        self._work.report(done, total, text, time.monotonic())

    @contextmanager
    def away(self) -> Iterator[None]:
        """Erase the line, and keep it off the screen while the context lasts."""
        with self._mine:
            if self._drawn:
                self._write(self._erased())
                self._drawn = ""
            yield

    def paint(self) -> None:
        """Draw the line until the work is over."""
        if hasattr(signal, "pthread_sigmask"):  # signals must wake the main thread
            signal.pthread_sigmask(signal.SIG_BLOCK, signal.valid_signals())
        if self.over.wait(PATIENCE):
            return
        while not self.over.is_set():
            width = shutil.get_terminal_size().columns - 1 if self._terminal.isatty() else _NOTEBOOK
            drawn = self._work.line(width, time.monotonic(), self._terminal.encoding)
            with self._mine:
                if not self.over.is_set() and _in_foreground(self._terminal):
                    self._write(f"{self._erased()}{drawn}\r")
                    self._drawn = drawn
            self.over.wait(BETWEEN_FRAMES)

    def _erased(self) -> str:
        return _ERASE if self._terminal.isatty() else f"\r{' ' * len(self._drawn)}\r"

    def _write(self, text: str) -> None:
        with suppress(OSError):  # the terminal may have been closed
            self._terminal.write(text)
            self._terminal.flush()


_on_screen: _Line | None = None


class Work:
    """How far work is, how fast it is, and the line that says so.

    Parameters
    ----------
    text : str
        The text until the first report.
    expected : float, optional
        Estimate of the total time in seconds.
    began : float, optional
        When the work began, on the clock of `time.monotonic`.
    """

    def __init__(self, text: str, expected: float | None = None, began: float | None = None) -> None:
        self._report = 0.0, 0.0, text
        self._expected = expected
        self._began = time.monotonic() if began is None else began
        self._first = self._last = (self._began, 0.0)

    def report(self, done: float, total: float, text: str, now: float) -> None:
        """Note how far the work is; less than before, or another total, begins another stage."""
        before, of, _ = self._report
        if done < before or total != of:
            self._first = now, done
        self._last, self._report = (now, done), (done, total, text)

    def line(self, width: int, now: float, encoding: str = "utf-8") -> str:
        """Return the line of at most `width` columns; if it is too long, the least important facts go."""
        done, total, text = self._report
        facts, text = self._facts(now), printable(text)
        while len(facts) > 1 and len("  ".join([text, *facts])) + _BAR > width:
            facts.pop()
        facts_text = "  ".join(facts)
        text = text[: max(0, width - len(facts_text) - _BAR)]
        room = min(width - len(text) - len(facts_text) - 3, _LONGEST_BAR)
        share = int(room * min(done / total, 1.0)) if total else 0
        bar = ("━" * share + "─" * (room - share)) if total else ""
        try:
            bar.encode(encoding or "ascii")
        except (UnicodeEncodeError, LookupError):
            bar = "=" * share + "-" * (room - share)
        return " ".join(filter(None, [text, bar, facts_text]))[: max(width, 0)]

    def _facts(self, now: float) -> list[str]:
        """Return facts about the work, the most important first."""
        done, total, _ = self._report
        if not total:
            return [_clock(now - self._began)]
        share, left = done / total, None
        (then, before), (latest, _) = self._first, self._last
        rate = (done - before) / (latest - then) if latest > then else 0.0
        if rate and _MEASURED <= share < 1:
            left = (total - done) / rate - (now - latest)
        if self._expected is not None and share < _EXPECTED:
            left = self._expected * (1 - share)
        facts = [f"{int(100 * share):3d}%", *([] if left is None else [f"{_clock(max(1.0, left))} left"])]
        if total <= 1:  # a fraction, not a count
            return facts
        if rate:  # only two digits are meaningful
            digits = f"{rate:.2g}"
            facts.append(f"{digits if rate < 10 else f'{float(digits):,.0f}'}/s")
        return [*facts, f"{done:,.0f} of {total:,.0f}"]


def _clock(seconds: float) -> str:
    return str(timedelta(seconds=int(seconds)))


def _in_foreground(terminal: TextIO) -> bool:
    """Tell whether this process is in the foreground: not started with ``&`` or resumed with ``bg``."""
    try:
        return not terminal.isatty() or os.tcgetpgrp(terminal.fileno()) == os.getpgrp()
    except (AttributeError, OSError):  # Windows, or a terminal without a controlled process
        return True
