"""Stored births: whole periods are checked, whatever is in the making beside them."""

import sqlite3
from contextlib import closing
from pathlib import Path

import pytest

from orbitdb.filling.births import fill_births
from orbitdb.store.reading.catalogue import Catalogue
from orbitdb.verification.births import check_births
from orbitdb.verification.lives import prove_lives


@pytest.fixture
def begun(tmp_path: Path) -> Path:
    """A catalogue with the births of p = 5, and with those of p = 4 as if they were being found."""
    path = tmp_path / "orbits.db"
    Catalogue.create(path)
    for _ in fill_births(path, [4, 5]):
        pass
    with closing(sqlite3.connect(path)) as plain, plain:
        plain.execute("UPDATE birth_fill SET state = 'filling' WHERE p = 4")
    return path


def test_a_period_in_the_making_hides_none_behind_it(begun, monkeypatch):
    monkeypatch.setattr("orbitdb.verification.lives._BLOCK", 12)
    with Catalogue(begun).reading() as connection:
        steps = list(prove_lives(connection))
        assert [(step.stage, step.done, step.total) for step in steps] == [
            ("births missing, p = 5", 12, 17),
            ("births missing, p = 5", 17, 17),
        ]
        assert [(c.name, c.rows, c.failures) for step in steps for c in step.checks] == [
            ("lives", 12, 0),
            ("lives", 5, 0),
        ]
        (found,) = check_births(connection)
        assert (found.rows, found.failures) == (17, 0)
