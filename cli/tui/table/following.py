"""Following in *a*: the orbit on screen by keys, and the rows with it, as far as births are stored."""

from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING

from orbitdb.cli.tui.orbit.lives import told
from orbitdb.cli.tui.screens import in_thread
from orbitdb.cli.tui.table.pages import Pages
from orbitdb.orbits.orbit import Orbit

if TYPE_CHECKING:
    from orbitdb.cli.tui.panels import Panels
    from orbitdb.store.reading.lives import Standings

_Found = tuple[Orbit, Pages | None, "Standings | None", list[int]]
"""An orbit, the rows as they are there, their births, and the periods of which none are stored."""

_ORBIT = "orbit"
_SECONDS_UNTOLD = 0.08
"""How long following may take before the heading says so."""


class Following:
    """The main screen, looked at for another *a* than that of its rows.

    Attributes
    ----------
    away : float or None
        The *a* that words are followed to, if it is not that of the rows.
    """

    def __init__(self, screen: "Panels") -> None:
        self._screen = screen
        self.away: float | None = None
        self._pages: Pages | None = None
        self._standings: Standings | None = None
        self._without: list[int] = []
        self._steps: list[bool] = []
        self._under_way = False

    def step(self, up: bool) -> None:
        """Follow the orbit to a greater or smaller *a*, past its births and deaths."""
        self._steps.append(up)
        self.go_on()

    def take_rows(self, pages: Pages | None) -> None:
        """Take the rows that are to follow; None for none."""
        self._pages, self._standings = pages, None

    def take_orbit(self, orbit: Orbit | None) -> None:
        """Let the rows follow another orbit; steps that were meant for the last one are forgotten."""
        self._steps = []
        if orbit is None or orbit.a == self._screen.selection.a:
            self.come_back()
        else:
            self.away = orbit.a
            self.go_on()

    def come_back(self) -> None:
        """Show the rows as they are stored."""
        self.away = None
        panel = self._screen.rows
        panel.say_standing(None)
        if panel.table.source.a is not None and self._pages is not None:
            panel.show(self._pages, panel.table.cursor)

    def stop(self) -> None:
        """Follow no farther: something went wrong."""
        self._under_way, self._steps = False, []

    def go_on(self) -> None:
        """Follow the orbit by all steps that were asked for meanwhile, unless a worker does so already."""
        orbit, screen = self._screen.orbit, self._screen
        if self._under_way or orbit is None or not (self._steps or self._rows_lag_behind()):
            return
        self._under_way, steps, self._steps = True, tuple(self._steps), []
        screen.set_timer(_SECONDS_UNTOLD, self._say_following)
        pages, standings = self._pages, self._standings
        in_thread(
            screen,
            "follow",
            lambda _: self._follow(orbit, steps, pages, standings),
            partial(self._arrive, orbit),
        )

    def _rows_lag_behind(self) -> bool:
        """Tell whether the rows are those of another *a* than that of the orbit which they follow."""
        source = self._screen.rows.table.source
        return source.whole and self.away not in (None, source.a)

    def _say_following(self) -> None:
        if self._under_way:
            self._screen.rows.say("reading births …" if self._standings is None else "following …")

    def _follow(
        self, orbit: Orbit, steps: Sequence[bool], pages: Pages | None, standings: "Standings | None"
    ) -> _Found:
        """Follow an orbit some steps, and find what the rows are there; the first time read their births."""
        from orbitdb.store.reading.lives import load_standings
        from orbitdb.store.reading.places import periods_without

        rows, without = None, self._without
        followed = self._screen.browser.follow(orbit, steps, self._screen.selection.a)
        if pages is not None:
            if standings is None:
                with pages.catalogue.reading() as connection:
                    standings = load_standings(connection, pages.chosen.ids)
                    without = periods_without(connection, pages.chosen.ids, standings)
            rows = pages.followed(followed.a, standings.at(followed.a))
        return followed, rows, standings, without

    def _arrive(self, begun: Orbit, found: _Found) -> None:
        """Show the orbit and the rows where they are by now, unless others are on screen by now."""
        orbit, rows, standings, without = found
        self._under_way = False
        self._screen.rows.say()
        if rows is not None and rows.pages is self._pages:
            self._standings, self._without = standings, without
        if begun is self._screen.orbit:
            steps = self._steps
            if orbit is not begun:
                self._show(begun, orbit)
            self._steps = steps
            if rows is not None and rows.pages is self._pages and rows.a == self.away:
                self._show_rows(rows)
        self.go_on()

    def _show(self, before: Orbit, orbit: Orbit) -> None:
        self._under_way = True  # its rows come with it
        self._screen.orbit = orbit
        self._under_way = False
        if happened := told(orbit.exists or (), before.a, orbit.a):
            self._screen.notify(happened)

    def _show_rows(self, rows: Pages) -> None:
        """Show the rows as they are elsewhere, or why they stay."""
        from orbitdb.catalogue.gaps import describe_lacking
        from orbitdb.symbols.enumeration import MAX_PERIOD

        panel, lacking = self._screen.rows, describe_lacking([p for p in self._without if p <= MAX_PERIOD])
        assert self._standings is not None
        if lacking and not self._standings.known.any():
            panel.say_standing(f"the rows stay at a = {self._screen.selection.a:g}: {lacking}")
            self.away = None
        else:
            others = [f"{n:,} {words}" for words, n in rows.counts().items() if words != _ORBIT]
            panel.say_standing("; ".join(filter(None, (", ".join(others) or "no other", lacking))))
            panel.table.show(rows, panel.table.cursor)
        panel.say()
