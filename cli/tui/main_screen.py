"""The main screen: the chosen subset as a table, and the orbit under the cursor."""

import os
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import ClassVar

from textual import events
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Horizontal
from textual.reactive import reactive

from orbitdb.catalogue import Catalogue
from orbitdb.cli.output import code_text
from orbitdb.cli.tui.dialogs import FilterDialog
from orbitdb.cli.tui.fill_dialog import FillDialog
from orbitdb.cli.tui.greeting import Greeting
from orbitdb.cli.tui.help import KeysLine, purpose
from orbitdb.cli.tui.panels.drawing import OrbitDrawing
from orbitdb.cli.tui.panels.facts import FactsPanel
from orbitdb.cli.tui.panels.filter_bar import FilterBar, View, equals
from orbitdb.cli.tui.panels.orbit_panel import OrbitPanel
from orbitdb.cli.tui.panels.paged_table import PagedTable
from orbitdb.cli.tui.panels.rows_panel import RowsPanel
from orbitdb.cli.tui.screens import OwnScreen, TopLine, key
from orbitdb.cli.tui.stored import Kept, begun_periods, stamp_of
from orbitdb.errors import InputError
from orbitdb.orbits.orbit import Orbit
from orbitdb.selection import Selection
from orbitdb.symbols.symmetry import MIRROR_X, MIRROR_Y, REVERSE
from orbitdb.symbols.words import least_rotation
from orbitdb.text import format_float

_SECONDS_BETWEEN_LOOKS = 2.0
_BRIEF = 28
"""Columns of the progress of a fill above the rows, beside the choices."""


def _to(part: str, action: str) -> str:
    return f"to({part!r}, {action!r})"


