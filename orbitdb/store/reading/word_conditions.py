"""Which words fulfil conditions on their texts alone, asked of SQLite a piece of a period at a time."""

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import sqlalchemy as sa
from numpy.typing import NDArray

from orbitdb.store.asking import expressions as free
from orbitdb.store.asking.conditions import answering, conditions_of
from orbitdb.store.asking.confinement import Patience, authorize_joined, never
from orbitdb.store.asking.selection import Selection
from orbitdb.store.file.engines import little_kept
from orbitdb.store.file.schema import catalogue as view
from orbitdb.store.file.schema import sequence
from orbitdb.store.reading.class_index import Index
from orbitdb.store.reading.class_values import CancelledError
from orbitdb.store.reading.reader import Reader

_PIECE = 1 << 16
_PERIOD, _AFTER, _UPTO = "piece p", "piece after", "piece upto"
"""Values of a query, by names that no free expression can write."""

_BEHIND_ALL = "9"
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
        Rising; None if other words are stored than those of the index, as they may be at another a.

    Raises
    ------
    SelectionError
        If ``where`` is refused.
    CancelledError
        If it is told to stop.
    """
    patience = Patience(cancelled=cancelled)
    found = [np.zeros(0, dtype=np.uint32)]
    query = _marked(index.a, selection)
    with reader.reading() as connection, little_kept(connection):
        for start, first, last, values in _pieces(index, chosen):
            if cancelled():
                raise CancelledError
            with answering(connection, selection, patience, authorize_joined):
                marks = connection.scalar(query, values) or ""
            if len(marks) != last - first:
                return None
            here = np.arange(start + first, start + last)
            fits = np.frombuffer(marks.encode(), dtype=np.uint8) == ord("1")
            found.append(here[fits & chosen[index.classes(here)]].astype(np.uint32))
    return np.concatenate(found)


def _pieces(index: Index, chosen: NDArray[np.bool_]) -> Iterator[tuple[int, int, int, dict[str, Any]]]:
    """Yield the words of periods with chosen classes in pieces: the places, and the values for `_marked`."""
    for part, start, of_class in zip(
        index.parts, index.starts.tolist(), index.class_starts.tolist(), strict=False
    ):
        if not chosen[of_class : of_class + len(part.numbers)].any():
            continue
        after, count = "", len(part.words)
        for first in range(0, count, _PIECE):
            last = min(first + _PIECE, count)
            upto = index.word(int(part.words.keys(slice(last - 1, last))[0])) if last < count else _BEHIND_ALL
            yield start, first, last, {_PERIOD: part.words.p, _AFTER: after, _UPTO: upto}
            after = upto


def _marked(a: float, selection: Selection) -> sa.Select[Any]:
    """Return the query that marks which of the words of a period, between two, fulfil the conditions."""
    rows = (
        sa.select(
            sa.cast(a, sa.REAL).label("a"), sequence.c.p, sequence.c.word.label("code"), sequence.c.word,
            sequence.c.cycle,
        )
        .where(sequence.c.p == sa.bindparam(_PERIOD))
        .where(sequence.c.word > sa.bindparam(_AFTER), sequence.c.word <= sa.bindparam(_UPTO))
        .subquery(view.name)
    )  # fmt: skip
    asked = Selection(a, contains=selection.contains, where=selection.where, parameters=selection.parameters)
    mark = sa.case((sa.and_(*conditions_of(asked, rows.c)), "1"), else_="0").label("mark")
    listed = sa.select(mark).order_by(rows.c.word).subquery()
    return sa.select(sa.func.group_concat(listed.c.mark, ""))
