"""Follow the current orbit to other values of *a*; the rows follow it where births are stored."""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

from orbitdb.answers.completeness import describe_lacking
from orbitdb.billiard.stadium import MAX_A, MIN_A
from orbitdb.cli.tui.catalogue_file import CatalogueFile
from orbitdb.cli.tui.table.pages import Pages
from orbitdb.cli.tui.table.panel import RowsPanel
from orbitdb.numerals import exact
from orbitdb.orbits.orbit import Orbit
from orbitdb.store.reading.lookup import with_existence
from orbitdb.symbols.enumeration import MAX_PERIOD

_ORBIT = "orbit"
_SECONDS_UNTOLD = 0.08
"""Seconds after which the heading says that the orbit is being followed."""

STEP = 0.02
"""Step in ln a per key press."""
_BESIDE = 1e-9
_SAME = 1e-12
"""A stop beyond a step by less than this fraction of a still ends it, so that steps up and down cancel."""

Lives = Sequence[tuple[float, float | None]]


def next_a(lives: Lives, a: float, up: bool, home: float | None = None) -> float:
    """Return the a that is one step away, or the first stop on the way there.

    The stops are `home` and the values just below and above each birth and death, where one sees the last
    margin of an orbit before it disappears.
    """
    way = 1 if up else -1
    new = min(max(a * math.exp(way * STEP), MIN_A), MAX_A)
    stops = [end * (1 + side * _BESIDE) for life in lives for end in life if end for side in (-1, 1)]
    stops += [] if home is None else [home]
    ahead = (stop for stop in stops if way * (stop - a) > 0 and way * (new - stop) > -_SAME * stop)
    return min(ahead, key=lambda stop: way * stop, default=new)


def told(lives: Lives, before: float, after: float) -> str | None:
    """Return a message about a birth or death between two values of a, or None if there is none."""
    low, high = sorted((before, after))
    for born, dies in lives:
        for end, begins in ((born, True), (dies, False)):
            if end and low < end < high:
                verb = "born" if begins is (after > before) else "gone"
                return f"{verb} at a = {end:.12g}"
    return None


class Following:
    """Follows the shown orbit to an *a* that can differ from `home`, the *a* of the stored rows."""

    def __init__(
        self, file: CatalogueFile, rows: RowsPanel, home: float, show: Callable[[Orbit], object]
    ) -> None:
        self._file, self._rows, self._show = file, rows, show
        self.home = home
        self.away: float | None = None
        self._orbit: Orbit | None = None
        self._steps: list[bool] = []
        self._under_way = False

    @property
    def here(self) -> float:
        """The current a: that of the stored rows, or the one to which the orbit has been followed."""
        return self.home if self.away is None else self.away

    def step(self, up: bool) -> None:
        """Follow the orbit to a larger or smaller *a*, past its births and deaths."""
        self._steps.append(up)
        self.go_on()

    def take_orbit(self, orbit: Orbit | None) -> None:
        """Follow another orbit; drop the steps queued for the previous one."""
        self._orbit, self._steps = orbit, []
        if orbit is None or orbit.a == self.home:
            self.come_back()
        else:
            self.away = orbit.a
            self.go_on()

    def come_back(self) -> None:
        """Return to the a of the stored rows, and show them."""
        self.away = None
        source = self._rows.table.source
        self._rows.note("#standing", None)
        if source.a is not None:
            self._rows.show(source.pages, self._rows.table.cursor)

    def go_on(self) -> None:
        """Follow the orbit through all queued steps, unless a worker is already doing so."""
        orbit, source = self._orbit, self._rows.table.source
        rows = source.pages if source.catalogue is not None else None
        lag = rows is not None and self.away not in (None, source.a)
        if self._under_way or orbit is None or not (self._steps or lag):
            return
        self._under_way, steps, self._steps = True, tuple(self._steps), []
        self._rows.set_timer(_SECONDS_UNTOLD, partial(self._say_following, rows))
        follow, arrive = partial(self._follow, orbit, steps, rows), partial(self._arrive, orbit)
        self._rows.in_thread("follow", lambda _: follow(), arrive, self._fail)

    def _say_following(self, rows: Pages | None) -> None:
        if self._under_way:
            self._rows.say("following …" if "births" in vars(rows or self) else "reading births …")

    def _follow(self, orbit: Orbit, steps: Sequence[bool], rows: Pages | None) -> tuple[Orbit, Pages | None]:
        """Follow an orbit through the given steps in a; return it with the rows at its new a."""
        if steps:
            lives, a = with_existence(orbit).exists, orbit.a
            for up in steps:
                a = next_a(lives or (), a, up, self.home)
            orbit = replace(self._file.find(orbit.code, a), exists=lives)
        return orbit, None if rows is None else rows.followed(orbit.a)

    def _arrive(self, begun: Orbit, found: tuple[Orbit, Pages | None]) -> None:
        """Show the orbit and the rows at the new a, unless others have been chosen meanwhile."""
        (orbit, rows), steps = found, self._steps
        if begun is self._orbit is not orbit:
            self._show(orbit)  # this drops the queued steps
            self._steps = steps
            if happened := told(orbit.exists or (), begun.a, orbit.a):
                self._rows.app.notify(happened)
        self._under_way = False
        self._rows.say()
        if rows is not None and rows.stored is self._rows.table.source.pages and rows.a == self.away:
            self._show_rows(rows)
        self.go_on()

    def _fail(self, reason: str) -> None:
        self._under_way, self._steps = False, []
        self._rows.failed(reason)
        self._rows.say()

    def _show_rows(self, rows: Pages) -> None:
        """Show the rows at another a or, if none of their births is stored, a note that they stay."""
        panel, (standings, without) = self._rows, rows.pages.births
        lacking = describe_lacking([p for p in without if p <= MAX_PERIOD])
        if lacking and not standings.known.any():
            panel.note("#standing", f"the rows stay at a = {exact(self.home)}: {lacking}")
            self.away = None
            panel.leave()
        else:
            others = [f"{n:,} {words}" for words, n in rows.counts().items() if words != _ORBIT]
            panel.note("#standing", "; ".join(filter(None, (", ".join(others) or "no other words", lacking))))
            panel.show(rows, panel.table.cursor)
