"""The values of many rows as one text: SQLite joins them, NumPy takes them apart, and no row is an object."""

from typing import Any

import numpy as np
import sqlalchemy as sa
from numpy.typing import NDArray

from orbitdb.store.reading.period_words import Integers
from orbitdb.store.reading.soundness import is_written, unsound
from orbitdb.symbols.words import from_strings, keys, pack


def one_text(column: sa.ColumnElement[Any]) -> sa.ColumnElement[str]:
    """Return the values of a column, one behind the other."""
    return sa.func.group_concat(column, "")


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
