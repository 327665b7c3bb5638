"""The panels of the main screen: the chosen subset as a table, and the orbit under the cursor."""

import time
from dataclasses import dataclass
from typing import TYPE_CHECKING, cast

from textual import work
from textual.app import ComposeResult
from textual.containers import Horizontal, Vertical
from textual.message import Message
from textual.reactive import reactive
from textual.widgets import Footer, Header, Static
from textual.worker import get_current_worker

from orbitdb.cli.tui import choices
from orbitdb.cli.tui.browser import Browser
from orbitdb.cli.tui.orbit.drawing import OrbitDrawing, View
from orbitdb.cli.tui.orbit.facts import Certificate, FactsPanel
from orbitdb.cli.tui.screens import OwnScreen
from orbitdb.cli.tui.table.columns import COLUMNS, USUAL, Column, fields_of
from orbitdb.cli.tui.table.paged_table import PagedTable, Position
from orbitdb.cli.tui.table.source import NoRows, Ordering, Pages, head_of
from orbitdb.errors import InputError, StoreError
from orbitdb.orbits.orbit import Orbit
from orbitdb.store.asking.confinement import CancelledError
from orbitdb.store.asking.selection import Selection
from orbitdb.store.reading.soundness import need_words
from orbitdb.symbols.words import least_rotation

if TYPE_CHECKING:
    from orbitdb.store.reading.catalogue import Catalogue

GREETING = """\
[b]Nothing is stored here yet.[/b]

{path}

Press [b]f[/b] to fill it: the periods up to 11 take a few seconds
and hold 89,789 symbol sequences, the paper's Table 1.

Press [b]c[/b] to type a code, such as 1232131, and see its orbit.
Press [b]?[/b] for the keys, [b]q[/b] to leave."""

_HEAD = 200
_AT_WORK = ("reading …", "sorting …")


