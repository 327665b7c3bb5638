"""The main screen: the chosen subset as a table, and the orbit under the cursor."""

import os
from collections.abc import Callable
from dataclasses import replace
from typing import ClassVar

from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Horizontal, Vertical
from textual.content import Content
from textual.reactive import reactive
from textual.screen import Screen
from textual.widgets import Footer, Header, Static

from orbitdb.cli.render import code_text
from orbitdb.cli.tui.catalogue_file import CatalogueFile
from orbitdb.cli.tui.choices import Choices
from orbitdb.cli.tui.dialogs.fill import FillDialog
from orbitdb.cli.tui.kept import Kept
from orbitdb.cli.tui.keys import MAIN, Keys, bindings
from orbitdb.cli.tui.orbit.drawing import OrbitDrawing
from orbitdb.cli.tui.orbit.facts import FactsPanel
from orbitdb.cli.tui.orbit.panel import OrbitPanel
from orbitdb.cli.tui.screens import OwnScreen
from orbitdb.cli.tui.table.filter_dialog import FilterDialog
from orbitdb.cli.tui.table.pages import NONE, Ordering
from orbitdb.cli.tui.table.panel import RowsPanel
from orbitdb.orbits.orbit import Orbit
from orbitdb.plaintext import printable
from orbitdb.store.asking.selection import Selection
from orbitdb.symbols.words import least_rotation

_GREETING = """\
[b]Nothing is stored here yet.[/b]

$path

Press [b]f[/b] to fill the catalogue. Periods up to 11 take a few seconds
and contain 89,789 words, those of the paper's Table 1.

Press [b]c[/b] to type a code, such as 1232131, and see its orbit.
Press [b]?[/b] for the keys, [b]q[/b] to quit."""

_LEAVE = Binding("q", "leave_whole", "back", tooltip="go back to the rows")


