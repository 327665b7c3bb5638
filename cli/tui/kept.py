"""What is saved from one session to the next: columns, marked orbits, and named filters.

All of it is in one JSON file in the user's state folder. Each change first reads the file again, so two
sessions that run at the same time keep each other's marks.
"""

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field, fields
from pathlib import Path
from typing import Any

from orbitdb.cli.tui.columns import USUAL
from orbitdb.errors import InputError, StoreError
from orbitdb.export import complete
from orbitdb.store.asking.criteria import chosen_by
from orbitdb.store.asking.selection import Selection
from orbitdb.store.file.tokens import tokens
from orbitdb.symbols.words import least_rotation, parse_primitive

KeptCriteria = Mapping[str, Any]
"""A subset as stored in JSON: the arguments of `chosen_by`, by name."""


@dataclass
class State:
    """The saved columns in order, filters (for any catalogue) by name, and words in the order of marking."""

    columns: list[str] = field(default_factory=lambda: list(USUAL))
    filters: dict[str, KeptCriteria] = field(default_factory=dict)
    marked: list[str] = field(default_factory=list)


class Kept:
    """The state and its file, which need not exist. Without a path, the state lasts for the session.

    A file that cannot be used is reported and left unchanged.
    """

    def __init__(self, path: Path | None, complain: Callable[[str], object]) -> None:
        self.path, self._complain = path, complain
        self.state = State()

    def load(self) -> bool:
        """Read the file, if there is one; return whether the file can be used."""
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
        """Let a block change the state, then write it to the file, unless the file cannot be used."""
        usable = self.load()
        yield self.state
        if usable and self.path is not None:
            try:
                self.path.parent.mkdir(parents=True, exist_ok=True)
                with complete(self.path) as draft:
                    draft.write_text(json.dumps(asdict(self.state), indent=1) + "\n", encoding="utf-8")
            except (OSError, StoreError, InputError) as error:
                self._complain(f"{error}: your choice lasts for this session only")


def state_path() -> Path:
    """Return the path of the state file, which is in the user's state folder."""
    from platformdirs import user_state_path

    return user_state_path("orbitdb") / "browse.json"


def among_marked(words: Sequence[str], where: str | None) -> str:
    """Return the filter that chooses the marked words, or those of them that `where` also allows."""
    marks = f"code({', '.join(map(repr, words))})"
    if not where:
        return marks
    # the filter becomes one line, in which a comment would hide what follows
    bare = "".join(" " if token.kind == "blank" else token.text for token in tokens(where))
    return f"({bare.strip()}) and {marks}"


def criteria_of(selection: Selection) -> KeptCriteria:
    """Return a subset as arguments of `chosen_by`, leaving out a and empty criteria."""
    spans = ",".join(str(low) if low == high else f"{low}-{high}" for low, high in selection.periods)
    plain = {name: getattr(selection, name) for name in ("time_reversal", "symmetry", "contains", "where")}
    several = {"p": spans, "status": ",".join(selection.statuses), "exists": list(selection.exists),
               "not_at": list(selection.not_at), "parameters": dict(selection.parameters)}  # fmt: skip
    ranges = {name: list(bounds) for name, bounds in selection.ranges.items()}
    return {name: value for name, value in (plain | several | ranges).items() if value}


def selection_of(criteria: KeptCriteria, a: float) -> Selection:
    """Return a saved subset at the given a; raise if it is invalid, for example after editing by hand."""
    try:
        parameters = dict(criteria.get("parameters") or {})
        return chosen_by(a=a, **{**criteria, "parameters": parameters})
    except (TypeError, ValueError, AttributeError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"{dict(criteria)!r:.60} is not a valid filter") from error
