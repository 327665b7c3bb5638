"""Pages of a chosen subset in any order, without reading the rows that are not shown.

Conditions and sort keys that belong to a class are asked for once a class, an eighth of the words
(`orbitdb.store.reading.class_values`). A page is fetched by the primary keys of its rows, so it costs the
same at the beginning and at the end of a million.
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from itertools import groupby
from typing import Any

import numpy as np
import sqlalchemy as sa
from numpy.typing import NDArray

from orbitdb.store.asking.confinement import never
from orbitdb.store.asking.selection import Selection, SelectionError
from orbitdb.store.file.schema import catalogue as view
from orbitdb.store.file.schema import certificate, cycle, stadium
from orbitdb.store.reading.class_index import Index
from orbitdb.store.reading.class_values import CancelledError, Values, chosen_classes, class_values
from orbitdb.store.reading.index_reading import load_index
from orbitdb.store.reading.ordered import ByText, Listed, Ordered, by_class, grouped
from orbitdb.store.reading.pattern_places import fitting_places
from orbitdb.store.reading.period_words import Integers
from orbitdb.store.reading.reader import Reader
from orbitdb.store.reading.text_order import texts_of
from orbitdb.store.reading.text_parts import text_parts
from orbitdb.store.reading.word_conditions import chosen_words, same_for_texts

__all__ = ["CancelledError", "certificate_of", "chosen_keys", "fetch", "load_index"]

_BLOCK = 4096
_PIECE = 1 << 20
_TEXTS = ("code", "word")


def chosen_keys(
    reader: Reader,
    index: Index,
    selection: Selection,
    column: str = "p",
    descending: bool = False,
    cancelled: Callable[[], bool] = never,
) -> Ordered:
    """Return the rows of a chosen subset, as keys, in the order of one column, then of (p, word).

    The order is the same as that of `Catalogue.rows`.

    Parameters
    ----------
    reader : Reader
    index : Index
        Of the same a as the selection.
    selection : Selection
    column : str, optional
        A column of the view ``catalogue``.
    descending : bool, optional
    cancelled : callable, optional
        Asked now and then whether to stop.

    Raises
    ------
    SelectionError
        If ``where`` is refused.
    CancelledError
        If it is told to stop.
    """
    by_text = column in _TEXTS and not index.long_words
    plain = column == "p" and not descending
    with _unless(cancelled):
        values = None if by_text or plain else class_values(reader, index, column, cancelled)
        if values is None and not (by_text or plain):
            return _scanned(
                reader, index, selection, f"{column} {'desc' if descending else 'asc'}", cancelled
            )
        found = _in_order(reader, index, selection, values, by_text, descending, cancelled)
    if cancelled():
        raise CancelledError
    found.prepare()
    return found


def _in_order(
    reader: Reader,
    index: Index,
    selection: Selection,
    values: Values | None,
    by_text: bool,
    descending: bool,
    cancelled: Callable[[], bool],
) -> Ordered:
    """Return the rows of a subset by their texts, by values of their classes, or by period and word."""
    parts = text_parts(selection)
    if parts is not None and not parts.patterns:
        chosen = chosen_classes(reader, index, selection, cancelled)
        if by_text:
            return ByText(index, chosen, descending)
        return by_class(index, chosen, values, descending)
    places = None
    if parts is not None:
        chosen = chosen_classes(reader, index, parts.classes, cancelled)
        places = fitting_places(index, parts.patterns, chosen, cancelled)
    elif same_for_texts(selection):
        rest = replace(selection, contains=None, where=None, parameters={})
        chosen = chosen_classes(reader, index, rest, cancelled)
        places = chosen_words(reader, index, selection, chosen, cancelled)
    if places is None:
        places = _scanned(reader, index, selection, "p,code", cancelled).places
    return Listed(index, places[_order(index, places, values, by_text, descending)])


def _order(
    index: Index, places: NDArray[np.uint32], values: Values | None, by_text: bool, descending: bool
) -> NDArray[np.intp] | slice:
    """Return in which order words, which are given by rising places, are wanted."""
    if by_text:
        texts = texts_of(index.keys(places.astype(np.int64)))
        return np.argsort(-texts if descending else texts, kind="stable")
    if values is None:
        return slice(None)
    by_rank, new = grouped(values, descending)
    ranks = np.empty(len(values), dtype=np.uint32)
    ranks[by_rank] = np.cumsum(new)
    of_words = np.empty(len(places), dtype=np.uint32)
    for begin in range(0, len(places), _PIECE):  # of millions of words, places of eight bytes take much room
        here = places[begin : begin + _PIECE].astype(np.int64)
        of_words[begin : begin + _PIECE] = ranks[index.classes(here)]
    return np.argsort(of_words, kind="stable")


def _scanned(
    reader: Reader, index: Index, selection: Selection, order: str, cancelled: Callable[[], bool]
) -> Listed:
    """Return a subset in any order, by a pass over the view."""
    found: list[int] = []
    with _unless(cancelled):
        for count, (word,) in enumerate(reader.rows(selection, ("code",), order, cancelled=cancelled)):
            if count % _BLOCK == 0 and cancelled():
                raise CancelledError
            number = index.key(word)
            if number is not None:
                found.append(number)
    keys = np.array(found, dtype=np.int64)
    rising = np.argsort(keys)
    places = index.places(keys[rising])
    if len(places) != len(keys):
        raise CancelledError  # rows were stored meanwhile: they are about to be read anew
    wanted = np.empty(len(keys), dtype=np.uint32)
    wanted[rising] = places
    return Listed(index, wanted)


@contextmanager
def _unless(cancelled: Callable[[], bool]) -> Iterator[None]:
    """Tell a query that nobody waits for from one that is refused."""
    try:
        yield
    except SelectionError:
        if cancelled():
            raise CancelledError from None
        raise


def fetch(
    reader: Reader, index: Index, keys: Integers, columns: Sequence[str]
) -> list[tuple[Any, ...] | None]:
    """Return the rows that have some keys, in their order; None for a row that is no longer there."""
    words = [index.word(key) for key in keys.tolist()]
    found: dict[str, tuple[Any, ...]] = {}
    wanted = [view.c.code, *(view.c[name] for name in columns)]
    with reader.reading() as connection:
        for p, group in groupby(sorted(words, key=len), key=len):
            here = (view.c.a == index.a, view.c.p == p, view.c.word.in_(list(group)))
            rows = connection.execute(sa.select(*wanted).where(*here))
            found |= {code: tuple(values) for code, *values in rows}
    return [found.get(word) for word in words]


def certificate_of(reader: Reader, representative: str, a: float) -> tuple[float, int] | None:
    """Return the radius and the bits of the proof of a class's orbit, or None if there is none."""
    joined = certificate.join(cycle, cycle.c.id == certificate.c.cycle)
    joined = joined.join(stadium, stadium.c.id == certificate.c.stadium)
    query = sa.select(certificate.c.radius, certificate.c.bits).select_from(joined)
    here = (cycle.c.p == len(representative), cycle.c.word == representative, stadium.c.a == a)
    with reader.reading() as connection:
        row = connection.execute(query.where(*here)).first()
    return None if row is None else (row.radius, row.bits)
