"""Store one row per symmetry class, with all its words, and drop the table of words.

This migration takes its tables and views from `orbitdb.store.file.schema`, which describes its result. The
next migration must copy here, unchanged, each statement that it changes there.
"""

import sqlite3
from collections.abc import Iterator

import numpy as np
from alembic import op

from orbitdb.errors import StoreError
from orbitdb.store.file.database import driver
from orbitdb.store.file.ids import LONG
from orbitdb.store.file.schema import TABLES, VIEWS
from orbitdb.symbols.symmetry import ELEMENT_ROWS, classify, joined_members, joined_words
from orbitdb.symbols.words import MAX_KEYED, key, packed

revision = "0007"
down_revision = "0006"
branch_labels = None
depends_on = None

_ROWS = 1 << 14
"""Number of classes to hold in memory at a time."""

_STORED = """
    UPDATE fill SET words = (
        SELECT coalesce(sum(class_size), 0)
        FROM cycle CROSS JOIN orbit ON orbit.stadium = fill.stadium AND orbit.cycle = cycle.id
        WHERE cycle.p = fill.p AND cycle.word <= fill.cursor
    ) WHERE state <> 'done'
"""
_BORN = """
    UPDATE birth_fill SET words = (
        SELECT coalesce(sum(class_size), 0)
        FROM cycle CROSS JOIN change ON change.cycle = cycle.id AND change.number = 1
        WHERE cycle.p = birth_fill.p AND cycle.word <= birth_fill.cursor
    ) WHERE state <> 'done'
"""


def upgrade() -> None:
    plain = driver(op.get_bind())
    for view in ("catalogue", "life"):
        plain.execute(f"DROP VIEW IF EXISTS {view}")
    plain.execute("PRAGMA legacy_alter_table = ON")  # so that references keep the table's name
    for table in ("cycle", "fill"):
        plain.execute(f"ALTER TABLE {table} RENAME TO old_{table}")
    for table in ("pruned", "cycle", "element", "fill", "level_fill", "level"):
        plain.execute(TABLES[table])
    try:
        plain.executemany("INSERT INTO pruned VALUES (?, ?, ?, ?)", _pruned(plain))
        plain.execute("DROP TABLE sequence")  # first, to reuse its space for the classes
        plain.executemany("INSERT INTO cycle VALUES (?, ?, ?, ?, ?, ?, ?, ?)", _classes(plain))
    except (LookupError, ValueError, OverflowError) as error:  # from a text that is not a word
        raise StoreError("the catalogue was altered: restore it from a copy, or fill a new one") from error
    for table in ("orbit", "certificate", "change"):
        plain.execute(f"UPDATE {table} SET cycle = {LONG - 1} - cycle WHERE cycle < 0")
    plain.executemany("INSERT INTO element VALUES (?, ?, ?)", ELEMENT_ROWS)
    plain.execute("INSERT INTO fill SELECT * FROM old_fill")
    for statement in (_STORED, _BORN, "DROP TABLE old_cycle", "DROP TABLE old_fill", *VIEWS.values()):
        plain.execute(statement)


def _pruned(plain: sqlite3.Connection) -> Iterator[tuple[int, int, str, str]]:
    """Yield the rows of geometrically pruned words."""
    following = -LONG
    for p, word, rules in plain.execute("SELECT p, word, rules FROM sequence WHERE cycle IS NULL"):
        if p <= MAX_KEYED:
            yield -key(word), p, word, rules
        else:
            yield following, p, word, rules
            following -= 1


def _classes(plain: sqlite3.Connection) -> Iterator[tuple[int | str, ...]]:
    """Yield the rows of the classes, each with its words; the ids of words too long to pack now ascend."""
    for p in range(1, MAX_KEYED + 1):
        stored = plain.execute("SELECT * FROM old_cycle WHERE p = ? AND id >= 0 ORDER BY word", (p,))
        while rows := stored.fetchmany(_ROWS):
            codes = packed(np.array([row[0] for row in rows]), p)
            words = joined_words(codes, classify(codes, p).stabiliser, p)
            yield from ((*row, joined) for row, joined in zip(rows, words, strict=True))
    others = f"SELECT * FROM old_cycle WHERE id < 0 OR p NOT BETWEEN 1 AND {MAX_KEYED} ORDER BY id DESC"
    for number, *row in plain.execute(others):
        yield LONG - 1 - number if number < 0 else number, *row, joined_members(row[1])
