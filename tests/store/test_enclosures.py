"""Proved bounds on the entropy in the catalogue: kept once, read back, shown beside what orbits give."""

import shutil
import sqlite3
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest
from there import there

from orbitdb.billiard.stadium import Stadium
from orbitdb.catalogue.catalogue import Catalogue
from orbitdb.cli.app import call
from orbitdb.entropy.bounds import search
from orbitdb.errors import InputError


def altered(path: Path, statement: str) -> list[tuple[Any, ...]]:
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
    closest = there(catalogue.entropy_bounds())
    assert (closest.lower, closest.upper, closest.window) == (found.lower, found.upper, 6)
    assert (closest.windows, closest.undecided, closest.proof) == (found.windows, found.undecided, "doubles")
    surer = there(catalogue.entropy_bounds(1.6, "balls"))
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
