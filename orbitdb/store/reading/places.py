"""Where the wanted rows of a subset are: by which words they are looked up, without a pass over all of them.

What stands before them in their order is counted by classes, and not read.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import sqlalchemy as sa

from orbitdb.columns import kind_of
from orbitdb.store.asking.conditions import answering
from orbitdb.store.asking.confinement import Patience
from orbitdb.store.asking.selection import Selection
from orbitdb.store.file.schema import sequence
from orbitdb.store.reading.class_first import (
    OF_FEW_VALUES,
    few_classes,
    few_words,
    is_long,
    orders,
    pruned_words,
    ragged_periods,
    words_of,
)
from orbitdb.store.reading.class_view import class_view
from orbitdb.store.reading.counted_words import Words, by_periods
from orbitdb.store.reading.first_rows import MOST, Asked, Keys, first_words, keys_before_words

_VALUED = np.dtype("f8,i8")


@dataclass(frozen=True)
class Place:
    """Where rows are.

    Attributes
    ----------
    words : list of str
        Least rotations; the wanted rows are among those of these words.
    before : int
        How many rows of the subset come before all of these in the order that is asked for.
    """

    words: list[str]
    before: int = 0


def place_of(
    connection: sa.Connection,
    selection: Selection,
    order: str,
    limit: int | None,
    offset: int,
    patience: Patience,
) -> Place | None:
    """Return where the wanted rows of a subset are; None if only a pass over all words can tell.

    Parameters
    ----------
    connection : Connection
    selection : Selection
    order : str
    limit, offset : int
        As in `orbitdb.store.reading.catalogue.Catalogue.rows`.
    patience : Patience
    """
    wanted, usual = None if limit is None else limit + offset, limit is None or 0 < limit <= MOST
    words = few_words(connection, selection, order, wanted, patience)
    if words is not None:
        return Place(words)
    asked, keys = Asked(connection, selection, patience), keys_before_words(order)
    if usual and is_long(connection) and not asked.by_class:
        place = _of_single_words(asked, keys, limit, offset)
        if place is not None:
            return place
    words = first_words(connection, selection, order, wanted, patience)
    if words is not None:
        return Place(words)
    if limit is None or not usual or limit + offset <= MOST or not is_long(connection):
        return None
    if not asked.by_class or ragged_periods(connection) or pruned_words(connection, selection):
        return None
    return _behind(asked, keys, limit, offset)


def _of_single_words(asked: Asked, keys: Keys, limit: int | None, offset: int) -> Place | None:
    """Return where rows are of which patterns are asked; None if they are many, in another order."""
    periods = by_periods(asked)
    if periods is None:
        return None
    if not keys and limit is not None:
        return Place(list(_words_behind(periods, limit, offset)), offset)
    found: list[str] = []
    for words in periods:
        if len(found) + words.rows > MOST:
            return None
        found += words.between(0, words.rows)
    return Place(found)


def _words_behind(periods: Iterator[Words], limit: int, offset: int) -> Iterator[str]:
    """Yield the words of rows behind an offset in the order of the table."""
    for words in periods:
        first, last = min(offset, words.rows), min(offset + limit, words.rows)
        yield from words.between(first, last)
        offset, limit = offset - first, limit - (last - first)
        if not limit:
            return


def _behind(asked: Asked, keys: Keys, limit: int, offset: int) -> Place | None:
    if not keys:
        return Place(list(_in_order_of_table(asked, limit, offset)), offset)
    (name, falling), *rest = keys
    if name in OF_FEW_VALUES:
        return _behind_values(asked, name, falling, rest, limit, offset)
    if name in class_view().c and kind_of(name) == "number":
        return _behind_numbers(asked, name, falling, rest, limit, offset)
    return None


def _shifted(place: Place | None, rows: int) -> Place | None:
    return None if place is None else replace(place, before=place.before + rows)


def _in_order_of_table(asked: Asked, limit: int, offset: int) -> Iterator[str]:
    """Yield the words of rows behind an offset."""
    wanted = [p for p in orders(asked.connection) if asked.selection.includes(p)]
    if not asked.whole_periods.keys() >= set(wanted):
        yield from _words_behind(by_periods(asked) or iter(()), limit, offset)
        return
    for p in wanted:
        rows = asked.whole_periods[p]
        if offset < rows:
            here = sa.select(sequence.c.word).where(sequence.c.p == p).order_by(sequence.c.word)
            found = asked.connection.scalars(here.limit(limit).offset(offset)).all()
            limit -= len(found)
            yield from found
        offset = max(offset - rows, 0)


def _behind_values(
    asked: Asked, name: str, falling: bool, rest: Keys, limit: int, offset: int
) -> Place | None:
    """Pass over all rows of one value after the other."""
    before = 0
    for value, rows in _rows_of_values(asked, name, falling):
        if offset < before + rows:
            inside = offset + limit <= before + rows
            found = _behind(asked.where(name, value), rest, limit, offset - before) if inside else None
            return _shifted(found, before)
        before += rows
    return Place([], before)


def _rows_of_values(asked: Asked, name: str, falling: bool) -> list[tuple[Any, int]]:
    """Return the values of a column of few values in their order, none last, each with its rows."""
    known = class_view().c
    rows = asked.all(asked.classes(known[name], sa.func.sum(known.class_size)).group_by(known[name]))
    found = sorted(((value, count) for value, count in rows if value is not None), reverse=falling)
    return found + [(value, count) for value, count in rows if value is None]


def _behind_numbers(
    asked: Asked, name: str, falling: bool, rest: Keys, limit: int, offset: int
) -> Place | None:
    """Pass over the classes of smaller numbers, or greater ones; those without a number are last."""
    known = class_view().c
    query = asked.classes(known[name], known.class_size).where(known[name].is_not(None))
    with answering(asked.connection, asked.selection, asked.patience):
        cursor = asked.connection.execute(query).cursor
        pairs = np.fromiter(iter(cursor.fetchone, None), _VALUED)
    numbers, sizes = pairs["f0"], pairs["f1"]
    total = int(sizes.sum())
    if offset >= total:
        return _shifted(_behind(asked.where(name, None), rest, limit, offset - total), total)
    if offset + limit > total:
        return None
    order = np.argsort(-numbers if falling else numbers)
    ends = np.cumsum(sizes[order])
    places = np.searchsorted(ends, [offset, offset + limit - 1], side="right")
    first, last = numbers[order[places]].tolist()
    before = int(sizes[numbers > first if falling else numbers < first].sum())
    least = asked.classes(known.representative, known.p).where(
        known[name].between(min(first, last), max(first, last))
    )
    few = few_classes(asked.connection)
    found = asked.all(least.limit(few + 1))
    return Place(words_of(found), before) if len(found) <= few else None
