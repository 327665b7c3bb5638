"""Deleting what is stored at one a leaves everything else as it was, and the file sound."""

import os
import shutil
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import pytest
from contents import alter, ask, content, made, whole
from made_levels import keep_made_levels

from orbitdb import Catalogue
from orbitdb.errors import StoreError
from orbitdb.filling.fill import fill_births
from orbitdb.filling.sweeps import sweep_periods

Tables = dict[str, list[tuple[Any, ...]]]
"""The rows of every table, by its name."""

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
@pytest.mark.parametrize(("reply", "code", "left"), [("n", 1, 7), ("", 1, 7), ("y", 0, 0)])
def test_on_a_terminal_the_command_asks(awkward, cli, monkeypatch, reply, code, left):
    before = whole(awkward)
    typing, terminal = os.openpty()
    with open(terminal, encoding="utf-8") as screen:
        monkeypatch.setattr(sys, "stdin", screen)
        os.write(typing, f"{reply}\n".encode())
        done = cli("delete", "--a", "1.6")
    os.close(typing)
    assert done.code == code
    assert "[y/N]" in done.err
    assert len(Catalogue(awkward).fills(a=1.6)) == left
    assert (whole(awkward) == before) == bool(left)


def test_what_changed_since_the_question_is_not_deleted(awkward):
    catalogue = Catalogue(awkward)
    known = catalogue.contents(1.6, "2-4")
    catalogue.delete(1.6, 4)
    before = whole(awkward)
    with pytest.raises(StoreError, match="nothing was deleted"):
        catalogue.delete(1.6, "2-4", only=known)
    assert whole(awkward) == before
    left = catalogue.contents(1.6, "2-4")
    assert catalogue.delete(1.6, "2-4", only=left) == left
    assert not catalogue.contents(1.6, "2-4")


# every table afterwards


def at_a(path: Path, rows: Tables, a: float, periods: Iterable[int] = ()) -> Tables:
    """Return the rows that belong to a stadium, or to some of its periods."""
    number = {a: number for number, a, *_ in rows["stadium"]}.get(a)
    period = dict(ask(path, "SELECT id, p FROM cycle"))
    own: Tables = {}
    for name in ("orbit", "certificate"):
        own[name] = [
            row for row in rows[name] if row[0] == number and (period[row[1]] in periods or not periods)
        ]
    for name in ("fill", "sweep", "sweep_block"):
        own[name] = [row for row in rows[name] if row[0] == number and (row[1] in periods or not periods)]
    if not periods:
        own["trajectory"] = [row for row in rows["trajectory"] if row[1] == number]
        for name in ("level", "level_fill", "entropy_bound"):
            own[name] = [row for row in rows[name] if row[0] == a]
    return own


def without(rows: Tables, *gone: Tables) -> Tables:
    """Return all rows but some."""
    every = {name: {row for part in gone for row in part.get(name, ())} for name in rows}
    return {name: [row for row in own if row not in every[name]] for name, own in rows.items()}


@pytest.mark.parametrize(
    ("a", "periods", "tables"),
    [
        (0.3, [6], {"orbit", "fill", "sweep"}),
        (1.6, [6], {"orbit", "fill"}),
        (0.3, [8], {"sweep", "sweep_block"}),
        (1.6, [3, 6, 7], {"orbit", "fill", "certificate"}),
    ],
)
def test_some_periods_go_and_every_other_row_stays(awkward, cli, a, periods, tables):
    before = whole(awkward)
    gone = at_a(awkward, before, a, periods)
    assert {name for name, rows in gone.items() if rows} == tables
    assert cli("delete", "--a", str(a), "--p", ",".join(map(str, periods)), "--yes").code == 0
    assert whole(awkward) == without(before, gone)


def test_classes_stay_for_births_and_for_orbits_at_another_a(awkward):
    """Period 8 has no births, and is stored at 1.6 alone; then its classes go."""
    before = whole(awkward)
    classes = {"cycle": ask(awkward, "SELECT * FROM cycle WHERE p = 8")}
    gone = at_a(awkward, before, 1.6, [8])
    Catalogue(awkward).delete(1.6, 8)
    assert whole(awkward) == without(before, gone, classes)


