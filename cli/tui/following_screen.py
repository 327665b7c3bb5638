"""Following in a: the orbit on screen by keys, and the table with it, as far as births are stored."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

from textual import work
from textual.message import Message
from textual.widgets import Static

from orbitdb.cli.tui.following import told
from orbitdb.cli.tui.source import Followed, Pages
from orbitdb.cli.tui.table import PagedTable
from orbitdb.cli.tui.word_screen import WordScreen
from orbitdb.errors import StoreError
from orbitdb.orbits.orbit import Orbit
from orbitdb.store.asking.selection import Selection

if TYPE_CHECKING:
    from orbitdb.store.reading.standings import Standings

_ORBIT = "orbit"


class FollowingScreen(WordScreen):
    """The main screen, looked at for another a than that of its rows."""

    @dataclass
    class StandingsRead(Message):
        """A worker has read the births of the rows."""

        pages: Pages
        standings: "Standings"
        without: list[int]

    def __init__(self, selection: Selection, code: str | None = None) -> None:
        super().__init__(selection, code)
        self._away: float | None = None
        self._pages: Pages | None = None
        self._standings: Standings | None = None
        self._without: list[int] = []

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
        if self.orbit is None:
            return
        before = self.orbit
        self.orbit = followed = self.browser.follow(before, up, self.selection.a)
        if happened := told(followed.exists or (), before.a, followed.a):
            self.notify(happened)

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
        """Let the rows follow the orbit."""
        super().watch_orbit(orbit)
        if not self.is_mounted:
            return
        if orbit is None or orbit.a == self.selection.a:
            self._come_back()
            return
        self._away = orbit.a
        if self._pages is not None:
            self._follow(self._pages)

    def show_rows(self, rows: Pages, cursor: int) -> None:
        """Show the rows that have been read, as they are where words are shown."""
        self._pages, self._standings = rows, None
        super().show_rows(rows, cursor)
        if self._away is not None:
            self._follow(rows)

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

    def _follow(self, pages: Pages) -> None:
        """Show the rows as they are elsewhere; the first time their births are read."""
        if self._standings is None:
            self._say_reading("reading births …")
            self._read_standings(pages)
        elif self._away is not None:
            self._show_standing(pages, self._standings, self._away)

    def _show_standing(self, pages: Pages, standings: "Standings", a: float) -> None:
        note, table = self.query_one("#standing", Static), self.query_one(PagedTable)
        note.display = True
        lacking = _lacking(self._without)
        if lacking and not (standings.known & (pages.keys.words_of_classes() > 0)).any():
            note.update(f"the rows stay at a = {self.selection.a:g}: {lacking}")
            self._away = None
        else:
            rows = Followed(pages, a, standings.at(a))
            others = [f"{n:,} {words}" for words, n in rows.counts().items() if words != _ORBIT]
            note.update("; ".join(filter(None, (", ".join(others) or "no other", lacking))))
            table.show(rows, table.cursor)
        self._say_reading("")

    @work(thread=True, exclusive=True, group="standings")
    def _read_standings(self, pages: Pages) -> None:
        from orbitdb.store.reading.standings import load_standings, periods_without

        try:
            standings = load_standings(pages.catalogue, pages.index)
            without = periods_without(pages.index, pages.keys, standings)
        except StoreError as error:
            self.post_message(self.Failed(str(error)))
            return
        self.post_message(self.StandingsRead(pages, standings, without))

    def on_following_screen_standings_read(self, message: StandingsRead) -> None:
        """Show the rows where the orbit is by now, unless they are others by now."""
        if message.pages is self._pages:
            self._standings, self._without = message.standings, message.without
            self._follow(message.pages)
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
