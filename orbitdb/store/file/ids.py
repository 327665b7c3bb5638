"""Ids of classes and of geometrically pruned words.

The id of a class is the key of its representative (`orbitdb.symbols.words.key`), so any process can compute
it, and the table is in the order of words. Classes whose words are too long for a key are numbered from
`LONG` up in order of arrival. Ids of geometrically pruned words are made in the same way, but are negative.
"""

import sqlite3
from collections.abc import Sequence

from orbitdb.symbols.words import MAX_KEYED, key

LONG = 7 << 58
"""The first id for classes whose words are too long for a key.

It is larger than all keys, and four times its value still fits into an SQLite integer."""


def id_of_class(connection: sqlite3.Connection, word: str) -> int:
    """Return the id of the class of a representative; a long word that is not stored gets a new id."""
    if len(word) <= MAX_KEYED:
        return key(word)
    known = "SELECT id FROM cycle WHERE id >= ? AND p = ? AND word = ?"
    stored = connection.execute(known, (LONG, len(word), word)).fetchone()
    (last,) = connection.execute("SELECT max(id) FROM cycle").fetchone()
    return int(stored[0]) if stored else max(LONG, (last or 0) + 1)


def ids_of_pruned(connection: sqlite3.Connection, p: int, words: Sequence[str]) -> list[int]:
    """Return ids for pruned words of period p that are not yet stored."""
    if p <= MAX_KEYED:
        return [-key(word) for word in words]
    (last,) = connection.execute("SELECT min(id) FROM pruned").fetchone()
    first = min(-LONG, (last or 0) - 1)
    return list(range(first, first - len(words), -1))
