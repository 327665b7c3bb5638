"""Values that somebody has changed in a sound file: who meets them says what they are, in one line."""

import sqlite3
from contextlib import closing

import pytest

from orbitdb.errors import StoreError
from orbitdb.filling.births import fill_births
from orbitdb.store.asking.selection import Selection
from orbitdb.store.reading import class_first
from orbitdb.store.reading.catalogue import Catalogue
from orbitdb.store.reading.index_reading import load_index
from orbitdb.store.reading.pages import chosen_keys
from orbitdb.store.reading.references import best_reference

LAST_CLASS = "WHERE p = 5 AND word = (SELECT max(word) FROM cycle WHERE p = 5)"
FIRST_WORD = "WHERE p = 5 AND word = (SELECT min(word) FROM sequence WHERE p = 5)"
LAST_WORD = "WHERE p = 5 AND word = (SELECT max(word) FROM sequence WHERE p = 5)"


def altered(source, path, statement):
    """Return a copy of a catalogue in which statements have changed what they like."""
    path.write_bytes(source.read_bytes())
    with closing(sqlite3.connect(path)) as plain, plain:
        plain.executescript(statement)
    return Catalogue(path, a=1.6)


def index(catalogue):
    return load_index(catalogue, 1.6)


def coordinates(catalogue):
    return catalogue.select(p=5, coordinates=True).coordinates_of(0)


@pytest.mark.parametrize(
    ("statement", "question", "message"),
    [
        ("UPDATE fill SET p = 1 WHERE p = 6", Catalogue.fills, "a filled period of '1'"),
        (
            "INSERT INTO birth_fill (p, state, seconds, words) VALUES (1, 'done', 0, 0)",
            Catalogue.birth_fills,
            "births of a period of '1'",
        ),
        (
            f"DELETE FROM sequence {LAST_WORD}; UPDATE cycle SET class_size = class_size - 1 {LAST_CLASS}",
            index,
            "classes of impossible sizes, of period '5'",
        ),
        (f"UPDATE cycle SET word = '00000' {LAST_CLASS}", index, "impossible numbers or sizes of classes"),
        (f"UPDATE cycle SET word = '99999' {LAST_CLASS}", index, "words that are none, of period '5'"),
        (
            "UPDATE cycle SET class_size = class_size + 1 WHERE p = 5;"
            f"UPDATE sequence SET word = word || '5' {LAST_WORD};"
            f"UPDATE sequence SET word = substr(word, 2) {FIRST_WORD}",
            index,
            "words that are none, of period '5'",
        ),
        (
            f"UPDATE cycle SET id = id + 1000000000000 {LAST_CLASS}",
            lambda catalogue: catalogue.select(p=5),
            "no row for some of the classes",
        ),
        (
            "UPDATE orbit SET length = 9e999 WHERE length IS NOT NULL",
            lambda catalogue: catalogue.select(p=5),
            "infinite numbers in the column 'length'",
        ),
        (
            "UPDATE sequence SET element = (element + 1) % 8 WHERE p = 5",
            coordinates,
            "a symmetry element that leads to another word:",
        ),
        (
            "INSERT INTO trajectory SELECT id, id, 1, 1, 'abc', 1, 1, 1, 1, 1, 1, 1 FROM stadium",
            lambda catalogue: best_reference(catalogue, 1.6),
            "a seed that is none: 'abc'",
        ),
    ],
)
def test_what_was_altered_is_named(varied, tmp_path, statement, question, message):
    catalogue = altered(varied, tmp_path / "orbits.db", statement)
    with closing(catalogue), pytest.raises(StoreError) as error:
        question(catalogue)
    assert str(error.value).startswith(f"the catalogue was altered: {message}")
    assert str(error.value).endswith("; 'orbitdb verify' tells what is wrong")


