"""Rows inserted into SQLite: their number, types and ids."""

import sqlite3
from typing import Any

import pytest
from contents import ask

from orbitdb.catalogue import Catalogue
from orbitdb.filling.fill import fill_word
from orbitdb.store.file import migrate
from orbitdb.store.schema import LONG
from orbitdb.store.writing import NULL, Writer, insert
from orbitdb.symbols.words import MAX_KEYED, keys_of_period, parse

ROWS = 150


@pytest.fixture
def connection(tmp_path):
    migrate(tmp_path / "some.db")
    writer = Writer(tmp_path / "some.db", {}, references=False)
    with writer.writing() as connection:
        yield connection
    writer.close()


def test_null_is_stored_as_null_and_existing_rows_are_left_alone(connection):
    numbers = list(range(ROWS))
    length = [None if number % 3 else number / 7 for number in numbers]
    blobs = [None if number % 3 else bytearray([number] * 8) for number in numbers]
    half, ones, texts = [[0.5] * ROWS] * 8, [1] * ROWS, (["orbit"] * ROWS, ["newton"] * ROWS)
    wanted: list[list[Any]] = [ones, numbers, texts[0], blobs, length, *half, numbers, texts[1], ones]
    names = [row[1] for row in connection.execute("PRAGMA table_info(orbit)")]
    given = [[NULL if value is None else value for value in column] for column in wanted]
    columns = dict(zip(names, given, strict=True))
    insert(connection, "orbit", columns)
    insert(connection, "orbit", columns)  # all are present, so nothing is inserted again
    found = connection.execute("SELECT * FROM orbit ORDER BY cycle").fetchall()
    assert found == list(zip(*wanted, strict=True))


@pytest.mark.parametrize("short", [1, 2])
def test_columns_must_have_the_same_length(connection, short):
    columns = [[1] * (ROWS - (place == short)) for place in range(3)]
    with pytest.raises(ValueError, match="zip"):
        insert(connection, "pruned", dict(zip(("id", "p", "word"), columns, strict=True)))
    assert connection.scalar("SELECT count(*) FROM pruned") == 0


def test_inserting_no_rows_is_allowed(connection):
    insert(connection, "pruned", {"id": [], "p": [], "word": [], "rules": []})
    assert connection.scalar("SELECT count(*) FROM pruned") == 0


def test_a_row_without_a_required_value_raises(connection):
    rows: dict[str, list[Any]] = {"id": [1, 2], "p": [3, 3], "word": ["001", "010"], "rules": ["1", NULL]}
    with pytest.raises(sqlite3.IntegrityError, match=r"NOT NULL constraint failed: pruned\.rules"):
        insert(connection, "pruned", rows)


def test_columns_may_come_in_any_order(connection):
    insert(connection, "pruned", {"rules": ["1"], "word": ["001"], "id": [-1], "p": [3]})
    assert connection.execute("SELECT * FROM pruned").fetchall() == [(-1, 3, "001", "1")]


def test_long_words_get_ids_in_order_of_arrival(tmp_path):
    """Ids of classes count up, and those of pruned words count down."""
    path = tmp_path / "orbits.db"
    migrate(path)
    words = [parse(text) for text in ("1^30 5^29", "1^31 5^29", "1^30 5^31")]
    broken = ["001" * 7 + "1", "0" * 29 + "1"]
    for word in (*words, words[0], *broken, broken[1]):
        fill_word(path, word, 1.6)
    catalogue = Catalogue(path)
    assert len({catalogue[word].length for word in words}) == len(words)
    assert ask(path, "SELECT id FROM cycle ORDER BY id") == [(LONG,), (LONG + 1,), (LONG + 2,)]
    assert ask(path, "SELECT id, p FROM pruned ORDER BY id DESC") == [(-LONG, 22), (-LONG - 1, 30)]


def test_ids_of_long_words_are_above_those_of_all_periods():
    """So counting a period by its range of ids never includes a long word."""
    assert keys_of_period(MAX_KEYED)[1] < LONG
