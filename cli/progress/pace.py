"""How far a piece of work is, how fast it is, and the line that says so."""

import math
from collections import deque

from orbitdb.plaintext import printable

_MEMORY = 20.0
"""Seconds over which the rate is taken, if there are a few steps in them."""

_STEPS = 3
_TELLING, _LONG = 0.01, 10.0
"""Which part of the work, or how many seconds of it, tell how long all of it takes: a fill begins with small
periods, which would let it take hours."""
_NARROWEST, _WIDEST = 8, 40
"""Columns of the bar, which has a third of the line."""

_DONE, _HALF, _TO_COME = "━╾─"


class Pace:
    """How far work is, and how fast it has been lately.

    Attributes
    ----------
    text : str
        What is at work.
    done, total : float
        How much of it is done; a total of 0 if nobody knows.
    counted : bool
        Whether these are numbers of things, so that their rate tells something.
    """

    def __init__(self, text: str) -> None:
        self.text, self.done, self.total, self.counted = text, 0.0, 0.0, True
        self._marks: deque[tuple[float, float]] = deque()

    def tell(
        self, now: float, text: str, done: float = 0.0, total: float = 0.0, counted: bool = True
    ) -> None:
        """Take note of how far the work is at a moment; a new total is new work."""
        if total != self.total or done < self.done:
            self._marks.clear()
        self._marks.append((now, done))
        while len(self._marks) > _STEPS and self._marks[1][0] < now - _MEMORY:
            self._marks.popleft()
        self.text, self.done, self.total, self.counted = text, done, total, counted

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
        rate, marks = self.rate(), tuple(self._marks)
        if rate <= 0 or self.done >= self.total:
            return None
        (began, at_first), (last, done) = marks[0], marks[-1]
        if done - at_first < _TELLING * self.total and last - began < _LONG:
            return None
        return max(1.0, (self.total - self.done) / rate - (now - marks[-1][0]))


def frame(pace: Pace, now: float, elapsed: float, room: int) -> str:
    """Return the line that says how far the work is; where it is too long, what matters least goes.

    Parameters
    ----------
    pace : Pace
    now : float
        The moment, in seconds.
    elapsed : float
        Since the work was begun, in seconds.
    room : int
        Columns that the line may take.
    """
    text = printable(pace.text)
    facts, shown = [clock(elapsed)], [text]
    if pace.total > 0:
        facts = _facts(pace, now)
        columns = min(_WIDEST, room // 3, room - len("  ".join([text, "", facts[0]])))
        shown += [_bar(pace.share, columns)] if columns >= _NARROWEST else []
    while len(facts) > 1 and len("  ".join([*shown, *facts])) > room:
        facts.pop()
    return "  ".join(part for part in [*shown, *facts] if part)[: max(room, 0)]


def _facts(pace: Pace, now: float) -> list[str]:
    """Return what there is to say of work whose total is known, what matters most first."""
    left, rate = pace.left(now), pace.rate()
    facts = [f"{math.floor(100 * pace.share):3d}%"]
    if left is not None:
        facts.append(f"{clock(left)} left".rjust(len("12:34 left")))
    if pace.counted and rate > 0:  # two digits of it are all that can be known
        facts.append(f"{rate:.2g}/s" if rate < 10 else f"{float(f'{rate:.2g}'):,.0f}/s")
    if pace.counted:
        facts.append(f"{pace.done:,.0f} of {pace.total:,.0f}")
    return facts


def _bar(share: float, columns: int) -> str:
    halves = math.floor(2 * columns * share)
    return (_DONE * (halves // 2) + _HALF * (halves % 2)).ljust(columns, _TO_COME)


def clock(seconds: float) -> str:
    """Write a time as minutes and seconds, with hours if there are any."""
    minutes, rest = divmod(int(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02d}:{rest:02d}" if hours else f"{minutes}:{rest:02d}"


def in_ascii(shown: str) -> str:
    """Return the line for terminals that have no other characters."""
    return shown.translate(str.maketrans(_DONE + _HALF + _TO_COME, "##-"))