class MainScreen(OwnScreen[None]):
    """The main screen: the rows of the chosen subset, beside the current orbit."""

    KEYS: ClassVar[Keys] = MAIN
    BINDINGS: ClassVar[list[BindingType]] = [*bindings(MAIN), _LEAVE]

    whole: reactive[bool] = reactive(False, init=False, repaint=False, bindings=True, toggle_class="-whole")

    def __init__(
        self, file: CatalogueFile, kept: Kept, selection: Selection, code: str | None = None
    ) -> None:
        super().__init__()
        kept.load()
        self._file, self._code = file, code
        self.choices = Choices(file, kept, selection)
        self.rows = RowsPanel(file, kept, lambda rows: self.side.take_rows(rows))
        self.side = OrbitPanel(file, self.rows, selection.a)

    def compose(self) -> ComposeResult:
        """Lay out the panels."""
        yield Header()
        yield self.choices
        with Vertical(id="greeting"):
            yield Static(Content.from_markup(_GREETING, path=printable(str(self._file.path))))
        with Horizontal(id="body"):
            yield self.rows
            yield self.side
        yield Footer(show_command_palette=False, compact=True)

    def on_mount(self) -> None:
        """Read the rows, and look up the word given at the start, if any."""
        self.watch(self.choices, "selection", self._take_selection, init=False)
        self.watch(self.side, "orbit", self._take_orbit, init=False)
        self.watch(self.app, "fill_state", self.say_choices)
        self.action_look_again()
        self.rows.table.focus()
        if self._code is not None:
            self.call_next(self.side.ask_for, self._code)

    def say_choices(self) -> None:
        """Show the choices as links, after the progress of any fill; describe them in the subtitle.

        While all facts about an orbit are shown, the subtitle names that orbit instead.
        """
        fill = getattr(self.app, "fill_state", None)
        self.choices.say(fill.sentence() if fill is not None and fill.runs else "")
        self.sub_title = self.choices.selection.describe()
        if self.whole and self.side.orbit is not None:
            self.sub_title = f"{code_text(self.side.orbit.code)} at a = {self.side.orbit.a:.9g}"

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
        if selection.a != old.a:
            self.rows.wanted = self.rows.left = self.rows.total = None
            self.side.clear(selection.a)
            self.rows.say_gaps("", "")
            self.rows.table.show(NONE)
        self.say_choices()
        self.rows.read(selection)

    def on_rows_panel_moved(self) -> None:
        """Show the word that is now under the cursor."""
        self.side.catch_up()
        self.rows.say_orbit(self.side.orbit)

    def action_filter(self) -> None:
        """Edit the filter; the rows update as you type, and `escape` restores the previous rows."""
        dialog = FilterDialog(self.rows, self.choices)
        self.app.push_screen(dialog, dialog.take)

    def action_choose_a(self) -> None:
        """Choose another a, stored or not; if all facts about a word are shown, show those at the new a."""

        def take(a: float) -> None:
            shown = self.side.orbit
            self.choices.selection = replace(self.choices.selection, a=a)
            if self.whole and shown is not None:
                self.side.following.come_back()
                self.side.ask_for(shown.code)

        self.choices.ask_for_a(take)

    def action_mark(self) -> None:
        """Mark or unmark the current orbit."""
        if (orbit := self.side.need()) is not None:
            self.rows.marked = self.choices.mark(least_rotation(orbit.code))

    # the orbit

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        """Disable the keys that choose rows while the facts about an orbit hide the rows."""
        if action == "leave_whole":
            return self.whole
        chooses = action == "filter" or (action == "to" and parameters[0] in ("chips", "rows", "position"))
        return not (self.whole and chooses) and super().check_action(action, parameters)

    def watch_whole(self, whole: bool) -> None:
        """Show all facts about the orbit in place of the rows, or the rows again."""
        self.side.whole = whole
        (self.query_one(FactsPanel) if whole else self.rows.table).focus()
        self.say_choices()

    def action_whole(self) -> None:
        """Switch between showing the rows and showing everything about the orbit."""
        if self.side.need() is not None:
            self.whole = not self.whole

    def action_leave_whole(self) -> None:
        """Go back to the rows."""
        self.whole = False

    def action_back(self) -> None:
        """Go back from the facts to the rows, or from another orbit to the one of the current row."""
        if self.whole:
            self.whole = False
        else:
            self.side.action_back()

    async def action_to(self, part: str, action: str) -> None:
        """Bring the current orbit up to date with the cursor, then pass an action on to its widget."""
        self.side.catch_up()
        if part == "drawing" and self.has_class("-empty"):  # the greeting hides the drawing
            self.side.need()
        await super().action_to(part, action)

    def _take_orbit(self, orbit: Orbit | None) -> None:
        """Show the panels once there is an orbit; while all its facts are shown, name it in the subtitle."""
        if orbit is not None:
            self.remove_class("-empty")
        if self.whole:
            self.say_choices()

    # the catalogue

    def action_fill(self) -> None:
        """Open the fill dialog."""
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
        """Open the statistics of the chosen subset."""
        from orbitdb.cli.tui.statistics.statistics_screen import StatisticsScreen

        self._open(StatisticsScreen)

    def action_counts(self) -> None:
        """Open the counts of the chosen subset, with a histogram of the sort column (by default, length)."""
        from orbitdb.cli.tui.statistics.counts_screen import CountsScreen

        ordering = self.rows.ordering
        self._open(CountsScreen, "length" if ordering == Ordering() else ordering.column)

    def _open(self, screen: Callable[..., Screen[None]], *more: str) -> None:
        """Open a screen that reads the stored data, or report that nothing is stored yet."""
        if self._file.reader is None:
            self.notify("nothing is stored yet: press f to fill the catalogue")
        else:
            self.app.push_screen(screen(self._file.reader, self.choices.selection, *more))

    def action_export(self) -> None:
        """Ask for a file, and export to it what is on the screen."""
        from orbitdb.cli.tui.export import Shown, ask_for_shown

        self.side.catch_up()
        drawing = self.query_one(OrbitDrawing)
        in_phase_space = drawing.in_phase_space() if drawing.phase and not self.whole else []
        shown = Shown(
            self._file.reader, self.choices.selection, self.rows.ordering, self.side.orbit, in_phase_space
        )
        ask_for_shown(self, shown, of_rows=self.rows.table.has_focus)
