"""Stored births: whole periods are checked, whatever is in the making beside them."""

import sqlite3
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest
from contents import alter
from there import there

from orbitdb.catalogue.catalogue import Catalogue
from orbitdb.filling.births import fill_births
from orbitdb.filling.periods import fill_periods
from orbitdb.orbits.births.changes import events
from orbitdb.store.asking.criteria import choose
from orbitdb.symbols.words import keys_of_period
from orbitdb.verification.births import check_births, prove_lives, whole_births
from orbitdb.verification.verify import verify


@pytest.fixture
def begun(tmp_path: Path) -> Path:
    """A catalogue with the births of p = 5, and with those of p = 4 as if they were being found."""
    path = tmp_path / "orbits.db"
    Catalogue.create(path)
    for _ in fill_births(path, [4, 5]):
        pass
    alter(path, "UPDATE birth_fill SET state = 'filling' WHERE p = 4")
    return path


def test_a_period_in_the_making_hides_none_behind_it(begun, monkeypatch):
    for _ in fill_periods(begun, 1.6, [5]):
        pass
    alter(begun, "UPDATE fill SET state = 'filling', n_c = NULL")
    monkeypatch.setattr("orbitdb.verification.births.BLOCK", 12)
    with Catalogue(begun).reading() as connection:
        steps = list(prove_lives(connection, whole_births(connection)))
        assert [(step.stage, step.done, step.total) for step in steps] == [
            ("missing births, p = 5", 12, 17),
            ("missing births, p = 5", 17, 17),
        ]
        assert [(c.name, c.rows, c.failures) for step in steps for c in step.checks] == [
            ("lives", 12, 0),
            ("lives", 5, 0),
        ]
        (found,) = check_births([], connection)
        assert (found.rows, found.failures) == (17, 0)


def test_only_the_births_of_chosen_periods_are_looked_at(begun):
    for _ in fill_births(begun, [6]):
        pass
    for chosen, expected in (((), [5, 6]), ([choose(p=6)], [6]), ([choose(p=7), choose(a=1, p="4-5")], [5])):
        with Catalogue(begun).reading() as connection:
            assert [found.p for found in whole_births(connection, chosen)] == expected
    steps = verify(Catalogue(begun), [choose(p=5)], missing_births=True)
    counted = {check.name: check.rows for step in steps for check in step.checks}
    assert (counted["births"], counted["lives"]) == (17, 17)


def test_a_class_that_died_and_was_born_again_is_sound_and_counts_once(begun):
    """Short words do not: by hand, as classes of p = 9 do."""

    def alter(*statements: str) -> None:
        with closing(sqlite3.connect(begun)) as plain, plain:
            for statement in statements:
                plain.execute(statement)
            moving = plain.execute("SELECT a, error, cycle, number FROM change WHERE a > 0").fetchall()
            for p in (4, 5):
                here = [row for row in moving if keys_of_period(p)[0] <= row[2] <= keys_of_period(p)[1]]
                a, error = np.array([row[:2] for row in here]).reshape(-1, 2).T
                keys = "UPDATE change SET event = ? WHERE cycle = ? AND number = ?"
                plain.executemany(
                    keys, [(n, *row[2:]) for n, row in zip(events(a, error).tolist(), here, strict=True)]
                )

    def found() -> tuple[int, int, str | None]:
        with Catalogue(begun).reading() as connection:
            (check,) = check_births([], connection)
        return check.rows, check.failures, check.first

    insert = "INSERT INTO change SELECT cycle, {}, {} * a, error, '{}', bounce, joint, NULL, slope, run"
    where = "FROM change WHERE a = (SELECT min(a) FROM change WHERE a > 0) AND number = 1 LIMIT 1"
    alter(*(f"{insert.format(*values)} {where}" for values in ((2, 1.1, "died"), (3, 1.2, "born"))))
    assert found() == (19, 2, "p = 5: births is 13 instead of 14")
    alter("UPDATE birth_fill SET births = 14, deaths = 1 WHERE p = 5")
    assert found() == (19, 0, None)
    for name in ("classes", "births", "deaths", "always", "least", "largest"):
        alter(f"UPDATE birth_fill SET {name} = 2 * {name} WHERE p = 5")
        rows, failures, told = found()
        assert (rows, failures) == (19, 1), (name, told)
        assert there(told).startswith(f"p = 5: {name} is ")
        alter(f"UPDATE birth_fill SET {name} = {name} / 2 WHERE p = 5")
    for wrong, right in (
        ("number = 4 WHERE number = 3", "number = 3 WHERE number = 4"),
        ("kind = 'died' WHERE number = 3", "kind = 'born' WHERE number = 3"),
        ("error = 2 * a WHERE number = 2", "error = 0 WHERE number = 2"),
    ):
        alter(f"UPDATE change SET {wrong}")
        rows, failures, _ = found()
        assert (rows, failures > 0) == (19, True)
        alter(f"UPDATE change SET {right}")
        assert found() == (19, 0, None)
