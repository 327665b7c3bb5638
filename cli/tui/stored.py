"""What the screen reads and keeps: the catalogue, pages of its rows, and choices kept between sessions."""

import json
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import asdict, dataclass, field, fields
from pathlib import Path
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray
from textual.cache import LRUCache

from orbitdb.catalogue import Catalogue
from orbitdb.columns import IN_CATALOGUE
from orbitdb.errors import DeletedError, InputError, StoreError
from orbitdb.output_files import atomic_file
from orbitdb.selection import Selection
from orbitdb.store.select import Words, row_key_of, row_keys_of, rows_at, rows_of
from orbitdb.symbols.words import least_rotation, parse_primitive

_MOST_FILTERS = 50


def stamp_of(path: Path) -> tuple[int, ...]:
    """Return numbers that change whenever somebody writes to a catalogue."""
    stamps = []
    for ending in ("", "-wal"):
        with suppress(OSError):
            found = Path(f"{path}{ending}").stat()
            stamps += [found.st_mtime_ns, found.st_size, found.st_ino]
    return tuple(stamps)


def begun_periods(catalogue: Catalogue, a: float) -> list[int]:
    """Return the periods that are filled at this a, completely or in part."""
    return [fill.p for fill in catalogue.fills(a=a)]


USUAL = (
    "code", "p", "length", "status", "lambda_d", "lambda_c", "lyapunov", "time_reversal", "symmetry",
    "class_size", "margin", "error",
)  # fmt: skip
"""Names of the default columns."""

_IN_TABLE = {column.name: column for column in IN_CATALOGUE if column.name != "a"}  # all rows have the same a

SHOWABLE = {name: _IN_TABLE[name] for name in dict.fromkeys((*USUAL, *_IN_TABLE))}
"""All columns of the view ``catalogue`` that the table can show, by name."""


def known_columns(names: Iterable[str]) -> tuple[str, ...]:
    """Return those names that are columns, the code first."""
    return tuple(dict.fromkeys(["code", *(name for name in names if name in SHOWABLE)]))


class Ordering(NamedTuple):
    """The sort column, and whether the order is descending."""

    column: str = "p"
    descending: bool = False

    @classmethod
    def of(cls, text: str) -> Self:
        """Return the order that a text such as ``p desc`` names; the default one for an unknown column."""
        column, _, way = text.partition(" ")
        return cls(column, way == "desc") if column in SHOWABLE else cls()

    def __str__(self) -> str:
        """Return the order as `Catalogue.rows` and ``--order`` take it, such as ``p desc``."""
        return self.column + (" desc" if self.descending else "")


def said_by(selection: Selection) -> frozenset[str]:
    """Return the columns that say the same on every row, because the selection chooses one value."""
    (low, high), *others = selection.periods or ((0, 1),)
    said = {
        "status": len(selection.statuses) == 1,
        "time_reversal": selection.time_reversal is not None,
        "symmetry": selection.symmetry is not None,
        "p": low == high and not others,
    }
    return frozenset(name for name, same in said.items() if same)


Row = tuple[Any, ...]

_BLOCK = 64
_KEPT = 32


@dataclass(eq=False)
class Pages:
    """The rows of a subset in some order, each with the code first; the most recently read blocks are cached.

    The keys of all rows are kept as one array, so that the last row, and the row of a word, take no longer
    than the first. Without them, only the first rows are known. Without a catalogue there are no rows
    (`NONE`).
    """

    catalogue: Catalogue | None
    chosen: Words
    fields: Sequence[str]
    size: int = 0
    keys: NDArray[np.void] | None = None

    def __post_init__(self) -> None:
        self._blocks: LRUCache[int, list[Row]] = LRUCache(_KEPT)  # a cached method would keep it alive

    @classmethod
    def read(
        cls,
        catalogue: Catalogue,
        selection: Selection,
        ordering: Ordering,
        fields: Sequence[str],
        then: Catalogue,
        by_class: bool = False,
    ) -> Self:
        """Find the rows of a subset in a given order at one moment; later, they are read as they then are."""
        chosen = Words(selection, str(ordering), by_class)
        with then._reading() as connection:
            keys = row_keys_of(connection, chosen)
        return cls(catalogue, chosen, fields, len(keys), keys)

    @classmethod
    def first(
        cls, catalogue: Catalogue, selection: Selection, fields: Sequence[str], then: Catalogue, most: int
    ) -> Self:
        """Find the first rows of a subset in natural order, at most a given number, at one moment."""
        return cls(catalogue, Words(selection), fields, min(then.count(selection), most))

    def __len__(self) -> int:
        return self.size

    def row(self, place: int) -> Row:
        number, within = divmod(place, _BLOCK)
        if number not in self._blocks:
            assert self.catalogue is not None
            first, last = number * _BLOCK, (number + 1) * _BLOCK
            with self.catalogue._reading() as connection:
                self._blocks[number] = (
                    list(rows_of(connection, self.chosen, self.fields, first, last))
                    if self.keys is None
                    else rows_at(connection, self.chosen, self.fields, self.keys[first:last])
                )
        if within >= len(self._blocks[number]):
            self._blocks.discard(number)
            raise DeletedError("some of the rows")
        return self._blocks[number][within]

    def position(self, word: str) -> int | None:
        """Return the index of the row of a word, given as its least rotation, or None."""
        if self.catalogue is None or self.keys is None:
            return None
        with self.catalogue._reading() as connection:
            key = row_key_of(connection, self.chosen, word)
        if key is None:
            return None
        number, element = key
        found = np.flatnonzero((self.keys["id"] == number) & (self.keys["element"] == element))
        return int(found[0]) if len(found) else None


NONE = Pages(None, Words(Selection()), USUAL)
"""No rows: the table shows this before any rows are read, and if none can be read."""


@dataclass
class State:
    """Columns in order, words in the order of marking, and the filters used so far, the latest last.

    `order` is that of the rows, such as ``length desc``; with `classes`, each class has one row; `theme` is
    that of the screen, or empty.
    """

    columns: list[str] = field(default_factory=lambda: list(USUAL))
    marked: list[str] = field(default_factory=list)
    filters: list[str] = field(default_factory=list)
    order: str = "p"
    classes: bool = False
    theme: str = ""


class Kept:
    """The state and its JSON file, which need not exist. Without a path, the state lasts for the session.

    Each change first reads the file again, so two sessions that run at the same time keep each other's marks.
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
                columns, marked, filters, order, classes, theme = (
                    stored.get(entry.name) or () for entry in fields(State)
                )
                self.state = State(
                    [str(name) for name in columns or USUAL],
                    [*dict.fromkeys(least_rotation(parse_primitive(str(word))) for word in marked)],
                    [str(where) for where in filters],
                    str(Ordering.of(str(order or "p"))),
                    bool(classes),
                    str(theme or ""),
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
                with atomic_file(self.path) as draft:
                    draft.write_text(json.dumps(asdict(self.state), indent=1) + "\n", encoding="utf-8")
            except (OSError, StoreError, InputError) as error:
                self._complain(f"{error}: your choice lasts for this session only")

    def remember(self, where: str) -> None:
        """Keep a filter, so that it can be recalled; the oldest of more than 50 is forgotten."""
        with self.changing() as state:
            others = [entry for entry in state.filters if entry != where]
            state.filters = [*others[-_MOST_FILTERS + 1 :], where]


def state_path() -> Path:
    """Return the path of the state file, which is in the user's state folder."""
    from platformdirs import user_state_path

    return user_state_path("orbitdb") / "browse.json"
