"""The rows of the table, read in blocks when they are shown, and the rows that typed digits stand for."""

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np
from textual.cache import LRUCache

from orbitdb.cli.tui.view import USUAL
from orbitdb.store.asking.selection import Selection
from orbitdb.store.asking.where import never
from orbitdb.store.reading.moment import Reader
from orbitdb.store.reading.question import first_beginning, first_of_period, position_of
from orbitdb.store.reading.rows import Chosen
from orbitdb.symbols.words import SYMBOLS, WordError, least_rotation, parse_primitive

Row = tuple[Any, ...]

_BLOCK = 64
_KEPT = 32


@dataclass(eq=False)
class Pages:
    """The rows of a subset in some order, each with the code first; the most recently read blocks are cached.

    Without a catalogue there are no rows (`NONE`).
    """

    catalogue: Reader | None
    chosen: Chosen
    fields: Sequence[str]

    def __post_init__(self) -> None:
        self._blocks: LRUCache[int, list[Row]] = LRUCache(_KEPT)  # a cached method would keep it alive

    def __len__(self) -> int:
        return len(self.chosen)

    def row(self, place: int) -> Row:
        """Return the row at an index."""
        number, within = divmod(place, _BLOCK)
        if number not in self._blocks:
            assert self.catalogue is not None
            with self.catalogue.moment() as moment:
                first = number * _BLOCK
                self._blocks[number] = list(moment.rows(self.chosen, self.fields, first, first + _BLOCK))
        return self._blocks[number][within]

    def position(self, word: str) -> int | None:
        """Return the index of the row of a word, given as its least rotation, or None."""
        if self.catalogue is None:
            return None
        with self.catalogue.moment() as moment:
            return position_of(moment.connection, self.chosen, word)


NONE = Pages(None, Chosen(Selection(), np.zeros(0, np.int64), np.zeros(0, np.uint8)), USUAL)
"""No rows: the table shows this before any rows are read, and if none can be read."""

Place = tuple[int | None, str]
"""The index of a row, or None, and a description of what was found there."""


def place_of(pages: Pages, typed: str, cancelled: Callable[[], bool] = never) -> Place:
    """Return the index of the first row that the typed digits stand for, and a description of it.

    A number of one or two digits is a period if there are rows of that period. Anything else is a code: a
    word in any rotation, or the beginning of the code of a row. Once `cancelled` returns True, this raises
    `CancelledError`.
    """
    assert pages.catalogue is not None
    period = int(typed) if len(typed) <= 2 and typed[0] != "0" else 0
    with pages.catalogue.moment() as moment:
        connection = moment.connection
        place = first_of_period(connection, pages.chosen, period) if period else None
        if place is not None:
            return place, f"period {period}"
        if not set(typed) <= set(SYMBOLS):
            return None, f"no period {period}" if period else f"no code {typed}"
        with suppress(WordError):
            place = position_of(connection, pages.chosen, least_rotation(parse_primitive(typed)))
        if place is None:
            place = first_beginning(connection, pages.chosen, typed, cancelled)
    return place, f"code {typed}" if place is not None else f"no code {typed}"
