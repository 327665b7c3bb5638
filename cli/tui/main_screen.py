"""The main screen: keys, and what they do."""

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

from textual import work
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.widgets import Static

from orbitdb.cli.render import code_text
from orbitdb.cli.tui import choices
from orbitdb.cli.tui.dialogs.basic import ChoiceDialog, LineDialog
from orbitdb.cli.tui.dialogs.fill import FillDialog
from orbitdb.cli.tui.dialogs.filling import FillState
from orbitdb.cli.tui.dialogs.filter import FilterDialog
from orbitdb.cli.tui.dialogs.half_length import HalfLengthDialog
from orbitdb.cli.tui.dialogs.marks import MarksDialog, Names
from orbitdb.cli.tui.keeping import Keeping
from orbitdb.cli.tui.orbit.drawing import OrbitDrawing, View
from orbitdb.cli.tui.orbit.facts import FactsPanel
from orbitdb.cli.tui.panels import Panels
from orbitdb.cli.tui.screens import Failed
from orbitdb.cli.tui.table.columns import EVERY, chosen
from orbitdb.cli.tui.table.paged_table import PagedTable
from orbitdb.cli.tui.table.source import Ordering
from orbitdb.errors import InputError, StoreError
from orbitdb.orbits.orbit import Orbit, Status
from orbitdb.store.asking.codes import hint
from orbitdb.store.asking.confinement import CancelledError
from orbitdb.store.asking.expressions import names_in
from orbitdb.store.asking.selection import Selection
from orbitdb.symbols.symmetry import MIRROR_X, MIRROR_Y, REVERSE, images_of
from orbitdb.symbols.words import least_rotation, parse, primitive_root

if TYPE_CHECKING:
    from orbitdb.catalogue.catalogue import Catalogue

_MOST_COMPARED = 6
_ELEMENTS = {REVERSE: "time reverse", MIRROR_X: "mirror image left to right",
             MIRROR_Y: "mirror image upside down"}  # fmt: skip


