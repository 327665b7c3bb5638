"""Rows on their way into SQLite: as many as there are, each value of the type that it is to have."""

import sqlite3
from contextlib import closing

import pytest

from orbitdb.filling.single_word import fill_word
from orbitdb.store.file.migrate import migrate
from orbitdb.store.reading.catalogue import Catalogue
from orbitdb.store.writing.insertion import NULL, Same, insert
from orbitdb.store.writing.writer import Writer
from orbitdb.symbols.words import parse

ROWS = 150
"""More than two statements, and a rest."""


@pytest.fixture
def connection(tmp_path):
    migrate(tmp_path / "some.db")
    writer = Writer(tmp_path / "some.db", {}, references=False)
    with writer.writing() as connection:
        yield connection
    writer.close()


def test_null_is_null_and_what_rows_share_is_in_each(connection):
    numbers = list(range(ROWS))
    length = [NULL if number % 3 else number / 7 for number in numbers]
    blobs = [NULL if number % 3 else bytearray([number] * 8) for number in numbers]
    one = Same(1), numbers, Same("orbit"), blobs, length, *[Same(0.5)] * 6, numbers, Same("newton"), Same(1)
    insert(connection, "orbit", one)
    insert(connection, "orbit", one)  # they are there: nothing is inserted again
    found = connection.exec_driver_sql("SELECT * FROM orbit ORDER BY cycle").all()
    assert found == [
        (
            1,
            n,
            "orbit",
            None if n % 3 else bytes([n] * 8),
            None if n % 3 else n / 7,
            *[0.5] * 6,
            n,
            "newton",
            1,
        )
        for n in numbers
    ]


@pytest.mark.parametrize("short", [1, 2])
def test_columns_must_be_of_one_length(connection, short):
    columns = [["1"] * (ROWS - (place == short)) for place in range(3)]
    with pytest.raises(ValueError, match="size"):
        insert(connection, "sequence (p, word, cycle)", columns)
    assert connection.exec_driver_sql("SELECT count(*) FROM sequence").scalar_one() == 0


def test_no_rows_at_all(connection):
    insert(connection, "sequence (p, word, cycle)", (Same(3), [], []))
    assert connection.exec_driver_sql("SELECT count(*) FROM sequence").scalar_one() == 0


def test_long_words_of_several_classes_have_numbers_of_their_own(tmp_path):
    """They come down from -1 in the order of their arrival."""
    path = tmp_path / "orbits.db"
    migrate(path)
    words = [parse(text) for text in ("1^30 5^29", "1^31 5^29", "1^30 5^31")]
    for word in (*words, words[0]):
        fill_word(path, word, 1.6)
    catalogue = Catalogue(path)
    assert len({catalogue[word].length for word in words}) == len(words)
    with closing(sqlite3.connect(path)) as plain:
        numbers = plain.execute("SELECT id FROM cycle ORDER BY id").fetchall()
    assert numbers == [(-3,), (-2,), (-1,)]
