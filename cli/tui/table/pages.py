"""Rows for the table: what is shown is read when it is shown, a block at a time."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from orbitdb.cli.tui.table.columns import USUAL
from orbitdb.columns import OF_ORBITS
from orbitdb.store.asking.selection import Selection
from orbitdb.store.reading.chosen import Chosen
from orbitdb.store.reading.lives import Standing, Standings, load_standings, sums
from orbitdb.store.reading.moment import Reader
from orbitdb.store.reading.places import periods_without, position_of

Row = tuple[Any, ...]

_BLOCK = 64
_KEPT = 32
_OF_ONE_A = tuple(column.name for column in OF_ORBITS if column.name != "status")


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
    """The rows of a subset in some order, the code first in each; the blocks that were read last are kept.

    At another *a*, rows are the ``stored`` ones with a `Standing` a class of the subset there, shape (C,),
    and what is not known there is blank. Without a catalogue there are no rows (`NONE`).
    """

    catalogue: Reader | None
    chosen: Chosen
    fields: Sequence[str]
    stored: "Pages | None" = None
    a: float | None = None
    standing: NDArray[np.uint8] | None = None

    def __post_init__(self) -> None:
        self._blocks: dict[int, list[Row]] = {}  # no cache of a method: it would keep all this in memory

    def __len__(self) -> int:
        return len(self.chosen)

    @property
    def pages(self) -> "Pages":
        """The rows as they are stored."""
        return self.stored or self

    @property
    def columns(self) -> list[str]:
        """The fields of which something is known."""
        return [name for name in self.fields if self.standing is None or name not in _OF_ONE_A]

    def row(self, place: int) -> Row:
        """Return one row."""
        number, within = divmod(place, _BLOCK)
        if number not in self._blocks:
            if len(self._blocks) == _KEPT:
                del self._blocks[next(iter(self._blocks))]
            self._blocks[number] = self._read(number)
        return self._blocks[number][within]

    def _read(self, number: int) -> list[Row]:
        """Read a block of rows."""
        first, end = number * _BLOCK, (number + 1) * _BLOCK
        if self.stored is not None:
            return [self._there(self.stored.row(place), place) for place in range(len(self))[first:end]]
        assert self.catalogue is not None
        with self.catalogue.moment() as moment:
            return [
                row for block in moment.blocks(self.chosen, self.fields, first, end) for row in block.rows()
            ]

    def position(self, word: str) -> int | None:
        """Return where a word, as a least rotation, stands."""
        if self.catalogue is None:
            return None
        with self.catalogue.moment() as moment:
            return position_of(moment.connection, self.chosen, word)

    # at another a

    @cached_property
    def births(self) -> tuple[Standings, list[int]]:
        """The births of the classes, and the periods of which none are stored."""
        assert self.catalogue is not None
        with self.catalogue.moment() as moment:
            standings = load_standings(moment.connection, self.chosen.ids)
            return standings, periods_without(moment.connection, self.chosen.ids, standings)

    def followed(self, a: float) -> "Pages":
        """Return the rows as they are at another *a*."""
        return replace(self, stored=self, a=a, standing=self.births[0].at(a))

    def _there(self, row: Row, place: int) -> Row:
        """Return a row as it is at the other a."""
        assert self.standing is not None
        standing = Standing(self.standing[self.chosen.classes(place, place + 1)[0]])
        now = dict.fromkeys(_OF_ONE_A) | {"status": standing.words}
        return tuple(now.get(name, value) for name, value in zip(self.fields, row, strict=True))

    def counts(self) -> dict[str, int]:
        """Return how many rows there are of each standing that occurs."""
        assert self.standing is not None
        found = sums(self.standing, self.chosen.counts)
        return {each.words: count for each, count in zip(Standing, found, strict=True) if count}


NONE = Pages(None, Chosen(Selection(), np.zeros(0, np.int64), np.zeros(0, np.uint8)), USUAL)
"""What there is before rows are read, and where none can be read."""
