"""The panel of the rows: the table, notes on gaps, and the position of the cursor."""

from collections.abc import Callable, Iterator
from typing import cast

from textual.app import ComposeResult
from textual.containers import Vertical
from textual.reactive import reactive
from textual.widgets import Static

from orbitdb.answers.unfilled import lacking_births, partial_fills, unfilled
from orbitdb.cli.tui.screens import OwnScreen
from orbitdb.cli.tui.table.jumping import Jumping
from orbitdb.cli.tui.table.paged_table import PagedTable
from orbitdb.cli.tui.table.pages import NONE, Ordering, Pages
from orbitdb.orbits.orbit import Orbit
from orbitdb.store.asking.selection import Selection
from orbitdb.store.reading.moment import Moment, Reader
from orbitdb.symbols.words import least_rotation

_ORBIT = "orbit"
_AT_WORK = ("reading …", "sorting …")

Asked = tuple[Selection, Ordering]
"""A subset, and the order of its rows."""

_Found = tuple[Pages, tuple[str, str], int | None]
"""Rows, notes on gaps, and the number of rows without a filter, None for the first rows."""

_FIRST = 100
_SHOWN = 12
"""Most symbols to show of a word without a row."""


class RowsPanel(Vertical):
    """The rows of a subset in some order, shown or being read.

    The total is the number of rows without a filter, once they are counted.
    """

    report: reactive[str] = reactive("", repaint=False)

    def __init__(self, table: PagedTable) -> None:
        super().__init__(id="rows")
        self.table, self.jumping = table, Jumping(self)
        self.border_title = "words"
        self.asked: Asked | None = None
        self.total: int | None = None
        self._aside = ""

    def compose(self) -> ComposeResult:
        """Lay out the table and the lines below it."""
        yield self.table
        yield Static(id="unfilled", markup=False)
        yield Static(id="standing", markup=False)
        yield Static(id="position", markup=False)

    # reading

    @property
    def screen(self) -> OwnScreen[object]:
        """The main screen."""
        return cast(OwnScreen[object], super().screen)

    def read(
        self,
        catalogue: Reader,
        asked: Asked,
        fields: tuple[str, ...],
        begin: Callable[[Pages], None],
        take: Callable[[Pages], None],
    ) -> None:
        """Read rows in a worker, and pass them on unless others are wanted by then.

        If there were none before, the first rows go to `begin` until all are there.
        """
        (selection, ordering), total = asked, self.total
        self.asked = asked
        self.report = _AT_WORK[ordering != self.table.ordering]
        self.say(self.report)
        everything, nothing = Selection(selection.a), self.table.source is NONE

        def find(cancelled: Callable[[], bool]) -> Iterator[_Found]:
            with catalogue.moment() as moment:
                gaps = _gaps(moment, selection)
                if nothing and asked == (everything, Ordering()):
                    yield Pages(catalogue, moment.choose(selection, most=_FIRST), fields), gaps, None
                chosen = moment.choose(selection, str(ordering), cancelled=cancelled)
                every = chosen if selection == everything else None
                if every is None and total is None:
                    every = moment.choose(everything, cancelled=cancelled)
            count = total if every is None else len(every)
            yield Pages(catalogue, chosen, fields), gaps, count or 0

        def show(found: _Found) -> None:
            rows, gaps, self.total = found
            self.table.ordering = ordering
            self.say_gaps(*gaps)
            if self.total is None:
                begin(rows)
                return
            self.report = f"{len(rows):,} of {self.total:,} words"
            take(rows)

        self.screen.in_thread("rows", find, show, self._fail)

    def _fail(self, reason: str) -> None:
        """Show the error, and no rows, because the old ones belong to another subset."""
        self.show(NONE)
        self.report = reason
        if self.screen.is_current:  # a filter line shows it itself
            self.notify(reason, severity="error")

    @property
    def reads(self) -> bool:
        """Whether other rows are being read."""
        return self.report in _AT_WORK

    def stop_reading(self) -> None:
        """Stop reading, because the choice is about to change."""
        if self.reads:
            self.screen.give_up("rows")
            self.report, self.asked = "", None
            self.say()

    # saying

    def show(self, rows: Pages, cursor: int = 0) -> None:
        """Show rows, without the note that they are being read."""
        self.table.show(rows, cursor)
        self.say()

    def say(self, what: str = "") -> None:
        """Show the current work; otherwise describe the rows, with the number of orbits at another a."""
        source = self.table.source
        if not what and source.a is not None:
            what = f"{source.counts().get(_ORBIT, 0):,} orbits at a = {source.a:.9g}"
        self.border_title = what or "words"

    def say_gaps(self, partial: str, gaps: str) -> None:
        """Show which chosen periods are partial, and what is missing of the others."""
        self.border_subtitle = partial
        self._note("#unfilled", gaps)

    def say_standing(self, text: str | None) -> None:
        """Describe the rows that are not orbits at the followed a."""
        self._note("#standing", text)

    def _note(self, name: str, text: str | None) -> None:
        note = self.query_one(name, Static)
        if note.display or text:  # otherwise every key would lay out the screen again
            note.display = bool(text)
            note.update(text or "")

    def say_orbit(self, orbit: Orbit | None) -> None:
        """If the current orbit has no row, say so in place of the cursor's position."""
        told = ""
        if orbit is not None and (self.table.row or ("",))[0] != least_rotation(orbit.code):
            code = orbit.code if orbit.p <= _SHOWN else f"{orbit.code[:_SHOWN]}…"
            told = f"{code} is not {'among these' if orbit.stored else 'stored'}"
        if told != self._aside:
            self._aside = told
            self.say_position()

    def say_position(self) -> None:
        """Show the position of the cursor and the target of digits, or that the word has no row."""
        rows = len(self.table.source)
        known = "…" if self.total is None else f"{rows:,}"
        place = f"row {self.table.cursor + 1:,} of {known}" if rows else "no rows"
        told = " │ ".join(filter(None, (self.jumping.note, self._aside or place)))
        self.query_one("#position", Static).update(told, layout=False)

    on_paged_table_moved = say_position


def _gaps(moment: Moment, selection: Selection) -> tuple[str, str]:
    """Describe partial periods, and periods that are not filled or lack necessary births."""
    missing, lacking = unfilled(moment, selection), lacking_births(moment, selection)
    parts = [f"{missing}, and so does the key f" if missing else "", lacking or ""]
    partial = [str(fill.p) for fill in partial_fills(moment, selection)]
    verb = "are" if len(partial) > 1 else "is"
    return f"p = {', '.join(partial)} {verb} partial" if partial else "", "; ".join(filter(None, parts))
