"""Proved bounds on the entropy in the catalogue: kept once, read back, shown beside what orbits give."""

import shutil
import sqlite3
from contextlib import closing
from pathlib import Path

import pytest

from orbitdb.billiard.stadium import Stadium
from orbitdb.catalogue.catalogue import Catalogue
from orbitdb.cli.app import call
from orbitdb.entropy.bounds import search
from orbitdb.errors import InputError, StoreError
from orbitdb.verification.records import record_parts


def altered(path: Path, statement: str) -> list[tuple]:
    with closing(sqlite3.connect(path, isolation_level=None)) as plain:
        return plain.execute(statement).fetchall()


@pytest.fixture(scope="module")
def enclosed_once(filled_once, tmp_path_factory) -> Path:
    path = Path(shutil.copy(filled_once, tmp_path_factory.mktemp("enclosed")))
    for options in (["--window", "4", "--prove"], ["--window", "6"], ["--a", "0.5", "--window", "4"]):
        assert call(["bounds", *options, "--db", str(path), "--json"]) in (None, 0)
    return path


@pytest.fixture
def enclosed(enclosed_once, tmp_path) -> Path:
    """A catalogue with p = 2..8 at a = 1.6, and bounds: in balls at 1.6, closer in doubles at 1.6, at 0.5."""
    return Path(shutil.copy(enclosed_once, tmp_path / "orbits.db"))


def test_what_is_proved_is_kept_once_and_read_back(enclosed, cli):
    catalogue = Catalogue(enclosed)
    *_, found = search(Stadium(1.6), window=6)
    closest = catalogue.entropy_bounds()
    assert (closest.lower, closest.upper, closest.window) == (found.lower, found.upper, 6)
    assert (closest.windows, closest.undecided, closest.proof) == (found.windows, found.undecided, "doubles")
    surer = catalogue.entropy_bounds(1.6, "balls")
    assert (surer.window, surer.proof) == (4, "balls")
    assert surer.width > closest.width
    assert [(each.a, each.window) for each in catalogue.entropy_curve()] == [(0.5, 4), (1.6, 6)]
    assert [each.a for each in catalogue.entropy_curve("balls")] == [1.6]
    assert catalogue.entropy_bounds(3) is None
    with pytest.raises(InputError, match="use doubles or balls"):
        catalogue.entropy_bounds(proof="faith")
    assert catalogue.a_values() == [1.6]
    before = [altered(enclosed, f"SELECT * FROM {table}") for table in ("entropy_bound", "run")]
    assert len(before[0]) == 3 + 5 + 3
    cli("bounds", "--window", "5", "--db", str(enclosed))
    assert [altered(enclosed, f"SELECT * FROM {table}") for table in ("entropy_bound", "run")] == before
    altered(enclosed, "UPDATE entropy_bound SET lower = 0 WHERE edges = 6")
    cli("bounds", "--window", "6", "--db", str(enclosed))
    assert catalogue.entropy_bounds() == closest


@pytest.mark.slow
def test_altered_bounds_are_refused_and_found_by_verify(enclosed, monkeypatch):
    catalogue = Catalogue(enclosed)

    def found() -> list[tuple]:
        with catalogue.reading() as connection:
            parts = record_parts(connection)
            checks = [check for part in parts for check in part.checked(connection).checks]
        return [(check.rows, check.failures, check.first) for check in checks]

    assert found() == [(3, 0, None), (8, 0, None)]
    monkeypatch.setattr("orbitdb.verification.records.RECOUNTED", 0)
    closest = catalogue.entropy_bounds()
    where = "WHERE proof = 'balls' AND edges = 3"
    (kept,) = altered(enclosed, f"SELECT lower, upper FROM entropy_bound {where}")
    for lower, upper in ((closest.upper, 1.2), (1.1, closest.lower)):  # with one number in common
        altered(enclosed, f"UPDATE entropy_bound SET lower = {lower!r}, upper = {upper!r} {where}")
        touching = found()[1]
        altered(enclosed, f"UPDATE entropy_bound SET lower = {kept[0]!r}, upper = {kept[1]!r} {where}")
        assert touching == (8, 0, None)
    monkeypatch.undo()
    altered(
        enclosed, "UPDATE entropy_bound SET lower = 0.9, upper = 1.11 WHERE proof = 'balls' AND edges = 3"
    )
    assert found()[1] == (8, 1, "windows of 3 edges at a = 1.6")
    for edges, change in enumerate(("lower = -1", "upper = 9e999", "proof = 'x'", "undecided = 9999"), 3):
        altered(enclosed, f"UPDATE entropy_bound SET {change} WHERE proof = 'doubles' AND edges = {edges}")
    assert found()[1][1] == 5
    with pytest.raises(StoreError, match=r"altered: a bound on the entropy at a = '1\.6'"):
        catalogue.entropy_bounds()
