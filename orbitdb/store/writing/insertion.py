"""Storing words, their symmetry classes and orbits, many rows at a time.

The number of a class is the key of its least word (`orbitdb.symbols.words.key`): it can be told from the word
alone, by any process, and classes stand in the table in the order of their words. Classes of longer
words have negative numbers, in the order of their arrival.
"""

import sqlite3
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from itertools import count
from typing import Any

import numpy as np
import sqlalchemy as sa
from numpy.typing import NDArray

from orbitdb.orbits.orbit import EXISTING, NUMBERS, Orbits
from orbitdb.store.file.schema import cycle
from orbitdb.store.writing.writer import Writer
from orbitdb.symbols import symmetry
from orbitdb.symbols.words import MAX_KEYED, from_strings, key, to_strings

_ROWS_A_STATEMENT = 64

NULL = float("nan")
"""What SQLite takes for NULL. Python's driver looks for an adapter of every None, and of bytes (not of a
bytearray), which takes longer than all the rest of a value."""


def class_number(connection: sa.Connection, word: str) -> int | None:
    """Return the number under which a class, given by its least word, is stored or would be.

    None for a class of a long word that is not stored.
    """
    if len(word) <= MAX_KEYED:
        return key(word)
    return connection.scalar(sa.select(cycle.c.id).where(cycle.c.p == len(word), cycle.c.word == word))


def add_cycles(
    connection: sa.Connection,
    numbers: Sequence[int],
    words: NDArray[np.uint8],
    stabilisers: NDArray[np.uint8],
) -> None:
    """Store symmetry classes by their numbers, least words, shape (N, p), and stabilisers."""
    masks, kind = np.unique(stabilisers, return_inverse=True)
    sizes, reversals, labels = (
        np.array([say(mask) for mask in masks.tolist()])[kind].tolist()
        for say in (symmetry.class_size, symmetry.time_reversal, symmetry.label)
    )
    walls = ((words == 0) | (words == 2)).sum(axis=1).tolist()
    p = Same(words.shape[1])
    insert(connection, "cycle", (numbers, p, to_strings(words), sizes, walls, reversals, labels))


def add_class(connection: sa.Connection, family: symmetry.SymmetryClass) -> int:
    """Store one symmetry class of any order and all its words, unless they are there; return its number."""
    word = family.representative
    number = class_number(connection, word)
    if number is None:
        number = min(connection.scalar(sa.select(sa.func.min(cycle.c.id))) or 0, 0) - 1
    stabilisers = np.array([family.stabiliser], dtype=np.uint8)
    add_cycles(connection, [number], from_strings([word]), stabilisers)
    members = symmetry.members(word)
    add_sequences(connection, len(word), list(members), [number] * len(members), list(members.values()))
    return number


def add_sequences(
    connection: sa.Connection, p: int, words: Sequence[str], cycles: Sequence[int], elements: Sequence[int]
) -> None:
    """Store admissible words of order p as least rotations, with their classes and elements."""
    insert(connection, "sequence (p, word, cycle, element)", (Same(p), words, cycles, elements))


def add_pruned(connection: sa.Connection, p: int, words: Sequence[str], rules: Sequence[str]) -> None:
    """Store geometrically pruned words of order p as least rotations, with the rules they break."""
    insert(connection, "sequence (p, word, rules)", (Same(p), words, rules))


def add_orbits(
    writer: Writer,
    connection: sa.Connection,
    stadium_id: int,
    cycles: Sequence[int],
    orbits: Orbits,
    solver: str,
    computed: str | None = None,
) -> None:
    """Store what became of some classes, with the arithmetic that computed it, this machine's by default.

    ``orbits`` holds their least words.
    """
    kept = np.isin(orbits.status, EXISTING)
    numbers = (_or_null(getattr(orbits, name), kept | (name == "margin")) for name in NUMBERS)
    columns = (
        Same(stadium_id), cycles, orbits.status.tolist(), _blobs(orbits.coordinates, kept), *numbers,
        orbits.iterations.tolist(), Same(solver), Same(writer.run_id(connection, computed)),
    )  # fmt: skip
    insert(connection, "orbit", columns)


def _or_null(values: NDArray[np.float64], kept: NDArray[np.bool_]) -> list[float]:
    found: list[float] = np.where(kept & np.isfinite(values), values, NULL).tolist()
    return found


def _blobs(coordinates: NDArray[np.float64], kept: NDArray[np.bool_]) -> list[bytearray | float]:
    data = bytearray(np.ascontiguousarray(coordinates, dtype="<f8").tobytes())
    width = 8 * coordinates.shape[1]
    return [data[i * width : (i + 1) * width] if keep else NULL for i, keep in enumerate(kept.tolist())]


@dataclass(frozen=True)
class Same:
    """A column with one value in all rows."""

    value: Any


def insert(connection: sa.Connection, table: str, columns: Sequence[Sequence[Any] | Same]) -> None:
    """Insert rows that are not there yet, through SQLite's own driver.

    Many rows a statement take half the time of one row a statement, most of which is not storing but
    going into SQLite and out of it. So what all rows share goes there once a statement, and the other
    values from one list, row by row.
    """
    driver = connection.connection.driver_connection
    assert isinstance(driver, sqlite3.Connection)
    same = [column.value for column in columns if isinstance(column, Same)]
    each = [column for column in columns if not isinstance(column, Same)]
    width = len(each)
    values: list[Any] = [None] * (width * len(each[0]))
    for place, column in enumerate(each):
        values[place::width] = column  # an extended slice: another length is refused
    marks = tuple(isinstance(column, Same) for column in columns)
    for start in range(0, len(values), _ROWS_A_STATEMENT * width):
        several = values[start : start + _ROWS_A_STATEMENT * width]
        driver.execute(_statement(table, marks, len(several) // width), same + several)


@cache
def _statement(table: str, same: tuple[bool, ...], rows: int) -> str:
    """Return what inserts so many rows; the values that all of them share come first."""
    shared, following = count(1), count(1 + sum(same))
    fixed = [next(shared) if one else None for one in same]
    several = (", ".join(f"?{number or next(following)}" for number in fixed) for _ in range(rows))
    return f"INSERT OR IGNORE INTO {table} VALUES ({'), ('.join(several)})"
