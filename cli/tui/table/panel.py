"""The panel of the rows: the table, what it lacks, and where its cursor is; it reads what it shows."""

import time
from dataclasses import dataclass
from typing import TYPE_CHECKING

from textual import work
from textual.app import ComposeResult
from textual.containers import Vertical
from textual.message import Message
from textual.reactive import reactive
from textual.widgets import Static
from textual.worker import get_current_worker

from orbitdb.cli.tui.table.columns import COLUMNS, USUAL, Column
from orbitdb.cli.tui.table.jumping import Jumping
from orbitdb.cli.tui.table.paged_table import PagedTable, Position
from orbitdb.cli.tui.table.source import Followed, NoRows, Ordering, Pages, Source, head_of
from orbitdb.errors import InputError, StoreError
from orbitdb.store.asking.confinement import CancelledError
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


class RowsPanel(Vertical):
    """The rows of a subset in some order."""

    columns: reactive[tuple[Column, ...]] = reactive(COLUMNS, repaint=False)
    marked: reactive[frozenset[str]] = reactive(frozenset(), repaint=False)
    report: reactive[str] = reactive("", repaint=False)

    @dataclass
    class Read(Message):
        """A worker has read the rows of a subset."""

        asked: Asked
        rows: Pages
        gaps: Gaps
        total: int
        seconds: float

    @dataclass
    class Unread(Message):
        """A worker could not."""

        asked: Asked
        reason: str

    def __init__(self) -> None:
        super().__init__(id="rows")
        self.jumping = Jumping(self)
        self.stopped = False
        self.total: int | None = None
        self.seconds_of_reading = 0.0
        self._asked: Asked | None = None
        self._place = ""

    def compose(self) -> ComposeResult:
        """Lay out the table, and lines for what there is to say of it."""
        yield PagedTable(id="table").data_bind(RowsPanel.columns, RowsPanel.marked)
        yield Static(id="unfilled", markup=False)
        yield Static(id="standing", markup=False)
        yield Position(id="position")

    @property
    def table(self) -> PagedTable:
        """The table."""
        return self.query_one(PagedTable)

    # reading

    def show_head(self, catalogue: "Catalogue", selection: Selection, fields: tuple[str, ...]) -> None:
        """Show the first rows in the first frame, where that takes no search."""
        if selection == Selection(selection.a):
            with catalogue.at_one_moment() as still:
                self.say_gaps(*_gaps(still, selection))
            self.table.show(head_of(catalogue, selection, fields, _HEAD))

    def read(
        self, catalogue: "Catalogue", selection: Selection, ordering: Ordering, fields: tuple[str, ...]
    ) -> None:
        """Read the rows in a worker; `Read` brings them."""
        self.report = _AT_WORK[ordering != self.table.ordering]
        self.say(self.report)
        self._asked, self.stopped = (selection, ordering), False
        self._read(catalogue, selection, ordering, fields)

    def stop_reading(self) -> None:
        """Read no further: somebody is about to choose something else."""
        if self.report in _AT_WORK:
            self.workers.cancel_group(self, "rows")
            self.report, self.stopped = "", True
            self.say()

    @work(thread=True, exclusive=True, group="rows")
    def _read(
        self, catalogue: "Catalogue", selection: Selection, ordering: Ordering, fields: tuple[str, ...]
    ) -> None:
        worker, begun, total = get_current_worker(), time.monotonic(), self.total
        asked = (selection, ordering)

        def cancelled() -> bool:
            return worker.is_cancelled

        try:
            with catalogue.at_one_moment() as still:
                gaps, everything = _gaps(still, selection), Selection(selection.a)
                chosen = still.choose(selection, str(ordering), cancelled=cancelled)
                if selection == everything:
                    total = len(chosen)
                elif total is None:
                    total = len(still.choose(everything, cancelled=cancelled))
        except CancelledError:
            return
        except (InputError, StoreError) as error:
            if not worker.is_cancelled:
                self.post_message(self.Unread(asked, str(error)))
            return
        if not worker.is_cancelled:
            pages, seconds = Pages(catalogue, chosen, fields), time.monotonic() - begun
            self.post_message(self.Read(asked, pages, gaps, total, seconds))

    def on_rows_panel_read(self, message: Read) -> None:
        """Say what rows those are that come, unless others are wanted by now."""
        if message.asked != self._asked:
            message.stop()
            return
        self.total, self.seconds_of_reading = message.total, message.seconds
        self.table.ordering = message.asked[1]
        self.say_gaps(*message.gaps)

    def on_rows_panel_unread(self, message: Unread) -> None:
        """Show no rows, as those that are shown are of another subset, and report what went wrong."""
        if message.asked != self._asked:
            message.stop()
            return
        self.show(NoRows(USUAL))
        self.report = message.reason

    # saying

    def show(self, rows: Source, cursor: int = 0) -> None:
        """Show rows, and no longer that they are read."""
        self.table.show(rows, cursor)
        self.say()

    def say(self, what: str = "") -> None:
        """Say what is done; else what the rows are, and how many are orbits where they are followed to."""
        source = self.table.source
        if not what and isinstance(source, Followed):
            what = f"{source.counts().get(_ORBIT, 0):,} orbits at a = {source.a:.9g}"
        self.border_title = what or "sequences"

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

    def on_paged_table_moved(self, message: PagedTable.Moved) -> None:
        """Say where the cursor is."""
        self._place = message.text
        self.say_position()

    def say_position(self) -> None:
        """Say where the cursor is, and where digits have led it to."""
        self.query_one(Position).text = " │ ".join(filter(None, (self.jumping.note, self._place)))


def _gaps(catalogue: "Catalogue", selection: Selection) -> Gaps:
    """Return the partial periods, and which are not filled, or lack the births that the subset depends on."""
    unfilled, lacking = catalogue.unfilled(selection), catalogue.lacking_births(selection)
    parts = [f"{unfilled}, and so does the key f" if unfilled else "", lacking or ""]
    return [fill.p for fill in catalogue.partial(selection)], "; ".join(filter(None, parts))
