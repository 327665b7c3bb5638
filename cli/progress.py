"""The progress line on stderr, shown only on a terminal.

Rich measures the rate and draws the bar. A separate thread writes the line, so that it stays alive during
long steps. The cursor stays visible at the beginning of the line. Therefore the terminal needs no restoring,
however a command ends, and keys echoed by the terminal are erased together with the line, even if it was
wrapped.
"""

import os
import signal
import stat
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext, suppress
from datetime import timedelta
from typing import TYPE_CHECKING, TextIO

from orbitdb.cli.interrupts import go_on
from orbitdb.plaintext import printable
from orbitdb.progress import Tell

if TYPE_CHECKING:
    from rich.progress import Progress, Task

PATIENCE = 0.5
"""Seconds until the line appears; shorter work shows none and does not import Rich."""

BETWEEN_FRAMES = 0.2
_ERASE = "\r\x1b[J"
_MEMORY = 300.0
"""Seconds over which the rate is measured, because a single step can take minutes."""
_TELLING, _EXPECTED = 0.01, 0.1
"""Fraction of the work after which the remaining time follows from the rate, without and with an earlier
estimate. A fill begins with short periods, whose rate would suggest hours."""
_BAR = 8
"""Minimum width of the bar in columns; facts are left out to make room for it."""


@contextmanager
def progress(text: str, to_stdout: bool = False, expected: float | None = None) -> Iterator[Tell]:
    """Show the progress of long work on a terminal while the context lasts; yield a function that reports it.

    A call of this function raises if the work is to end (`go_on`). `text` is shown until the first call, and
    `expected`, the total time in seconds, gives the remaining time until enough work is done to measure its
    rate. No line is shown while rows go to stdout (`to_stdout`), if stdout is a terminal or a pipe.
    """
    global _on_screen
    watched = sys.stderr.isatty() and os.environ.get("TERM", "dumb") != "dumb"  # it must erase lines
    if not watched or (to_stdout and _seen(sys.stdout)):
        yield lambda done, total, text: go_on()
        return
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
    """The progress line of a terminal, and the report that it shows."""

    def __init__(self, terminal: TextIO, text: str, expected: float | None) -> None:
        self._terminal, self._expected = terminal, expected
        self._told = 0.0, 0.0, text
        self._began = time.monotonic()
        self._drawn = False
        self._mine = threading.RLock()
        self.over = threading.Event()

    def tell(self, done: float, total: float, text: str) -> None:
        """Accept a report, which the next frame shows; raise if the work is to end."""
        go_on()
        self._told = done, total, text

    @contextmanager
    def away(self) -> Iterator[None]:
        """Erase the line, and keep it off the screen while the context lasts."""
        with self._mine:
            if self._drawn:
                self._drawn = False
                self._write(_ERASE)
            yield

    def paint(self) -> None:
        """Draw the line until the work is over."""
        if hasattr(signal, "pthread_sigmask"):  # signals must wake the main thread
            signal.pthread_sigmask(signal.SIG_BLOCK, signal.valid_signals())
        if self.over.wait(PATIENCE):
            return
        bars = bars_on(self._terminal)
        while not self.over.is_set():
            drawn = frame(bars, *self._told, time.monotonic() - self._began, self._expected)
            with self._mine:
                if not self.over.is_set() and _in_foreground(self._terminal):
                    self._drawn = True
                    self._write(f"{_ERASE}{drawn}\r")
            self.over.wait(BETWEEN_FRAMES)

    def _write(self, text: str) -> None:
        with suppress(OSError):  # the terminal may have been closed
            self._terminal.write(text)
            self._terminal.flush()


_on_screen: _Line | None = None


def bars_on(terminal: TextIO) -> "Progress":
    """Return the progress bars of Rich that `frame` draws."""
    from rich.console import Console
    from rich.progress import BarColumn, Progress

    console = Console(file=terminal, markup=False, emoji=False, highlight=False)
    columns = "{task.description}", BarColumn(), "{task.fields[facts]}"
    return Progress(*columns, console=console, auto_refresh=False, speed_estimate_period=_MEMORY)


def frame(
    bars: "Progress", done: float, total: float, text: str, elapsed: float, expected: float | None = None
) -> str:
    """Return the line that shows a report, fitted to the width of the terminal.

    ``elapsed`` is the time since the work began, and ``expected`` the estimated total time, both in seconds.
    If the line is too long, the least important facts are left out.
    """
    if not bars.tasks or done < bars.tasks[0].completed or total != (bars.tasks[0].total or 0):
        for known in bars.task_ids:  # another stage of the work, with another rate
            bars.remove_task(known)
        bars.add_task("", total=total or None)
    (task,) = bars.tasks
    bars.update(task.id, completed=done)
    facts = _facts(task, expected) if total else [_clock(elapsed)]
    room, text = bars.console.width - 1, printable(text)
    while len(facts) > 1 and len("  ".join([text, *facts])) + _BAR > room:
        facts.pop()
    shown = "  ".join(facts)
    bars.update(task.id, description=text[: max(0, room - len(shown) - 3)], facts=shown)
    with bars.console.capture() as drawn:
        bars.console.print(bars.get_renderable(), width=max(1, room), end="")
    return drawn.get().rstrip("\n")


def _facts(task: "Task", expected: float | None) -> list[str]:
    """Return facts about work with a known total, the most important first."""
    share = task.percentage / 100
    left = task.time_remaining if share >= _TELLING and not task.finished else None
    if expected is not None and share < _EXPECTED:
        left = expected * (1 - share)
    facts = [f"{int(task.percentage):3d}%", *([] if left is None else [f"{_clock(max(1.0, left))} left"])]
    if task.total is None or task.total <= 1:  # a fraction, not a count
        return facts
    if task.speed:  # only two digits are meaningful
        rate = f"{task.speed:.2g}"
        facts.append(f"{rate if task.speed < 10 else f'{float(rate):,.0f}'}/s")
    return [*facts, f"{task.completed:,.0f} of {task.total:,.0f}"]


def _clock(seconds: float) -> str:
    return str(timedelta(seconds=int(seconds)))


def _seen(stream: TextIO) -> bool:
    """Tell whether output to a stream may be visible at once, because it is a terminal or a pipe."""
    if stream.isatty():
        return True
    try:
        return stat.S_ISFIFO(os.fstat(stream.fileno()).st_mode)
    except (OSError, ValueError):  # not a file
        return False


def _in_foreground(terminal: TextIO) -> bool:
    """Tell whether this process is in the foreground: not started with ``&`` or resumed with ``bg``."""
    try:
        return os.tcgetpgrp(terminal.fileno()) == os.getpgrp()
    except (AttributeError, OSError):  # Windows, or a terminal without a controlled process
        return True
