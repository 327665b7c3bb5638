"""Deleting what is stored at one a leaves everything else as it was, and the file sound."""

import shutil
import sys
from pathlib import Path

import pexpect
import pytest
from contents import alter, ask, content, made
from made_levels import keep_made_levels
from terminal import spawn

from orbitdb import Catalogue
from orbitdb.filling.fill import fill_births
from orbitdb.filling.sweeps import sweep_periods

TABLES = ("orbit", "fill", "sweep", "sweep_block", "level", "level_fill", "entropy_bound", "trajectory")


@pytest.fixture(scope="module")
def full_once(varied, made_once):
    """A copy of the varied catalogue with something of every kind at a = 1, and births to p = 4."""

    def make(path):
        shutil.copy(varied, path)
        made(path, sweep_periods(path, 1.0, [6, 7]), fill_births(path, [2, 3, 4]))
        catalogue = Catalogue(path, a=1.0)
        catalogue.simulate(3000)
        catalogue.prove_bounds(3)
        keep_made_levels(path, 1.0)

    return made_once("full", make)


@pytest.fixture
def full(full_once, tmp_path):
    return Path(shutil.copy(full_once, tmp_path / "orbits.db"))


def test_everything_at_one_a_goes_and_nothing_else(full, varied):
    of_births = ask(full, "SELECT * FROM change")
    classes = ask(full, "SELECT count(*) FROM cycle")
    catalogue = Catalogue(full)
    deleted = catalogue.delete(1)
    assert (deleted.words, deleted.filled, deleted.swept) == (389, (2, 3, 4, 5, 6), (6, 7))
    assert min(deleted.levels, deleted.bounds, deleted.trajectories) > 0
    assert catalogue.a_values() == [1.6]
    assert all(ask(full, f"SELECT count(*) FROM {table}") == [(0,)] for table in TABLES[2:])
    left = {name: [row for row in rows if row[0] == 1.6] for name, rows in content(varied).items()}
    assert {name: left[name] for name in ("coordinates", "fill")} == {
        name: content(full)[name] for name in ("coordinates", "fill")
    }
    assert ask(full, "SELECT * FROM change") == of_births
    assert ask(full, "SELECT count(*) FROM cycle") == classes
    assert not catalogue.contents(1)
    assert catalogue.verify().sound


def test_some_periods_go_and_can_be_filled_again(full):
    before = content(full)
    catalogue = Catalogue(full)
    deleted = catalogue.delete(1.0, "5-6")
    assert str(deleted) == "348 words, 2 fills (periods 5-6), 1 sweep (period 6)"
    assert [fill.p for fill in catalogue.fills(a=1.0)] == [2, 3, 4]
    assert catalogue.contents(1.0).levels > 0
    catalogue.delete(1.6, 5)
    assert ask(full, "SELECT count(*) FROM cycle WHERE p = 5") == [(0,)]
    for a, periods in ((1.0, "5-6"), (1.6, 5)):
        catalogue.fill(periods, a=a)
    assert content(full) == before
    alter(full, "DELETE FROM level", "DELETE FROM level_fill")  # made up
    assert catalogue.verify().sound


def test_a_file_becomes_smaller(tmp_path):
    path = tmp_path / "orbits.db"
    catalogue = Catalogue.create(path, a=1.6)
    empty = path.stat().st_size
    catalogue.fill("2-8")
    full = path.stat().st_size
    catalogue.delete(1.6)
    catalogue.close()
    assert empty <= path.stat().st_size < (empty + full) / 2
    assert [part.name for part in tmp_path.iterdir()] == [path.name]


def test_the_command_deletes_only_with_yes(full, cli):
    before = content(full)
    assert cli("delete", "--a", "1").says(2, "this would delete 389 words", "quantum levels", "--yes")
    assert cli("delete", "--a", "3", "--yes").says(1, "nothing is stored at a = 3 in")
    assert content(full) == before
    assert cli("delete", "--a", "1", "--p", "2", "--yes").says(
        0, "deleted 1 word, 1 fill (period 2) at a = 1"
    )
    assert cli("delete", "--a", "1", "--p", "x", "--yes").code == 2


@pytest.mark.skipif(sys.platform == "win32", reason="needs a pseudo-terminal")
@pytest.mark.parametrize(
    ("reply", "code", "left"), [pytest.param("n", 1, 5, marks=pytest.mark.slow), ("y", 0, 0)]
)
def test_on_a_terminal_the_command_asks(full, reply, code, left):
    child = spawn("delete", "--a", "1", "--db", str(full))
    child.expect(r"\[y/N\]")
    child.sendline(reply)
    child.expect(pexpect.EOF)
    child.close()
    assert child.exitstatus == code
    assert len(Catalogue(full).fills(a=1.0)) == left


def test_info_lists_levels_and_trajectories(full, cli):
    shown = cli("info", "--db", str(full)).out
    assert "levels" in shown
    assert "k = 0..9 (" in shown
    assert "a = 1: 1 average, up to" in shown
