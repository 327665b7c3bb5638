"""Births in the store: whole, resumable, and what they say of any a."""

import json
import shutil
import sqlite3
import time
from contextlib import closing
from pathlib import Path

import pytest

from orbitdb.catalogue.catalogue import Catalogue
from orbitdb.filling import births as module
from orbitdb.filling.births import fill_births
from orbitdb.filling.periods import fill_periods
from orbitdb.symbols.counting import count_admissible


def fill(path: Path, periods=range(2, 8)) -> None:
    for _ in fill_births(path, periods):
        pass


@pytest.fixture(scope="module")
def once(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("births") / "orbits.db"
    Catalogue.create(path)
    begun = time.monotonic()
    fill(path)
    spent = time.monotonic() - begun
    assert 0 < sum(each.seconds for each in Catalogue(path).birth_fills()) < spent
    return path


@pytest.fixture
def born(once: Path, tmp_path: Path) -> Path:
    """A catalogue with the births of p = 2..7 and no fill, the test's own."""
    return Path(shutil.copy(once, tmp_path / "born.db"))


def test_one_row_a_period(born):
    found = {each.p: each for each in Catalogue(born).birth_fills()}
    assert [each.p for each in found.values()] == list(range(2, 8))
    assert all(each.whole for each in found.values())
    assert [each.words for each in found.values()] == [count_admissible(p) for p in range(2, 8)]
    assert [(each.classes, each.births, each.deaths, each.always) for each in found.values()] == [
        (1, 0, 0, 1), (2, 0, 0, 2), (8, 0, 0, 8), (17, 13, 0, 4), (47, 33, 0, 14), (107, 101, 0, 6)
    ]  # fmt: skip
    assert all(each.seconds > 0 for each in found.values())
    assert found[4].least is None
    assert found[7].largest == pytest.approx(4.773733293664)


def test_the_run_says_what_it_was_asked_to_do(born):
    with closing(sqlite3.connect(born)) as plain:
        ((parameters,),) = plain.execute("SELECT DISTINCT parameters FROM run").fetchall()
    asked = json.loads(parameters)
    assert (asked["command"], asked["periods"]) == ("births", list(range(2, 8)))


@pytest.mark.parametrize(("a", "p", "boundary"), [(1.0, 6, 32), (1.6, 7, 0)])
def test_counts_of_fills_and_of_births_are_the_same(born, a, p, boundary):
    """Orbits through a joint among them."""
    before = Catalogue(born).counts(a=a)
    assert before.from_births == tuple(range(2, 8))
    for _ in fill_periods(born, a, [p]):
        pass
    after = Catalogue(born).counts(a=a)
    assert p not in after.from_births
    assert after.known == before.known
    assert after.known[p].boundary == boundary


def test_a_second_process_goes_on_behind_the_first(tmp_path, monkeypatch):
    monkeypatch.setattr(module, "BLOCK", 100)
    path = tmp_path / "two.db"
    Catalogue.create(path)
    one, other = fill_births(path, [3, 4, 5]), fill_births(path, [3, 4, 5])
    assert [(step.p, step.words) for step in (next(one), next(other))] == [(3, 8), (4, 32)]
    other.close()
    assert [(step.p, step.words) for step in one] == [(5, 96)]
    assert [each.births for each in Catalogue(path).birth_fills()] == [0, 0, 13]


def test_partners_share_an_event(born):
    with closing(sqlite3.connect(born)) as plain:
        events = plain.execute(
            "SELECT count(DISTINCT cycle), max(a + error) - min(a - error), max(error) FROM change"
            " JOIN cycle ON id = cycle WHERE p = 7 AND event IS NOT NULL GROUP BY event"
        ).fetchall()
    assert len(events) == 43
    assert {count for count, *_ in events} == {2, 3}
    assert all(width <= 4 * error for _, width, error in events)
