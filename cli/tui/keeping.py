"""What is kept from one session to the next: columns, marked orbits, and filters by name.

It is one JSON file in the user's state folder. What is changed is read again before it is written, so that
two sessions side by side keep each other's marks.
"""

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field, fields, replace
from functools import partial
from pathlib import Path
from typing import Any

from textual.app import ComposeResult

from orbitdb.cli.render import code_text
from orbitdb.cli.tui.dialogs.lines import LineDialog
from orbitdb.cli.tui.dialogs.lists import KEEP, ColumnDialog, FiltersDialog, Names
from orbitdb.cli.tui.panels import Panels
from orbitdb.cli.tui.table.columns import USUAL, chosen
from orbitdb.errors import InputError, StoreError
from orbitdb.export import complete
from orbitdb.plaintext import printable
from orbitdb.store.asking.criteria import chosen_by
from orbitdb.store.asking.selection import Selection
from orbitdb.store.asking.where import check
from orbitdb.store.file.tokens import tokens
from orbitdb.symbols.words import least_rotation, parse_primitive

_LONGEST_NAME = 40

KeptCriteria = Mapping[str, Any]
"""A subset as stored in JSON, as arguments of `chosen_by`."""


@dataclass
class State:
    """What is kept: columns in their order, subsets of any catalogue by name, words as they were marked."""

    columns: list[str] = field(default_factory=lambda: list(USUAL))
    filters: dict[str, KeptCriteria] = field(default_factory=dict)
    marked: list[str] = field(default_factory=list)


class Kept:
    """The state, and the file that it is kept in, which need not exist; without one it is lost at the end.

    It complains of a file that cannot be used, which is then left as it is.
    """

    def __init__(self, path: Path | None, complain: Callable[[str], object]) -> None:
        self.path, self._complain = path, complain
        self.state = State()

    def load(self) -> bool:
        """Read the file, if there is one, and tell whether it can be used."""
        try:
            if self.path is not None:
                stored = json.loads(self.path.read_text(encoding="utf-8"))
                columns, filters, marked = (stored.get(each.name) or () for each in fields(State))
                self.state = State(
                    [str(name) for name in columns or USUAL],
                    {str(name): dict(criteria) for name, criteria in dict(filters).items()},
                    [*dict.fromkeys(least_rotation(parse_primitive(str(word))) for word in marked)],
                )
        except FileNotFoundError:
            pass
        except OSError as error:
            self._complain(f"{self.path} cannot be read ({error.strerror})")
            return False
        except (ValueError, TypeError, AttributeError, RecursionError):
            self._complain(f"{self.path} was not written by orbitdb: move it away")
            return False
        return True

    @contextmanager
    def changing(self) -> Iterator[State]:
        """Change the state in a block: here in any case, and then in the file."""
        usable = self.load()
        yield self.state
        if usable and self.path is not None:
            try:
                self.path.parent.mkdir(parents=True, exist_ok=True)
                with complete(self.path) as draft:
                    draft.write_text(json.dumps(asdict(self.state), indent=1) + "\n", encoding="utf-8")
            except (OSError, StoreError, InputError) as error:
                self._complain(f"{error}: what is chosen holds for now only")


def state_path() -> Path:
    """Return the file in the user's state folder."""
    from platformdirs import user_state_path

    return user_state_path("orbitdb") / "browse.json"


def among_marked(words: Sequence[str], where: str | None) -> str:
    """Return the expression that chooses marked words, within any filter."""
    marks = f"code({', '.join(map(repr, words))})"
    if not where:
        return marks
    # in one line, so a comment would hide the rest
    bare = "".join(" " if token.kind == "blank" else token.text for token in tokens(where))
    return f"({bare.strip()}) and {marks}"


def criteria_of(selection: Selection) -> KeptCriteria:
    """Return a subset as arguments of `chosen_by`, without a and empty criteria."""
    spans = ",".join(str(low) if low == high else f"{low}-{high}" for low, high in selection.periods)
    plain = {name: getattr(selection, name) for name in ("time_reversal", "symmetry", "contains", "where")}
    several = {"p": spans, "status": ",".join(selection.statuses), "exists": list(selection.exists),
               "not_at": list(selection.not_at), "parameters": dict(selection.parameters)}  # fmt: skip
    ranges = {name: list(bounds) for name, bounds in selection.ranges.items()}
    return {name: value for name, value in (plain | several | ranges).items() if value}


def selection_of(criteria: KeptCriteria, a: float) -> Selection:
    """Return a stored subset at some a; refuse an invalid one, for example written by hand."""
    try:
        parameters = dict(criteria.get("parameters") or {})
        return chosen_by(a=a, **{**criteria, "parameters": parameters})
    except (TypeError, ValueError, AttributeError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"{dict(criteria)!r:.60} is no filter of this program") from error


class Keeping(Panels):
    """The part of the main screen that lasts from session to session."""

    _unmarked_where: str | None = None
    _marked_where: str | None = None

    def compose(self) -> ComposeResult:
        """Lay out the panels, with the stored columns and marks."""
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
        """Show the marked orbits only, or the previous rows."""
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
        """Use a stored filter, or store the present one."""

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