class MainScreen(Panels):
    """Look at orbits and choose them."""

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("slash", "filter", "filter", key_display="/"),
        Binding("c", "code", "code"),
        Binding("s", "sort", "sort"),
        Binding("v", "view", "view"),
        Binding("space", "particle", "run a particle", show=False),
        Binding(
            "less_than_sign", "follow(False)", "smaller a, the orbit followed", show=False, key_display="<"
        ),
        Binding(
            "greater_than_sign", "follow(True)", "greater a, the orbit followed", show=False, key_display=">"
        ),
        Binding("enter", "whole", "the whole orbit", show=False),
        Binding("f", "fill", "fill"),
        Binding("S", "statistics", "stats"),
        Binding("d", "counts", "counts"),
        Binding("e", "export", "export"),
        Binding("y", "copy", "copy the word", show=False),
        Binding("o", "status", "status: all, orbits, pruned ..", show=False),
        Binding("O", "statuses", "statuses from a list", show=False),
        Binding("r", "reversal", "self-retracing or not", show=False),
        Binding("right_square_bracket", "period(1)", "next period", show=False, key_display="]"),
        Binding("left_square_bracket", "period(-1)", "period before", show=False, key_display="["),
        Binding("a", "choose_a", "another a", show=False),
        Binding("ctrl+r,f5", "look_again", "read the file again", show=False, key_display="ctrl+r"),
        Binding("R", "reverse_order", "turn the order round", show=False),
        Binding("T,t", f"move_in_class({REVERSE})", "time reverse", show=False),
        Binding("X,x", f"move_in_class({MIRROR_X})", "mirror left and right", show=False),
        Binding("Y", f"move_in_class({MIRROR_Y})", "mirror up and down", show=False),
        Binding("m", "compare", "compare in phase space, or not", show=False),
        Binding("M", "compare_none", "compare none", show=False),
        Binding("escape", "back", "back to the row", show=False),
        Binding("C", "columns", "columns", show=False),
        Binding("asterisk", "mark", "mark the orbit, or unmark it", show=False, key_display="*"),
        Binding("apostrophe", "marked", "marked orbits only", show=False, key_display="'"),
        Binding("F", "filters", "filters kept by name", show=False),
        *(Binding(digit, f"jump('{digit}')", show=False) for digit in "0123456789"),
        Binding("backspace", "jump_back", show=False),
    ]

    def __init__(self, selection: Selection, code: str | None = None) -> None:
        super().__init__(selection, code)
        self._history: list[str] = [selection.where] if selection.where else []
        self._codes: list[str] = []
        self._values = dict(selection.parameters)
        self.keeping = Keeping(self)

    def compose(self) -> ComposeResult:
        """Lay out the panels, with the columns and marks that were kept."""
        state = self.keeping.load()
        self.set_reactive(Panels.columns, chosen(state.columns))
        self.set_reactive(Panels.marked, frozenset(state.marked))
        yield from super().compose()

    # moving

    def action_jump(self, digit: str) -> None:
        """Go to a period, or to a code, by digits that are typed one after the other."""
        self.rows.jumping.type(digit)

    def action_jump_back(self) -> None:
        """Take the last digit back."""
        self.rows.jumping.take_back()

    def _shown(self) -> Orbit | None:
        """Return the orbit on show, or say that there is none."""
        self.catch_up()
        if self.orbit is None:
            self.notify("no orbit is shown: c asks for one by its code", timeout=2)
        return self.orbit

    def action_follow(self, up: bool) -> None:
        """Follow the orbit to a greater or smaller a, past its births and deaths."""
        if self._shown() is not None:
            self.following.step(up)

    def action_move_in_class(self, element: int) -> None:
        """Show the image of the orbit under a mirror or time reversal."""
        orbit = self._shown()
        if orbit is None:
            return
        word = images_of(orbit.code)[element]
        same = least_rotation(word) == least_rotation(orbit.code)
        name = _ELEMENTS[element]
        told = f"its own {name}" if same else f"{name} of {orbit.code[:20]}"
        self.search.go_to(self.browser.find_at(word, orbit.a, orbit.exists))
        self.query_one(FactsPanel).border_title = told

    def action_code(self) -> None:
        """Ask for a code in any rotation."""

        def take(code: str | None) -> None:
            if code:
                self._codes.append(code)
                self.search.ask_for(code)

        self.app.push_screen(
            LineDialog("code, in any rotation", "", "1232131 or 1^20(02)^5 3", _check_code, self._codes), take
        )

    # choosing

    def action_filter(self) -> None:
        """Edit the filter; the rows follow as it is typed, and come back if it is left."""
        row, before = self.rows.table.row, self.selection.where
        word = row[0] if row and self.rows.table.cursor else None

        def attempt(where: str | None) -> None:
            if (where or None) != self.selection.where:
                self.wanted = word
                self.selection = self._filtered(where or None)
            elif self.rows.stopped:  # read it after all
                self.read()

        def take(where: str | None) -> None:
            attempt(before if where is None else where)
            if where and where not in self._history:
                self._history.append(where)

        dialog = FilterDialog(
            before or "", self._check_filter, self.rows.stop_reading, attempt, self.rows, self._history
        )
        self.app.push_screen(dialog, take)

    def _check_filter(self, where: str) -> str:
        self.browser.check_filter(where, dict(self._filtered(where).parameters))
        return hint(where) or ""

    def _filtered(self, where: str | None) -> Selection:
        """Return what is chosen with another filter; of the values given with -P, those it names."""
        used = names_in(where or "")
        known = self._values | dict(self.selection.parameters)
        values = {name: value for name, value in known.items() if name in used}
        return replace(self.selection, where=where, parameters=values)

    def action_status(self) -> None:
        """Choose the next status."""
        self.selection = choices.next_status(self.selection)

    def action_statuses(self) -> None:
        """Pick statuses from a list."""

        def take(statuses: Names | None) -> None:
            if statuses is not None:
                self.selection = replace(self.selection, statuses=tuple(map(Status, statuses)))

        hint = "space marks, enter takes; none marked: every status"
        texts = {status.value: status.sentence for status in choices.SHOWN}
        self.app.push_screen(MarksDialog("statuses", hint, texts, self.selection.statuses), take)

    def action_reversal(self) -> None:
        """Choose self-retracing orbits, the others, or all."""
        self.selection = choices.next_reversal(self.selection)

    def action_period(self, step: int) -> None:
        """Choose another period."""
        self.selection = choices.other_period(self.selection, self.periods, step)

    def action_choose_a(self) -> None:
        """Choose another stadium: one of the catalogue, or any."""
        catalogue = self.browser.catalogue
        values = catalogue.a_values() if catalogue is not None else []

        def take(a: str | None) -> None:
            if a is not None:
                self.selection = replace(self.selection, a=float(a))

        self.app.push_screen(HalfLengthDialog(values, self.selection.a), take)

    def action_sort(self) -> None:
        """Choose the column to sort by."""
        every = dict.fromkeys((*self.columns, *EVERY.values()))
        named = [(column.name, column.heading) for column in every]
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

    # keeping

    def action_columns(self) -> None:
        """Choose the columns of the table."""
        self.keeping.ask_for_columns()

    def action_mark(self) -> None:
        """Mark the orbit, or unmark it."""
        if (orbit := self._shown()) is not None:
            self.keeping.mark(orbit)

    def action_marked(self) -> None:
        """Show the marked orbits only, or what was shown before."""
        self.keeping.show_marked()

    def action_filters(self) -> None:
        """Take a filter that was kept, or keep the present one."""
        self.keeping.ask_for_filter()

    # looking

    def action_view(self) -> None:
        """Change between the stadium and phase space."""
        self.view = View.STADIUM if self.view is View.PHASE else View.PHASE
        if self.has_class("-empty"):  # the greeting is in its place
            self._shown()

    def action_particle(self) -> None:
        """Send a particle along the orbit, or stop it."""
        self.view = View.STADIUM
        self.query_one(OrbitDrawing).toggle_particle()

    def action_whole(self) -> None:
        """Open all that is known of the orbit."""
        if (orbit := self._shown()) is not None:
            from orbitdb.cli.tui.orbit.whole_orbit import WholeOrbitScreen

            self.app.push_screen(WholeOrbitScreen(orbit))

    def action_compare(self) -> None:
        """Compare the orbit in phase space, or no longer."""
        orbit = self._shown()
        if orbit is None:
            return
        if orbit.coordinates is None:
            self.notify("it has no bounces to compare: only orbits do", timeout=2)
            return
        others = tuple(other for other in self.compared if other.code != orbit.code)
        if len(others) == len(self.compared):
            others = (*others, orbit)[-_MOST_COMPARED + 1 :]
        self.compared = others
        self.notify(f"{len(others)} to compare; v shows phase space", timeout=2)

    def action_compare_none(self) -> None:
        """Compare none."""
        self.compared = ()

    def action_copy(self) -> None:
        """Copy the word."""
        if (orbit := self._shown()) is not None:
            self.app.copy_to_clipboard(orbit.code)
            self.notify(f"copied {orbit.code}", timeout=2)

    # computing and taking away

    def action_look_again(self) -> None:
        """Show what other processes have stored meanwhile."""
        self.browser.look_again()

    def action_fill(self) -> None:
        """Open the fill dialog."""
        if not self.browser.writable():
            self.notify(f"{self.browser.path} is read-only: copy it, or name another file with --db")
            return
        from orbitdb.numerals import exact
        from orbitdb.symbols.enumeration import MAX_PERIOD

        wanted = [high for _, high in self.selection.periods if high not in self.periods]
        top = min(max(wanted, default=max(self.periods, default=10) + 1), MAX_PERIOD)
        dialog = FillDialog(self.browser.path, exact(self.selection.a), f"2-{top}", self.browser.fill_state)
        self.app.push_screen(dialog)

    def go_along(self, a: float) -> None:
        """Look at the stadium that is being filled, if there is nothing at the one that is shown."""
        if not self.periods and not len(self.rows.table.source):
            self.selection = replace(self.selection, a=a)

    def follow_fill(self, state: FillState) -> None:
        """Show how far a fill is."""
        self.query_one("#chips", Static).update(
            f"[b]{state.sentence()}[/b] │ {choices.chips(self.selection, 1)}"
        ) if state.runs else self.say_choices()

    def _what_is_stored(self) -> "Catalogue | None":
        """Return the catalogue, or say that there is none yet."""
        if self.browser.catalogue is None:
            self.notify("nothing is stored yet: the key f fills the catalogue")
        return self.browser.catalogue

    def action_statistics(self) -> None:
        """Open the statistics of the chosen subset."""
        from orbitdb.cli.tui.statistics.averages_screen import StatisticsScreen

        if (catalogue := self._what_is_stored()) is not None:
            self.app.push_screen(StatisticsScreen(catalogue, self.selection))

    def action_counts(self) -> None:
        """Open the counts of the chosen subset; the histogram is that of the column it is sorted by."""
        from orbitdb.cli.tui.statistics.counts_screen import CountsScreen

        if (catalogue := self._what_is_stored()) is not None:
            column = "length" if self.ordering == Ordering() else self.ordering.column
            self.app.push_screen(CountsScreen(catalogue, self.selection, column))

    def action_export(self) -> None:
        """Ask for a file and write what is shown to it."""
        self.catch_up()
        word = self.orbit.code[:40] if self.orbit is not None else ""

        def take(name: str | None) -> None:
            if name:
                self._write(Path(name).expanduser(), self.selection, self.ordering, self.orbit)

        self.app.push_screen(
            LineDialog(
                "export to a file", f"{word or 'orbits'}.svg", "orbits.csv, .parquet ..", _check_export
            ),
            take,
        )

    @work(thread=True, group="export")
    def _write(self, path: Path, selection: Selection, ordering: Ordering, orbit: Orbit | None) -> None:
        from orbitdb.cli.tui.export import export

        self.browser.take_in_hand()
        try:
            told = export(
                path, self.browser.catalogue, selection, ordering, orbit, lambda: self.browser.leaving
            )
        except CancelledError:
            return
        except (InputError, StoreError, OSError) as error:
            self.post_message(Failed(str(error)))
            return
        self.browser.tell(told)


def _check_code(code: str) -> str:
    word = primitive_root(parse(code))
    return f"p = {len(word)}, least rotation {code_text(least_rotation(word))}"


def _check_export(name: str) -> str:
    from orbitdb.cli.tui.export import kind_of

    path = Path(name).expanduser()
    told = kind_of(path)
    return f"{path} is there and will be replaced: {told}" if path.exists() else told
