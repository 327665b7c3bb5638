"""What is chosen for good on the main screen: columns, marked orbits, and filters by name."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import ClassVar

from textual.app import ComposeResult
from textual.binding import Binding, BindingType

from orbitdb.cli.render import code_text
from orbitdb.cli.tui.dialogs.basic import LineDialog
from orbitdb.cli.tui.dialogs.columns import ColumnDialog, Names
from orbitdb.cli.tui.dialogs.filters import KEEP, FiltersDialog
from orbitdb.cli.tui.jumping_screen import JumpingScreen
from orbitdb.cli.tui.kept import State, among_marked, criteria_of, selection_of, toggled
from orbitdb.cli.tui.orbit_screen import OrbitScreen
from orbitdb.cli.tui.table.columns import chosen
from orbitdb.cli.tui.table.paged_table import PagedTable
from orbitdb.errors import InputError
from orbitdb.plaintext import printable
from orbitdb.store.asking.selection import Selection
from orbitdb.symbols.words import least_rotation

_LONGEST_NAME = 40


class KeepingScreen(JumpingScreen):
    """The main screen, with what is kept from one session to the next."""

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("C", "columns", "columns", show=False),
        Binding("asterisk", "mark", "mark the orbit, or unmark it", show=False, key_display="*"),
        Binding("apostrophe", "marked", "marked orbits only", show=False, key_display="'"),
        Binding("F", "filters", "filters kept by name", show=False),
    ]

    def __init__(self, selection: Selection, code: str | None = None) -> None:
        super().__init__(selection, code)
        self._unmarked_where: str | None = None
        self._marked_where: str | None = None

    def compose(self) -> ComposeResult:
        """Lay out the panels, with the columns and marks that were kept."""
        try:
            self.browser.kept.load()
        except InputError as error:
            self.call_later(self.notify, str(error), severity="error")
        state = self.browser.kept.state
        self.set_reactive(OrbitScreen.columns, chosen(state.columns))
        self.set_reactive(OrbitScreen.marked, frozenset(state.marked))
        yield from super().compose()

    def _change(self, changed: Callable[[State], State]) -> None:
        """Change what is kept; where it cannot be, it holds for this session."""
        try:
            self.browser.kept.change(changed)
        except InputError as error:
            self.notify(str(error), severity="error")

    # columns

    def action_columns(self) -> None:
        """Choose the columns of the table."""

        def take(names: Names | None) -> None:
            if names is not None:
                self._change(partial(replace, columns=names))
                self.query_one(PagedTable).first_column = 1
                self.columns = chosen(names)

        self.app.push_screen(ColumnDialog([column.name for column in self.columns]), take)

    # marked orbits

    def action_mark(self) -> None:
        """Mark the orbit, or unmark it."""
        self.catch_up()
        if self.orbit is None:
            return
        word = least_rotation(self.orbit.code)
        self._change(partial(toggled, word=word))
        marked = self.browser.kept.state.marked
        verb = "marked" if word in marked else "unmarked"
        self.notify(f"{verb} {code_text(word)}, {len(marked)} in all; ' shows them", timeout=2)
        self.marked = frozenset(marked)
        if self._shows_marked:
            self._choose_marked(self._unmarked_where)

    @property
    def _shows_marked(self) -> bool:
        return self._marked_where is not None and self.selection.where == self._marked_where

    def action_marked(self) -> None:
        """Show the marked orbits only, or what was shown before."""
        if self._shows_marked:
            self.selection = replace(self.selection, where=self._unmarked_where)
        else:
            self._choose_marked(self.selection.where)

    def _choose_marked(self, where: str | None) -> None:
        """Choose the marked orbits among those of a filter."""
        words = self.browser.kept.state.marked
        if not words:
            self.notify("no orbit is marked: * marks one")
            self.selection = replace(self.selection, where=where)
            return
        wanted = among_marked(words, where)
        try:
            self.browser.check_filter(wanted, dict(self.selection.parameters))
        except InputError as error:
            self.notify(str(error), severity="error")
            return
        self._unmarked_where, self._marked_where = where, wanted
        self.selection = replace(self.selection, where=wanted)

    # filters by name

    def action_filters(self) -> None:
        """Take a filter that was kept, or keep the present one."""

        def take(name: str | None) -> None:
            if name == KEEP:
                self._ask_for_name()
            elif name is not None:
                self._take_filter(name)

        told = {name: self._told(name) for name in self.browser.kept.state.filters}
        self.app.push_screen(FiltersDialog(told, self._forget, self.selection.describe()), take)

    def _told(self, name: str) -> str:
        try:
            return self._kept_filter(name).describe()
        except InputError as error:
            return str(error)

    def _kept_filter(self, name: str) -> Selection:
        return selection_of(self.browser.kept.state.filters[name], self.selection.a)

    def _forget(self, name: str) -> None:
        self._change(
            lambda state: replace(state, filters={k: v for k, v in state.filters.items() if k != name})
        )

    def _take_filter(self, name: str) -> None:
        try:
            selection = self._kept_filter(name)
            if selection.where is not None:
                self.browser.check_filter(selection.where, dict(selection.parameters))
        except InputError as error:
            self.notify(str(error), severity="error")
            return
        self.selection = selection

    def _ask_for_name(self) -> None:
        criteria = criteria_of(self.selection)
        if not criteria:
            self.notify("every sequence is shown: choose some first, as with / or o")
            return

        def check(name: str) -> str:
            if len(name.strip()) > _LONGEST_NAME or printable(name) != name:
                raise InputError(f"{len(name.strip())} characters: take a name of {_LONGEST_NAME} or less")
            there = name.strip() in self.browser.kept.state.filters
            return "it is there and will be replaced" if there else self.selection.describe()

        def take(name: str | None) -> None:
            if name:
                self._change(lambda state: replace(state, filters={**state.filters, name: criteria}))
                self.notify(f"kept as {name}", timeout=2)

        self.app.push_screen(LineDialog("keep this filter as", "", "short orbits", check), take)
