"""Values that somebody has changed in a sound file: who meets them says what they are, in one line."""

import sqlite3
from contextlib import closing

import pytest

from orbitdb.catalogue.catalogue import Catalogue
from orbitdb.errors import StoreError
from orbitdb.filling.births import fill_births

LAST_CLASS = "WHERE p = 5 AND word = (SELECT max(word) FROM cycle WHERE p = 5)"


def altered(source, path, statement):
    """Return a copy of a catalogue in which statements have changed what they like."""
    path.write_bytes(source.read_bytes())
    with closing(sqlite3.connect(path)) as plain, plain:
        plain.executescript(statement)
    return Catalogue(path, a=1.6)


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
            "UPDATE orbit SET length = 9e999 WHERE length IS NOT NULL",
            lambda catalogue: catalogue.select(p=5),
            "infinite numbers in the column 'length'",
        ),
        (
            "INSERT INTO trajectory SELECT id, id, 1, 1, 'abc', 1, 1, 1, 1, 1, 1, 1 FROM stadium",
            Catalogue.reference,
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


def test_rows_with_altered_texts_are_not_written(varied, tmp_path, cli):
    path, target = tmp_path / "orbits.db", tmp_path / "rows.npz"
    statement = f"UPDATE pruned SET rules = '7' WHERE p = 3; UPDATE cycle SET symmetry = 'ξ' {LAST_CLASS}"
    altered(varied, path, statement).close()
    of_all = ("--a", "1.6", "--db", str(path))
    for asked, told in (
        (("query", "--status", "geometric", "-c", "code,rules", "--format", "csv"), "rules '7'"),
        (("export", str(target), "--p", "5", "--coordinates"), "was altered: a symmetry that is none: 'ξ'"),
    ):
        outcome = cli(*asked, *of_all)
        assert outcome.code == 3
        assert told in outcome.err
        assert outcome.err.endswith("'orbitdb verify' tells what is wrong\n")
    assert not target.exists()


def test_counts_from_births_of_no_word_are_refused(tmp_path):
    path = tmp_path / "births.db"
    Catalogue.create(path, 1.6)
    for _ in fill_births(path, [4]):
        pass
    near = "UPDATE change SET a = 1.6, error = 0.01;"
    moved = "UPDATE change SET cycle = 0x105f WHERE cycle = (SELECT max(cycle) FROM change);"
    of_seven = "UPDATE cycle SET id = 0x105f WHERE id = (SELECT max(id) FROM cycle)"
    with closing(sqlite3.connect(path)) as plain, plain:
        plain.executescript(near + moved + of_seven)
    told = pytest.raises(StoreError, match="the catalogue was altered: a class with births '0137'")
    with closing(Catalogue(path, a=1.6)) as catalogue, told:
        catalogue.counts(p=4)
