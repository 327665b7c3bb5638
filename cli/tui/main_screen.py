"""The main screen: the chosen subset as a table, and the orbit of the row under the cursor."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar, cast

from textual import work
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Horizontal, Vertical, VerticalScroll
from textual.message import Message
from textual.reactive import reactive
from textual.screen import Screen
from textual.widgets import Footer, Header, Static
from textual.worker import get_current_worker

from orbitdb.cli.tui import choices
from orbitdb.cli.tui.dialogs import ChoiceDialog, LineDialog
from orbitdb.cli.tui.drawing import OrbitDrawing, View
from orbitdb.cli.tui.facts import Certificate, as_text, facts_of
from orbitdb.cli.tui.filling import FillDialog, FillState
from orbitdb.cli.tui.source import Head, Ordering, Pages, Source, head_of
from orbitdb.cli.tui.table import COLUMNS, NAMES, PagedTable
from orbitdb.errors import InputError, StoreError
from orbitdb.orbits import Orbit
from orbitdb.selection import Selection
from orbitdb.symmetry import MIRROR_X, MIRROR_Y, REVERSE, images_of
from orbitdb.words import least_rotation, parse, primitive_root

if TYPE_CHECKING:
    from orbitdb.cli.tui.app import BrowseApp

GREETING = """\
[b]Nothing is stored here yet.[/b]

{path}

Press [b]f[/b] to fill it: the periods up to 11 take a few seconds
and hold 89 791 symbol sequences, the paper's Table 1.

