"""The words of a subset, period by period in the order of the table, counted and found by their classes.

Which words fit patterns is told from the least words of the classes. Where not all words of a period are
those of its classes, or these are too long for a key, the view is asked.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import sqlalchemy as sa
from numpy.typing import NDArray

from orbitdb.store.asking.conditions import answering
from orbitdb.store.asking.confinement import authorize_joined
from orbitdb.store.file.schema import catalogue as view
from orbitdb.store.file.schema import cycle
from orbitdb.store.reading.class_first import orders, pruned_words, ragged_periods
from orbitdb.store.reading.class_view import class_view
from orbitdb.store.reading.first_rows import Asked
from orbitdb.store.reading.fitting_words import Masks, count_images, fitting_images, words_between
from orbitdb.store.reading.joined_texts import digits, one_text, written_keys
from orbitdb.store.reading.period_words import Integers
from orbitdb.store.reading.soundness import unsound
from orbitdb.store.reading.text_parts import TextParts, text_parts
from orbitdb.symbols.words import MAX_KEYED, keys_of_period, to_strings, unpack

_PIECE = 1 << 15
"""Classes that are read at a time."""


@dataclass(frozen=True, eq=False)
class ByClasses:
    """The words of some classes of one period that fit patterns.

    Attributes
    ----------
    p : int
    least : ndarray of int64, shape (C,)
        The keys of the classes' least words.
    masks : ndarray of uint8, shape (C,)
        Which of their images fit (`orbitdb.store.reading.fitting_words.fitting_images`).
    rows : int
        How many words there are.
    """

    p: int
    least: Integers
    masks: Masks
    rows: int

    def between(self, first: int, last: int) -> list[str]:
        """Return the words from one place on and below another, in their order."""
        found = words_between(self.least, self.p, self.masks, first, last)
        if len(found) != last - first:
            raise unsound("classes of impossible sizes, of period", self.p)
        return to_strings(unpack(found, self.p))


@dataclass(frozen=True)
class ByView:
    """The words of one period, as the view has them.

    Attributes
    ----------
    p : int
    asked : Asked
    """

    p: int
    asked: Asked

    @cached_property
    def rows(self) -> int:
        """How many words there are."""
        return int(self.asked.all(self.asked.rows(sa.func.count()).where(view.c.p == self.p))[0][0])

    def between(self, first: int, last: int) -> list[str]:
        """Return the words from one place on and below another, in their order."""
        query = self.asked.rows(view.c.word).where(view.c.p == self.p).order_by(view.c.word)
        return [word for (word,) in self.asked.all(query.offset(first).limit(last - first))]


Words = ByClasses | ByView


def by_periods(asked: Asked) -> Iterator[Words] | None:
    """Return the words of a subset by period; None if more than patterns is asked of single words."""
    parts = text_parts(asked.selection)
    return None if parts is None else _periods(asked, parts)


def _periods(asked: Asked, parts: TextParts) -> Iterator[Words]:
    others = {*ragged_periods(asked.connection), *pruned_words(asked.connection, parts.classes)}
    for p in filter(asked.selection.includes, orders(asked.connection)):
        yield ByView(p, asked) if p in others or p > MAX_KEYED else _by_classes(asked, parts, p)


def _by_classes(asked: Asked, parts: TextParts, p: int) -> ByClasses:
    """Return the words of one period, of which all words of classes, and no others, are stored."""
    found: list[tuple[Integers, Masks]] = [(np.zeros(0, np.int64), np.zeros(0, np.uint8))]
    rows = 0
    for least, sizes in _pieces(asked, parts, p):
        masks = fitting_images(least, p, parts.patterns)
        rows += count_images(masks, sizes)
        found.append((least[masks > 0], masks[masks > 0]))
    least, masks = (np.concatenate(column) for column in zip(*found, strict=True))
    return ByClasses(p, least, masks, rows)


def _pieces(asked: Asked, parts: TextParts, p: int) -> Iterator[tuple[Integers, NDArray[np.uint8]]]:
    """Yield the keys of the least words and the sizes of the chosen classes of one period, in no order."""
    query, number = _least_words(asked, p)
    for first, last in _spans(asked.connection, p):
        with answering(asked.connection, parts.classes, asked.patience, authorize_joined):
            piece = query.where(number.between(first, last))
            words, sizes = asked.connection.execute(piece).one()
        if words is not None:
            yield written_keys(words, len(sizes), p), digits(sizes)


def _least_words(asked: Asked, p: int) -> tuple[sa.Select[Any], sa.ColumnElement[int]]:
    """Return the query for least words and sizes, each as one text, and the column of the numbers."""
    if p in asked.whole_periods:  # all classes: what became of them need not be looked at
        return sa.select().add_columns(one_text(cycle.c.word), one_text(cycle.c.class_size)), cycle.c.id
    known = class_view().c
    query = asked.classes(one_text(known.representative), one_text(known.class_size))
    return query.where(known.p == p), known.cycle


def _spans(connection: sa.Connection, p: int) -> Iterator[tuple[int, int]]:
    """Yield the numbers of the first and the last class of each piece of a period."""
    low, high = keys_of_period(p)
    while True:
        piece = sa.select(cycle.c.id).where(cycle.c.id.between(low, high)).order_by(cycle.c.id).limit(_PIECE)
        last = connection.scalar(sa.select(sa.func.max(piece.subquery().c.id)))
        if last is None:
            return
        yield low, last
        low = last + 1