class OrbitScreen(OwnScreen[None]):
    """The state of the main screen: a subset in some order, and an orbit."""

    selection: reactive[Selection] = reactive(Selection, repaint=False)
    ordering: reactive[Ordering] = reactive(Ordering(), repaint=False)
    orbit: reactive[Orbit | None] = reactive(None, always_update=True, repaint=False)
    view: reactive[View] = reactive(View.STADIUM, repaint=False)
    compared: reactive[tuple[Orbit, ...]] = reactive((), always_update=True, repaint=False)
    report: reactive[str] = reactive("", repaint=False)
    columns: reactive[tuple[Column, ...]] = reactive(COLUMNS, repaint=False)
    marked: reactive[frozenset[str]] = reactive(frozenset(), repaint=False)

    @dataclass
    class RowsRead(Message):
        """A worker has read the rows of a subset."""

        source: Pages
        partial: list[int]
        gaps: str
        ordering: Ordering
        total: int
        seconds: float

    @dataclass
    class RowsFailed(Message):
        """A worker could not read the rows of a subset."""

        reason: str
        selection: Selection

    @dataclass
    class Failed(Message):
        """A worker could not do what it should."""

        reason: str

    def __init__(self, selection: Selection) -> None:
        super().__init__()
        self.set_reactive(OrbitScreen.selection, selection)
        self._wanted: str | None = None
        self._caught_up: str | None = None
        self._place = ""
        self._cancelled = False
        self._total: int | None = None
        self.seconds_of_reading = 0.0
        self.periods: list[int] = []

    @property
    def here(self) -> float:
        """The a at which words are shown."""
        return self.selection.a

    @property
    def rows_title(self) -> str:
        """What the rows are."""
        return "sequences"

    @property
    def position_note(self) -> str:
        """What there is to say of the place of the cursor, before its number."""
        return ""

    @property
    def facts_title(self) -> str:
        """What the facts are, and at which a if that is not the rows' own."""
        elsewhere = self.orbit is not None and self.orbit.a != self.selection.a
        return f"facts at a = {self.orbit.a:.9g}" if self.orbit is not None and elsewhere else "facts"

    @property
    def browser(self) -> Browser:
        """The application, which holds the catalogue."""
        return cast(Browser, self.app)

    def compose(self) -> ComposeResult:
        """Lay out the panels."""
        yield Header()
        yield Static(id="chips")
        with Vertical(id="greeting"):
            yield Static(GREETING.format(path=choices.escaped(str(self.browser.path))))
        with Horizontal(id="body"):
            with Vertical(id="rows"):
                yield PagedTable(id="table").data_bind(OrbitScreen.columns, OrbitScreen.marked)
                yield Static(id="unfilled", markup=False)
                yield Static(id="standing", markup=False)
                yield Position(id="position")
            with Vertical(id="side"):
                yield OrbitDrawing(self.selection.a, id="drawing").data_bind(
                    OrbitScreen.orbit, OrbitScreen.view, OrbitScreen.compared
                )
                yield FactsPanel(id="facts")
        yield Footer(show_command_palette=False, compact=True)

    def on_mount(self) -> None:
        """Show the first rows at once, and read the rest meanwhile."""
        self._say_reading("")
        self._show_head()
        self.refresh_catalogue()
        self.query_one(PagedTable).focus()

    def _show_head(self) -> None:
        """Show the first rows in the first frame, where that takes no search."""
        catalogue = self.browser.catalogue
        if catalogue is not None and self.selection == Selection(self.selection.a):
            with catalogue.at_one_moment() as still:
                partial = [fill.p for fill in still.partial(self.selection)]
                self._say_gaps(partial, _gaps(still, self.selection))
                fields = fields_of(self.columns, self.ordering.column)
                self.query_one(PagedTable).show(head_of(still, self.selection, fields, _HEAD))

    def refresh_catalogue(self) -> None:
        """Look at the file again: at the beginning, and when something has been stored."""
        catalogue = self.browser.catalogue
        values = catalogue.a_values() if catalogue is not None else []
        self.set_class(not values and self.orbit is None, "-empty")
        self._total = None
        if catalogue is None or not values:
            self.say_choices()
            return
        self.periods = [fill.p for fill in catalogue.fills(self.selection.a)]
        self.say_choices()
        self._reload()

    def watch_selection(self, old: Selection, selection: Selection) -> None:
        """Show the new subset."""
        if not self.is_mounted:
            return
        if selection.a != old.a:
            self._leave_stadium()
        self.say_choices()
        self._reload()

    def _leave_stadium(self) -> None:
        """Show nothing of the stadium that was shown: what is on screen is always of one a."""
        catalogue = self.browser.catalogue
        self.periods = [fill.p for fill in catalogue.fills(self.selection.a)] if catalogue else []
        self.query_one(OrbitDrawing).a = self.selection.a
        self._wanted = self._caught_up = self._total = None
        self.orbit, self.compared = None, ()
        self._say_gaps([], "")
        self.query_one(PagedTable).show(NoRows(USUAL))

    def watch_ordering(self) -> None:
        """Sort the subset."""
        if self.is_mounted:
            self._reload()

    def watch_columns(self) -> None:
        """Read the rows anew, with what other columns show."""
        if self.is_mounted:
            self._reload()

    def say_choices(self) -> None:
        """Show what is chosen, in the subtitle and as links."""
        catalogue = self.browser.catalogue
        count = len(catalogue.a_values()) if catalogue is not None else 0
        self.query_one("#chips", Static).update(choices.chips(self.selection, count))
        self.sub_title = self.selection.describe()

    def _reload(self) -> None:
        if self.browser.catalogue is not None:
            table = self.query_one(PagedTable)
            self.report = _AT_WORK[self.ordering != table.ordering]
            self._say_reading(self.report)
            self._cancelled = False
            self._read_rows(self.selection, self.ordering, self._total)

    def stop_reading(self) -> None:
        """Read no further: somebody is about to choose something else."""
        if self.report in _AT_WORK:
            self.workers.cancel_group(self, "rows")
            self._cancelled = True
            self.report = ""
            self._say_reading("")

    def go_on_reading(self) -> None:
        """Read what is chosen after all."""
        if self._cancelled:
            self._reload()

    def _say_reading(self, what: str) -> None:
        self.query_one("#rows").border_title = what or self.rows_title

    def _say_gaps(self, partial: list[int], gaps: str) -> None:
        """Say which of the periods asked for are stored in part, and what of the others is not known."""
        listed = ", ".join(map(str, partial))
        verb = "are" if len(partial) > 1 else "is"
        self.query_one("#rows").border_subtitle = f"p = {listed} {verb} partial" if partial else ""
        note = self.query_one("#unfilled", Static)
        note.display = bool(gaps)
        note.update(gaps)

    @work(thread=True, exclusive=True, group="rows")
    def _read_rows(self, selection: Selection, ordering: Ordering, total: int | None) -> None:
        worker, begun = get_current_worker(), time.monotonic()
        catalogue = self.browser.catalogue
        assert catalogue is not None

        def cancelled() -> bool:
            return worker.is_cancelled

        try:
            with catalogue.at_one_moment() as still:
                partial, gaps = [fill.p for fill in still.partial(selection)], _gaps(still, selection)
                chosen = still.choose(selection, str(ordering), cancelled=cancelled)
                everything = Selection(selection.a)
                if selection == everything:
                    total = len(chosen)
                elif total is None:
                    total = len(still.choose(everything, cancelled=cancelled))
        except CancelledError:
            return
        except (InputError, StoreError) as error:
            if not worker.is_cancelled:
                self.post_message(self.RowsFailed(str(error), selection))
            return
        if not worker.is_cancelled:
            pages = Pages(catalogue, chosen, fields_of(self.columns, ordering.column))
            seconds = time.monotonic() - begun
            self.post_message(self.RowsRead(pages, partial, gaps, ordering, total, seconds))

    def on_orbit_screen_rows_read(self, message: RowsRead) -> None:
        """Show the rows; the cursor stays on its word if it is among them, and at the top if it was there."""
        if (message.source.chosen.selection, message.ordering) != (self.selection, self.ordering):
            return
        self._total, self.seconds_of_reading = message.total, message.seconds
        table = self.query_one(PagedTable)
        table.ordering = message.ordering
        self._say_gaps(message.partial, message.gaps)
        word = self._wanted or (table.row[0] if table.row and table.cursor else None)
        alone = self._word_without_row()
        if self._wanted is None and alone is not None:
            word = alone
        place = message.source.position(word) if word else None
        self._wanted = self._caught_up = None
        if not len(message.source) and self.orbit is not None and self.orbit.stored:
            self.orbit = None
        self.show_rows(message.source, place or 0)
        if alone is not None and place is None:
            self._leave_the_row()
        self.report = f"{len(message.source):,} of {message.total:,} sequences"

    def _word_without_row(self) -> str | None:
        """Return the word on show, as a least rotation, if it is not that of the row under the cursor."""
        if self.orbit is None or self.orbit.stored:
            return None
        word, row = least_rotation(self.orbit.code), self.query_one(PagedTable).row
        return None if row is not None and row[0] == word else word

    def _leave_the_row(self) -> None:
        """Let the row under the cursor not take the place of what is shown, until the cursor moves."""
        row = self.query_one(PagedTable).row
        self._caught_up = None if row is None else row[0]

    def show_rows(self, rows: Pages, cursor: int) -> None:
        """Show the rows that have been read."""
        self.query_one(PagedTable).show(rows, cursor)
        self._say_reading("")

    def on_orbit_screen_rows_failed(self, message: RowsFailed) -> None:
        """Show no rows, as those that are shown are of another subset, and say what went wrong."""
        if message.selection == self.selection:
            self._wanted = None
            self._say_reading("")
            self.query_one(PagedTable).show(NoRows(USUAL))
            self.report = message.reason
            if isinstance(self.app.screen, OrbitScreen):  # a filter line says it itself
                self.notify(message.reason, severity="error")

    def on_orbit_screen_failed(self, message: Failed) -> None:
        """Say what went wrong."""
        self._say_reading("")
        self.notify(message.reason, severity="error")

    def on_paged_table_moved(self, message: PagedTable.Moved) -> None:
        """Say where the cursor is."""
        self._place = message.text
        self.say_position()

    def say_position(self) -> None:
        """Say where the cursor is, and what there is to say of the place."""
        self.query_one(Position).text = " │ ".join(filter(None, (self.position_note, self._place)))

    def on_paged_table_highlighted(self, message: PagedTable.Highlighted) -> None:
        """Show the orbit of the row, unless it is shown in another rotation or with its reverse."""
        self.catch_up()

    def catch_up(self) -> None:
        """Show the word under the cursor, which may have moved faster than messages go."""
        row = self.query_one(PagedTable).row
        if self._wanted is None and row is not None and row[0] != self._caught_up:
            self._caught_up = row[0]
            self.show_word(row[0])

    def show_word(self, word: str, anew: bool = False) -> None:
        """Show a word, as a least rotation; what is shown of it in another rotation stays, unless anew."""
        wanted = word
        if not anew and self.orbit is not None and self.orbit.a == self.here:
            shown, known = self.orbit.code, self.orbit.stored or self.here != self.selection.a
            if len(shown) == len(word) and least_rotation(shown) == word:
                if known:
                    return
                wanted = shown
        try:
            need_words([word], [len(word)])
            self.orbit = self.look_up(wanted)
        except StoreError as error:
            self.orbit = None
            self.notify(str(error), severity="error")

    def look_up(self, word: str) -> Orbit:
        """Return the orbit of a word where words are shown."""
        return self.browser.find(word, self.here)

    def watch_orbit(self, orbit: Orbit | None) -> None:
        """Write what is known of the orbit."""
        if not self.is_mounted:
            return
        self.query_one(FactsPanel).border_title = self.facts_title
        self.query_one(OrbitDrawing).a = self.selection.a if orbit is None else orbit.a
        if orbit is None:
            self.query_one(FactsPanel).show(None)
            return
        self.remove_class("-empty")
        certificate: Certificate = self.browser.certificate(orbit)
        self.query_one(FactsPanel).show(orbit, certificate)

    def action_back(self) -> None:
        """Show the row under the cursor as it is stored."""
        row = self.query_one(PagedTable).row
        if row is not None:
            self.show_word(row[0], anew=True)


def _gaps(catalogue: "Catalogue", selection: Selection) -> str:
    """Say which of the periods asked for are not filled, or lack the births that the subset depends on."""
    unfilled, lacking = catalogue.unfilled(selection), catalogue.lacking_births(selection)
    parts = [f"{unfilled}, and so does the key f" if unfilled else "", lacking or ""]
    return "; ".join(filter(None, parts))