Press [b]c[/b] to type a code, such as 1232131, and see its orbit.
Press [b]?[/b] for the keys, [b]q[/b] to leave."""

_HEAD = 200
_MOST_COMPARED = 6
_ELEMENTS = {REVERSE: "time reverse", MIRROR_X: "mirror image, left and right,",
             MIRROR_Y: "mirror image, up and down,"}  # fmt: skip


class MainScreen(Screen[None]):
    """Look at orbits and choose them."""

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("slash", "filter", "filter", key_display="/"),
        Binding("c", "code", "code"),
        Binding("s", "sort", "sort"),
        Binding("v", "view", "view"),
        Binding("space", "particle", "run"),
        Binding("f", "fill", "fill"),
        Binding("S", "statistics", "statistics"),
        Binding("e", "export", "export"),
        Binding("y", "copy", "copy the word", show=False),
        Binding("o", "status", "status: all, orbits, pruned ..", show=False),
        Binding("r", "reversal", "self-retracing or not", show=False),
        Binding("right_square_bracket", "period(1)", "next period", show=False, key_display="]"),
        Binding("left_square_bracket", "period(-1)", "period before", show=False, key_display="["),
        Binding("a", "choose_a", "another a", show=False),
        Binding("R", "reverse_order", "turn the order round", show=False),
        Binding("T,t", f"move_in_class({REVERSE})", "time reverse", show=False),
        Binding("X,x", f"move_in_class({MIRROR_X})", "mirror left and right", show=False),
        Binding("Y", f"move_in_class({MIRROR_Y})", "mirror up and down", show=False),
        Binding("m", "compare", "mark to compare in phase space", show=False),
        Binding("M", "compare_none", "unmark all", show=False),
        Binding("escape", "back", "back to the row", show=False),
    ]

    selection: reactive[Selection] = reactive(Selection)
    ordering: reactive[Ordering] = reactive(Ordering())
    orbit: reactive[Orbit | None] = reactive(None)
    view: reactive[View] = reactive(View.STADIUM)
    compared: reactive[tuple[Orbit, ...]] = reactive(())

    @dataclass
    class RowsRead(Message):
        """A worker has read the rows of a subset."""

        source: Source
        selection: Selection
        ordering: Ordering

    @dataclass
    class OrbitFound(Message):
        """A worker has found, or solved, a word that was asked for."""

        orbit: Orbit

    @dataclass
    class Failed(Message):
        """A worker could not do what it should."""

        reason: str

    def __init__(self, selection: Selection, code: str | None = None) -> None:
        super().__init__()
        self.set_reactive(MainScreen.selection, selection)
        self._code = code
        self._wanted: str | None = None
        self._history: list[str] = [selection.where] if selection.where else []
        self._codes: list[str] = []
        self._periods: list[int] = []

    @property
    def browser(self) -> "BrowseApp":
        """The application, which holds the catalogue."""
        return cast("BrowseApp", self.app)

    def compose(self) -> ComposeResult:
        """Lay out the panels."""
        yield Header()
        yield Static(id="chips")
        with Vertical(id="greeting"):
            yield Static(GREETING.format(path=self.browser.path))
        with Horizontal(id="body"):
            yield PagedTable(id="table")
            with Vertical(id="side"):
                yield OrbitDrawing(self.selection.a, id="drawing").data_bind(
                    MainScreen.orbit, MainScreen.view, MainScreen.compared
                )
                with VerticalScroll(id="facts-box"):
                    yield Static(id="facts")
        yield Footer(show_command_palette=False)

    def on_mount(self) -> None:
        """Show the first rows at once, and read the rest meanwhile."""
        self.query_one(PagedTable).border_title = "sequences"
        self.query_one("#facts-box").border_title = "facts"
        self._show_head()
        self.refresh_catalogue()
        self.query_one(PagedTable).focus()
        if self._code is not None:
            self._ask_for(self._code)

    def _show_head(self) -> None:
        """Show the first rows in the first frame, where that takes no search."""
        catalogue = self.browser.catalogue
        if catalogue is not None and self.selection == Selection(self.selection.a):
            self.query_one(PagedTable).show(head_of(catalogue, self.selection, NAMES, _HEAD))

    def refresh_catalogue(self) -> None:
        """Look at the file again: at the beginning, and when something has been stored."""
        catalogue = self.browser.catalogue
        values = catalogue.a_values() if catalogue is not None else []
        self.set_class(not values and self.orbit is None, "-empty")
        if catalogue is None or not values:
            self._say_choices()
            return
        if self.selection.a not in values and self.orbit is None and self._code is None:
            self.selection = replace(self.selection, a=values[0])
        self._periods = [fill.p for fill in catalogue.fills(self.selection.a)]
        self._say_choices()
        self._reload()

    def watch_selection(self, old: Selection, selection: Selection) -> None:
        """Show the new subset."""
        if not self.is_mounted:
            return
        self.query_one(OrbitDrawing).a = selection.a
        if selection.a != old.a and self.browser.catalogue is not None:
            self._periods = [fill.p for fill in self.browser.catalogue.fills(selection.a)]
            self.orbit, self.compared = None, ()
        self._say_choices()
        self._reload()

    def watch_ordering(self) -> None:
        """Sort the subset."""
        if self.is_mounted:
            self._reload()

    def _say_choices(self) -> None:
        catalogue = self.browser.catalogue
        count = len(catalogue.a_values()) if catalogue is not None else 0
        self.query_one("#chips", Static).update(choices.chips(self.selection, count))
        self.sub_title = self.selection.describe()

    def _reload(self) -> None:
        if self.browser.catalogue is not None:
            table = self.query_one(PagedTable)
            table.border_title = "reading …" if self.ordering == table.ordering else "sorting …"
            self._read_rows(self.selection, self.ordering)

    @work(thread=True, exclusive=True, group="rows", exit_on_error=False)
    def _read_rows(self, selection: Selection, ordering: Ordering) -> None:
        from orbitdb.store.pages import Cancelled, chosen_keys

        worker = get_current_worker()
        catalogue = self.browser.catalogue
        assert catalogue is not None

        def cancelled() -> bool:
            return worker.is_cancelled

        try:
            index = self.browser.index(selection.a)
            keys = chosen_keys(catalogue, index, selection, ordering.column, ordering.descending, cancelled)
        except Cancelled:
            return
        except (InputError, StoreError) as error:
            if not worker.is_cancelled:
                self.post_message(self.Failed(str(error)))
            return
        if not worker.is_cancelled:
            self.post_message(self.RowsRead(Pages(catalogue, index, keys, NAMES), selection, ordering))

    def on_main_screen_rows_read(self, message: RowsRead) -> None:
        """Show the rows, with the cursor on the word where it was, if it is among them."""
        if (message.selection, message.ordering) != (self.selection, self.ordering):
            return
        table = self.query_one(PagedTable)
        table.ordering, table.border_title = message.ordering, "sequences"
        word = self._wanted or (table.row[0] if table.row else None)
        place = message.source.position(word) if word else None
        self._wanted = None
        if not len(message.source) and self.orbit is not None and self.orbit.stored:
            self.orbit = None
        table.show(message.source, place or 0)

    def on_main_screen_failed(self, message: Failed) -> None:
        """Say what went wrong."""
        self.query_one(PagedTable).border_title = "sequences"
        self.notify(message.reason, severity="error", markup=False)

    def on_paged_table_highlighted(self, message: PagedTable.Highlighted) -> None:
        """Show the orbit of the row, unless it is shown in another rotation or with its reverse."""
        table = self.query_one(PagedTable)
        if self._wanted is None and table.row is not None and table.row[0] == message.word:
            self._show_word(message.word)

    def _show_word(self, word: str, anew: bool = False) -> None:
        if not anew and self.orbit is not None and self.orbit.a == self.selection.a:
            shown = self.orbit.code
            if len(shown) == len(word) and least_rotation(shown) == word and self.orbit.stored:
                return
        self.orbit = self.browser.find(word, self.selection.a)

    def watch_orbit(self, orbit: Orbit | None) -> None:
        """Write what is known of the orbit."""
        if not self.is_mounted:
            return
        if orbit is None:
            self.query_one("#facts", Static).update("")
            return
        self.remove_class("-empty")
        certificate: Certificate = self.browser.certificate(orbit)
        self.query_one("#facts", Static).update(as_text(facts_of(orbit, certificate), "bold"))

    def action_back(self) -> None:
        """Show the row under the cursor as it is stored."""
        row = self.query_one(PagedTable).row
        if row is not None:
            self._show_word(row[0], anew=True)

    # moving in the class

    def action_move_in_class(self, element: int) -> None:
        """Show the image of the orbit under a mirror or time reversal."""
        if self.orbit is None:
            return
        word = images_of(self.orbit.code)[element]
        same = least_rotation(word) == least_rotation(self.orbit.code)
        self.notify(
            f"{self.orbit.code} is its own {_ELEMENTS[element].strip(',')}"
            if same
            else f"{_ELEMENTS[element].strip(',')}: {least_rotation(word)}",
            timeout=3,
            markup=False,
        )
        self._go_to(self.browser.find(word, self.orbit.a))

    def _go_to(self, orbit: Orbit) -> bool:
        """Show an orbit in its rotation, the cursor on its row; return whether it has one."""
        table = self.query_one(PagedTable)
        self.orbit = orbit
        word = least_rotation(orbit.code)
        place = table.source.position(word) if orbit.a == self.selection.a else None
        if place is not None:
            table.cursor = place
        elif isinstance(table.source, Head):
            self._wanted = word
            return True
        return place is not None

    def action_code(self) -> None:
        """Ask for a code in any rotation."""

        def take(code: str | None) -> None:
            if code:
                self._codes.append(code)
                self._ask_for(code)

        self.app.push_screen(
            LineDialog("code, in any rotation", "", "1232131 or 1^20(02)^5 3", _check_code, self._codes), take
        )

    def _ask_for(self, code: str) -> None:
        word = parse(code)
        root = primitive_root(word)
        if root != word:
            self.notify(f"{code} is {root} {len(word) // len(root)} times over", markup=False)
        self._find(root, self.selection.a)

    @work(thread=True, exclusive=True, group="find", exit_on_error=False)
    def _find(self, word: str, a: float) -> None:
        try:
            orbit = self.browser.find(word, a)
        except (InputError, StoreError) as error:
            self.post_message(self.Failed(str(error)))
            return
        self.post_message(self.OrbitFound(orbit))

    def on_main_screen_orbit_found(self, message: OrbitFound) -> None:
        """Show the orbit, and say where it comes from."""
        if self._go_to(message.orbit):
            return
        told = "it is not in the chosen subset" if message.orbit.stored else "not stored: solved on the spot"
        self.notify(told, timeout=4)

    # choosing

    def action_filter(self) -> None:
        """Edit the filter."""

        def take(where: str | None) -> None:
            if where is None:
                return
            if where and where not in self._history:
                self._history.append(where)
            self.selection = replace(self.selection, where=where or None)

        self.app.push_screen(
            LineDialog(
                "filter, as in --where",
                self.selection.where or "",
                "lambda_c < 0.5 and time_reversal = 'self'",
                self._check_filter,
                self._history,
            ),
            take,
        )

    def _check_filter(self, where: str) -> str:
        self.browser.check_filter(where, dict(self.selection.parameters))
        return replace(self.selection, where=where).describe()

    def action_status(self) -> None:
        """Choose the next status."""
        self.selection = choices.next_status(self.selection)

    def action_reversal(self) -> None:
        """Choose self-retracing orbits, the others, or all."""
        self.selection = choices.next_reversal(self.selection)

    def action_period(self, step: int) -> None:
        """Choose another period."""
        self.selection = choices.other_period(self.selection, self._periods, step)

    def action_choose_a(self) -> None:
        """Choose another stadium of the catalogue."""
        catalogue = self.browser.catalogue
        values = catalogue.a_values() if catalogue is not None else []

        def take(a: str | None) -> None:
            if a is not None:
                self.selection = replace(self.selection, a=float(a))

        if values:
            named = [(repr(a), f"a = {a:g}") for a in values]
            self.app.push_screen(ChoiceDialog("half length a", named, repr(self.selection.a)), take)

    def action_sort(self) -> None:
        """Choose the column to sort by."""
        named = [(column.name, column.heading) for column in COLUMNS]
        self.app.push_screen(ChoiceDialog("sort by", named, self.ordering.column), self._sort_by)

    def _sort_by(self, column: str | None) -> None:
        if column is not None:
            falls = column == self.ordering.column and not self.ordering.descending
            self.ordering = Ordering(column, falls)

    def action_reverse_order(self) -> None:
        """Turn the order round."""
        self.ordering = replace(self.ordering, descending=not self.ordering.descending)

    def on_paged_table_heading_clicked(self, message: PagedTable.HeadingClicked) -> None:
        """Sort by the column; again, the other way round."""
        self._sort_by(message.column)

    # looking

    def action_view(self) -> None:
        """Change between the stadium and phase space."""
        self.view = View.STADIUM if self.view is View.PHASE else View.PHASE

    def action_particle(self) -> None:
        """Send a particle along the orbit, or stop it."""
        self.view = View.STADIUM
        self.query_one(OrbitDrawing).toggle_particle()

    def action_compare(self) -> None:
        """Mark the orbit to be compared in phase space, or unmark it."""
        if self.orbit is None or self.orbit.coordinates is None:
            return
        others = tuple(orbit for orbit in self.compared if orbit.code != self.orbit.code)
        if len(others) == len(self.compared):
            others = (*others, self.orbit)[-_MOST_COMPARED + 1 :]
        self.compared = others
        self.notify(f"{len(others)} marked to compare; v shows phase space", timeout=2)

    def action_compare_none(self) -> None:
        """Unmark all."""
        self.compared = ()

    def action_copy(self) -> None:
        """Copy the word."""
        if self.orbit is not None:
            self.app.copy_to_clipboard(self.orbit.code)
            self.notify(f"copied {self.orbit.code}", timeout=2, markup=False)

    # computing and taking away

    def action_fill(self) -> None:
        """Open the fill dialog."""
        if not self.browser.writable():
            self.notify(f"{self.browser.path} is read-only: copy it, or name another file with --db")
            return
        top = max(self._periods, default=10) + 1
        self.app.push_screen(FillDialog(self.selection.a, f"2-{top}", self.browser.fill_state))

    def follow_fill(self, state: FillState) -> None:
        """Show how far a fill is."""
        self.query_one("#chips", Static).update(
            f"[b]{state.sentence()}[/b] │ {choices.chips(self.selection, 1)}"
        ) if state.runs else self._say_choices()

    def action_statistics(self) -> None:
        """Open the statistics of the chosen subset."""
        from orbitdb.cli.tui.statistics import StatisticsScreen

        if self.browser.catalogue is not None:
            self.app.push_screen(StatisticsScreen(self.browser.catalogue, self.selection))

    def action_export(self) -> None:
        """Ask for a file and write what is shown to it."""
        word = self.orbit.code[:40] if self.orbit is not None else ""

        def take(name: str | None) -> None:
            if name:
                self._write(Path(name).expanduser(), self.selection, self.ordering, self.orbit)

        self.app.push_screen(
            LineDialog("export to a file", f"{word or 'orbits'}.svg", "orbits.csv", _check_export), take
        )

    @work(thread=True, group="export", exit_on_error=False)
    def _write(self, path: Path, selection: Selection, ordering: Ordering, orbit: Orbit | None) -> None:
        from orbitdb.cli.tui.export import export

        try:
            told = export(path, self.browser.catalogue, selection, ordering, orbit)
        except (InputError, StoreError, OSError) as error:
            self.post_message(self.Failed(str(error)))
            return
        self.browser.tell(told)


def _check_code(code: str) -> str:
    word = primitive_root(parse(code))
    return f"p = {len(word)}, least rotation {least_rotation(word)[:60]}"


def _check_export(name: str) -> str:
    from orbitdb.cli.tui.export import kind_of

    path = Path(name).expanduser()
    told = kind_of(path)
    return f"{path} is there and will be replaced: {told}" if path.exists() else told


