"""Rows for the table: what is shown is read when it is shown, a block at a time."""

from collections import OrderedDict
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from orbitdb.cli.tui.table.columns import USUAL
from orbitdb.columns import OF_ORBITS
from orbitdb.store.asking.selection import Selection

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from orbitdb.store.reading.catalogue import Catalogue
    from orbitdb.store.reading.chosen import Chosen

Row = tuple[Any, ...]

_BLOCK = 64
_KEPT = 32
_OF_ONE_A = tuple(column.name for column in OF_ORBITS if column.name not in ("a", "status"))


@dataclass(frozen=True)
class Ordering:
    """The column that rows are sorted by, and whether they fall."""

    column: str = "p"
    descending: bool = False

    def __str__(self) -> str:
        """Write it as `Catalogue.rows` reads it."""
        return f"{self.column} {'desc' if self.descending else 'asc'}"


@dataclass(eq=False)
class Pages:
    """The rows of a subset in some order; the last blocks that were read are kept.

    Attributes
    ----------
    catalogue : Catalogue
    chosen : Chosen
        The subset in its order.
    columns : sequence of str
        The columns of the table, the code first.
    whole : bool
        Whether all rows are there; if not, it is the first ones.
    """

    catalogue: "Catalogue"
    chosen: "Chosen"
    columns: Sequence[str]
    whole: bool = True
    _blocks: OrderedDict[int, list[Row]] = field(default_factory=OrderedDict, repr=False)

    def __len__(self) -> int:
        return len(self.chosen)

    @property
    def pages(self) -> "Pages":
        """These rows, as they are stored."""
        return self

    def row(self, place: int) -> Row:
        """Return one row."""
        number, within = divmod(place, _BLOCK)
        if number not in self._blocks:
            self._blocks[number] = self._read(number * _BLOCK)
            if len(self._blocks) > _KEPT:
                self._blocks.popitem(last=False)
        self._blocks.move_to_end(number)
        return self._blocks[number][within]

    def _read(self, first: int) -> list[Row]:
        blocks = self.catalogue.blocks(self.chosen, self.columns, first, first + _BLOCK)
        return [row for block in blocks for row in block.rows()]

    def position(self, word: str) -> int | None:
        """Return where a word, as a least rotation, stands."""
        from orbitdb.store.reading.order import position_of

        return position_of(self.catalogue, self.chosen, word)


@dataclass(frozen=True)
class NoRows:
    """What there is before rows are read, and where none can be read."""

    columns: Sequence[str] = USUAL
    whole: bool = False
    pages: None = None

    def __len__(self) -> int:
        return 0

    def row(self, place: int) -> Row:
        """Return nothing: there is no row."""
        raise IndexError(place)

    def position(self, word: str) -> None:
        """Return that a word is not there."""


@dataclass(frozen=True, eq=False)
class Followed:
    """The rows of a subset as they are at another a: what is not known there is blank.

    Attributes
    ----------
    pages : Pages
        The rows, as they are where they are stored.
    a : float
        The stadium that is looked at.
    standing : ndarray of uint8, shape (C,)
        A `Standing` a class of the subset.
    """

    pages: Pages
    a: float
    standing: "NDArray[np.uint8]"
    whole: bool = True

    @property
    def columns(self) -> Sequence[str]:
        """The columns that are known at any a."""
        return [name for name in self.pages.columns if name not in _OF_ONE_A]

    def __len__(self) -> int:
        return len(self.pages)

    def row(self, place: int) -> Row:
        """Return one row."""
        from orbitdb.store.reading.lives import Standing

        standing = Standing(self.standing[self.pages.chosen.classes(place, place + 1)[0]])
        now = dict.fromkeys(_OF_ONE_A) | {"status": standing.words}
        stored = self.pages.row(place)
        return tuple(now.get(name, value) for name, value in zip(self.pages.columns, stored, strict=True))

    def counts(self) -> dict[str, int]:
        """Return how many rows there are of each standing that occurs."""
        from orbitdb.store.reading.lives import Standing, sums

        found = sums(self.standing, self.pages.chosen.counts)
        return {each.words: count for each, count in zip(Standing, found, strict=True) if count}

    def position(self, word: str) -> int | None:
        """Return where a word stands."""
        return self.pages.position(word)


Source = NoRows | Pages | Followed


def head_of(catalogue: "Catalogue", selection: Selection, columns: Sequence[str], rows: int) -> Pages:
    """Find the first rows in their natural order."""
    return Pages(catalogue, catalogue.choose(selection, most=rows), columns, whole=False)
