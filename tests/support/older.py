"""Catalogues as earlier versions made them."""

import sqlite3
from contextlib import closing
from pathlib import Path


def make_older(path: Path) -> None:
    """Turn a catalogue into what schema 1 had: classes numbered as they came, fewer columns."""
    with closing(sqlite3.connect(path, isolation_level=None)) as plain:
        plain.execute("CREATE TEMP TABLE old (id INTEGER PRIMARY KEY, new INTEGER)")
        plain.execute("INSERT INTO old SELECT id, row_number() OVER (ORDER BY id < 0, id) FROM cycle")
        for table, column in (("sequence", "cycle"), ("orbit", "cycle"), ("cycle", "id")):
            plain.execute(
                f"UPDATE {table} SET {column} = (SELECT new FROM old WHERE id = {table}.{column})"
                f" WHERE {column} IS NOT NULL"
            )
        for column in ("words", "enumerating", "solving", "storing"):
            plain.execute(f"ALTER TABLE fill DROP COLUMN {column}")
        plain.execute("DROP VIEW life")
        for table in ("sweep_block", "sweep", "entropy_bound", "birth_fill", "change"):
            plain.execute(f"DROP TABLE {table}")
        plain.execute("UPDATE alembic_version SET version_num = '0001'")
        plain.execute("PRAGMA user_version = 1")
