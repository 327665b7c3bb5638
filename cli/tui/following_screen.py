"""Following in a: the orbit on screen by keys, and the table with it, as far as births are stored."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from textual import work
from textual.message import Message
from textual.widgets import Static

from orbitdb.cli.tui.orbit.lives import told
from orbitdb.cli.tui.orbit_screen import OrbitScreen
from orbitdb.cli.tui.table.paged_table import PagedTable
from orbitdb.cli.tui.table.source import Followed, Pages
from orbitdb.cli.tui.word_screen import WordScreen
from orbitdb.errors import InputError, StoreError
from orbitdb.orbits.orbit import Orbit
from orbitdb.store.asking.selection import Selection

if TYPE_CHECKING:
    from orbitdb.store.reading.lives import Standings

_ORBIT = "orbit"
_SECONDS_UNTOLD = 0.08
"""How long following may take before the heading says so."""


class FollowingScreen(WordScreen):
    """The main screen, looked at for another a than that of its rows."""

    @dataclass
    class Arrived(Message):
        """A worker has followed an orbit, and the rows with it."""

        begun: Orbit
        orbit: Orbit
        rows: Followed | None
        standings: "Standings | None"
        without: list[int]

    def __init__(self, selection: Selection, code: str | None = None) -> None:
        super().__init__(selection, code)
        self._away: float | None = None
        self._pages: Pages | None = None
        self._standings: Standings | None = None
        self._without: list[int] = []
        self._steps: list[bool] = []
        self._under_way = False

    @property
    def here(self) -> float:
        """The a at which words are shown: that of the rows, or the one they are followed to."""
        return self.selection.a if self._away is None else self._away

    @property
    def rows_title(self) -> str:
        """What the rows are, and how many of them are orbits at the a they are followed to."""
        source = self.query_one(PagedTable).source
        if not isinstance(source, Followed):
            return super().rows_title
        return f"{source.counts().get(_ORBIT, 0):,} orbits at a = {source.a:.9g}"

    def action_follow(self, up: bool) -> None:
        """Follow the orbit to a greater or smaller a, past its births and deaths."""
        self.catch_up()
        if self.orbit is not None:
            self._steps.append(up)
            self._go_on()

    def action_back(self) -> None:
        """Show the row under the cursor as it is stored."""
        self._come_back()
        super().action_back()

    def look_up(self, word: str) -> Orbit:
        """Return the orbit of a word where words are shown."""
        stored = self.browser.find(word, self.selection.a)
        if self._away is None:
            return stored
        return self.browser.find_at(word, self._away, stored.exists)

    def watch_orbit(self, orbit: Orbit | None) -> None:
        """Let the rows follow the orbit; steps that were meant for another one are forgotten."""
        super().watch_orbit(orbit)
        self._steps = []
        if not self.is_mounted:
            return
        if orbit is None or orbit.a == self.selection.a:
            self._come_back()
            return
        self._away = orbit.a
        self._go_on()

    def show_rows(self, rows: Pages, cursor: int) -> None:
        """Show the rows that have been read, as they are where words are shown."""
        self._pages, self._standings = rows, None
        super().show_rows(rows, cursor)
        self._go_on()

    def _leave_stadium(self) -> None:
        self._pages = self._standings = None
        super()._leave_stadium()

    def _come_back(self) -> None:
        """Show the rows as they are stored."""
        self._away = None
        self.query_one("#standing").display = False
        table = self.query_one(PagedTable)
        if isinstance(table.source, Followed) and self._pages is not None:
            super().show_rows(self._pages, table.cursor)

    def _go_on(self) -> None:
        """Follow the orbit by all steps that were asked for meanwhile, unless a worker does so already."""
        orbit, pages = self.orbit, self._pages
        if self._under_way or orbit is None or not (self._steps or self._rows_lag_behind()):
            return
        self._under_way = True
        self.set_timer(_SECONDS_UNTOLD, self._say_following)
        self._follow(orbit, tuple(self._steps), pages, self._standings)
        self._steps = []

    def _rows_lag_behind(self) -> bool:
        """Tell whether the rows are those of another a than that of the orbit which they follow."""
        source = self.query_one(PagedTable).source
        return source.whole and self._away not in (None, getattr(source, "a", None))

    def _say_following(self) -> None:
        if self._under_way:
            self._say_reading("reading births …" if self._standings is None else "following …")

    @work(thread=True, group="follow", description="follow")  # else Textual writes out all rows for its log
    def _follow(
        self, orbit: Orbit, steps: Sequence[bool], pages: Pages | None, standings: "Standings | None"
    ) -> None:
        """Follow an orbit some steps, and find what the rows are there; the first time read their births."""
        from orbitdb.store.reading.finding import periods_without
        from orbitdb.store.reading.lives import load_standings

        rows, without = None, self._without
        try:
            followed = self.browser.follow(orbit, steps, self.selection.a)
            if pages is not None and standings is None:
                with pages.catalogue.reading() as connection:
                    standings = load_standings(connection, pages.chosen.ids)
                    without = periods_without(connection, pages.chosen.ids, standings)
            if pages is not None and standings is not None:
                rows = Followed(pages, followed.a, standings.at(followed.a))
        except (InputError, StoreError) as error:
            self.post_message(self.Failed(str(error)))
            return
        self.post_message(self.Arrived(orbit, followed, rows, standings, without))

    def on_orbit_screen_failed(self, message: OrbitScreen.Failed) -> None:
        """Follow no farther; Textual calls the handlers of the other classes, too."""
        self._under_way, self._steps = False, []

    def on_following_screen_arrived(self, message: Arrived) -> None:
        """Show the orbit and the rows where they are by now, unless others are on screen by now."""
        self._under_way = False
        self._say_reading("")
        rows = message.rows
        if rows is not None and rows.pages is self._pages:
            self._standings, self._without = message.standings, message.without
        if message.begun is self.orbit:
            steps = self._steps
            if message.orbit is not message.begun:
                self._show_followed(message.begun, message.orbit)
            self._steps = steps
            if rows is not None and rows.pages is self._pages and rows.a == self._away:
                self._show_standing(rows)
        self._go_on()

    def _show_followed(self, before: Orbit, orbit: Orbit) -> None:
        self._under_way = True  # its rows come with it
        self.orbit = orbit
        self._under_way = False
        if happened := told(orbit.exists or (), before.a, orbit.a):
            self.notify(happened)

    def _show_standing(self, rows: Followed) -> None:
        """Show the rows as they are elsewhere, or why they stay."""
        note, table = self.query_one("#standing", Static), self.query_one(PagedTable)
        note.display = True
        lacking = _lacking(self._without)
        assert self._standings is not None
        if lacking and not self._standings.known.any():
            note.update(f"the rows stay at a = {self.selection.a:g}: {lacking}")
            self._away = None
        else:
            others = [f"{n:,} {words}" for words, n in rows.counts().items() if words != _ORBIT]
            note.update("; ".join(filter(None, (", ".join(others) or "no other", lacking))))
            table.show(rows, table.cursor)
        self._say_reading("")


def _lacking(periods: list[int]) -> str:
    """Say of which periods no births are stored, and what finds them."""
    from orbitdb.store.reading.fills import written_periods
    from orbitdb.symbols.enumeration import MAX_PERIOD

    if not periods:
        return ""
    found = [p for p in periods if p <= MAX_PERIOD]
    remedy = f"; 'orbitdb births --p {max(found)}' finds them" if found else ""
    return f"births of {written_periods(periods)} are not stored{remedy}"
