"""The main screen: the chosen subset as a table, and the orbit under the cursor."""

import os
from collections.abc import Callable
from dataclasses import replace
from typing import ClassVar

from textual.app import ComposeResult
from textual.containers import Horizontal
from textual.screen import Screen
from textual.widgets import Footer, Header

from orbitdb.cli.render import code_text, repeats
from orbitdb.cli.tui.catalogue_file import CatalogueFile
from orbitdb.cli.tui.choices import Choices
from orbitdb.cli.tui.dialogs.fill import FillDialog
from orbitdb.cli.tui.dialogs.lines import LineDialog, code_told
from orbitdb.cli.tui.greeting import Greeting
from orbitdb.cli.tui.kept import Kept
from orbitdb.cli.tui.keys import MAIN, Keys, bindings
from orbitdb.cli.tui.orbit.drawing import OrbitDrawing
from orbitdb.cli.tui.orbit.facts import ELEMENT_NAMES
from orbitdb.cli.tui.orbit.panel import OrbitPanel
from orbitdb.cli.tui.orbit.whole_orbit import WholeOrbitScreen
from orbitdb.cli.tui.screens import OwnScreen
from orbitdb.cli.tui.table.filter_dialog import FilterDialog
from orbitdb.cli.tui.table.following import Following
from orbitdb.cli.tui.table.pages import NONE, Ordering, Pages
from orbitdb.cli.tui.table.panel import RowsPanel
from orbitdb.errors import StoreError
from orbitdb.orbits.orbit import Orbit
from orbitdb.store.asking.selection import Selection
from orbitdb.store.reading.soundness import need_words
from orbitdb.symbols.symmetry import images_of
from orbitdb.symbols.words import least_rotation, parse, primitive_root


