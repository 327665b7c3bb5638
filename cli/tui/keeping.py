"""What is chosen for good on the main screen: columns, marked orbits, and filters by name."""

from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

from orbitdb.cli.render import code_text
from orbitdb.cli.tui.dialogs.basic import LineDialog
from orbitdb.cli.tui.dialogs.kept_filters import KEEP, FiltersDialog
from orbitdb.cli.tui.dialogs.marks import ColumnDialog, Names
from orbitdb.cli.tui.state_file import Kept, among_marked, criteria_of, selection_of, toggled
from orbitdb.cli.tui.table.columns import chosen
from orbitdb.errors import InputError
from orbitdb.orbits.orbit import Orbit
from orbitdb.plaintext import printable
from orbitdb.store.asking.expressions import check
from orbitdb.store.asking.selection import Selection
from orbitdb.symbols.words import least_rotation

if TYPE_CHECKING:
    from orbitdb.cli.tui.panels import Panels

_LONGEST_NAME = 40


class Keeping:
    """What is kept from one session to the next."""

    def __init__(self, screen: "Panels") -> None:
        self._screen = screen
        self._unmarked_where: str | None = None
        self._marked_where: str | None = None

    @property
    def _kept(self) -> Kept:
        return self._screen.browser.kept

    # columns

    def ask_for_columns(self) -> None:
        """Choose the columns of the table."""

        def take(names: Names | None) -> None:
            if names is not None:
                names = ("code", *names)
                self._kept.change(partial(replace, columns=names))
                self._screen.rows.table.first_column = 1
                self._screen.columns = chosen(names)

        self._screen.app.push_screen(ColumnDialog([column.name for column in self._screen.columns]), take)

    # marked orbits

    def mark(self, orbit: Orbit) -> None:
        """Mark an orbit, or unmark it."""
        word = least_rotation(orbit.code)
        self._kept.change(partial(toggled, word=word))
        marked = self._kept.state.marked
        verb = "marked" if word in marked else "unmarked"
        self._screen.notify(f"{verb} {code_text(word)}, {len(marked)} in all; ' shows them", timeout=2)
        self._screen.marked = frozenset(marked)
        if self._shows_marked:
            self._choose_marked(self._unmarked_where)

    @property
    def _shows_marked(self) -> bool:
        return self._marked_where is not None and self._screen.selection.where == self._marked_where

    def show_marked(self) -> None:
        """Show the marked orbits only, or what was shown before."""
        if self._shows_marked:
            self._screen.selection = replace(self._screen.selection, where=self._unmarked_where)
        else:
            self._choose_marked(self._screen.selection.where)

    def _choose_marked(self, where: str | None) -> None:
        """Choose the marked orbits among those of a filter."""
        words = self._kept.state.marked
        if not words:
            self._screen.notify("no orbit is marked: * marks one")
            self._screen.selection = replace(self._screen.selection, where=where)
            return
        wanted = among_marked(words, where)
        try:
            check(wanted, dict(self._screen.selection.parameters))
        except InputError as error:
            self._screen.notify(str(error), severity="error")
            return
        self._unmarked_where, self._marked_where = where, wanted
        self._screen.selection = replace(self._screen.selection, where=wanted)

    # filters by name

    def ask_for_filter(self) -> None:
        """Take a filter that was kept, or keep the present one."""

        def take(name: str | None) -> None:
            if name == KEEP:
                self._ask_for_name()
            elif name is not None:
                self._take_filter(name)

        told = {name: self._told(name) for name in self._kept.state.filters}
        self._screen.app.push_screen(
            FiltersDialog(told, self._forget, self._screen.selection.describe()), take
        )

    def _told(self, name: str) -> str:
        try:
            return self._kept_filter(name).describe()
        except InputError as error:
            return str(error)

    def _kept_filter(self, name: str) -> Selection:
        return selection_of(self._kept.state.filters[name], self._screen.selection.a)

    def _forget(self, name: str) -> None:
        self._kept.change(
            lambda state: replace(state, filters={k: v for k, v in state.filters.items() if k != name})
        )

    def _take_filter(self, name: str) -> None:
        try:
            selection = self._kept_filter(name)
            if selection.where is not None:
                check(selection.where, dict(selection.parameters))
        except InputError as error:
            self._screen.notify(str(error), severity="error")
            return
        self._screen.selection = selection

    def _ask_for_name(self) -> None:
        criteria = criteria_of(self._screen.selection)
        if not criteria:
            self._screen.notify("every word is shown: choose some first, as with / or o")
            return

        def check(name: str) -> str:
            if len(name.strip()) > _LONGEST_NAME or printable(name) != name:
                raise InputError(f"{len(name.strip())} characters: take a name of {_LONGEST_NAME} or less")
            there = name.strip() in self._kept.state.filters
            return (
                "a filter of this name exists and will be replaced"
                if there
                else self._screen.selection.describe()
            )

        def take(name: str | None) -> None:
            if name:
                self._kept.change(lambda state: replace(state, filters={**state.filters, name: criteria}))
                self._screen.notify(f"kept as {name}", timeout=2)

        self._screen.app.push_screen(LineDialog("keep this filter as", "", "short orbits", check), take)
