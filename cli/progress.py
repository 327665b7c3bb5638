"""The progress line on stderr, for a terminal.

A thread of its own draws the line, so it stays alive during long steps. The cursor stays visible at the
beginning of the line. However a command ends or is killed, the terminal needs no restoring, and echoed keys
or folded lines are erased with the line.
"""

import math
import os
import signal
import stat
import sys
import threading
import time
from collections import deque
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext, suppress
from typing import TextIO

from orbitdb.cli.interrupts import go_on
from orbitdb.plaintext import printable

PATIENCE = 0.5
"""Seconds until the line appears; shorter work needs none."""

BETWEEN_FRAMES = 0.2
_ERASE = "\r\x1b[J"

_MEMORY = 20.0
"""Seconds over which the rate is measured, if they contain a few steps."""

_STEPS = 3
_TELLING, _LONG = 0.01, 10.0
"""Fraction of the work, or seconds, before the remaining time is estimated: a fill begins with small periods,
whose rate would suggest hours."""
_EXPECTED = 0.1
"""Fraction of the work after which its own rate replaces an earlier estimate."""
_NARROWEST, _WIDEST = 8, 40
"""Limits on the columns of the bar, a third of the line."""

_SIGNS, _IN_ASCII = "━╾─", "##-"
"""Characters of the bar: done, half a column, still to do."""


class Progress:
    """Takes progress reports without showing them."""

    def tell(self, text: str, done: float = 0.0, total: float = 0.0) -> None:
        """Take a report as in `Pace`, unless the work is to end here (`go_on`)."""
        go_on()

    def __call__(self, done: float, total: float, text: str) -> None:
        """Take a report of the library (`orbitdb.progress.Tell`)."""
        self.tell(text, done, total)


@contextmanager
def progress(text: str, to_stdout: bool = False, expected: float | None = None) -> Iterator[Progress]:
    """Show the progress of long work on a terminal while the context lasts.

    The text is shown until a step reports more. The bar follows the expected seconds until enough work is
    done to measure its rate. There is no line if rows go to stdout meanwhile and are visible, or go to a
    pager.
    """
    global _on_screen
    watched = sys.stderr.isatty() and os.environ.get("TERM", "dumb") != "dumb"  # by what can erase a line
    if not watched or (to_stdout and _seen(sys.stdout)):
        yield Progress()
        return
    _on_screen = line = _Line(sys.stderr, text, expected)
    try:
        with line.shown():
            yield line
    finally:
        _on_screen = None


def aside() -> AbstractContextManager[None]:
    """Hide the line while something else is written."""
    return nullcontext() if _on_screen is None else _on_screen.away()


class Pace:
    """The amount of work done, its total (0 if unknown), and its rate."""

    def __init__(self, text: str, expected: float | None = None) -> None:
        self.text, self.done, self.total, self.expected = text, 0.0, 0.0, expected
        self._marks: deque[tuple[float, float]] = deque()

    def tell(self, now: float, text: str, done: float = 0.0, total: float = 0.0) -> None:
        """Take a report at a moment; a new total means new work."""
        if total != self.total or done < self.done:
            self._marks.clear()
        self._marks.append((now, done))
        while len(self._marks) > _STEPS and self._marks[1][0] < now - _MEMORY:
            self._marks.popleft()
        self.text, self.done, self.total = text, done, total

    @property
    def share(self) -> float:
        """The fraction done, of a known total."""
        return min(max(self.done / self.total, 0.0), 1.0)

    def rate(self) -> float:
        """Return the work per second; 0 if not known yet."""
        marks = tuple(self._marks)
        passed = marks[-1][0] - marks[0][0] if marks else 0.0
        return (marks[-1][1] - marks[0][1]) / passed if passed > 0 else 0.0

    def left(self, now: float) -> float | None:
        """Return the remaining seconds; None if not known yet."""
        if self.expected is not None and self.total and self.share < _EXPECTED:
            return max(1.0, self.expected * (1 - self.share))
        rate, marks = self.rate(), tuple(self._marks)
        if rate <= 0 or self.done >= self.total:
            return None
        (began, at_first), (last, done) = marks[0], marks[-1]
        if done - at_first < _TELLING * self.total and last - began < _LONG:
            return None
        return max(1.0, (self.total - self.done) / rate - (now - last))


