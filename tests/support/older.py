"""Catalogues as earlier versions made them."""

import sqlite3
from contextlib import closing
from pathlib import Path

from orbitdb.store.file.layout import TABLES


def without_subsets(path: Path) -> None:
    """Turn a catalogue into what schema 5 had: sweeps of all orbits, and of no subsets."""
    with closing(sqlite3.connect(path, isolation_level=None)) as plain:
        for table in ("sweep", "sweep_block"):
            plain.execute("PRAGMA legacy_alter_table = ON")  # what refers to a table keeps its name
            plain.execute(f"ALTER TABLE {table} RENAME TO new_{table}")
            (text,) = (text for text in TABLES if text.startswith(f"CREATE TABLE {table} "))
            plain.execute(text.replace("selection TEXT NOT NULL,", "").replace("p, selection", "p"))
            names = ", ".join(row[1] for row in plain.execute(f"PRAGMA table_info({table})"))
            plain.execute(f"INSERT INTO {table} SELECT {names} FROM new_{table} WHERE selection = ''")
            plain.execute(f"DROP TABLE new_{table}")
        plain.execute("UPDATE alembic_version SET version_num = '0005'")
        plain.execute("PRAGMA user_version = 5")


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
