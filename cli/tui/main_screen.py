"""The main screen: keys and their actions."""

import os
from collections.abc import Callable
from dataclasses import replace
from typing import ClassVar

from textual.binding import Binding
from textual.screen import Screen

from orbitdb.cli.tui import choices
from orbitdb.cli.tui.dialogs.fill import FillDialog
from orbitdb.cli.tui.dialogs.lines import FilterDialog, LineDialog
from orbitdb.cli.tui.dialogs.lists import ChoiceDialog, MarksDialog, Names
from orbitdb.cli.tui.keeping import Keeping
from orbitdb.cli.tui.orbit.drawing import OrbitDrawing
from orbitdb.cli.tui.orbit.facts import FactsPanel
from orbitdb.cli.tui.orbit.whole_orbit import WholeOrbitScreen
from orbitdb.cli.tui.screens import Keys, bindings, key
from orbitdb.cli.tui.table.columns import EVERY
from orbitdb.cli.tui.table.paged_table import PagedTable
from orbitdb.cli.tui.table.pages import Ordering
from orbitdb.numerals import exact
from orbitdb.orbits.status import Status
from orbitdb.store.asking.selection import Selection
from orbitdb.symbols.enumeration import MAX_PERIOD
from orbitdb.symbols.symmetry import MIRROR_X, MIRROR_Y, REVERSE, images_of
from orbitdb.symbols.words import least_rotation

_MOST_COMPARED = 6
_ELEMENTS = {REVERSE: "time reverse", MIRROR_X: "mirror image left to right",
             MIRROR_Y: "mirror image upside down"}  # fmt: skip