def test_the_classes_of_complete_births_stay_even_if_they_are_never_born(awkward):
    alter(awkward, "DELETE FROM change WHERE cycle = (SELECT max(cycle) FROM change)")  # as if never born
    before = whole(awkward)
    catalogue = Catalogue(awkward)
    for a in catalogue.a_values():
        catalogue.delete(a)
    after = whole(awkward)
    assert after["cycle"] == [row for row in before["cycle"] if row[1] <= 7]
    assert after["change"] == before["change"]
    assert after["orbit"] == after["fill"] == after["stadium"] == []


def test_classes_that_another_a_needs_stay(varied, tmp_path):
    path = Path(shutil.copy(varied, tmp_path / "orbits.db"))
    before = whole(path)
    gone = at_a(path, before, 1.0, [5])
    assert gone["orbit"]
    Catalogue(path).delete(1.0, 5)
    left = whole(path)
    needed = {row[1] for row in left["orbit"]}
    assert left.pop("cycle") == [row for row in before["cycle"] if row[0] in needed]
    assert left == {name: rows for name, rows in without(before, gone).items() if name != "cycle"}


@pytest.mark.parametrize("a", [0.3, 1.0, 1.6, 2.0, 2.5, 3.0])
def test_everything_at_one_a_goes_and_every_other_row_stays(awkward, cli, a):
    """Stadiums with sweeps or a begun fill alone stay; levels belong to an a without a stadium, too."""
    begin_fill = "INSERT INTO fill (stadium, p, state, seconds) SELECT id, 9, 'filling', 0 FROM stadium"
    alter(awkward, "INSERT INTO stadium (a) VALUES (5)", f"{begin_fill} WHERE a = 5")
    before = whole(awkward)
    classes = {"cycle": ask(awkward, "SELECT * FROM cycle WHERE p > 7") if a == 1.6 else []}  # without births
    stadium = {"stadium": [row for row in before["stadium"] if row[1] == a]}
    gone = at_a(awkward, before, a)
    assert any(gone.values())
    done = cli("delete", "--a", str(a), "--yes")
    told = done.err
    assert done.code == 0
    assert ("level" in told, "sweep" in told) == (bool(gone["level"]), bool(gone["sweep"]))
    assert whole(awkward) == without(before, gone, stadium, classes)
    assert not Catalogue(awkward).contents(a)


def test_a_sweep_goes_and_its_stadium_with_the_last(awkward):
    catalogue = Catalogue(awkward)
    before = whole(awkward)
    catalogue.delete(3, "2-5")
    assert [sweep.p for sweep in catalogue.sweeps(a=3)] == [6]
    assert whole(awkward)["stadium"] == before["stadium"]
    catalogue.delete(3, 6)
    assert [row for row in before["stadium"] if row[1] != 3] == whole(awkward)["stadium"]


def test_what_would_be_deleted_is_counted_period_by_period(awkward):
    catalogue = Catalogue(awkward)
    assert str(catalogue.contents(0.3, "5-6")) == "252 words, 1 fill (period 6), 1 sweep (period 6)"
    assert str(catalogue.contents(2.5)) == "2 sweeps (periods 6, 8)"
    assert not catalogue.contents(2.5, 5)
    levels = ask(awkward, "SELECT count(*) FROM level WHERE a = 1")[0][0]
    assert str(catalogue.contents(1)) == f"{levels} quantum levels"
    everything = catalogue.contents(0.3)
    counted = (everything.words, everything.levels, everything.bounds, everything.trajectories)
    words = ask(awkward, "SELECT count(*) FROM catalogue WHERE a = 0.3 AND p < 100")[0][0]
    assert counted == (words, 0, ask(awkward, "SELECT count(*) FROM entropy_bound WHERE a = 0.3")[0][0], 1)


def test_what_is_deleted_is_gone_even_if_its_space_cannot_be_returned(awkward, cli, monkeypatch):
    """Another process may begin to write in between, or the disk may be full."""
    before = whole(awkward)
    gone = at_a(awkward, before, 0.3, [6])

    def fail(path):
        raise StoreError(f"{path} is locked")

    monkeypatch.setattr("orbitdb.store.deleting.vacuum", fail)
    assert cli("delete", "--a", "0.3", "--p", "6", "--yes").code == 0
    assert whole(awkward) == without(before, gone)


def test_info_lists_levels_and_trajectories(full, cli):
    shown = cli("info", "--db", str(full)).out
    assert "levels" in shown
    assert "k = 0..9 (" in shown
    assert "a = 1: 1 average, up to" in shown
