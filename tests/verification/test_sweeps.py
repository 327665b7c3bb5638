"""Sweeps against the transfer matrix, fills, births and new solutions; what is altered is found."""

import shutil
import sqlite3
import struct
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import pytest
from contents import alter
from solutions import representatives
from there import there

from orbitdb.billiard.stadium import Stadium
from orbitdb.catalogue.catalogue import Catalogue
from orbitdb.filling.births import fill_births
from orbitdb.filling.periods import fill_periods
from orbitdb.filling.sweeps import sweep_periods
from orbitdb.orbits.newton import solve
from orbitdb.store.asking.selection import Selection
from orbitdb.verification.check import Check
from orbitdb.verification.sweeps import check_sweeps

BOTH = [Selection(1.6), Selection(1.0)]


@pytest.fixture(scope="module")
def swept_once(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("swept") / "orbits.db"
    Catalogue.create(path)
    for going in (sweep_periods(path, 1.6, [4, 5]), sweep_periods(path, 1.0, [4])):
        for _ in going:
            pass
    return path


@pytest.fixture
def swept(swept_once: Path, tmp_path: Path) -> Callable[..., list[Check]]:
    """Alter a sweep of p = 4 and 5 at a = 1.6 and p = 4 at a = 1; return what is then found of it."""
    path = tmp_path / "orbits.db"
    shutil.copy(swept_once, path)

    def found(change: str = "p = p", *values: object) -> list[Check]:
        with closing(sqlite3.connect(path)) as plain, plain:
            plain.execute(f"UPDATE sweep SET {change} WHERE p = 5", values)
        with Catalogue(path).at_one_moment() as still:
            return list(check_sweeps(still, BOTH))

    return found


def told(checks: list[Check]) -> list[tuple[str, str | None]]:
    return [(check.name, check.first) for check in checks if check.failures]


def test_what_is_sound_passes_and_is_counted_once(swept):
    found = swept()
    assert not told(found)
    assert [sum(check.rows for check in found if check.name == name) for name in ("sweeps", "sums")] == [3, 3]
    (only,) = {check.name: check for check in found if check.name == "sums"}.values()
    assert 0 <= only.share < 0.5


@pytest.mark.parametrize(
    ("change", "first"),
    [
        ("n_c = n_c - 2", "n_c is 78 instead of 80"),
        ("classes = classes - 1", "classes is 14 instead of 15"),
        ("boundary = 2", "boundary is 2 instead of 0"),
        ("words = words - 2", "94 words instead of 96"),
        ("words = 97, state = 'filling'", "97 words instead of 96"),
        ("n_c = 97, state = 'filling'", "more words have a status than there are"),
        ("unresolved = 17, state = 'filling'", "more words have a status than there are"),
        ("classes = 81, state = 'filling'", "more words have a status than there are"),
    ],
)
def test_counts_that_cannot_be_are_found(swept, change, first):
    assert told(swept(change))[0] == ("sweeps", f"p = 5 at a = 1.6: {first}")


def test_a_period_in_the_making_may_have_counted_little(swept):
    assert not told(swept("state = 'filling', words = 30, n_c = 30, classes = 30"))


@pytest.mark.parametrize("change", ["n_c = -2", "sums = x'00'"])
def test_what_no_sweep_has_written_hides_no_other_a(swept, change):
    found = swept(change)
    ((name, first),) = told(found)
    assert name == "sweeps"
    assert there(first).startswith("at a = 1.6: the catalogue was altered: ")
    assert [check.rows for check in found if check.name == "sums"] == [1]


def test_sums_without_the_least_and_greatest_of_orbits_are_found(swept):
    found = swept("sums = substr(sums, 1 + 8 * 2 * 3)")  # of three measures
    assert told(found) == [("sums", "p = 5 at a = 1.6")]


def test_sums_are_those_of_new_solutions_to_their_rounding(swept, tmp_path):
    with closing(sqlite3.connect(tmp_path / "orbits.db")) as plain:
        ((blob,),) = plain.execute("SELECT sums FROM sweep WHERE p = 5 AND sums NOT NULL").fetchall()
    *rest, last = struct.unpack(f"<{len(blob) // 8}d", blob)
    orbits = solve(representatives(5), Stadium(1.6))
    orbits = orbits.rows(orbits.status == "orbit")
    loose = (orbits.lyapunov_error + orbits.length_error / orbits.length).max()
    for off, share in ((4e-13, 0.4), (1e-9, 1000)):
        found = swept("sums = ?", struct.pack(f"<{len(blob) // 8}d", *rest, last * (1 + off)))
        sums = [check for check in found if check.name == "sums"][1]
        assert sums.share == pytest.approx(share, rel=0.4)
        assert sums.worst / sums.share == pytest.approx(1e-12 + 20 * loose, rel=1e-9)
        assert told(found) == ([("sums", "p = 5 at a = 1.6")] if share > 1 else [])


@pytest.mark.parametrize(
    "fill", [lambda path: fill_periods(path, 1.6, [5]), lambda path: fill_births(path, [5])]
)
def test_counts_of_fills_and_of_births_are_compared(swept, fill, tmp_path):
    for _ in fill(tmp_path / "orbits.db"):
        pass
    assert not told(swept())
    alter(
        tmp_path / "orbits.db",
        "UPDATE fill SET n_c = 82",
        "UPDATE change SET a = 3 WHERE cycle = (SELECT max(cycle) FROM change)",
    )
    assert there(told(swept())[0][1]).startswith("p = 5 at a = 1.6: n_c is 80 instead of ")
    assert not told(swept("state = 'filling'"))
