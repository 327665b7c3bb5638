"""The main screen: keys, and what they do."""

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

from textual import work
from textual.binding import Binding, BindingType
from textual.widgets import Static

from orbitdb.cli.render import code_text
from orbitdb.cli.tui import choices
from orbitdb.cli.tui.dialogs.basic import ChoiceDialog, LineDialog
from orbitdb.cli.tui.dialogs.fill import FillDialog
from orbitdb.cli.tui.dialogs.filling import FillState
from orbitdb.cli.tui.dialogs.filter import FilterDialog
from orbitdb.cli.tui.dialogs.half_length import HalfLengthDialog
from orbitdb.cli.tui.dialogs.status import StatusDialog, Statuses
from orbitdb.cli.tui.keeping_screen import KeepingScreen
from orbitdb.cli.tui.orbit.drawing import OrbitDrawing, View
from orbitdb.cli.tui.orbit.facts import FactsPanel
from orbitdb.cli.tui.table.columns import EVERY
from orbitdb.cli.tui.table.paged_table import PagedTable
from orbitdb.cli.tui.table.source import Ordering
from orbitdb.errors import InputError, StoreError
from orbitdb.orbits.orbit import Orbit
from orbitdb.store.asking.codes import hint
from orbitdb.store.asking.confinement import CancelledError
from orbitdb.store.asking.expressions import names_in
from orbitdb.store.asking.selection import Selection
from orbitdb.symbols.symmetry import MIRROR_X, MIRROR_Y, REVERSE, images_of
from orbitdb.symbols.words import least_rotation, parse, primitive_root

if TYPE_CHECKING:
    from orbitdb.store.reading.catalogue import Catalogue

_MOST_COMPARED = 6
_ELEMENTS = {REVERSE: "time reverse", MIRROR_X: "mirror image left to right",
             MIRROR_Y: "mirror image upside down"}  # fmt: skip


class MainScreen(KeepingScreen):
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
    ]

    def __init__(self, selection: Selection, code: str | None = None) -> None:
        super().__init__(selection, code)
        self._history: list[str] = [selection.where] if selection.where else []
        self._codes: list[str] = []
        self._values = dict(selection.parameters)

    # moving in the class

    def action_move_in_class(self, element: int) -> None:
        """Show the image of the orbit under a mirror or time reversal."""
        self.catch_up()
        if self.orbit is None:
            return
        word = images_of(self.orbit.code)[element]
        same = least_rotation(word) == least_rotation(self.orbit.code)
        name = _ELEMENTS[element]
        told = f"its own {name}" if same else f"{name} of {self.orbit.code[:20]}"
        self.go_to(self.browser.find_at(word, self.orbit.a, self.orbit.exists))
        self.query_one(FactsPanel).border_title = told

    def action_code(self) -> None:
        """Ask for a code in any rotation."""

        def take(code: str | None) -> None:
            if code:
                self._codes.append(code)
                self.ask_for(code)

        self.app.push_screen(
            LineDialog("code, in any rotation", "", "1232131 or 1^20(02)^5 3", _check_code, self._codes), take
        )

    # choosing

    def action_filter(self) -> None:
        """Edit the filter; the rows follow as it is typed, and come back if it is left."""
        row, before = self.query_one(PagedTable).row, self.selection.where
        word = row[0] if row and self.query_one(PagedTable).cursor else None

        def attempt(where: str | None) -> None:
            if (where or None) != self.selection.where:
                self._wanted = word
                self.selection = self._filtered(where or None)
            else:
                self.go_on_reading()

        def take(where: str | None) -> None:
            attempt(before if where is None else where)
            if where and where not in self._history:
                self._history.append(where)

        dialog = FilterDialog(
            before or "", self._check_filter, self.stop_reading, attempt, self, self._history
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

        def take(statuses: Statuses | None) -> None:
            if statuses is not None:
                self.selection = replace(self.selection, statuses=statuses)

        self.app.push_screen(StatusDialog(self.selection.statuses), take)

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

    # looking

    def action_view(self) -> None:
        """Change between the stadium and phase space."""
        self.view = View.STADIUM if self.view is View.PHASE else View.PHASE

    def action_particle(self) -> None:
        """Send a particle along the orbit, or stop it."""
        self.view = View.STADIUM
        self.query_one(OrbitDrawing).toggle_particle()

    def action_whole(self) -> None:
        """Open all that is known of the orbit."""
        self.catch_up()
        if self.orbit is not None:
            from orbitdb.cli.tui.orbit.whole_orbit import WholeOrbitScreen

            self.app.push_screen(WholeOrbitScreen(self.orbit))

    def action_compare(self) -> None:
        """Compare the orbit in phase space, or no longer."""
        self.catch_up()
        if self.orbit is None or self.orbit.coordinates is None:
            return
        others = tuple(orbit for orbit in self.compared if orbit.code != self.orbit.code)
        if len(others) == len(self.compared):
            others = (*others, self.orbit)[-_MOST_COMPARED + 1 :]
        self.compared = others
        self.notify(f"{len(others)} to compare; v shows phase space", timeout=2)

    def action_compare_none(self) -> None:
        """Compare none."""
        self.compared = ()

    def action_copy(self) -> None:
        """Copy the word."""
        self.catch_up()
        if self.orbit is not None:
            self.app.copy_to_clipboard(self.orbit.code)
            self.notify(f"copied {self.orbit.code}", timeout=2)

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
        if not self.periods and not len(self.query_one(PagedTable).source):
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
            self.post_message(self.Failed(str(error)))
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
