"""Rows for the table: what is shown is read when it is shown, a block at a time."""

from collections import OrderedDict
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from orbitdb.store.asking.selection import Selection

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from orbitdb.store.reading.catalogue import Catalogue
    from orbitdb.store.reading.class_index import Index
    from orbitdb.store.reading.ordered import Ordered

Row = tuple[Any, ...]

_BLOCK = 64
_KEPT = 32
_OF_ONE_A = (
    "length", "lambda_d", "lambda_c", "lyapunov", "margin", "error", "length_error", "lyapunov_error",
    "residual", "iterations", "solver",
)  # fmt: skip


@dataclass(frozen=True)
class Ordering:
    """The column that rows are sorted by, and whether they fall."""

    column: str = "p"
    descending: bool = False


@dataclass
class Head:
    """The first rows of a subset, for the time until all keys are known.

    Attributes
    ----------
    rows : list of tuple
        The columns of the table, the code first.
    """

    rows: list[Row]
    columns: Sequence[str]

    def __len__(self) -> int:
        return len(self.rows)

    def row(self, place: int) -> Row | None:
        """Return one row."""
        return self.rows[place]

    def position(self, word: str) -> int | None:
        """Return where a word stands."""
        return next((place for place, row in enumerate(self.rows) if row[0] == word), None)


@dataclass
class Pages:
    """All rows of a subset in some order; the last blocks that were read are kept.

    Attributes
    ----------
    catalogue : Catalogue
    index : Index
        The sequences at one a.
    keys : Ordered
        The subset in its order.
    columns : sequence of str
        The columns of the table, the code first.
    """

    catalogue: "Catalogue"
    index: "Index"
    keys: "Ordered"
    columns: Sequence[str]
    _blocks: OrderedDict[int, list[Row | None]] = field(default_factory=OrderedDict)

    def __len__(self) -> int:
        return len(self.keys)

    def row(self, place: int) -> Row | None:
        """Return one row; None if it has gone."""
        number, within = divmod(place, _BLOCK)
        if number not in self._blocks:
            self._blocks[number] = self._read(number)
            if len(self._blocks) > _KEPT:
                self._blocks.popitem(last=False)
        self._blocks.move_to_end(number)
        return self._blocks[number][within]

    def _read(self, number: int) -> list[Row | None]:
        from orbitdb.store.reading.pages import fetch

        keys = self.keys[number * _BLOCK : (number + 1) * _BLOCK]
        return fetch(self.catalogue, self.index, keys, self.columns)

    def position(self, word: str) -> int | None:
        """Return where a word, as a least rotation, stands."""
        return self.keys.position(word)


@dataclass(frozen=True)
class Followed:
    """The rows of a subset as they are at another a: what is not known there is blank.

    Attributes
    ----------
    pages : Pages
        The rows, as they are where they are stored.
    a : float
        The stadium that is looked at.
    standing : ndarray of uint8, shape (C,)
        A `Standing` a class of the index.
    """

    pages: Pages
    a: float
    standing: "NDArray[np.uint8]"

    @property
    def columns(self) -> Sequence[str]:
        """The columns that are known at any a."""
        return [name for name in self.pages.columns if name not in _OF_ONE_A]

    def __len__(self) -> int:
        return len(self.pages)

    def row(self, place: int) -> Row | None:
        """Return one row; None if it has gone."""
        stored = self.pages.row(place)
        if stored is None:
            return None
        now = dict.fromkeys(_OF_ONE_A) | {"status": self._words(stored[0])}
        return tuple(now.get(name, value) for name, value in zip(self.pages.columns, stored, strict=True))

    def _words(self, word: str) -> str:
        from orbitdb.store.reading.standings import Standing

        number = self.pages.index.class_of(word)
        return Standing(Standing.UNKNOWN if number is None else self.standing[number]).words

    def counts(self) -> dict[str, int]:
        """Return how many rows there are of each standing that occurs."""

        from orbitdb.store.reading.standings import Standing

        words = self.pages.keys.words_of_classes()
        found = [int(words[self.standing == each].sum()) for each in Standing]
        return {each.words: count for each, count in zip(Standing, found, strict=True) if count}

    def position(self, word: str) -> int | None:
        """Return where a word stands."""
        return self.pages.position(word)


Source = Head | Pages | Followed


def head_of(catalogue: "Catalogue", selection: Selection, columns: Sequence[str], rows: int) -> Head:
    """Read the first rows in the order of period and word."""
    return Head(list(catalogue.rows(selection, columns, limit=rows)), columns)