class MainScreen(OwnScreen[None]):
    """The main screen: the rows of the chosen subset, beside the current orbit.

    The orbit follows the cursor (`RowsPanel.word`), and the cursor goes to an orbit that was asked for
    (`OrbitPanel.sought`). If that orbit has no row, it stays until the cursor moves.
    """

    BINDINGS: ClassVar[list[BindingType]] = [
        *purpose(
            "move",
            key("n", _to("table", "move(1)"), "next orbit"),
            key("p", _to("table", "move(-1)"), "previous orbit"),
            key("escape", "back", "return to the orbit of the row"),
            Binding("q", "back(True)", "back", tooltip="return to the rows"),
        ),
        *purpose(
            "orbit",
            Binding("c", _to("side", "code"), "code", tooltip="look up a code, stored or not"),
            Binding("enter", "whole", "facts", tooltip="all facts about this orbit", key_display="enter"),
            Binding("enter", "back(True)", "back", tooltip="return to the rows", key_display="enter"),
            key("v", _to("side", "draw('view')"), "switch between stadium and phase space"),
            key("P", _to("side", "pair"), "draw the marked orbit, or the reverse, too"),
            key("space", _to("side", "draw('particle')"), "start or stop the particle"),
            key("T,t", _to("side", f"move_in_class({REVERSE})"), "reverse the orbit in time"),
            key("X,x", _to("side", f"move_in_class({MIRROR_X})"), "mirror the orbit left-right"),
            key("Y", _to("side", f"move_in_class({MIRROR_Y})"), "mirror the orbit up-down"),
            key("less_than_sign", _to("side", "follow(False)"), "follow the orbit to a smaller a"),
            key("greater_than_sign", _to("side", "follow(True)"), "follow the orbit to a larger a"),
            key("comma", _to("side", "follow(False, True)"), "follow it down to a birth or death"),
            key("full_stop", _to("side", "follow(True, True)"), "follow it up to a birth or death"),
            key("y", _to("side", "copy"), "copy the code"),
            key("asterisk", "mark", "mark the orbit, or remove its mark"),
        ),
        *purpose(
            "choose rows",
            key("a", _to("chips", "half_length"), "change a"),
            key("right_square_bracket", _to("chips", "turn('periods', 1)"), "show the next period"),
            key("left_square_bracket", _to("chips", "turn('periods', -1)"), "show the previous period"),
            key("o", _to("chips", "turn('statuses', 1)"), "show the next status"),
            key("O", _to("chips", "statuses"), "choose statuses from a list"),
            key("r", _to("chips", "turn('time_reversal', 1)"), "step through reversal: self, pairs, all"),
            Binding("slash", _to("chips", "filter"), "filter", tooltip="filter the rows, as with --where"),
            key("equals_sign", "filter_value", "filter by the value under the cursor"),
            key("apostrophe", _to("chips", "marked"), "show only the marked orbits, or all"),
            key("u", "past_view", "undo the last change of the rows or columns"),
            key("K", _to("rows", "classes"), "show one row a class, or every word"),
            Binding("s", _to("rows", "sort"), "sort", tooltip="sort by the column under the cursor"),
            key("R", _to("rows", "sort(True)"), "sort by it in descending order"),
            key("C", _to("rows", "columns"), "choose columns"),
        ),
        *purpose(
            "other",
            Binding("S", "statistics", "stats", tooltip="averages over the chosen orbits by period"),
            Binding("d", "counts", "counts", tooltip="counts, and a histogram of this column"),
            key("E", "copy_view", "copy the view as a command, or as Python"),
            Binding("e", "export", "save", tooltip="save the rows or the picture to a file"),
            Binding("f", "fill", "fill", tooltip="fill the catalogue"),
            key("ctrl+r,f5", "look_again", "read the file again"),
        ),
    ]

    whole: reactive[bool] = reactive(False, init=False, repaint=False, bindings=True, toggle_class="-whole")

    def __init__(self, catalogue: Catalogue, kept: Kept, selection: Selection, code: str | None) -> None:
        super().__init__()
        kept.load()
        self._catalogue, self._kept, self._code = catalogue, kept, code
        self.choices = FilterBar(catalogue, kept, selection)
        self.rows = RowsPanel(catalogue, kept)
        self.side = OrbitPanel(catalogue, kept, selection.a)
        self._stamp: tuple[int, ...] = ()
        self._lacking: tuple[int, ...] = ()  # the file when it last lacked a row
        self._filled: list[int] = []  # the periods filled at this a when last asked
        self._view = self.view
        self._past: list[View] = []
        self._word: str | None = None  # the word under the cursor before a filter was typed

    def compose(self) -> ComposeResult:
        yield TopLine()
        yield self.choices
        with Horizontal(id="body"):
            yield self.rows
            yield self.side
        yield Greeting()
        yield KeysLine()

    def on_mount(self) -> None:
        self.watch(self.choices, "selection", self._take_selection, init=False)
        self.watch(self.choices, "trying", self._take_trying, init=False)
        self.watch(self.rows, "ordering", self._remember, init=False)
        self.watch(self.rows, "columns", self._remember, init=False)
        self.watch(self.rows, "by_class", self._remember, init=False)
        self.watch(self.rows, "report", self._say_report, init=False)
        self.watch(self.rows, "word", lambda word: self.side.show_word(word), init=False)
        self.watch(self.side, "orbit", self._take_orbit, init=False)
        self.watch(self.side, "sought", self.rows.go_to, init=False)
        self._show_openings()
        self.action_look_again()
        self.set_interval(_SECONDS_BETWEEN_LOOKS, self.look_for_changes)
        self.rows.table.focus()
        if self._code is not None:
            self.call_next(self.side.ask_for, self._code)

    def say_choices(self) -> None:
        """Show the choices, and name them, or the orbit whose facts are shown, in the subtitle."""
        fill = getattr(self.app, "fill_state", None)
        self.choices.say(fill.sentence(_BRIEF) if fill is not None and fill.runs else "")
        orbit = self.side.orbit if self.whole else None
        of_orbit = "" if orbit is None else f"{code_text(orbit.code)} at a = {format_float(orbit.a)}"
        self.sub_title = of_orbit or self.choices.selection.describe()

    # the view

    @property
    def view(self) -> View:
        return View(self.choices.selection, self.rows.ordering, self.rows.columns, self.rows.by_class)

    def _remember(self) -> None:
        """Remember the view before this change, unless a filter is still being typed."""
        if not self.choices.trying and self._view != self.view:
            self._past.append(self._view)
            self._view = self.view

    def action_past_view(self) -> None:
        if not self._past:
            self.notify("there is no view to go back to", timeout=2)
            return
        *past, view = self._past
        self.rows.ordering, self.rows.columns, self.rows.by_class = view.ordering, view.columns, view.by_class
        self.choices.selection = view.selection
        self._past, self._view = past, view  # going back is no new view

    def action_copy_view(self) -> None:
        self.choices.ask_to_copy(self.view)

    # the rows

    def action_look_again(self) -> None:
        """Read the file at the start, and read it again after changes or on request."""
        self._stamp = stamp_of(self._catalogue.path)
        filled = self._catalogue.a_values()
        self._filled = begun_periods(self._catalogue, self.choices.selection.a)
        self.set_class(not filled and self.side.orbit is None, "-empty")
        self.rows.total = None
        self.say_choices()
        if filled:
            self.rows.read(self.choices.selection)

    def look_for_changes(self) -> None:
        """Notice that another process has filled or deleted periods, if the file has changed."""
        a = self.choices.selection.a

        def compare(filled: list[int]) -> None:
            if a == self.choices.selection.a:
                before, self._filled = self._filled, filled
                if set(before) - set(filled):
                    self._read_anew()
                elif before != filled:
                    self.action_look_again()

        if self._stamp != (stamp := stamp_of(self._catalogue.path)):
            self._stamp = stamp
            self.in_thread("look", lambda _: begun_periods(self._catalogue, a), compare)

    def on_paged_table_deleted(self, message: PagedTable.Deleted) -> None:
        """Read the rows again; if the same file lacks rows again, it is damaged."""
        if stamp_of(self._catalogue.path) == self._lacking:
            self.rows.fail(message.reason)
        else:
            self._lacking = stamp_of(self._catalogue.path)
            self._read_anew()

    def _read_anew(self) -> None:
        self.notify("another process deleted these rows; the file has been reloaded")
        self.side.clear(self.choices.selection.a)
        self.rows.forget()
        self.action_look_again()

    def _take_selection(self, old: Selection, selection: Selection) -> None:
        """Show the new subset; at another a, clear the screen first, and find the word of the facts again."""
        self._remember()
        orbit, trying = self.side.orbit, self.choices.trying
        if selection.a != old.a:
            self._filled = begun_periods(self._catalogue, selection.a)
            self.side.clear(selection.a)
            self.rows.forget()
        if trying:
            self.rows.wanted = self._word
        self._show_openings()
        self.say_choices()
        self.rows.read(selection, patient=trying)
        if selection.a != old.a and self.whole and orbit is not None:
            self.side.ask_for(orbit.code)

    def _show_openings(self) -> None:
        """Let the stadium show the openings in which the chosen words have no bounce."""
        drawing, chosen = self.query_one(OrbitDrawing), self.choices.selection
        drawing.opened_at, drawing.opening = chosen.a, ()
        try:
            chosen.check_opening()
        except InputError as error:  # at another a
            self.notify(str(error), severity="warning")
        else:
            drawing.opening = chosen.opening

    def on_paste(self, event: events.Paste) -> None:
        """Look up a pasted word."""
        try:
            self.side.ask_for(event.text.strip())
        except InputError as error:
            self.notify(str(error), severity="warning")

    def _take_trying(self, trying: bool) -> None:
        """Note where the cursor is when a filter begins to be typed; remember the view when it is done."""
        row = self.rows.table.row
        self._word = row[0] if trying and row is not None and self.rows.table.cursor else None
        self._remember()

    def _say_report(self) -> None:
        if isinstance(dialog := self.app.screen, FilterDialog):
            dialog.say(self.rows.report)

    on_screen_suspend = _say_report  # a dialog has opened

    def action_filter_value(self) -> None:
        if (cell := self.rows.table.cell) is not None:
            self.choices.add(equals(*cell))

    def action_mark(self) -> None:
        if (orbit := self.side.need()) is not None:
            self.rows.marked = self.choices.mark(least_rotation(orbit.code))

    # the orbit

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        """Disable the keys that choose rows while the facts about an orbit hide the rows; a can be chosen."""
        if action == "whole" or (action == "back" and parameters):  # in turn, by the same key
            return self.whole != (action == "whole")
        chooses = action in ("filter_value", "past_view") or (
            action == "to" and parameters[0] in ("chips", "rows") and parameters[1] != "half_length"
        )
        return not (self.whole and chooses) and super().check_action(action, parameters)

    def watch_whole(self, whole: bool) -> None:
        self.side.whole = whole
        (self.query_one(FactsPanel) if whole else self.rows.table).focus()
        self.say_choices()

    def action_whole(self) -> None:
        self.whole = self.side.need() is not None

    def action_back(self, leave: bool = False) -> None:
        """Go back one step: from the facts, or from an orbit other than the row's."""
        row, orbit = self.rows.table.row, self.side.orbit
        if self.whole:
            self.whole = False
        elif row is not None and (orbit is None or (orbit.code, orbit.a) != (row[0], self.side.home)):
            self.side.show_word(row[0], anew=True)

    def _take_orbit(self, orbit: Orbit | None) -> None:
        """Show the panels once there is an orbit; while all its facts are shown, name it in the subtitle."""
        self.rows.take_orbit(orbit)
        if orbit is not None:
            self.remove_class("-empty")
        if self.whole:
            self.say_choices()

    # the catalogue

    def action_fill(self) -> None:
        path = self._catalogue.path
        if path.exists() and not (os.access(path, os.W_OK) and os.access(path.parent, os.W_OK)):
            self.notify(f"{path} is read-only: copy it, or name another file with --db")
            return
        filled = begun_periods(self._catalogue, self.choices.selection.a)
        self.app.push_screen(FillDialog(path, self.choices.selection, filled))

    def go_along(self, a: float) -> None:
        """Switch to the a that is being filled, if the current a has neither filled periods nor rows."""
        if not begun_periods(self._catalogue, self.choices.selection.a) and not len(self.rows.table.source):
            self.choices.selection = replace(self.choices.selection, a=a)

    def action_statistics(self) -> None:
        from orbitdb.cli.tui.statistics_screen import StatisticsScreen

        self._open(StatisticsScreen)

    def action_counts(self) -> None:
        """Open the counts of the chosen subset, with a histogram of the column under the cursor."""
        from orbitdb.cli.tui.counts_screen import CountsScreen

        self._open(CountsScreen, self.rows.table.current)

    def _open(self, screen: Callable[..., OwnScreen[str | None]], *more: str) -> None:
        """Open a screen that reads the stored data; the condition with which it closes joins the filter."""
        if not self._catalogue.path.exists():
            self.notify("nothing is stored yet: press f to fill the catalogue")
        else:
            self.ask(screen(self._catalogue, self.choices.selection, *more), self.choices.add)

    def action_export(self) -> None:
        from orbitdb.cli.tui.export import ask_for_file, save_orbit, write_rows

        orbit, phase = self.side.orbit, self.query_one(OrbitDrawing).phase
        if orbit is None and not len(self.rows.table.source):
            self.notify("there is nothing to save: no orbit, and no rows")
            return
        of_rows = orbit is None or self.rows.table.has_focus
        ask_for_file(
            self,
            "orbits.csv" if orbit is None or of_rows else f"{orbit.code[:40]}.svg",
            "the bounces in phase space" if phase else "the orbit in its stadium",
            partial(save_orbit, orbit, phase),
            partial(write_rows, self._catalogue, self.view),
        )
