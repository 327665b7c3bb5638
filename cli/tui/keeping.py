"""What is chosen for good on the main screen: columns, marked orbits, and filters by name."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial

from textual.app import ComposeResult

from orbitdb.cli.render import code_text
from orbitdb.cli.tui.dialogs.lines import LineDialog
from orbitdb.cli.tui.dialogs.lists import KEEP, ColumnDialog, FiltersDialog, Names
from orbitdb.cli.tui.panels import Panels
from orbitdb.cli.tui.state_file import among_marked, criteria_of, selection_of
from orbitdb.cli.tui.table.columns import chosen
from orbitdb.errors import InputError
from orbitdb.plaintext import printable
from orbitdb.store.asking.expressions import check
from orbitdb.store.asking.selection import Selection
from orbitdb.symbols.words import least_rotation

_LONGEST_NAME = 40


class Keeping(Panels):
    """The main screen, as far as it keeps something from one session to the next."""

    _unmarked_where: str | None = None
    _marked_where: str | None = None

    def compose(self) -> ComposeResult:
        """Lay out the panels, with the columns and marks that were kept."""
        self.browser.kept.load()
        self.set_reactive(Panels.columns, chosen(self.browser.kept.state.columns))
        self.set_reactive(Panels.marked, frozenset(self.browser.kept.state.marked))
        yield from super().compose()

    def action_columns(self) -> None:
        """Choose the columns of the table."""

        def take(names: Names) -> None:
            with self.browser.kept.changing() as state:
                state.columns = ["code", *names]
            self.rows.table.first_column = 1
            self.columns = chosen(names)

        self.ask(ColumnDialog([column.name for column in self.columns]), take)

    # marked orbits

    def action_mark(self) -> None:
        """Mark the orbit, or unmark it."""
        if (orbit := self.shown_orbit()) is None:
            return
        word = least_rotation(orbit.code)
        with self.browser.kept.changing() as state:
            verb = "unmarked" if word in state.marked else "marked"
            (state.marked.remove if word in state.marked else state.marked.append)(word)
        self.notify(f"{verb} {code_text(word)}, {len(state.marked)} in all; ' shows them", timeout=2)
        self.marked = frozenset(state.marked)
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
        if self._choose(lambda: replace(self.selection, where=wanted)):
            self._unmarked_where, self._marked_where = where, wanted

    def _choose(self, wanted: Callable[[], Selection]) -> bool:
        """Choose a subset, or say why it cannot be used."""
        try:
            selection = wanted()
            if selection.where is not None:
                check(selection.where, dict(selection.parameters))
        except InputError as error:
            self.notify(str(error), severity="error")
            return False
        self.selection = selection
        return True

    # filters by name

    def action_filters(self) -> None:
        """Take a filter that was kept, or keep the present one."""

        def take(name: str) -> None:
            if name == KEEP:
                self._ask_for_name()
            else:
                self._choose(partial(self._kept_filter, name))

        told = {name: self._told(name) for name in self.browser.kept.state.filters}
        self.ask(FiltersDialog(told, self._forget, self.selection.describe()), take)

    def _told(self, name: str) -> str:
        try:
            return self._kept_filter(name).describe()
        except InputError as error:
            return str(error)

    def _kept_filter(self, name: str) -> Selection:
        return selection_of(self.browser.kept.state.filters[name], self.selection.a)

    def _forget(self, name: str) -> None:
        with self.browser.kept.changing() as state:
            state.filters.pop(name, None)

    def _ask_for_name(self) -> None:
        criteria, kept = criteria_of(self.selection), self.browser.kept
        if not criteria:
            self.notify("every word is shown: choose some first, as with / or o")
            return

        def check(name: str) -> str:
            if len(name.strip()) > _LONGEST_NAME or printable(name) != name:
                raise InputError(f"{len(name.strip())} characters: take a name of {_LONGEST_NAME} or less")
            if name.strip() in kept.state.filters:
                return "a filter of this name exists and will be replaced"
            return self.selection.describe()

        def take(name: str) -> None:
            with kept.changing() as state:
                state.filters[name] = criteria
            self.notify(f"kept as {name}", timeout=2)

        self.ask(LineDialog("keep this filter as", "", "short orbits", check), take)