def frame(pace: Pace, now: float, elapsed: float, room: int, signs: str = _SIGNS) -> str:
    """Return the progress line for a number of columns.

    ``now`` is the moment, ``elapsed`` the time since the start of the work, in seconds. If the line is too
    long, the least important parts go.
    """
    text = printable(pace.text)
    facts, shown = [clock(elapsed)], [text]
    if pace.total > 0:
        facts = _facts(pace, now)
        columns = min(_WIDEST, room // 3, room - len("  ".join([text, "", facts[0]])))
        halves = math.floor(2 * columns * pace.share)
        bar = (signs[0] * (halves // 2) + signs[1] * (halves % 2)).ljust(columns, signs[2])
        shown += [bar] if columns >= _NARROWEST else []
    while len(facts) > 1 and len("  ".join([*shown, *facts])) > room:
        facts.pop()
    return "  ".join(part for part in [*shown, *facts] if part)[: max(room, 0)]


def _facts(pace: Pace, now: float) -> list[str]:
    """Return facts about work with a known total, the most important first."""
    left, rate = pace.left(now), pace.rate()
    facts = [f"{math.floor(100 * pace.share):3d}%"]
    if left is not None:
        facts.append(f"{clock(left)} left".rjust(len("12:34 left")))
    if pace.total <= 1:  # a fraction, not a count
        return facts
    if rate > 0:  # only two digits are meaningful
        facts.append(f"{rate:.2g}/s" if rate < 10 else f"{float(f'{rate:.2g}'):,.0f}/s")
    return [*facts, f"{pace.done:,.0f} of {pace.total:,.0f}"]


def clock(seconds: float) -> str:
    """Write a time as minutes and seconds, and any hours."""
    minutes, rest = divmod(int(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02d}:{rest:02d}" if hours else f"{minutes}:{rest:02d}"


class _Line(Progress):
    """The line, on a terminal."""

    def __init__(self, terminal: TextIO, text: str, expected: float | None = None) -> None:
        self._terminal = terminal
        self._signs = _SIGNS if terminal.encoding.lower().startswith("utf") else _IN_ASCII
        self._pace = Pace(text, expected)
        self._began = time.monotonic()
        self._drawn = False
        self._mine = threading.RLock()
        self._over = threading.Event()

    def tell(self, text: str, done: float = 0.0, total: float = 0.0) -> None:
        """Take a report; the next frame shows it."""
        super().tell(text, done, total)
        self._pace.tell(time.monotonic(), text, done, total)

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
        """Erase the line, and keep it off the screen while the context lasts."""
        with self._mine:
            if self._drawn:
                self._drawn = False
                self._write(_ERASE)
            yield

    def _paint(self) -> None:
        if hasattr(signal, "pthread_sigmask"):  # signals must wake the main thread
            signal.pthread_sigmask(signal.SIG_BLOCK, signal.valid_signals())
        wait = PATIENCE
        while not self._over.wait(wait):
            wait = BETWEEN_FRAMES
            with self._mine:
                if not self._over.is_set() and _in_foreground(self._terminal):
                    now, room = time.monotonic(), _columns(self._terminal) - 1
                    self._drawn = True
                    drawn = frame(self._pace, now, now - self._began, room, self._signs)
                    self._write(f"{_ERASE}{drawn}\r")

    def _write(self, text: str) -> None:
        with suppress(OSError):  # the terminal may have been closed
            self._terminal.write(text)
            self._terminal.flush()


_on_screen: _Line | None = None


def _seen(stream: TextIO) -> bool:
    """Tell whether output to a stream may be visible at once: on a terminal, or through a pipe."""
    if stream.isatty():
        return True
    try:
        return stat.S_ISFIFO(os.fstat(stream.fileno()).st_mode)
    except (OSError, ValueError):  # not a file
        return False


def _in_foreground(terminal: TextIO) -> bool:
    """Tell whether this process is in the foreground: not with ``&``, or after Ctrl-Z and bg."""
    try:
        return os.tcgetpgrp(terminal.fileno()) == os.getpgrp()
    except (AttributeError, OSError):  # Windows, or a terminal without a controlled process
        return True


def _columns(terminal: TextIO) -> int:
    try:
        return os.get_terminal_size(terminal.fileno()).columns or 80
    except OSError:
        return 80
