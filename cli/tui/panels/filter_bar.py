"""The choices that make up the rows: each change gives a new `Selection`, and a `View` writes them down."""

import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

from textual.reactive import reactive
from textual.widgets import Static

from orbitdb.catalogue import Catalogue
from orbitdb.cli.grids import half_length
from orbitdb.cli.output import code_text
from orbitdb.cli.tui.dialogs import FilterDialog, LineDialog, ListDialog, MarksDialog, Names
from orbitdb.cli.tui.screens import Working
from orbitdb.cli.tui.stored import USUAL, Kept, Ordering, begun_periods
from orbitdb.errors import SelectionError
from orbitdb.orbits.status import STORED, Status
from orbitdb.selection import Selection
from orbitdb.sql_text import bound_names
from orbitdb.store.where import check
from orbitdb.text import as_options, format_float, printable, shell_line

SHOWN = (Status.ORBIT, Status.DYNAMICAL, Status.BOUNDARY, Status.GEOMETRIC, Status.UNRESOLVED)
"""The statuses that rows can have, in the order in which lists show them."""

RINGS: dict[str, tuple[Any, ...]] = {
    "statuses": ((), *((status,) for status in SHOWN if status is not Status.GEOMETRIC)),  # O has it
    "time_reversal": (None, "self", "pair"),
}
"""The values of each criterion, in the order in which a key steps through them."""

_WITHIN = 1e-9
"""Relative difference within which a real number counts as equal to the one under the cursor."""


class View(NamedTuple):
    """The rows that are shown."""

    selection: Selection
    ordering: Ordering = Ordering()
    columns: tuple[str, ...] = USUAL
    by_class: bool = False

    def command(self, path: Path) -> str:
        """Return the shell command that writes these rows."""
        columns = ["--classes"] * self.by_class + ["-c", ",".join(self.columns)]
        return shell_line(["orbitdb", "query", "--db", str(path), *as_options(self._criteria()), *columns])

    def python(self, path: Path) -> str:
        """Return the line of Python that selects these rows, after ``from orbitdb import Catalogue``."""
        criteria = self._criteria() | ({"classes": True} if self.by_class else {})
        arguments = ", ".join(f"{name}={value!r}" for name, value in criteria.items())
        return f"Catalogue({str(path)!r}).select({arguments})"

    def _criteria(self) -> dict[str, Any]:
        """Return the arguments of `Catalogue.select` that give these rows."""
        order = {} if self.ordering == Ordering() else {"order": str(self.ordering)}
        return self.selection.criteria() | order


