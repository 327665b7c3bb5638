"""The choices that make up the subset: each change gives a new `Selection`, which can describe itself."""

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
"""The statuses that rows can have, in the order in which lists show them."""

RINGS: dict[str, tuple[Any, ...]] = {
    "statuses": ((), *((status,) for status in SHOWN)),
    "time_reversal": (None, "self", "pair"),
}
"""The values of each criterion, in the order in which a key steps through them."""

_LONGEST_NAME = 40


class Choices(Static, Working):
    """A line that states the chosen subset, with links to the actions that change it."""

    selection: reactive[Selection] = reactive(Selection, init=False, layout=False, repaint=False)

    def __init__(self, file: CatalogueFile, kept: Kept, selection: Selection) -> None:
        super().__init__(id="chips")
        self._file, self._kept = file, kept
        self.set_reactive(Choices.selection, selection)
        self._values = dict(selection.parameters)
        self.tried = [selection.where] if selection.where else []  # filters used so far, the latest last
        self._unmarked_where: str | None = None
        self._marked_where: str | None = None

    def say(self, fill: str = "") -> None:
        """Show the choices, after the progress of any fill."""
        told = chips(self.selection, self._file.a_values())
        self.update(f"[b]{fill}[/b] │ {told}" if fill else told)

    def action_turn(self, name: str, step: int = 1) -> None:
        """Move a criterion to its next or previous value; after its last value comes no restriction."""
        periods = ((), *(((p, p),) for p in self._file.periods(self.selection.a)))
        self.selection = turned(self.selection, name, RINGS.get(name, periods), step)

    def action_statuses(self) -> None:
        """Choose statuses from a list."""

        def take(statuses: Names) -> None:
            self.selection = replace(self.selection, statuses=tuple(map(Status, statuses)))

        hint = "space marks, enter accepts; with no marks, all are shown"
        texts = {status.value: status.sentence for status in SHOWN}
        self.ask(MarksDialog("statuses", hint, texts, self.selection.statuses), take)

    def ask_for_a(self, take: Callable[[float], object]) -> None:
        """Ask for another a, stored or not."""
        values = [repr(a) for a in self._file.a_values()]

        def check(text: str) -> str:
            filled = repr(half_length(text)) in values
            return "filled" if filled else "nothing is filled there: press f to fill it, or c to solve a code"

        dialog = LineDialog("half length a", repr(self.selection.a), "such as 1.6", check, values)
        self.ask(dialog, lambda a: take(half_length(a)))

    # filters

    def check_filter(self, where: str) -> str:
        """Raise if a filter is invalid; return a hint if it compares codes with a word that no row has."""
        check(where, dict(self.filtered(where).parameters))
        return hint(where) or ""

    def filtered(self, where: str | None) -> Selection:
        """Return the selection with another filter and the values of -P that this filter uses."""
        used = names_in(where or "")
        known = self._values | dict(self.selection.parameters)
        values = {name: value for name, value in known.items() if name in used}
        return replace(self.selection, where=where, parameters=values)

    def _choose(self, wanted: Callable[[], Selection]) -> bool:
        """Choose the subset that `wanted` returns, or report why it cannot be used."""
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
        """Apply a saved filter, or save the current one."""

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
            self.notify("there is no filter to save: every word is shown; press / or o to choose some")
            return

        def check(name: str) -> str:
            if len(name.strip()) > _LONGEST_NAME or printable(name) != name:
                raise InputError(
                    f"{len(name.strip())} characters: use at most {_LONGEST_NAME}, all printable"
                )
            if name.strip() in self._kept.state.filters:
                return "a filter with this name exists and will be replaced"
            return self.selection.describe()

        def take(name: str) -> None:
            with self._kept.changing() as state:
                state.filters[name] = criteria
            self.notify(f"saved as {name}", timeout=2)

        self.ask(LineDialog("save this filter as", "", "short orbits", check), take)

    # marked orbits

    def action_marked(self) -> None:
        """Show only the marked orbits, or the previous rows again."""
        if self._shows_marked:
            self.selection = replace(self.selection, where=self._unmarked_where)
        else:
            self._choose_marked(self.selection.where)

    @property
    def _shows_marked(self) -> bool:
        return self._marked_where is not None and self.selection.where == self._marked_where

    def mark(self, word: str) -> frozenset[str]:
        """Mark or unmark a word; return all marked words."""
        with self._kept.changing() as state:
            verb = "unmarked" if word in state.marked else "marked"
            (state.marked.remove if word in state.marked else state.marked.append)(word)
        self.notify(f"{verb} {code_text(word)}, {len(state.marked)} in all; press ' to show them", timeout=2)
        if self._shows_marked:
            self._choose_marked(self._unmarked_where)
        return frozenset(state.marked)

    def _choose_marked(self, where: str | None) -> None:
        """Choose the marked orbits that a filter allows; if none is marked, apply the filter alone."""
        words = self._kept.state.marked
        if not words:
            self.notify("no orbit is marked: press * to mark one")
            self.selection = replace(self.selection, where=where)
            return
        wanted = among_marked(words, where)
        if self._choose(lambda: replace(self.selection, where=wanted)):
            self._unmarked_where, self._marked_where = where, wanted


def turned(selection: Selection, name: str, ring: Sequence[Any], step: int = 1) -> Selection:
    """Return the selection with a criterion moved along its ring; a value outside it counts as the first."""
    present = getattr(selection, name)
    place = ring.index(present) if present in ring else 0
    return replace(selection, **{name: ring[(place + step) % len(ring)]})


def chips(selection: Selection, a_values: Sequence[float]) -> str:
    """Return the choices as a line with links to the actions that change them."""
    spans = ", ".join(str(low) if low == high else f"{low}-{high}" for low, high in selection.periods)
    status = ", ".join(selection.statuses) or "every status"
    reversal = {"self": "self-retracing", "pair": "reversed pairs", None: "any reversal"}
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
    """Return a text with the markup characters of Textual escaped."""
    return printable(text).replace("\\", "\\\\").replace("[", "\\[")
