"""The panel of the rows: the table, what it lacks, and where its cursor is; it reads what it shows."""

import time
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING

from textual.app import ComposeResult
from textual.containers import Vertical
from textual.reactive import reactive
from textual.widgets import Static

from orbitdb.cli.tui.screens import in_thread
from orbitdb.cli.tui.table.jumping import Jumping
from orbitdb.cli.tui.table.paged_table import PagedTable
from orbitdb.cli.tui.table.pages import NoRows, Ordering, Pages, Source, head_of
from orbitdb.store.asking.selection import Selection

if TYPE_CHECKING:
    from orbitdb.catalogue.catalogue import Catalogue

_HEAD = 200
_ORBIT = "orbit"
_AT_WORK = ("reading …", "sorting …")

Asked = tuple[Selection, Ordering]
"""A subset, and the order of its rows."""

Gaps = tuple[list[int], str]
"""Periods that are stored in part, and a line on others."""

_Found = tuple[Pages, Gaps, int, float]
"""Rows, what they lack, how many there are without a filter, and the seconds it took to find them."""


class RowsPanel(Vertical):
    """The rows of a subset in some order."""

    report: reactive[str] = reactive("", repaint=False)

    def __init__(self, table: PagedTable) -> None:
        super().__init__(id="rows")
        self.table, self.jumping = table, Jumping(self)
        self.stopped = False
        self.total: int | None = None
        self.seconds_of_reading = 0.0
        self._asked: Asked | None = None

    def compose(self) -> ComposeResult:
        """Lay out the table, and lines for what there is to say of it."""
        yield self.table
        yield Static(id="unfilled", markup=False)
        yield Static(id="standing", markup=False)
        yield Static(id="position", markup=False)

    # reading

    def show_head(self, catalogue: "Catalogue", selection: Selection, fields: tuple[str, ...]) -> None:
        """Show the first rows in the first frame, where that takes no search."""
        if selection == Selection(selection.a):
            with catalogue.at_one_moment() as still:
                self.say_gaps(*_gaps(still, selection))
            self.table.show(head_of(catalogue, selection, fields, _HEAD))

    def read(
        self,
        catalogue: "Catalogue",
        selection: Selection,
        ordering: Ordering,
        fields: tuple[str, ...],
        take: Callable[[Pages], None],
    ) -> None:
        """Read the rows in a worker, and give them to whoever wants them if no others are wanted by then."""
        self.report = _AT_WORK[ordering != self.table.ordering]
        self.say(self.report)
        asked = self._asked = selection, ordering
        self.stopped, total = False, self.total

        def find(cancelled: Callable[[], bool]) -> _Found:
            begun, everything = time.monotonic(), Selection(selection.a)
            with catalogue.at_one_moment() as still:
                gaps = _gaps(still, selection)
                chosen = still.choose(selection, str(ordering), cancelled=cancelled)
                if selection == everything:
                    count = len(chosen)
                else:
                    count = total or len(still.choose(everything, cancelled=cancelled))
            return Pages(catalogue, chosen, fields), gaps, count, time.monotonic() - begun

        in_thread(self.screen, "rows", find, partial(self._take, asked, take), partial(self._fail, asked))

    def _take(self, asked: Asked, take: Callable[[Pages], None], found: _Found) -> None:
        if asked == self._asked:
            rows, gaps, self.total, self.seconds_of_reading = found
            self.table.ordering = asked[1]
            self.say_gaps(*gaps)
            take(rows)
            self.report = f"{len(rows):,} of {self.total:,} words"

    def _fail(self, asked: Asked, reason: str) -> None:
        """Show no rows, as those that are shown are of another subset, and say what went wrong."""
        if asked == self._asked:
            self.show(NoRows())
            self.report = reason
            if self.screen.is_current:  # a filter line says it itself
                self.notify(reason, severity="error")

    def stop_reading(self) -> None:
        """Read no further: somebody is about to choose something else."""
        if self.report in _AT_WORK:
            self.workers.cancel_group(self.screen, "rows")
            self.report, self.stopped = "", True
            self.say()

    # saying

    def show(self, rows: Source, cursor: int = 0) -> None:
        """Show rows, and no longer that they are read."""
        self.table.show(rows, cursor)
        self.say()

    def say(self, what: str = "") -> None:
        """Say what is done; else what the rows are, and how many are orbits where they are followed to."""
        source = self.table.source
        if not what and isinstance(source, Pages) and source.a is not None:
            what = f"{source.counts().get(_ORBIT, 0):,} orbits at a = {source.a:.9g}"
        self.border_title = what or "words"

    def say_gaps(self, partial: list[int], gaps: str) -> None:
        """Say which of the periods asked for are stored in part, and what of the others is not known."""
        listed = ", ".join(map(str, partial))
        verb = "are" if len(partial) > 1 else "is"
        self.border_subtitle = f"p = {listed} {verb} partial" if partial else ""
        self._note("#unfilled", gaps)

    def say_standing(self, text: str | None) -> None:
        """Say what those rows are that are no orbits where they are followed to."""
        self._note("#standing", text)

    def _note(self, name: str, text: str | None) -> None:
        note = self.query_one(name, Static)
        note.display = bool(text)
        note.update(text or "")

    def say_position(self) -> None:
        """Say where the cursor is, and where digits have led it to."""
        source = self.table.source
        more = "" if source.whole else "+"
        place = f"{self.table.cursor + 1:,} of {len(source):,}{more}" if len(source) else "none"
        told = " │ ".join(filter(None, (self.jumping.note, place)))
        self.query_one("#position", Static).update(told, layout=False)

    on_paged_table_moved = say_position


def _gaps(catalogue: "Catalogue", selection: Selection) -> Gaps:
    """Return the partial periods, and which are not filled, or lack the births that the subset depends on."""
    unfilled, lacking = catalogue.unfilled(selection), catalogue.lacking_births(selection)
    parts = [f"{unfilled}, and so does the key f" if unfilled else "", lacking or ""]
    return [fill.p for fill in catalogue.partial(selection)], "; ".join(filter(None, parts))