def test_classes_that_lose_their_rows_behind_an_index_are_named(varied, tmp_path):
    """The browser asks by an index that it has read before."""
    catalogue = altered(varied, tmp_path / "orbits.db", "")
    with closing(catalogue):
        before = index(catalogue)
        with closing(sqlite3.connect(catalogue.path)) as plain, plain:
            plain.execute("DELETE FROM orbit WHERE cycle = (SELECT max(id) FROM cycle WHERE p = 5)")
        for selection, column, message in (
            (Selection(1.6, where="length > 3"), "p", "classes without what became of them at a = '1.6'"),
            (Selection(1.6), "length", "classes without what became of them, sorted by 'length'"),
        ):
            with pytest.raises(StoreError, match=f"the catalogue was altered: {message}"):
                chosen_keys(catalogue, before, selection, column)


@pytest.mark.parametrize(
    ("statement", "arguments", "message"),
    [
        (
            "UPDATE sequence SET rules = '7' WHERE p = 3",
            ("--status", "geometric", "--columns", "code,rules"),
            "rules '7' in the catalogue are none",
        ),
        (
            f"UPDATE cycle SET symmetry = '<word>' {LAST_CLASS}",
            ("--p", "5", "--columns", "code,symmetry"),
            "the catalogue was altered: a text of a class of period '5'",
        ),
    ],
)
def test_rows_with_altered_texts_are_not_written(
    varied, tmp_path, monkeypatch, cli, statement, arguments, message
):
    monkeypatch.setattr(class_first, "_MANY", 0)
    with closing(altered(varied, tmp_path / "orbits.db", statement)) as catalogue:
        outcome = cli("query", "--a", "1.6", *arguments, "--format", "csv", "--db", str(catalogue.path))
    assert outcome.code == 3
    assert message in outcome.err
    assert outcome.err.endswith("'orbitdb verify' tells what is wrong\n")


@pytest.mark.parametrize(
    ("statement", "message"),
    [
        (
            "UPDATE sequence SET element = (element + 1) % 8 WHERE p = 5",
            "a symmetry element that leads to another word:",
        ),
        (f"UPDATE cycle SET symmetry = 'ξ' {LAST_CLASS}", "a value of a class in the column 'symmetry'"),
    ],
)
def test_columns_with_altered_values_are_not_written(varied, tmp_path, monkeypatch, cli, statement, message):
    monkeypatch.setattr(class_first, "_MANY", 0)
    with closing(altered(varied, tmp_path / "orbits.db", statement)) as catalogue:
        target = tmp_path / "rows.npz"
        outcome = cli(
            "export",
            "--a",
            "1.6",
            "--p",
            "5",
            "--coordinates",
            "-o",
            str(target),
            "--format",
            "npz",
            "--db",
            str(catalogue.path),
        )
    assert outcome.code == 3
    assert outcome.err.startswith(f"orbitdb: the catalogue was altered: {message}")
    assert not target.exists()


def test_more_words_than_classes_have_are_named(varied, tmp_path, monkeypatch, cli):
    monkeypatch.setattr(class_first, "_MANY", 0)
    more = "UPDATE cycle SET class_size = class_size + 1 WHERE p = 5"
    with closing(altered(varied, tmp_path / "orbits.db", more)) as catalogue:
        asked = ("--where", "code LIKE '%1%'", "--p", "5", "--offset", "30", "--limit", "200")
        outcome = cli("query", "--a", "1.6", *asked, "--db", str(catalogue.path))
    assert outcome.code == 3
    assert "the catalogue was altered: classes of impossible sizes, of period '5'" in outcome.err


def test_counts_from_births_of_no_word_are_refused(tmp_path):
    path = tmp_path / "births.db"
    Catalogue.create(path, 1.6)
    for _ in fill_births(path, [4]):
        pass
    near = "UPDATE change SET a = 1.6, error = 0.01; UPDATE cycle SET word = word || 'x'"
    with closing(sqlite3.connect(path)) as plain, plain:
        plain.executescript(near)
    told = pytest.raises(StoreError, match="the catalogue was altered: a class of period '4'")
    with closing(Catalogue(path, a=1.6)) as catalogue, told:
        catalogue.counts(p=4)
