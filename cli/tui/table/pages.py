"""The rows of the table, read in blocks when they are shown."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from textual.cache import LRUCache

from orbitdb.cli.tui.columns import USUAL
from orbitdb.columns import OF_ORBITS
from orbitdb.store.asking.selection import Selection
from orbitdb.store.reading.lives import Standing, Standings, load_standings, sums
from orbitdb.store.reading.matching import periods_without, position_of
from orbitdb.store.reading.moment import Reader
from orbitdb.store.reading.rows import Chosen

Row = tuple[Any, ...]

_BLOCK = 64
_KEPT = 32
_OF_ONE_A = tuple(column.name for column in OF_ORBITS if column.name != "status")


@dataclass(frozen=True)
class Ordering:
    """The sort column, and whether the order is descending."""

    column: str = "p"
    descending: bool = False

    def __str__(self) -> str:
        """Return the order in the form that `Catalogue.rows` takes, such as ``p desc``."""
        return f"{self.column} {'desc' if self.descending else 'asc'}"


@dataclass(eq=False)
class Pages:
    """The rows of a subset in some order, each with the code first; the most recently read blocks are cached.

    At another *a*, these are the rows of `stored`, and `standing`, shape (C,), has the `Standing` of each
    class there; values that are not known there are blank. Without a catalogue there are no rows (`NONE`).
    """

    catalogue: Reader | None
    chosen: Chosen
    fields: Sequence[str]
    stored: "Pages | None" = None
    a: float | None = None
    standing: NDArray[np.uint8] | None = None

    def __post_init__(self) -> None:
        self._blocks: LRUCache[int, list[Row]] = LRUCache(_KEPT)  # a cached method would keep it alive

    def __len__(self) -> int:
        return len(self.chosen)

    @property
    def pages(self) -> "Pages":
        """The rows as they are stored."""
        return self.stored or self

    @property
    def columns(self) -> list[str]:
        """The fields whose values are known at this a."""
        return [name for name in self.fields if self.standing is None or name not in _OF_ONE_A]

    def row(self, place: int) -> Row:
        """Return the row at an index."""
        number, within = divmod(place, _BLOCK)
        if number not in self._blocks:
            self._blocks[number] = self._read(number)
        return self._blocks[number][within]

    def _read(self, number: int) -> list[Row]:
        """Read the rows of a block."""
        first, end = number * _BLOCK, (number + 1) * _BLOCK
        if self.stored is not None:
            return [self._there(self.stored.row(place), place) for place in range(len(self))[first:end]]
        assert self.catalogue is not None
        with self.catalogue.moment() as moment:
            return list(moment.rows(self.chosen, self.fields, first, end))

    def position(self, word: str) -> int | None:
        """Return the index of the row of a word, given as its least rotation, or None."""
        if self.catalogue is None:
            return None
        with self.catalogue.moment() as moment:
            return position_of(moment.connection, self.chosen, word)

    # at another a

    @cached_property
    def births(self) -> tuple[Standings, list[int]]:
        """The births and deaths of the classes, and the periods without stored births."""
        assert self.catalogue is not None
        with self.catalogue.moment() as moment:
            standings = load_standings(moment.connection, self.chosen.ids)
            return standings, periods_without(moment.connection, self.chosen.ids, standings)

    def followed(self, a: float) -> "Pages":
        """Return these rows at another *a*, where births and deaths decide their statuses."""
        return replace(self, stored=self, a=a, standing=self.births[0].at(a))

    def _there(self, row: Row, place: int) -> Row:
        """Return a stored row as it is at this a, with its status there and blanks for unknown values."""
        assert self.standing is not None
        standing = Standing(self.standing[self.chosen.classes(place, place + 1)[0]])
        now = dict.fromkeys(_OF_ONE_A) | {"status": standing.words}
        return tuple(now.get(name, value) for name, value in zip(self.fields, row, strict=True))

    def counts(self) -> dict[str, int]:
        """Return the number of rows with each standing that occurs."""
        assert self.standing is not None
        found = sums(self.standing, self.chosen.counts)
        return {each.words: count for each, count in zip(Standing, found, strict=True) if count}


NONE = Pages(None, Chosen(Selection(), np.zeros(0, np.int64), np.zeros(0, np.uint8)), USUAL)
"""No rows: the table shows this before any rows are read, and if none can be read."""