class FilterBar(Static, Working):
    """A line that states the chosen subset, with links to the actions that change it.

    While a filter is being typed, `trying` is true.
    """

    selection: reactive[Selection] = reactive(Selection, init=False, layout=False, repaint=False)
    trying: reactive[bool] = reactive(False, init=False, repaint=False)

    def __init__(self, catalogue: Catalogue, kept: Kept, selection: Selection) -> None:
        super().__init__(id="chips")
        self._catalogue, self._kept = catalogue, kept
        self.set_reactive(FilterBar.selection, selection)
        self._values = dict(selection.parameters)
        self._before_marks: str | None = None
        self._marks: str | None = None  # the filter that shows only marked orbits, once it has been chosen

    def say(self, fill: str = "") -> None:
        line = chips(self.selection, self._catalogue.a_values())
        self.update(f"[b]{fill}[/b] {line}" if fill else line)

    def action_turn(self, name: str, step: int = 1) -> None:
        """Move a criterion to its next or previous value; after its last value comes no restriction."""
        periods = ((), *(((p, p),) for p in begun_periods(self._catalogue, self.selection.a)))
        ring = RINGS.get(name, periods)
        if name == "statuses":
            usual = self.selection.usual_statuses
            ring = (usual, *ring[1:]) if usual == STORED else tuple(dict.fromkeys((*ring, usual)))
        self.selection = turned(self.selection, name, ring, step)

    def action_statuses(self) -> None:
        def take(statuses: Names) -> None:
            chosen = tuple(status for status in STORED if status in statuses)  # all of them are `STORED`
            self.selection = replace(self.selection, statuses=chosen)

        hint = "space marks, enter accepts; with no marks, all are shown"
        texts = {status.value: status.sentence for status in SHOWN}
        self.ask(MarksDialog("statuses", hint, texts, self.selection.statuses), take)

    def action_half_length(self) -> None:
        """Choose another a, stored or not."""
        values = [repr(a) for a in self._catalogue.a_values()]

        def describe(text: str) -> str:
            filled = repr(half_length(text)) in values
            return "filled" if filled else "nothing is filled there: press f to fill it, or c to solve a code"

        def take(text: str) -> None:
            self.selection = replace(self.selection, a=half_length(text))

        self.ask(LineDialog("half length a", repr(self.selection.a), "such as 1.6", describe, values), take)

    def ask_to_copy(self, view: View) -> None:
        """Copy a view as a shell command or as a line of Python."""
        path = self._catalogue.path
        lines = {"shell": view.command(path), "Python": view.python(path)}

        def take(language: str) -> None:
            self.app.copy_to_clipboard(lines[language])
            self.notify(f"copied {lines[language]}", timeout=4)

        texts = {language: f"{language:6}  {line}" for language, line in lines.items()}
        self.ask(ListDialog("copy the view", "enter copies", texts, "shell"), take)

    # filters

    def action_filter(self) -> None:
        """Edit the filter; the rows follow as you type, and `escape` restores the previous rows."""
        before = self.selection.where or ""

        def apply(where: str) -> None:
            if where != (self.selection.where or ""):
                self.selection = self.filtered(where or None)

        def take(where: str | None) -> None:
            apply(before if where is None else where)
            self.trying = False
            if typed := where or (dialog.tried if dialog.tried != before else ""):
                self._kept.remember(typed)

        self.trying = True
        dialog = FilterDialog(before, self.check_filter, self._kept.state.filters, apply)
        self.app.push_screen(dialog, take)

    def check_filter(self, where: str) -> str:
        try:
            check(where, dict(self.filtered(where).parameters))
        except SelectionError as error:  # without the line, which stands above, and advice for the shell
            message = str(error).removeprefix(f"where {where!r}: ")
            message = re.sub(r"[;,]? *`[^;]*|: give each :name .*", "", message)
            raise SelectionError(message) from error
        return ""

    def filtered(self, where: str | None) -> Selection:
        """Return the selection with another filter, the values that it uses, and its usual statuses."""
        used = bound_names(where or "")
        values_of_names = self._values | dict(self.selection.parameters)
        values = {name: value for name, value in values_of_names.items() if name in used}
        before = self.selection
        chosen = replace(before, where=where, parameters=values)
        usual = before.statuses == before.usual_statuses  # a filter by status then means every status
        return replace(chosen, statuses=chosen.usual_statuses) if usual else chosen

    def add(self, condition: str) -> None:
        self.selection = self.filtered(both(self.selection.where, condition))

    # marked orbits

    def action_marked(self) -> None:
        if self._shows_marked:
            self.selection = self.filtered(self._before_marks)
        else:
            self._choose_marked(self.selection.where)

    @property
    def _shows_marked(self) -> bool:
        return self._marks is not None and self.selection.where == self._marks

    def mark(self, word: str) -> frozenset[str]:
        """Mark or unmark a word; return all marked words."""
        with self._kept.changing() as state:
            verb = "unmarked" if word in state.marked else "marked"
            (state.marked.remove if word in state.marked else state.marked.append)(word)
        shown = "; press ' to show them" if state.marked else ""
        self.notify(f"{verb} {code_text(word)}, {len(state.marked)} in all{shown}", timeout=2)
        if self._shows_marked:
            self._choose_marked(self._before_marks)
        return frozenset(state.marked)

    def _choose_marked(self, where: str | None) -> None:
        """Choose the marked orbits that a filter allows; if none is marked, apply the filter alone."""
        if words := self._kept.state.marked:
            self._before_marks = where
            self._marks = both(where, f"code in ({', '.join(map(repr, words))})")
            self.selection = self.filtered(self._marks)
        else:
            self.notify("no orbit is marked: press * to mark one")
            self.selection = self.filtered(where)


def equals(column: str, value: object) -> str:
    """Return the SQL condition that a column has a value; real numbers may differ by a billionth."""
    match value:
        case None:
            return f"{column} is null"
        case float() if value:
            return f"abs({column} - {value!r}) <= {abs(value) * _WITHIN:.1g}"
        case int() | float():
            return f"{column} = {value!r}"
        case list():  # SQL has them as text
            return equals(column, ",".join(map(str, value)) or None)
    quoted = str(value).replace("'", "''")
    return f"{column} = '{quoted}'"


def both(where: str | None, condition: str) -> str:
    """Return a filter that allows what `where` and the condition allow."""
    if not where:
        return condition
    if "--" in where:  # a comment, which ends with its line
        where = f"({where}\n)"
    elif re.search(r"\bor\b", where, re.IGNORECASE):
        where = f"({where})"
    return f"{where} and {condition}"


def turned(selection: Selection, name: str, ring: Sequence[Any], step: int = 1) -> Selection:
    """Return the selection with a criterion moved along its ring; a value outside it counts as the first."""
    present = getattr(selection, name)
    place = ring.index(present) if present in ring else 0
    return replace(selection, **{name: ring[(place + step) % len(ring)]})


def chips(selection: Selection, a_values: Sequence[float]) -> str:
    """Return the choices as a line of links to the actions that change them, each with its key."""
    reversal = {"self": "self-retracing", "pair": "reversed pairs", None: "any reversal"}
    several = f", of {len(a_values)} values stored" if len(a_values) > 1 else ""
    stored = several if selection.a in (a_values or [selection.a]) else ", not filled"
    statuses = () if selection.statuses == STORED else selection.statuses
    parts = [
        ("half_length", "a", f"{format_float(selection.a)}{stored}"),
        ("turn('periods')", "\\[ ]", f"p {selection.criteria().get('p', 'all').replace(',', ', ')}"),
        ("turn('statuses')", "o", ", ".join(statuses) or "every status"),
        ("turn('time_reversal')", "r", reversal[selection.time_reversal]),
        ("filter", "/", escaped(selection.describe_rest()) or "no filter"),
    ]
    # a link would take the colour of all links, so the key stands before it
    line = (f"[b $key on $panel] {name}[/][@click={action}] {text} [/]" for action, name, text in parts)
    return " ".join(line)


def escaped(text: str) -> str:
    """Return a text with the markup characters of Textual escaped."""
    return printable(text).replace("\\", "\\\\").replace("[", "\\[")
