"""Choose a subset: each change gives a new `Selection`, which describes itself."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

from textual.reactive import reactive
from textual.widgets import Static

from orbitdb.cli.render import code_text
from orbitdb.cli.tui.catalogue_file import CatalogueFile
from orbitdb.cli.tui.dialogs.lines import LineDialog, half_length
from orbitdb.cli.tui.dialogs.lists import KEEP, FiltersDialog, MarksDialog, Names
from orbitdb.cli.tui.kept import Kept, among_marked, criteria_of, selection_of
from orbitdb.cli.tui.screens import Working
from orbitdb.errors import InputError
from orbitdb.numerals import exact
from orbitdb.orbits.status import Status
from orbitdb.plaintext import printable
from orbitdb.store.asking.codes import hint
from orbitdb.store.asking.selection import Selection
from orbitdb.store.asking.where import check, names_in

SHOWN = (Status.ORBIT, Status.DYNAMICAL, Status.BOUNDARY, Status.GEOMETRIC, Status.UNRESOLVED)
"""The statuses of rows."""

RINGS: dict[str, tuple[Any, ...]] = {
    "statuses": ((), *((status,) for status in SHOWN)),
    "time_reversal": (None, "self", "pair"),
}
"""The values of criteria, in the order in which a key steps through them."""

_LONGEST_NAME = 40


class Choices(Static, Working):
    """The chosen subset, as a line with links to the actions that change it."""

    selection: reactive[Selection] = reactive(Selection, init=False, layout=False, repaint=False)

    def __init__(self, file: CatalogueFile, kept: Kept, selection: Selection) -> None:
        super().__init__(id="chips")
        self._file, self._kept = file, kept
        self.set_reactive(Choices.selection, selection)
        self._values = dict(selection.parameters)
        self.tried = [selection.where] if selection.where else []  # filters, the newest last
        self._unmarked_where: str | None = None
        self._marked_where: str | None = None

    def say(self, fill: str = "") -> None:
        """Show the choices, after the progress of a fill."""
        told = chips(self.selection, self._file.a_values())
        self.update(f"[b]{fill}[/b] │ {told}" if fill else told)

    def action_turn(self, name: str, step: int = 1) -> None:
        """Choose the next or previous value of a criterion; after the last comes no restriction."""
        periods = ((), *(((p, p),) for p in self._file.periods(self.selection.a)))
        self.selection = turned(self.selection, name, RINGS.get(name, periods), step)

    def action_statuses(self) -> None:
        """Pick statuses from a list."""

        def take(statuses: Names) -> None:
            self.selection = replace(self.selection, statuses=tuple(map(Status, statuses)))

        hint = "space marks, enter accepts; mark none for every status"
        texts = {status.value: status.sentence for status in SHOWN}
        self.ask(MarksDialog("statuses", hint, texts, self.selection.statuses), take)

    def ask_for_a(self, take: Callable[[float], object]) -> None:
        """Ask for another a, stored or not."""
        values = [repr(a) for a in self._file.a_values()]

        def check(text: str) -> str:
            filled = repr(half_length(text)) in values
            return "filled" if filled else "nothing is filled there: f fills it, c solves a code"

        dialog = LineDialog("half length a", repr(self.selection.a), "such as 1.6", check, values)
        self.ask(dialog, lambda a: take(half_length(a)))

    # filters

    def check_filter(self, where: str) -> str:
        """Refuse an invalid filter; hint at comparisons of codes that name no row."""
        check(where, dict(self.filtered(where).parameters))
        return hint(where) or ""

    def filtered(self, where: str | None) -> Selection:
        """Return the selection with another filter, and the values of -P that it uses."""
        used = names_in(where or "")
        known = self._values | dict(self.selection.parameters)
        values = {name: value for name, value in known.items() if name in used}
        return replace(self.selection, where=where, parameters=values)

    def _choose(self, wanted: Callable[[], Selection]) -> bool:
        """Choose a subset, or report why it cannot be used."""
        try:
            selection = wanted()
            if selection.where is not None:
                check(selection.where, dict(selection.parameters))
        except InputError as error:
            self.notify(str(error), severity="error")
            return False
        self.selection = selection
        return True

    def action_filters(self) -> None:
        """Use a kept filter, or keep the current one."""

        def take(name: str) -> None:
            if name == KEEP:
                self._ask_for_name()
            else:
                self._choose(partial(self._kept_filter, name))

        told = {name: self._told(name) for name in self._kept.state.filters}
        self.ask(FiltersDialog(told, self._forget, self.selection.describe()), take)

    def _told(self, name: str) -> str:
        try:
            return self._kept_filter(name).describe()
        except InputError as error:
            return str(error)

    def _kept_filter(self, name: str) -> Selection:
        return selection_of(self._kept.state.filters[name], self.selection.a)

    def _forget(self, name: str) -> None:
        with self._kept.changing() as state:
            state.filters.pop(name, None)

    def _ask_for_name(self) -> None:
        if not (criteria := criteria_of(self.selection)):
            self.notify("every word is shown: choose some first, as with / or o")
            return

        def check(name: str) -> str:
            if len(name.strip()) > _LONGEST_NAME or printable(name) != name:
                raise InputError(f"{len(name.strip())} characters: take a name of {_LONGEST_NAME} or less")
            if name.strip() in self._kept.state.filters:
                return "a filter of this name exists and will be replaced"
            return self.selection.describe()

        def take(name: str) -> None:
            with self._kept.changing() as state:
                state.filters[name] = criteria
            self.notify(f"kept as {name}", timeout=2)

        self.ask(LineDialog("keep this filter as", "", "short orbits", check), take)

    # marked orbits

    def action_marked(self) -> None:
        """Show the marked orbits only, or the previous rows."""
        if self._shows_marked:
            self.selection = replace(self.selection, where=self._unmarked_where)
        else:
            self._choose_marked(self.selection.where)

    @property
    def _shows_marked(self) -> bool:
        return self._marked_where is not None and self.selection.where == self._marked_where

    def mark(self, word: str) -> frozenset[str]:
        """Mark a word, or unmark it; return the marked ones."""
        with self._kept.changing() as state:
            verb = "unmarked" if word in state.marked else "marked"
            (state.marked.remove if word in state.marked else state.marked.append)(word)
        self.notify(f"{verb} {code_text(word)}, {len(state.marked)} in all; ' shows them", timeout=2)
        if self._shows_marked:
            self._choose_marked(self._unmarked_where)
        return frozenset(state.marked)

    def _choose_marked(self, where: str | None) -> None:
        """Choose the marked orbits among those of a filter."""
        words = self._kept.state.marked
        if not words:
            self.notify("no orbit is marked: * marks one")
            self.selection = replace(self.selection, where=where)
            return
        wanted = among_marked(words, where)
        if self._choose(lambda: replace(self.selection, where=wanted)):
            self._unmarked_where, self._marked_where = where, wanted


def turned(selection: Selection, name: str, ring: Sequence[Any], step: int = 1) -> Selection:
    """Choose the value some steps further in a ring; a value outside it counts as the first."""
    present = getattr(selection, name)
    place = ring.index(present) if present in ring else 0
    return replace(selection, **{name: ring[(place + step) % len(ring)]})


def chips(selection: Selection, a_values: Sequence[float]) -> str:
    """Return the choices as one line with links to the actions that change them."""
    spans = ", ".join(str(low) if low == high else f"{low}-{high}" for low, high in selection.periods)
    status = ", ".join(selection.statuses) or "every status"
    reversal = {"self": "self-retracing", "pair": "with a reverse", None: "any reversal"}
    several = f", one of {len(a_values)} stadiums" if len(a_values) > 1 else ""
    stored = several if selection.a in (a_values or [selection.a]) else ", not filled"
    parts = [
        ("screen.choose_a", f"a = {exact(selection.a)}{stored}"),
        ("turn('periods')", f"p {spans or 'all'}"),
        ("turn('statuses')", status),
        ("turn('time_reversal')", reversal[selection.time_reversal]),
        ("screen.filter", escaped(selection.describe_rest()) or "no filter"),
    ]
    return " │ ".join(f"[@click={action}]{text}[/]" for action, text in parts)


def escaped(text: str) -> str:
    """Return a text escaped for markup."""
    return printable(text).replace("\\", "\\\\").replace("[", "\\[")
