"""The panels of the main screen: the chosen subset as a table, and the orbit under the cursor."""

from dataclasses import replace
from typing import TYPE_CHECKING, cast

from textual.app import ComposeResult
from textual.containers import Horizontal, Vertical
from textual.reactive import reactive
from textual.widgets import Footer, Header, Static

from orbitdb.cli.render import code_text
from orbitdb.cli.tui import choices
from orbitdb.cli.tui.orbit.drawing import OrbitDrawing
from orbitdb.cli.tui.orbit.facts import FactsPanel
from orbitdb.cli.tui.screens import Failed, OwnScreen
from orbitdb.cli.tui.table.columns import COLUMNS, Column, fields_of
from orbitdb.cli.tui.table.following import Following
from orbitdb.cli.tui.table.paged_table import PagedTable
from orbitdb.cli.tui.table.pages import NoRows, Ordering, Pages
from orbitdb.cli.tui.table.panel import RowsPanel
from orbitdb.cli.tui.word_search import WordSearch
from orbitdb.errors import StoreError
from orbitdb.orbits.orbit import Orbit
from orbitdb.store.asking.codes import hint
from orbitdb.store.asking.expressions import check, names_in
from orbitdb.store.asking.selection import Selection
from orbitdb.store.reading.soundness import need_words
from orbitdb.symbols.words import least_rotation

if TYPE_CHECKING:
    from orbitdb.cli.tui.app import BrowseApp

GREETING = """\
[b]Nothing is stored here yet.[/b]

{path}

Press [b]f[/b] to fill it: the periods up to 11 take a few seconds
and hold 89,789 words, the paper's Table 1.

Press [b]c[/b] to type a code, such as 1232131, and see its orbit.
Press [b]?[/b] for the keys, [b]q[/b] to leave."""


