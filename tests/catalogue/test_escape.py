"""What escapes from open stadiums is stored once, read back, listed, deleted and verified."""

import json
import sqlite3
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest

from orbitdb import Catalogue
from orbitdb.errors import InputError
from orbitdb.open_stadium import rates


@pytest.fixture(autouse=True)
def coarse(monkeypatch):
    """Use small transfer matrices, which are quick; the errors of the rates say how far off they are."""
    monkeypatch.setattr(rates, "GRIDS", (40, 60))
    monkeypatch.setattr(rates, "GRIDS_WITH_STATES", (40, 60))


@pytest.fixture
def catalogue(tmp_path):
    return Catalogue.create(tmp_path / "open.db")


def test_stored_result_is_read_back(catalogue, monkeypatch):
    made = catalogue.escape(["right:0.5:", "top:-0.3:0.3"], "33", trajectories=3000, bounces=50, seed=4)
    monkeypatch.setattr("orbitdb.filling.find_escape.find_escape", lambda *_: pytest.fail("computed again"))
    read = catalogue.escape(["top:-0.3:0.3", "right:0.5:"], ["33"], trajectories=3000, bounces=50, seed=4)
    assert read.rates() == made.rates()
    for by in ("bounce", "time", "leg"):
        assert read.columns(by) == made.columns(by)
    assert (read.opening, read.without, read.gaps, read.notes) == (
        made.opening,
        made.without,
        made.gaps,
        made.notes,
    )


def test_rates_are_read_whatever_the_sample(catalogue, monkeypatch):
    made = catalogue.escape("top:-0.3:0.3", trajectories=0)
    monkeypatch.setattr("orbitdb.filling.find_escape.escape_rates", lambda *_: pytest.fail("computed again"))
    assert catalogue.escape("top:-0.3:0.3", trajectories=100, bounces=5).rates() == made.rates()


@pytest.mark.slow
def test_processes_do_not_change_the_result(catalogue):
    one, two = (
        catalogue.escape("top:-0.3:0.3", trajectories=70_000, bounces=60, jobs=jobs, store=False)
        for jobs in (1, 2)
    )
    assert one.columns("time") == two.columns("time")


@pytest.mark.slow
def test_information_contents_and_deletion_know_it(catalogue):
    catalogue.escape("top:-0.3:0.3", trajectories=100, bounces=5, a=1)
    catalogue.escape(without="0202", trajectories=0, a=1)
    assert ("escape", "a = 1: by 0202, through top:-0.3:0.3") in catalogue.info().facts
    assert str(catalogue.delete(1)) == "2 open stadiums"
    assert not catalogue.contents(1)


def test_an_escape_does_not_decide_the_default_a(catalogue):
    catalogue.escape("top:-0.3:0.3", trajectories=0, a=1)
    assert catalogue.a == 1.6
    assert catalogue.a_values(with_levels=True) == [1]


ALTERED = (
    "rate_leg = 0.3", "rate_leg_error = NULL", "seed = '-1'", "trajectories = -1",
    "survival = zeroblob(16)", "survival = x'00'", "survival = zeroblob(length(survival))",
)  # fmt: skip


@pytest.mark.slow
def test_verify_finds_what_is_altered(catalogue):
    catalogue.escape("top:-0.3:0.3", trajectories=20_000, bounces=20)
    assert catalogue.verify().sound
    sound = catalogue.path.read_bytes()
    for change in ALTERED:
        catalogue.path.write_bytes(sound)
        with closing(sqlite3.connect(catalogue.path)) as driver, driver:
            driver.execute(f"UPDATE open_stadium SET {change}")
        assert not catalogue.verify().sound, change


def test_a_generator_draws_the_seed(catalogue):
    found = catalogue.escape("top:-0.3:0.3", trajectories=100, seed=np.random.default_rng(1), store=False)
    assert found.seed > 0


def test_command_writes_rows_rates_and_notes(cli, tmp_path):
    path = str(tmp_path / "new.db")
    asked = ["escape", "--opening", "top:-0.3:0.3", "--trajectories", "2000", "--bounces", "20", "--db", path]
    shown = cli(*asked, "--json")
    rows = json.loads(shown.out)
    assert [row["n"] for row in rows] == [1, 2, 5, 10, 20]
    assert {*rows[0]} == {"n", "survival", "error", "tail"}
    assert "survival falls like 0.2430/n and 0.4113/t" in shown.err
    assert {*json.loads(cli(*asked, "--by", "time", "--json").out)[0]} == {"t", "survival", "error", "tail"}
    assert json.loads(cli(*asked, "--by", "leg", "--json").out)[0]["tail"] is None
    (row,) = json.loads(cli(*asked[:3], "--rates", "--json", "--db", path).out)
    assert row["c1"] == pytest.approx(0.24304, abs=1e-5)
    assert row["rate_leg"] == pytest.approx(0.1166, abs=3 * row["rate_leg_error"])
    assert "escape" in cli("info", "--db", path).out


def test_command_refuses_what_it_cannot_open_and_makes_no_file(cli, tmp_path):
    path = tmp_path / "none.db"
    for opening, why in (("top:-3:0", "goes beyond its wall"), ("top", "write WALL:LOW:HIGH")):
        shown = cli("escape", "--opening", opening, "--db", str(path))
        assert (shown.code, shown.out) == (2, "")
        assert why in shown.err
    assert not Path(path).exists()
    with pytest.raises(InputError, match="nothing is opened"):
        Catalogue(path, missing_ok=True).escape()
