"""Which words fulfil conditions on their texts alone, asked of SQLite a piece of a period at a time."""

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import sqlalchemy as sa
from numpy.typing import NDArray

from orbitdb.store.asking import expressions as free
from orbitdb.store.asking.conditions import answering, conditions_of
from orbitdb.store.asking.confinement import Patience, never
from orbitdb.store.asking.selection import Selection
from orbitdb.store.file.schema import catalogue as view
from orbitdb.store.file.schema import sequence
from orbitdb.store.reading.class_index import Index
from orbitdb.store.reading.class_values import CancelledError, authorize_joined
from orbitdb.store.reading.reader import Reader

_PIECE = 1 << 16
_COLUMNS = {"a", "p", "code", "word"}


def same_for_texts(selection: Selection) -> bool:
    """Tell whether a free expression, if there is one, asks for nothing but texts and periods."""
    parameters = dict(selection.parameters)
    return selection.where is None or free.same_for_class(selection.where, parameters, _COLUMNS)


def chosen_words(
    reader: Reader,
    index: Index,
    selection: Selection,
    chosen: NDArray[np.bool_],
    cancelled: Callable[[], bool] = never,
) -> NDArray[np.uint32] | None:
    """Return the places of words of some classes that fulfil conditions on their texts.

    Parameters
    ----------
    reader : Reader
    index : Index
    selection : Selection
        Its ``contains`` and ``where`` count.
    chosen : ndarray of bool
        The classes.
    cancelled : callable, optional
        Asked now and then whether to stop.

    Returns
    -------
    ndarray of uint32 or None
        Rising; None if other words are stored than those of the index, as some are at another a, or long ones.

    Raises
    ------
    SelectionError
        If ``where`` is refused.
    CancelledError
        If it is told to stop.
    """
    asked = Selection(
        index.a, contains=selection.contains, where=selection.where, parameters=selection.parameters
    )
    patience = Patience(cancelled=cancelled)
    found = [np.zeros(0, dtype=np.uint32)]
    with reader.reading() as connection:
        for part, start, first, last in zip(
            index.parts, index.starts.tolist(), index.class_starts, index.class_starts[1:], strict=False
        ):
            if not chosen[first:last].any():
                continue
            place = start
            for marks in _answers(connection, part.words.p, asked, patience):
                if cancelled():
                    raise CancelledError
                here = np.arange(place, place + len(marks))
                place += len(marks)
                if place > start + len(part.words):
                    return None
                marks &= chosen[index.classes(here)]
                found.append(here[marks].astype(np.uint32))
            if place != start + len(part.words):
                return None
    return np.concatenate(found)


def _answers(
    connection: sa.Connection, p: int, selection: Selection, patience: Patience
) -> Iterator[NDArray[np.bool_]]:
    """Yield which of the stored words of a period fulfil the conditions, a piece at a time."""
    after = ""
    while True:
        rows = _words(selection.a, p, after)
        mark = sa.case((sa.and_(*conditions_of(selection, rows.c)), "1"), else_="0").label("mark")
        listed = sa.select(rows.c.word, mark).order_by(rows.c.word).limit(_PIECE).subquery().c
        query = sa.select(sa.func.group_concat(listed.mark, ""), sa.func.max(listed.word))
        with answering(connection, selection, patience, authorize_joined):
            marks, last = connection.execute(query).one()
        if last is None:
            return
        after = last
        yield np.frombuffer(marks.encode(), dtype=np.uint8) == ord("1")


def _words(a: float, p: int, after: str) -> sa.Subquery:
    """Return the words of a period behind one, as rows of the view that have no other columns."""
    columns: list[sa.ColumnElement[Any]] = [
        sa.cast(a, sa.REAL).label("a"),
        sequence.c.p,
        sequence.c.word.label("code"),
        sequence.c.word,
        sequence.c.cycle,
    ]
    return sa.select(*columns).where(sequence.c.p == p, sequence.c.word > after).subquery(view.name)
