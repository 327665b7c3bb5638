"""Classes are numbered by the keys of their words; fills count words and the time of every stage."""

import sqlite3

import sqlalchemy as sa
from alembic import op

revision = "0002"
down_revision = "0001"
branch_labels = None
depends_on = None

LONGEST_KEYED = 20
APART = 1 << 61


def upgrade() -> None:
    connection = op.get_bind()
    _renumber(connection)
    op.add_column("fill", sa.Column("words", sa.Integer, nullable=False, server_default="0"))
    for stage in ("enumerating", "solving", "storing"):
        op.add_column("fill", sa.Column(stage, sa.REAL, nullable=False, server_default="0"))
    _count_words(connection)


def _renumber(connection: sa.Connection) -> None:
    """Give the classes their new numbers, by way of numbers that neither the old nor the new ones have."""
    driver = connection.connection.driver_connection
    assert isinstance(driver, sqlite3.Connection)
    driver.create_function("new_number", 2, _new_number, deterministic=True)
    connection.exec_driver_sql("PRAGMA defer_foreign_keys = ON")
    connection.exec_driver_sql("CREATE TEMP TABLE renumbered (old INTEGER PRIMARY KEY, new INTEGER NOT NULL)")
    connection.exec_driver_sql("INSERT INTO renumbered SELECT id, new_number(id, word) FROM cycle")
    tables = {"cycle": "id", "sequence": "cycle", "orbit": "cycle", "certificate": "cycle"}
    for table, column in tables.items():
        new = f"(SELECT new FROM renumbered WHERE old = {column})"
        connection.exec_driver_sql(
            f"UPDATE {table} SET {column} = {new} + {APART} WHERE {column} IS NOT NULL"
        )
    for table, column in tables.items():
        connection.exec_driver_sql(
            f"UPDATE {table} SET {column} = {column} - {APART} WHERE {column} IS NOT NULL"
        )
    connection.exec_driver_sql("DROP TABLE renumbered")


def _new_number(old: int, word: str) -> int:
    return int("1" + word, 8) if len(word) <= LONGEST_KEYED else -old


def _count_words(connection: sa.Connection) -> None:
    """Say how many words each fill has stored: all of them, or those up to its cursor."""
    connection.exec_driver_sql("UPDATE fill SET words = n_t WHERE state = 'done'")
    stored = """
        SELECT count(*) FROM sequence JOIN orbit ON orbit.cycle = sequence.cycle
        WHERE sequence.p = fill.p AND sequence.word <= fill.cursor AND orbit.stadium = fill.stadium
    """
    connection.exec_driver_sql(
        f"UPDATE fill SET words = ({stored}) WHERE state <> 'done' AND cursor IS NOT NULL"
    )


def downgrade() -> None:
    for column in ("storing", "solving", "enumerating", "words"):
        op.drop_column("fill", column)
