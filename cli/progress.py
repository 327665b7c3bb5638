"""What shows on stderr how far a command is, if somebody watches there.

One line, drawn by a thread of its own, so that it lives through long steps. The cursor stays visible and
at the line's beginning: however a command ends or is stopped, nothing of the terminal has to be restored,
and what the system echoes into the line, or a narrower window makes of it, is erased together with it.
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
"""Seconds until the line appears: shorter work needs none."""

BETWEEN_FRAMES = 0.2
_ERASE = "\r\x1b[J"

_MEMORY = 20.0
"""Seconds over which the rate is taken, if there are a few steps in them."""

_STEPS = 3
_TELLING, _LONG = 0.01, 10.0
"""Which part of the work, or how many seconds of it, tell how long all of it takes: a fill begins with small
periods, which would let it take hours."""
_EXPECTED = 0.1
"""Which part of the work tells more than an estimate that was made before."""
_NARROWEST, _WIDEST = 8, 40
"""Columns of the bar, which has a third of the line."""

_SIGNS, _IN_ASCII = "━╾─", "##-"
"""What the bar is made of: what is done, half a column of it, what is to come."""


class Progress:
    """Takes note of how far the work is, and shows it to nobody."""

    def tell(self, text: str, done: float = 0.0, total: float = 0.0) -> None:
        """Take note of how far the work is, as in `Pace`, unless it is to end here (`go_on`)."""
        go_on()

    def __call__(self, done: float, total: float, text: str) -> None:
        """Take note of how far the work is, as the library tells it (`orbitdb.progress.Tell`)."""
        self.tell(text, done, total)


@contextmanager
def progress(text: str, to_stdout: bool = False, expected: float | None = None) -> Iterator[Progress]:
    """Show how far the work is while the context lasts, if it takes long and somebody watches.

    The text stands there until a step says more. The bar keeps to the seconds that the work is expected to
    take until enough of it is done to tell. Where rows that go to stdout meanwhile are seen, or go to a
    pager, no line may stand among them.
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
    """Keep the line off the screen while something else is written there."""
    return nullcontext() if _on_screen is None else _on_screen.away()


class Pace:
    """How much of a piece of work is done, of a total that is 0 if nobody knows, and how fast it has been."""

    def __init__(self, text: str, expected: float | None = None) -> None:
        self.text, self.done, self.total, self.expected = text, 0.0, 0.0, expected
        self._marks: deque[tuple[float, float]] = deque()

    def tell(self, now: float, text: str, done: float = 0.0, total: float = 0.0) -> None:
        """Take note of how far the work is at a moment; a new total is new work."""
        if total != self.total or done < self.done:
            self._marks.clear()
        self._marks.append((now, done))
        while len(self._marks) > _STEPS and self._marks[1][0] < now - _MEMORY:
            self._marks.popleft()
        self.text, self.done, self.total = text, done, total

    @property
    def share(self) -> float:
        """The part that is done, of a known total."""
        return min(max(self.done / self.total, 0.0), 1.0)

    def rate(self) -> float:
        """Return what is done in a second; 0 if nobody knows yet."""
        marks = tuple(self._marks)
        passed = marks[-1][0] - marks[0][0] if marks else 0.0
        return (marks[-1][1] - marks[0][1]) / passed if passed > 0 else 0.0

    def left(self, now: float) -> float | None:
        """Return the seconds that are left; None if nobody knows yet."""
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
    """Return the line that says how far the work is, in so many columns.

    ``now`` is the moment, ``elapsed`` the time since the work was begun, in seconds. Where the line is too
    long, what matters least goes.
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
    """Return what there is to say of work whose total is known, what matters most first."""
    left, rate = pace.left(now), pace.rate()
    facts = [f"{math.floor(100 * pace.share):3d}%"]
    if left is not None:
        facts.append(f"{clock(left)} left".rjust(len("12:34 left")))
    if pace.total <= 1:  # a share, not a number of things
        return facts
    if rate > 0:  # two digits of it are all that can be known
        facts.append(f"{rate:.2g}/s" if rate < 10 else f"{float(f'{rate:.2g}'):,.0f}/s")
    return [*facts, f"{pace.done:,.0f} of {pace.total:,.0f}"]


def clock(seconds: float) -> str:
    """Write a time as minutes and seconds, with hours if there are any."""
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
        """Take note of how far the work is; the next frame shows it."""
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
    """Tell whether what a stream is given may be seen at once: on a terminal, or behind a pipe."""
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
