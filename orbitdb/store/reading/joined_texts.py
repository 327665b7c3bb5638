"""The values of many rows as one text: SQLite joins them, NumPy takes them apart, and no row is an object."""

from typing import Any

import numpy as np
import sqlalchemy as sa
from numpy.typing import NDArray

from orbitdb.store.reading.period_words import Integers
from orbitdb.store.reading.soundness import is_written, unsound
from orbitdb.symbols.words import from_strings, keys, pack

_COARSE, _FINE = 2.0**40, 2.0**62
"""What a number is multiplied by for its first integer, and the rest of it for the second."""

_INFINITE: sa.ColumnElement[float] = sa.literal_column("9e999")


def one_text(column: sa.ColumnElement[Any]) -> sa.ColumnElement[str]:
    """Return the values of a column, one behind the other."""
    return sa.func.group_concat(column, "")


def joined_numbers(
    connection: sa.Connection, query: sa.Select[Any], values: dict[str, Any], whole: bool
) -> NDArray[np.float64]:
    """Return the numbers of a query with one column, bit by bit, and leave the interpreter free meanwhile.

    A row for each number would hand the interpreter over as often: beside a busy thread that takes several
    times what SQLite does. Those that are not whole go as two integers, which are written and read in half
    the time of as many digits.

    Parameters
    ----------
    connection : Connection
    query : Select
    values : dict
        What the query names.
    whole : bool
        Whether the numbers, but for infinite ones, are integers.
    """
    (number,) = query.subquery().c
    if whole:
        text = connection.scalar(sa.select(sa.func.group_concat(number)), values)
        return np.fromstring(text or "", dtype=np.float64, sep=",")
    coarse = sa.cast(number * _COARSE, sa.Integer)
    fine = sa.cast((number * _COARSE - coarse) * _FINE, sa.Integer)
    differs = sa.and_(number < _INFINITE, (coarse + fine * (1 / _FINE)) * (1 / _COARSE) != number)
    joined = sa.select(sa.func.group_concat(coarse), sa.func.group_concat(fine), sa.func.total(differs))
    *texts, wrong = connection.execute(joined, values).one()
    if wrong:  # numbers below 1e-15 or above 8e6
        return np.array(connection.scalars(sa.select(number), values).all(), dtype=np.float64)
    large, small = (np.fromstring(text or "", dtype=np.int64, sep=",") for text in texts)
    found: NDArray[np.float64] = (large + small / _FINE) / _COARSE
    found[large == np.iinfo(np.int64).max] = np.inf
    return found


def digits(text: str) -> NDArray[np.uint8]:
    """Return the digits that a text is made of."""
    return np.frombuffer(text.encode("latin-1", "replace"), dtype=np.uint8) - np.uint8(ord("0"))


def written_keys(words: str, count: int, p: int) -> Integers:
    """Return the keys of some words of order p, written one behind the other.

    Raises
    ------
    StoreError
        If they are not so many words.
    """
    if len(words) != p * count or not is_written(words, len(words)):
        raise unsound("words that are none, of period", p)
    return keys(pack(from_strings([words]).reshape(-1, p)), p)
