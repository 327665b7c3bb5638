"""Catalogues of schema 6, which had one row per word."""

import sqlite3
from collections.abc import Iterable
from contextlib import closing
from pathlib import Path

from orbitdb.store.file.ids import LONG
from orbitdb.store.file.schema import APPLICATION_ID, REVISIONS
from orbitdb.symbols import symmetry
from orbitdb.symbols.words import MAX_KEYED, key

BASELINE = Path(__file__).with_name("schema_6.sql").read_text()
_CHANGED = ("cycle", "sequence", "pruned", "element", "fill", "alembic_version")


def empty(path: Path) -> sqlite3.Connection:
    """Create an empty catalogue of schema 6, and connect to it."""
    plain = sqlite3.connect(path, isolation_level=None)
    plain.executescript(f"PRAGMA application_id = {APPLICATION_ID}; PRAGMA user_version = 6; {BASELINE}")
    plain.executescript(f"{REVISIONS}; INSERT INTO alembic_version VALUES ('0006')")
    return plain


def add_classes(plain: sqlite3.Connection, words: Iterable[str]) -> list[int]:
    """Store the classes of representatives as schema 6 did, with all their words; return the ids."""
    numbers = []
    for word in words:
        stabiliser = symmetry.class_of(word).stabiliser
        (least,) = plain.execute("SELECT min(0, coalesce(min(id), 0)) FROM cycle").fetchone()
        number = key(word) if len(word) <= MAX_KEYED else least - 1
        members = symmetry.members(word)
        row = (number, len(word), word, len(members), word.count("0") + word.count("2"),
               symmetry.time_reversal(stabiliser), symmetry.label(stabiliser))  # fmt: skip
        plain.execute("INSERT INTO cycle VALUES (?, ?, ?, ?, ?, ?, ?)", row)
        plain.executemany(
            "INSERT INTO sequence VALUES (?, ?, ?, ?, NULL)",
            [(len(word), member, number, element) for member, element in members.items()],
        )
        numbers.append(number)
    return numbers


def make_older(path: Path) -> None:
    """Convert a catalogue to schema 6, with a row for each word."""
    new = path.with_name(f"{path.name}.new")
    with closing(sqlite3.connect(path)) as plain:
        plain.execute("PRAGMA journal_mode = DELETE")
    path.rename(new)
    old = f"CASE WHEN {{0}} < {LONG} THEN {{0}} ELSE {LONG - 1} - {{0}} END"
    with closing(empty(path)) as plain:
        plain.execute("ATTACH ? AS new", (str(new),))
        tables = plain.execute("SELECT name FROM main.sqlite_master WHERE type = 'table'").fetchall()
        for (table,) in tables:
            if table not in _CHANGED:
                plain.execute(f"INSERT INTO main.{table} SELECT * FROM new.{table}")
        for table in ("orbit", "certificate", "change"):
            plain.execute(f"UPDATE main.{table} SET cycle = {LONG - 1} - cycle WHERE cycle >= {LONG}")
        plain.execute("INSERT INTO main.fill SELECT * FROM new.fill")
        kept = "p, word, class_size, walls, time_reversal, symmetry"
        plain.execute(f"INSERT INTO main.cycle SELECT {old.format('id')}, {kept} FROM new.cycle")
        plain.execute(
            f"INSERT INTO sequence SELECT p, substr(words, 1 + p * n, p), {old.format('id')}, element, NULL"
            " FROM new.cycle JOIN new.element USING (symmetry)"
        )
        plain.execute("INSERT INTO sequence SELECT p, word, NULL, NULL, rules FROM new.pruned")
        plain.execute("DETACH new")
    new.unlink()
