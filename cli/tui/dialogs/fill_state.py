"""Computing: what is wanted, what it is going to take, and how far it has come."""

import time
from collections.abc import Generator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import NamedTuple

from orbitdb.catalogue.catalogue import Catalogue
from orbitdb.cli.tui.choices import half_length
from orbitdb.errors import InputError
from orbitdb.numerals import exact
from orbitdb.store.asking.parsing import parse_periods
from orbitdb.symbols.counting import count_admissible
from orbitdb.symbols.enumeration import MAX_PERIOD
from orbitdb.symbols.words import parse, primitive_root


class Wish(NamedTuple):
    """What to fill: periods, or words."""

    a: float
    periods: tuple[int, ...] = ()
    words: tuple[str, ...] = ()


@dataclass(frozen=True)
class FillState:
    """How far a fill has come.

    Attributes
    ----------
    wish : Wish
    state : str
        ``running``, ``stopping``, ``done``, ``stopped`` or ``failed``.
    done, total : int
        Words of all periods, or words chosen.
    p : int
        The period at work.
    began : float
        When, on the monotonic clock.
    message : str
        What went wrong.
    """

    wish: Wish
    state: str = "running"
    done: int = 0
    total: int = 0
    p: int = 0
    began: float = field(default_factory=time.monotonic)
    message: str = ""

    @property
    def runs(self) -> bool:
        """Whether it is at work."""
        return self.state in ("running", "stopping")

    def sentence(self) -> str:
        """Say how far it is."""
        from orbitdb.filling.estimate import duration

        if self.state == "failed":
            return self.message
        if not self.runs:
            return f"{self.state}: {self.done:,} word{'s' * (self.done != 1)}"
        seconds = time.monotonic() - self.began
        rate = self.done / seconds if seconds > 0 else 0.0
        left = f", {duration((self.total - self.done) / rate)} left" if rate else ""
        share = 100 * self.done / self.total if self.total else 0
        return f"{self.state}: p = {self.p}, {share:.0f}%, {rate:,.0f}/s{left}"


def parse_wish(a: str, periods: str, codes: str) -> Wish:
    """Read what to fill.

    Raises
    ------
    InputError
        If a part cannot be read.
    """
    value = half_length(a)
    if codes.strip():
        return Wish(value, words=tuple(primitive_root(parse(code)) for code in codes.split(",")))
    spans = parse_periods(periods)
    if not all(low >= 2 and high <= MAX_PERIOD for low, high in spans):
        raise InputError(f"periods {periods!r}: fill from 2 to {MAX_PERIOD}")
    return Wish(value, periods=tuple(sorted({p for low, high in spans for p in range(low, high + 1)})))


class Cost(NamedTuple):
    """What a wish is going to take; whether to ask before it begins; whether nothing is left to do."""

    sentence: str
    large: bool = False
    nothing: bool = False


def cost_of(path: Path, wish: Wish) -> Cost:
    """Estimate what a wish is going to take.

    Raises
    ------
    StoreError
        If the disk has no room for it, or the catalogue cannot be read.
    """
    from orbitdb.filling.estimate import LARGE, about, check_room, gigabytes, need

    at = f"at a = {exact(wish.a)}"
    if wish.words:
        count = len(wish.words)
        return Cost(f"{count} word{'s' * (count > 1)} to solve {at}")
    coming = need(path, wish.a, wish.periods, jobs=1)
    if not coming.words:
        return Cost(f"these periods are filled {at}: nothing is left to do", nothing=True)
    check_room(path, coming)
    what = f"{coming.words:,} word{'s' * (coming.words != 1)}"
    takes = f"{about(coming.seconds)}, {gigabytes(coming.bytes)}"
    return Cost(f"{what} to come {at}: {takes}", large=coming.words >= LARGE)


def work(path: Path, state: FillState) -> Generator[FillState, None, None]:
    """Fill, and tell how far it is behind every batch that is safely stored."""
    from orbitdb.filling.fill_word import fill_word
    from orbitdb.filling.periods import fill_periods

    Catalogue.create(path)
    wish = state.wish
    if wish.words:
        for count, word in enumerate(wish.words, 1):
            fill_word(path, word, wish.a)
            yield replace(state, done=count, total=len(wish.words), p=len(word))
        return
    counts = {p: count_admissible(p) for p in wish.periods}
    steps = fill_periods(path, wish.a, wish.periods)
    for step in steps:
        before = sum(count for p, count in counts.items() if p < step.p)
        yield replace(state, done=before + step.words, total=sum(counts.values()), p=step.p)
