"""Storing words, their symmetry classes and orbits, many rows at a time.

The number of a class is the key of its least word (`orbitdb.symbols.words.key`): it can be told from the word
alone, by any process, and classes stand in the table in the order of their words. Classes of longer
words have negative numbers, in the order of their arrival.
"""

import sqlite3
from collections.abc import Sequence
from itertools import chain, islice
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
    kinds = {
        mask: (symmetry.class_size(mask), symmetry.time_reversal(mask), symmetry.label(mask))
        for mask in np.unique(stabilisers).tolist()
    }
    sizes, reversals, labels = ([kinds[mask][i] for mask in stabilisers.tolist()] for i in range(3))
    walls = ((words == 0) | (words == 2)).sum(axis=1).tolist()
    columns = (numbers, [words.shape[1]] * len(words), to_strings(words), sizes, walls, reversals, labels)
    insert(connection, "cycle", columns)


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
    insert(connection, "sequence (p, word, cycle, element)", ([p] * len(words), words, cycles, elements))


def add_pruned(connection: sa.Connection, p: int, words: Sequence[str], rules: Sequence[str]) -> None:
    """Store geometrically pruned words of order p as least rotations, with the rules they break."""
    insert(connection, "sequence (p, word, rules)", ([p] * len(words), words, rules))


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
    n = len(orbits)
    columns = (
        [stadium_id] * n, cycles, orbits.status.tolist(), _blobs(orbits.coordinates, kept), *numbers,
        orbits.iterations.tolist(), [solver] * n, [writer.run_id(connection, computed)] * n,
    )  # fmt: skip
    insert(connection, "orbit", columns)


def _or_null(values: NDArray[np.float64], kept: NDArray[np.bool_]) -> list[float | None]:
    boxed = values.astype(object)
    boxed[~(kept & np.isfinite(values))] = None
    found: list[float | None] = boxed.tolist()
    return found


def _blobs(coordinates: NDArray[np.float64], kept: NDArray[np.bool_]) -> list[bytes | None]:
    data = np.ascontiguousarray(coordinates, dtype="<f8").tobytes()
    width = 8 * coordinates.shape[1]
    return [data[i * width : (i + 1) * width] if keep else None for i, keep in enumerate(kept.tolist())]


def insert(connection: sa.Connection, table: str, columns: Sequence[Sequence[Any]]) -> None:
    """Insert rows that are not there yet, through SQLite's own driver.

    Many rows a statement take half the time of one row a statement, most of which is not storing but
    going into SQLite and out of it.
    """
    driver = connection.connection.driver_connection
    assert isinstance(driver, sqlite3.Connection)
    row = f"({', '.join('?' * len(columns))})"
    values = chain.from_iterable(zip(*columns, strict=True))
    while several := tuple(islice(values, _ROWS_A_STATEMENT * len(columns))):
        rows = ", ".join([row] * (len(several) // len(columns)))
        driver.execute(f"INSERT OR IGNORE INTO {table} VALUES {rows}", several)