class MainScreen(Keeping):
    """Look at orbits and choose them."""

    KEYS: ClassVar[Keys] = {
        "moving": [
            key("0", "jump('0')", tooltip="go to a period or code", key_display="0 .. 9"),
            *(key(digit, f"jump('{digit}')") for digit in "123456789"),
            key("backspace", "jump_back", tooltip="take back a digit"),
            Binding("c", "code", "code", tooltip="go to any code"),
        ],
        "its symmetry class": [
            key("T,t", f"move_in_class({REVERSE})", "time reverse"),
            key("X,x", f"move_in_class({MIRROR_X})", "mirror left and right"),
            key("Y", f"move_in_class({MIRROR_Y})", "mirror up and down"),
            key("escape", "back", "back to the row"),
        ],
        "looking": [
            key("enter", "whole", "the whole orbit"),
            key("space", "particle", "run a particle, or stop it"),
            Binding("v", "view", "view", tooltip="stadium or phase space"),
            key("less_than_sign", "follow(False)", "follow the orbit to a smaller a"),
            key("greater_than_sign", "follow(True)", "follow the orbit to a greater a"),
            key("m", "compare", "compare in phase space, or not"),
            key("M", "compare_none", "compare none"),
            Binding("S", "statistics", "stats", tooltip="averages by period"),
            Binding("d", "counts", "counts", tooltip="counts and histograms"),
        ],
        "choosing": [
            Binding("slash", "filter", "filter", tooltip="filter, as with --where"),
            key("o", "status", "next status"),
            key("O", "statuses", "statuses from a list"),
            key("r", "reversal", "self-retracing, or not"),
            key("right_square_bracket", "period(1)", "next period"),
            key("left_square_bracket", "period(-1)", "previous period"),
            key("a", "choose_a", "another a"),
            Binding("s", "sort", "sort", tooltip="sort by a column"),
            key("R", "reverse_order", "reverse the order"),
            key("C", "columns", "choose the columns"),
        ],
        "keeping": [
            key("asterisk", "mark", "mark the orbit, or unmark it"),
            key("apostrophe", "marked", "marked orbits only"),
            key("F", "filters", "filters kept by name"),
            key("y", "copy", "copy the code"),
            Binding("e", "export", "export", tooltip="export to a file"),
        ],
        "orbitdb": [
            Binding("f", "fill", "fill", tooltip="fill the catalogue"),
            key("ctrl+r,f5", "look_again", "read the file again", key_display="ctrl+r"),
        ],
    }
    BINDINGS = bindings(KEYS)

    def __init__(self, selection: Selection, code: str | None = None) -> None:
        super().__init__(selection, code)
        self._filters: list[str] = [selection.where] if selection.where else []
        self._codes: list[str] = []

    # moving

    def action_jump(self, digit: str) -> None:
        """Go to a period or a code by typing digits."""
        self.rows.jumping.type(digit)

    def action_jump_back(self) -> None:
        """Take the last digit back."""
        self.rows.jumping.take_back()

    def action_follow(self, up: bool) -> None:
        """Follow the orbit to a greater or smaller a, past its births and deaths."""
        if self.shown_orbit() is not None:
            self.following.step(up)

    def action_move_in_class(self, element: int) -> None:
        """Show the image of the orbit under a mirror or time reversal."""
        if (orbit := self.shown_orbit()) is None:
            return
        word = images_of(orbit.code)[element]
        same = least_rotation(word) == least_rotation(orbit.code)
        name = _ELEMENTS[element]
        self.go_to(replace(self.browser.find(word, orbit.a), exists=orbit.exists))
        told = f"its own {name}" if same else f"{name} of {orbit.code[:20]}"
        self.query_one(FactsPanel).border_title = told

    def action_code(self) -> None:
        """Ask for a code in any rotation."""

        def take(code: str) -> None:
            self._codes.append(code)
            self.ask_for(code)

        title, example = "code, in any rotation", "1232131 or 1^20(02)^5 3"
        self.ask(LineDialog(title, "", example, choices.code_told, self._codes), take)

    def action_next(self, steps: int) -> None:
        """Go to another row, wherever the focus is."""
        self.rows.table.action_move(steps)

    # choosing

    def action_filter(self) -> None:
        """Edit the filter; the rows follow the typing, and return on escape."""
        before = self.selection.where or ""
        dialog = FilterDialog(self, before, self._filters)

        def take(where: str | None) -> None:
            self.try_filter(before if where is None else where, dialog.word)
            if where:
                self._filters.append(where)

        self.app.push_screen(dialog, take)

    def action_status(self) -> None:
        """Choose the next status."""
        self.selection = choices.turned(self.selection, "statuses", choices.STATUSES)

    def action_statuses(self) -> None:
        """Pick statuses from a list."""

        def take(statuses: Names) -> None:
            self.selection = replace(self.selection, statuses=tuple(map(Status, statuses)))

        hint = "space marks, enter takes; none marked: every status"
        texts = {status.value: status.sentence for status in choices.SHOWN}
        self.ask(MarksDialog("statuses", hint, texts, self.selection.statuses), take)

    def action_reversal(self) -> None:
        """Choose self-retracing orbits, the others, or all."""
        self.selection = choices.turned(self.selection, "time_reversal", choices.REVERSALS)

    def action_period(self, step: int) -> None:
        """Choose the next or previous period; beyond the ends, all periods."""
        ring = ((), *(((p, p),) for p in self.periods))
        self.selection = choices.turned(self.selection, "periods", ring, step)

    def action_choose_a(self, stay: bool = False) -> None:
        """Choose another a, stored or not, and optionally stay with the current word."""
        values = [repr(a) for a in self.browser.a_values()]

        def check(text: str) -> str:
            filled = repr(choices.half_length(text)) in values
            return "filled" if filled else "nothing is filled there: f fills it, c solves a code"

        def take(a: str) -> None:
            shown = self.orbit
            self.selection = replace(self.selection, a=choices.half_length(a))
            if stay and shown is not None:
                self.following.come_back()
                self.ask_for(shown.code)

        self.ask(LineDialog("half length a", repr(self.selection.a), "such as 1.6", check, values), take)

    def action_sort(self) -> None:
        """Choose the column to sort by."""
        every = dict.fromkeys((*self.columns, *EVERY.values()))
        named = {column.name: column.name for column in every}
        self.ask(ChoiceDialog("sort by", "", named, self.ordering.column), self._sort_by)

    def _sort_by(self, column: str) -> None:
        falls = column == self.ordering.column and not self.ordering.descending
        self.ordering = Ordering(column, falls)

    def action_reverse_order(self) -> None:
        """Reverse the order."""
        self.ordering = replace(self.ordering, descending=not self.ordering.descending)

    def on_paged_table_heading_clicked(self, message: PagedTable.HeadingClicked) -> None:
        """Sort by the column; a second click reverses the order."""
        self._sort_by(message.column)

    # looking

    def action_view(self) -> None:
        """Change between the stadium and phase space."""
        self.query_one(OrbitDrawing).toggle_phase()
        if self.has_class("-empty"):  # the greeting is shown instead
            self.shown_orbit()

    def action_particle(self) -> None:
        """Send a particle along the orbit, or stop it."""
        self.query_one(OrbitDrawing).toggle_particle()

    def action_whole(self) -> None:
        """Open all facts about the orbit."""
        if (orbit := self.shown_orbit()) is not None:
            self.app.push_screen(WholeOrbitScreen(self, orbit))

    def action_compare(self) -> None:
        """Add the orbit to the comparison in phase space, or remove it."""
        if (orbit := self.shown_orbit()) is None:
            return
        if orbit.coordinates is None:
            self.notify("only orbits have bounces to compare", timeout=2)
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
        """Copy the code."""
        if (orbit := self.shown_orbit()) is not None:
            self.app.copy_to_clipboard(orbit.code)
            self.notify(f"copied {orbit.code}", timeout=2)

    # computing and taking away

    def action_fill(self) -> None:
        """Open the fill dialog."""
        path = self.browser.path
        if path.exists() and not (os.access(path, os.W_OK) and os.access(path.parent, os.W_OK)):
            self.notify(f"{path} is read-only: copy it, or name another file with --db")
            return
        wanted = [high for _, high in self.selection.periods if high not in self.periods]
        top = min(max(wanted, default=max(self.periods, default=10) + 1), MAX_PERIOD)
        self.app.push_screen(FillDialog(exact(self.selection.a), f"2-{top}"))

    def go_along(self, a: float) -> None:
        """Switch to the a being filled, if there is nothing at the current one."""
        if not self.periods and not len(self.rows.table.source):
            self.selection = replace(self.selection, a=a)

    def action_statistics(self) -> None:
        """Open the statistics of the chosen subset."""
        from orbitdb.cli.tui.statistics.statistics_screen import StatisticsScreen

        self._open(StatisticsScreen)

    def action_counts(self) -> None:
        """Open the counts of the chosen subset; the histogram is that of the column it is sorted by."""
        from orbitdb.cli.tui.statistics.counts_screen import CountsScreen

        self._open(CountsScreen, "length" if self.ordering == Ordering() else self.ordering.column)

    def _open(self, screen: Callable[..., Screen[None]], *more: str) -> None:
        """Open a screen on the stored data, or say that there is none yet."""
        if self.browser.catalogue is None:
            self.notify("nothing is stored yet: the key f fills the catalogue")
        else:
            self.app.push_screen(screen(self.browser.catalogue, self.selection, *more))

    def action_export(self, of_orbit: bool = False) -> None:
        """Ask for a file and export the shown data to it."""
        from orbitdb.cli.tui.export import ask_for_file, export

        self.catch_up()
        orbit, of_rows = self.orbit, self.rows.table.has_focus and not of_orbit
        name = "orbits.csv" if orbit is None or of_rows else f"{orbit.code[:40]}.svg"
        drawing = self.query_one(OrbitDrawing)
        in_phase_space = drawing.in_phase_space() if drawing.phase and not of_orbit else []
        shown = self.browser.catalogue, self.selection, self.ordering, orbit
        ask_for_file(
            self,
            name,
            lambda path: export(path, *shown, lambda: self.browser.leaving, in_phase_space),
            "the bounces in phase space" if in_phase_space else "the orbit in its stadium",
            rows=True,
        )
