"""The main screen: the chosen subset as a table, and the orbit under the cursor."""

import os
from collections.abc import Callable
from dataclasses import replace

from textual import events
from textual.app import ComposeResult
from textual.containers import Horizontal
from textual.reactive import reactive
from textual.screen import Screen
from textual.widgets import Footer, Header, HelpPanel

from orbitdb.cli.output import code_text
from orbitdb.cli.tui.choices import Choices, FilterDialog, equals
from orbitdb.cli.tui.dialogs import describe_code
from orbitdb.cli.tui.drawing import OrbitDrawing
from orbitdb.cli.tui.facts import FactsPanel
from orbitdb.cli.tui.fill_dialog import FillDialog, Greeting
from orbitdb.cli.tui.keys import MAIN
from orbitdb.cli.tui.orbit_panel import OrbitPanel
from orbitdb.cli.tui.rows_panel import RowsPanel
from orbitdb.cli.tui.screens import OwnScreen
from orbitdb.cli.tui.stored import CatalogueFile, Kept
from orbitdb.cli.tui.view import Ordering, View
from orbitdb.errors import InputError
from orbitdb.orbits.orbit import Orbit
from orbitdb.store.selection import Selection
from orbitdb.symbols.words import least_rotation
from orbitdb.text import exact


class MainScreen(OwnScreen[None]):
    """The main screen: the rows of the chosen subset, beside the current orbit."""

    BINDING_GROUP_TITLE = "Orbits"
    BINDINGS = MAIN

    whole: reactive[bool] = reactive(False, init=False, repaint=False, bindings=True, toggle_class="-whole")

    def __init__(self, file: CatalogueFile, kept: Kept, selection: Selection, code: str | None) -> None:
        super().__init__()
        kept.load()
        self._file, self._kept, self._code = file, kept, code
        self.choices = Choices(file, kept, selection)
        self.rows = RowsPanel(file, kept)
        self.side = OrbitPanel(file, selection.a)
        self._view = self.view
        self._past: list[View] = []
        self._trying = False  # a filter is being typed

    def compose(self) -> ComposeResult:
        yield Header()
        yield self.choices
        yield Greeting(self._file.path)
        with Horizontal(id="body"):
            yield self.rows
            yield self.side
        yield Footer(show_command_palette=False, compact=True)

    def on_mount(self) -> None:
        self.watch(self.choices, "selection", self._take_selection, init=False)
        self.watch(self.rows, "ordering", self._remember, init=False)
        self.watch(self.rows, "columns", self._remember, init=False)
        self.watch(self.side, "orbit", self._take_orbit, init=False)
        self.watch(self.app, "fill_state", self.say_choices)
        self.action_look_again()
        self.rows.table.focus()
        if self._code is not None:
            self.call_next(self.side.ask_for, self._code)

    def say_choices(self) -> None:
        """Show the choices, and name them, or the orbit whose facts are shown, in the subtitle."""
        fill = getattr(self.app, "fill_state", None)
        self.choices.say(fill.sentence() if fill is not None and fill.runs else "")
        self.sub_title = self.choices.selection.describe()
        if self.whole and self.side.orbit is not None:
            self.sub_title = f"{code_text(self.side.orbit.code)} at a = {exact(self.side.orbit.a)}"

    # the view

    @property
    def view(self) -> View:
        return View(self.choices.selection, self.rows.ordering, self.rows.columns)

    def _remember(self) -> None:
        """Remember the view before this change, unless a filter is still being typed."""
        if not self._trying and self._view != self.view:
            self._past.append(self._view)
            self._view = self.view

    def action_past_view(self) -> None:
        if not self._past:
            self.notify("there is no view to go back to", timeout=2)
            return
        self._view = view = self._past.pop()
        self._trying = True
        self.rows.ordering, self.rows.columns = view.ordering, view.columns
        self.choices.selection = view.selection
        self._trying = False

    def action_copy_view(self) -> None:
        self.choices.ask_to_copy(self.view)

    # the rows

    def action_look_again(self) -> None:
        """Read the file at the start, and read it again after changes or on request."""
        filled = self._file.a_values()
        self.set_class(not filled and self.side.orbit is None, "-empty")
        self.rows.total = None
        self.say_choices()
        if filled:
            self.rows.read(self.choices.selection)

    def _take_selection(self, old: Selection, selection: Selection) -> None:
        """Show the new subset; if it is at another a, clear the screen first."""
        self._remember()
        if selection.a != old.a:
            self.side.clear(selection.a)
            self.rows.forget()
        self.say_choices()
        self.rows.read(selection)

    def on_rows_panel_read(self, message: RowsPanel.Read) -> None:
        """Show new rows, then go to the digits that waited for them."""
        self.catch_up()
        if not len(message.rows) and not self.rows.alone:
            self.side.orbit = None
        if self.rows.take(message.rows):
            self._say_no_row()
        self.catch_up()
        self.rows.position.go_on()

    def catch_up(self) -> None:
        """Bring cursor and orbit together, even if the message that one of them moved has not arrived yet."""
        row = self.rows.table.row
        if (sought := self.side.sought) is not None:
            self.side.sought = None
            if not self.rows.go_to(least_rotation(sought.code)) and self.rows.wanted is None:
                self._say_no_row()
            self.rows.say_orbit(self.side.orbit)
        elif row is not None and row[0] != self.rows.left:
            self.rows.left = None
            self.side.show_word(row[0])

    def on_rows_panel_moved(self) -> None:
        self.catch_up()
        self.rows.say_orbit(self.side.orbit)

    def on_orbit_panel_sought(self) -> None:
        self.catch_up()

    def _say_no_row(self) -> None:
        if (orbit := self.side.orbit) is not None:
            outside = f"{code_text(orbit.code)} is not among the rows"
            self.notify(outside if orbit.stored else "not stored: solved on the spot", timeout=4)

    def action_digit(self, digit: str) -> None:
        self.catch_up()
        self.rows.position.take(digit)

    def on_paste(self, event: events.Paste) -> None:
        """Go to a pasted period or code as if it were typed; look up a word in run notation."""
        text = event.text.strip()
        if text.isdecimal() and text.isascii():
            self.action_digit(text)
        else:
            try:
                describe_code(text)
            except InputError as error:
                self.notify(str(error), severity="warning")
            else:
                self.side.ask_for(text)

    def action_filter(self) -> None:
        """Edit the filter; the rows update as you type, and `escape` restores the previous rows."""
        dialog = FilterDialog(self.rows, self.choices, self._kept.state.filters)

        def take(where: str | None) -> None:
            dialog.apply(dialog.before if where is None else where)
            self._trying = False
            self._remember()
            if typed := where or (dialog.tried if dialog.tried != dialog.before else ""):
                self._kept.remember(typed)

        self._trying = True
        self.app.push_screen(dialog, take)

    def action_filter_value(self) -> None:
        if (cell := self.rows.table.cell) is not None:
            self.choices.add(equals(*cell))

    def action_choose_a(self) -> None:
        """Choose another a, stored or not; if all facts about a word are shown, show those at the new a."""

        def take(a: float) -> None:
            shown = self.side.orbit
            self.choices.selection = replace(self.choices.selection, a=a)
            if self.whole and shown is not None:
                self.side.ask_for(shown.code)

        self.choices.ask_for_a(take)

    def action_mark(self) -> None:
        self.catch_up()
        if (orbit := self.side.need()) is not None:
            self.rows.marked = self.choices.mark(least_rotation(orbit.code))

    # the orbit

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        """Disable the keys that choose rows while the facts about an orbit hide the rows."""
        if action == "leave_whole":
            return self.whole
        chooses = action in ("filter", "filter_value", "past_view") or (
            action == "to" and parameters[0] in ("chips", "rows", "position")
        )
        return not (self.whole and chooses) and super().check_action(action, parameters)

    def watch_whole(self, whole: bool) -> None:
        self.side.whole = whole
        (self.query_one(FactsPanel) if whole else self.rows.table).focus()
        self.say_choices()

    def action_whole(self) -> None:
        self.catch_up()
        self.whole = not self.whole and self.side.need() is not None

    def action_leave_whole(self) -> None:
        self.whole = False

    def action_back(self) -> None:
        """Go back one step: from the help, the facts, typed digits, or an orbit other than the row's."""
        if self.query(HelpPanel):
            self.app.action_hide_help_panel()
        elif self.whole:
            self.whole = False
        elif not self.rows.position.give_up_digits():
            self.rows.left, row = None, self.rows.table.row
            if row is not None:
                self.side.show_word(row[0], anew=True)

    async def action_to(self, part: str, action: str) -> None:
        """Bring the current orbit up to date with the cursor, then pass an action on to its widget."""
        self.catch_up()
        if part == "drawing" and self.has_class("-empty"):  # the greeting hides the drawing
            self.side.need()
        await super().action_to(part, action)

    def _take_orbit(self, orbit: Orbit | None) -> None:
        """Show the panels once there is an orbit; while all its facts are shown, name it in the subtitle."""
        self.rows.say_orbit(orbit)
        if orbit is not None:
            self.remove_class("-empty")
        if self.whole:
            self.say_choices()

    # the catalogue

    def action_fill(self) -> None:
        path = self._file.path
        if path.exists() and not (os.access(path, os.W_OK) and os.access(path.parent, os.W_OK)):
            self.notify(f"{path} is read-only: copy it, or name another file with --db")
            return
        filled = self._file.periods(self.choices.selection.a)
        self.app.push_screen(FillDialog(path, self.choices.selection, filled))

    def go_along(self, a: float) -> None:
        """Switch to the a that is being filled, if the current a has neither filled periods nor rows."""
        if not self._file.periods(self.choices.selection.a) and not len(self.rows.table.source):
            self.choices.selection = replace(self.choices.selection, a=a)

    def action_statistics(self) -> None:
        from orbitdb.cli.tui.statistics_screen import StatisticsScreen

        self._open(StatisticsScreen)

    def action_counts(self) -> None:
        """Open the counts of the chosen subset, with a histogram of the sort column (by default, length)."""
        from orbitdb.cli.tui.counts_screen import CountsScreen

        ordering = self.rows.ordering
        self._open(CountsScreen, "length" if ordering == Ordering() else ordering.column)

    def _open(self, screen: Callable[..., Screen[str | None]], *more: str) -> None:
        """Open a screen that reads the stored data; the condition with which it closes joins the filter."""
        if self._file.reader is None:
            self.notify("nothing is stored yet: press f to fill the catalogue")
        else:
            opened = screen(self._file.reader, self.choices.selection, *more)
            self.app.push_screen(opened, lambda condition: self.choices.add(condition) if condition else None)

    def action_export(self) -> None:
        from orbitdb.cli.tui.export import Shown, ask_for_shown

        self.catch_up()
        phase = self.query_one(OrbitDrawing).phase and not self.whole
        shown = Shown(self._file.reader, self.choices.selection, self.rows.ordering, self.side.orbit, phase)
        ask_for_shown(self, shown, of_rows=self.rows.table.has_focus)