class MainScreen(OwnScreen[None]):
    """Look at orbits and choose them."""

    KEYS: ClassVar[Keys] = MAIN
    BINDINGS = bindings(MAIN)

    def __init__(
        self, file: CatalogueFile, kept: Kept, selection: Selection, code: str | None = None
    ) -> None:
        super().__init__()
        kept.load()
        self._file, self._code = file, code
        self.choices = Choices(file, kept, selection)
        self.rows = RowsPanel(file, kept, self.take_rows)
        self.side = OrbitPanel(file, selection.a)
        self.following = Following(file, self.rows, selection.a, self._show)
        self._codes: list[str] = []

    @property
    def selection(self) -> Selection:
        """The chosen subset."""
        return self.choices.selection

    @property
    def orbit(self) -> Orbit | None:
        """The current orbit."""
        return self.side.orbit

    def _show(self, orbit: Orbit | None) -> None:
        self.side.orbit = orbit

    def compose(self) -> ComposeResult:
        """Lay out the panels."""
        yield Header()
        yield self.choices
        yield Greeting(self._file.path)
        with Horizontal(id="body"):
            yield self.rows
            yield self.side
        yield Footer(show_command_palette=False, compact=True)

    def on_mount(self) -> None:
        """Read the rows, and look the first word up."""
        self.watch(self.choices, "selection", self._take_selection, init=False)
        self.watch(self.side, "orbit", self._take_orbit, init=False)
        self.watch(self.app, "fill_state", self.say_choices)
        self.action_look_again()
        self.rows.table.focus()
        if self._code is not None:
            self.call_next(self.ask_for, self._code)

    def say_choices(self) -> None:
        """Show the choices in the subtitle and as links, after the progress of a fill."""
        fill = getattr(self.app, "fill_state", None)
        self.choices.say(fill.sentence() if fill is not None and fill.runs else "")
        self.sub_title = self.selection.describe()

    # the rows

    def action_look_again(self) -> None:
        """Read the file again, at the start and after changes."""
        filled = self._file.a_values()
        self.set_class(not filled and self.orbit is None, "-empty")
        self.rows.total = None
        self.say_choices()
        if filled:
            self.rows.read(self.selection)

    def _take_selection(self, old: Selection, selection: Selection) -> None:
        """Show the new subset; at another a, nothing stays on screen."""
        if selection.a != old.a:
            self.rows.wanted = self.rows.left = self.rows.total = None
            self.following.home = selection.a
            self.side.clear(selection.a)
            self.rows.say_gaps("", "")
            self.rows.table.show(NONE)
        self.say_choices()
        self.rows.read(selection)

    def take_rows(self, rows: Pages) -> None:
        """Show the rows, and follow the orbit, and digits, that waited for them."""
        self.catch_up()
        if not len(rows) and not self.rows.alone:
            self._show(None)
        if self.rows.take(rows):
            self._say_no_row()
        self.catch_up()
        self.following.go_on()
        self.rows.position.go_on()

    def on_paged_table_moved(self) -> None:
        """Show the word under the cursor."""
        self.catch_up()
        self.rows.say_orbit(self.orbit)

    def catch_up(self) -> None:
        """Show the word under the cursor, which may be ahead of its messages."""
        row = self.rows.table.row
        if row is not None and row[0] != self.rows.left:
            self.rows.left = None
            self._show_word(row[0])

    def action_filter(self) -> None:
        """Edit the filter; the rows follow the typing, and return on escape."""
        dialog = FilterDialog(self.rows, self.choices)
        self.app.push_screen(dialog, dialog.take)

    def action_choose_a(self, stay: bool = False) -> None:
        """Choose another a, stored or not, and optionally stay with the current word."""

        def take(a: float) -> None:
            shown = self.orbit
            self.choices.selection = replace(self.selection, a=a)
            if stay and shown is not None:
                self.following.come_back()
                self.ask_for(shown.code)

        self.choices.ask_for_a(take)

    def action_mark(self) -> None:
        """Mark the orbit, or unmark it."""
        if (orbit := self.need_orbit()) is not None:
            self.rows.marked = self.choices.mark(least_rotation(orbit.code))

    # the orbit

    async def action_to(self, part: str, action: str) -> None:
        """Pass an action on to the widget that does it, with the orbit under the cursor."""
        self.catch_up()
        if part == "drawing" and self.has_class("-empty"):  # the greeting is shown instead
            self.side.need()
        await super().action_to(part, action)

    def need_orbit(self) -> Orbit | None:
        """Return the current orbit, or say that there is none."""
        self.catch_up()
        return self.side.need()

    def _take_orbit(self, orbit: Orbit | None) -> None:
        """Let the rows follow the orbit."""
        if orbit is not None:
            self.remove_class("-empty")
        self.rows.say_orbit(orbit)
        self.following.take_orbit(orbit)

    def ask_for(self, code: str) -> None:
        """Show a word, in the rotation given, that may have to be solved first."""
        word = parse(code)
        root = primitive_root(word)
        if root != word:
            self.notify(repeats(word, root))
        self.side.solve(root, self.following.here, self.take_found)

    def take_found(self, orbit: Orbit) -> None:
        """Show the orbit and its source, unless another stadium is shown by now."""
        if orbit.a == self.following.here and not self.go_to(orbit) and self.rows.wanted is None:
            self._say_no_row()

    def go_to(self, orbit: Orbit) -> bool:
        """Show an orbit in its rotation, the cursor on its row; return whether it has one."""
        self._show(orbit)
        return self.rows.go_to(least_rotation(orbit.code))

    def _say_no_row(self) -> None:
        """Explain why the current orbit has no row."""
        if (orbit := self.orbit) is not None:
            outside = f"{code_text(orbit.code)} is not among the rows"
            self.notify(outside if orbit.stored else "not stored: solved on the spot", timeout=4)

    def _show_word(self, word: str, anew: bool = False) -> None:
        """Show a word, given as its least rotation; a shown rotation of it stays unless `anew`."""
        shown, away, here = self.orbit, self.following.away, self.following.here
        same = shown is not None and shown.a == here and len(shown.code) == len(word) and not anew
        if shown is not None and same and word in (shown.code, least_rotation(shown.code)):
            if shown.stored or away is not None:
                return
            word = shown.code
        try:
            need_words([word], [len(word)])
            stored = self._file.find(word, self.selection.a)
            there = None if away is None else self._file.find(word, away)
            self._show(stored if there is None else replace(there, exists=stored.exists))
        except StoreError as error:
            self._show(None)
            self.failed(str(error))

    def action_back(self) -> None:
        """Go back to where digits began, or show the row under the cursor as stored."""
        if self.rows.position.give_up_digits():
            return
        self.following.come_back()
        self.rows.left, row = None, self.rows.table.row
        if row is not None:
            self._show_word(row[0], anew=True)

    def action_follow(self, up: bool) -> None:
        """Follow the orbit to a greater or smaller a, past its births and deaths."""
        if self.need_orbit() is not None:
            self.following.step(up)

    def action_move_in_class(self, element: int) -> None:
        """Show the image of the orbit under a mirror or time reversal."""
        if (orbit := self.need_orbit()) is None:
            return
        word = images_of(orbit.code)[element]
        self.go_to(replace(self._file.find(word, orbit.a), exists=orbit.exists))
        same = least_rotation(word) == least_rotation(orbit.code)
        self.side.entitle(f"{'itself' if same else orbit.code[:20]}, {ELEMENT_NAMES[element]}")

    def action_code(self) -> None:
        """Ask for a code in any rotation."""

        def take(code: str) -> None:
            self._codes.append(code)
            self.ask_for(code)

        title, example = "code, in any rotation", "1232131 or 1^20(02)^5 3"
        self.ask(LineDialog(title, "", example, code_told, self._codes), take)

    def action_whole(self) -> None:
        """Open all facts about the orbit."""
        if self.need_orbit() is not None:
            self.app.push_screen(WholeOrbitScreen(self.side))

    # the catalogue

    def action_fill(self) -> None:
        """Open the fill dialog."""
        path = self._file.path
        if path.exists() and not (os.access(path, os.W_OK) and os.access(path.parent, os.W_OK)):
            self.notify(f"{path} is read-only: copy it, or name another file with --db")
            return
        filled = self._file.periods(self.selection.a)
        self.app.push_screen(FillDialog(path, self.selection, filled))

    def go_along(self, a: float) -> None:
        """Switch to the a being filled, if there is nothing at the current one."""
        if not self._file.periods(self.selection.a) and not len(self.rows.table.source):
            self.choices.selection = replace(self.selection, a=a)

    def action_statistics(self) -> None:
        """Open the statistics of the chosen subset."""
        from orbitdb.cli.tui.statistics.statistics_screen import StatisticsScreen

        self._open(StatisticsScreen)

    def action_counts(self) -> None:
        """Open the counts of the chosen subset; the histogram is that of the column it is sorted by."""
        from orbitdb.cli.tui.statistics.counts_screen import CountsScreen

        ordering = self.rows.ordering
        self._open(CountsScreen, "length" if ordering == Ordering() else ordering.column)

    def _open(self, screen: Callable[..., Screen[None]], *more: str) -> None:
        """Open a screen on the stored data, or say that there is none yet."""
        if self._file.reader is None:
            self.notify("nothing is stored yet: the key f fills the catalogue")
        else:
            self.app.push_screen(screen(self._file.reader, self.selection, *more))

    def action_export(self, of_orbit: bool = False) -> None:
        """Ask for a file and export the shown data to it."""
        from orbitdb.cli.tui.export import Shown, ask_for_shown

        self.catch_up()
        drawing = self.query_one(OrbitDrawing)
        in_phase_space = drawing.in_phase_space() if drawing.phase and not of_orbit else []
        shown = Shown(self._file.reader, self.selection, self.rows.ordering, self.orbit, in_phase_space)
        ask_for_shown(self, shown, of_rows=self.rows.table.has_focus and not of_orbit)