class Panels(OwnScreen[None]):
    """The state of the main screen: a subset in some order, and an orbit.

    Parameters
    ----------
    selection : Selection
        The subset to begin with.
    code : str, optional
        The word to begin with.

    Attributes
    ----------
    wanted : str or None
        The word that the cursor goes to when the rows come.
    caught_up : str or None
        The word of the row of which the orbit was shown last.
    periods : list of int
        Those that are filled, whole or in part.
    """

    selection: reactive[Selection] = reactive(Selection, repaint=False)
    ordering: reactive[Ordering] = reactive(Ordering(), repaint=False)
    orbit: reactive[Orbit | None] = reactive(None, always_update=True, repaint=False)
    compared: reactive[tuple[Orbit, ...]] = reactive((), always_update=True, repaint=False)
    columns: reactive[tuple[Column, ...]] = reactive(COLUMNS, repaint=False)
    marked: reactive[frozenset[str]] = reactive(frozenset(), repaint=False)

    def __init__(self, selection: Selection, code: str | None = None) -> None:
        super().__init__()
        self.set_reactive(Panels.selection, selection)
        self._code = code
        self._values = dict(selection.parameters)
        self.wanted: str | None = None
        self.caught_up: str | None = None
        self.periods: list[int] = []
        self.following = Following(self)
        self.search = WordSearch(self)

    @property
    def browser(self) -> "BrowseApp":
        """The application, which holds the catalogue."""
        return cast("BrowseApp", self.app)

    @property
    def rows(self) -> RowsPanel:
        """The panel of the rows."""
        return self.query_one(RowsPanel)

    @property
    def here(self) -> float:
        """The a at which words are shown: that of the rows, or the one they are followed to."""
        return self.selection.a if self.following.away is None else self.following.away

    def compose(self) -> ComposeResult:
        """Lay out the panels."""
        yield Header()
        yield Static(id="chips")
        with Vertical(id="greeting"):
            yield Static(GREETING.format(path=choices.escaped(str(self.browser.path))))
        with Horizontal(id="body"):
            yield RowsPanel(PagedTable(id="table").data_bind(Panels.columns, Panels.marked))
            with Vertical(id="side"):
                yield OrbitDrawing(self.selection.a, id="drawing").data_bind(Panels.orbit, Panels.compared)
                yield FactsPanel(id="facts")
        yield Footer(show_command_palette=False, compact=True)

    def on_mount(self) -> None:
        """Show the first rows at once, and read the rest meanwhile; look the first word up."""
        self.rows.say()
        if self.browser.catalogue is not None:
            self.rows.show_head(self.browser.catalogue, self.selection, self._fields())
        self.refresh_catalogue()
        self.rows.table.focus()
        if self._code is not None:
            self.call_next(self.search.ask_for, self._code)

    # the subset

    def refresh_catalogue(self) -> None:
        """Look at the file again: at the beginning, and when something has been stored."""
        catalogue = self.browser.catalogue
        values = catalogue.a_values() if catalogue is not None else []
        self.set_class(not values and self.orbit is None, "-empty")
        self.rows.total = None
        if values:
            self._look_at_periods()
        self.say_choices()
        if values:
            self.read()

    def _look_at_periods(self) -> None:
        catalogue = self.browser.catalogue
        self.periods = [fill.p for fill in catalogue.fills(self.selection.a)] if catalogue else []

    def watch_selection(self, old: Selection, selection: Selection) -> None:
        """Show the new subset; of another stadium nothing stays on screen."""
        if not self.is_mounted:
            return
        if selection.a != old.a:
            self._look_at_periods()
            self.following.take_rows(None)
            self.query_one(OrbitDrawing).a = selection.a
            self.wanted = self.caught_up = self.rows.total = None
            self.orbit, self.compared = None, ()
            self.rows.say_gaps([], "")
            self.rows.table.show(NoRows())
        self.say_choices()
        self.read()

    def say_choices(self) -> None:
        """Show what is chosen, in the subtitle and as links."""
        catalogue = self.browser.catalogue
        count = len(catalogue.a_values()) if catalogue is not None else 0
        self.query_one("#chips", Static).update(choices.chips(self.selection, count))
        self.sub_title = self.selection.describe()

    def _fields(self) -> tuple[str, ...]:
        return fields_of(self.columns, self.ordering.column)

    def read(self) -> None:
        """Read the chosen rows."""
        if self.browser.catalogue is not None:
            chosen = self.selection, self.ordering
            self.rows.read(self.browser.catalogue, *chosen, self._fields(), self._take_rows)

    def watch_ordering(self) -> None:
        """Read the rows in another order, or with other columns."""
        if self.is_mounted:
            self.read()

    watch_columns = watch_ordering

    def check_filter(self, where: str) -> str:
        """Refuse a filter that cannot be used; say where it compares codes with what names no row."""
        check(where, dict(self._filtered(where).parameters))
        return hint(where) or ""

    def try_filter(self, where: str, word: str | None) -> None:
        """Show the rows of a filter that can be used, the cursor on a word if it is among them."""
        if (where or None) != self.selection.where:
            self.wanted = word
            self.selection = self._filtered(where or None)
        elif self.rows.stopped:  # read it after all
            self.read()

    def _filtered(self, where: str | None) -> Selection:
        """Return what is chosen with another filter; of the values given with -P, those it names."""
        used = names_in(where or "")
        known = self._values | dict(self.selection.parameters)
        values = {name: value for name, value in known.items() if name in used}
        return replace(self.selection, where=where, parameters=values)

    def _take_rows(self, rows: Pages) -> None:
        """Show the rows; the cursor stays on its word if it is among them, and at the top if it was there."""
        table = self.rows.table
        word = self.wanted or (table.row[0] if table.row and table.cursor else None)
        alone = self._word_without_row()
        if self.wanted is None and alone is not None:
            word = alone
        place = rows.position(word) if word else None
        self.wanted = self.caught_up = None
        if not len(rows) and self.orbit is not None and self.orbit.stored:
            self.orbit = None
        self.show_rows(rows, place or 0)
        if alone is not None and place is None:
            self.leave_the_row()

    def show_rows(self, rows: Pages, cursor: int) -> None:
        """Show the rows that have been read, as they are where words are shown."""
        self.following.take_rows(rows)
        self.rows.show(rows, cursor)
        self.search.take_rows(rows)
        self.following.go_on()
        self.rows.jumping.go_on()

    def on_failed(self, message: Failed) -> None:
        """Go on with nothing that a worker could not do."""
        self.following.stop()
        self.search.say_solving(None)
        self.rows.say()

    # the orbit

    def _word_without_row(self) -> str | None:
        """Return the word on show, as a least rotation, if it is not that of the row under the cursor."""
        if self.orbit is None or self.orbit.stored:
            return None
        word, row = least_rotation(self.orbit.code), self.rows.table.row
        return None if row is not None and row[0] == word else word

    def leave_the_row(self) -> None:
        """Let the row under the cursor not take the place of what is shown, until the cursor moves."""
        row = self.rows.table.row
        self.caught_up = None if row is None else row[0]

    def catch_up(self) -> None:
        """Show the word under the cursor, which may have moved faster than messages go."""
        row = self.rows.table.row
        if self.wanted is None and row is not None and row[0] != self.caught_up:
            self.caught_up = row[0]
            self._show_word(row[0])

    on_paged_table_moved = catch_up

    def _show_word(self, word: str, anew: bool = False) -> None:
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
            self.orbit = self._look_up(wanted)
        except StoreError as error:
            self.orbit = None
            self.notify(str(error), severity="error")

    def _look_up(self, word: str) -> Orbit:
        """Return the orbit of a word where words are shown."""
        stored, away = self.browser.find(word, self.selection.a), self.following.away
        return stored if away is None else self.browser.find_at(word, away, stored.exists)

    def watch_orbit(self, orbit: Orbit | None) -> None:
        """Write what is known of the orbit, and let the rows follow it."""
        if not self.is_mounted:
            return
        self.entitle_facts()
        self.query_one(OrbitDrawing).a = self.selection.a if orbit is None else orbit.a
        if orbit is None:
            self.query_one(FactsPanel).show(None)
        else:
            self.remove_class("-empty")
            self.query_one(FactsPanel).show(orbit, self.browser.certificate(orbit))
        self.following.take_orbit(orbit)

    def entitle_facts(self) -> None:
        """Say what the facts are, and at which a if that is not the rows' own, or that a word is solved."""
        title = "facts"
        if self.orbit is not None and self.orbit.a != self.selection.a:
            title = f"facts at a = {self.orbit.a:.9g}"
        if self.search.solving is not None:
            title = f"solving {code_text(self.search.solving)} …"
        self.query_one(FactsPanel).border_title = title

    def action_back(self) -> None:
        """Go back to where digits began, or else show the row under the cursor as it is stored."""
        if self.rows.jumping.under_way:
            self.rows.jumping.give_up()
            return
        self.following.come_back()
        row = self.rows.table.row
        if row is not None:
            self._show_word(row[0], anew=True)
