"""Merging parts: the target becomes what one file would be, or nothing changes."""

import shutil
import signal
import sqlite3
import subprocess
import sys
from contextlib import closing

import pytest
from contents import alter, ask, begin_sweep

from orbitdb import Catalogue, InputError, StoreError
from orbitdb.open_stadium import rates
from orbitdb.store import merging
from orbitdb.store.tables import PAGE_SIZE

TABLES = {
    "cycle": "word, class_size, words",
    "orbit": "a, word, status, coordinates, length, lyapunov, margin, solver",
    "fill": "a, p, state, cursor, words, n_c, classes",
    "sweep": "a, p, state, blocks, words, n_c, sums",
    "certificate": "a, word, radius, bits",
    "birth_fill": "p, state, classes, births",
    "entropy_bound": "a, edges, lower, upper",
    "level": "a, parity, number, k",
    "trajectory": "a, bounces, seed, lambda_d",
    "pruned": "p, word, rules",
}
OF_CYCLE = {"orbit", "certificate"}
OF_STADIUM = {"orbit", "fill", "sweep", "certificate", "trajectory"}


def content(path):
    """Return what a catalogue holds, without the numbers of its rows, its runs and its times."""
    return {
        table: ask(
            path,
            f"SELECT {names} FROM {table} t"
            + " JOIN stadium s ON s.id = t.stadium" * (table in OF_STADIUM)
            + " JOIN cycle c ON c.id = t.cycle" * (table in OF_CYCLE)
            + f" ORDER BY {names}",
        )
        for table, names in TABLES.items()
    }


STORED = "orbit,dynamical,boundary,unresolved"
LONG = ("13" * 30 + "1", "13" * 40 + "113")


@pytest.fixture(scope="module")
def made(made_once):
    """A folder with parts that overlap, and with one catalogue to which the same was written."""

    def make(path):
        Catalogue.create(path)
        folder = path.parent
        first, second = (Catalogue.create(folder / f"part-{number}.db") for number in (1, 2))
        whole = Catalogue.create(folder / "whole.db")
        for catalogue in (first, whole):
            catalogue.fill("2-5", a=1.6)
            catalogue.fill_births("2-5")
            catalogue.fill(code=LONG[0], a=1.6)
            catalogue.prove_bounds(3, a=2.0)
        for catalogue in (second, whole):
            catalogue.fill(code=(LONG[1], LONG[0]), a=1.6)
            catalogue.fill(4, a=1.6, geometric=True)
            catalogue.fill("2-4", a=0.5)
            catalogue.sweep([6], a=1.6)
            catalogue.simulate(2000, a=2.0)
            catalogue.fill_levels(4.0, a=1.0)
            catalogue.verify(p=3, a=0.5, prove=True)
            begin_sweep(catalogue.path, 1.6, 8)

    return made_once("merging", make).parent


@pytest.fixture
def parts(made, tmp_path):
    for name in ("part-1.db", "part-2.db", "whole.db"):
        shutil.copy(made / name, tmp_path / name)
    return [tmp_path / "part-1.db", tmp_path / "part-2.db"]


def test_parts_become_what_one_file_would_be(parts, tmp_path):
    for order in (parts, parts[::-1]):
        target = tmp_path / f"all-{order[0].stem}.db"
        merged = Catalogue.create(target)
        added = merged.merge(order)
        assert content(target) == content(tmp_path / "whole.db")
        assert sum(each.words for each in added) == merged.count(a=1.6, status=STORED) + merged.count(
            a=0.5, status=STORED
        )
        found = merged.verify(p="2-4")
        assert found.sound, found
        before = target.read_bytes()
        assert merged.merge(order) == []
        assert target.read_bytes() == before


def test_rows_keep_the_run_that_wrote_them(parts, tmp_path):
    Catalogue.create(tmp_path / "all.db").merge(parts)
    query = """SELECT DISTINCT a, started FROM orbit JOIN stadium ON stadium.id = stadium
        JOIN run ON run.id = run WHERE a = 0.5"""
    assert ask(tmp_path / "all.db", query) == ask(parts[1], query)


def test_the_command_says_what_each_part_added(parts, tmp_path, cli):
    target = tmp_path / "all.db"
    done = cli("merge", *map(str, parts), "--db", str(target), "--format", "tsv")
    assert done.code == 0
    lines = [line.split("\t") for line in done.out.splitlines()]
    assert lines[0] == ["part", "a", "periods", "words", "other"]
    assert ["part-1.db", "", "", "0", "births (periods 2-5)"] in lines
    assert ["part-2.db", "0.5", "2-4", "41", "2 certificates"] in lines
    assert cli("merge", *map(str, parts), "--db", str(target)).says(
        0, "has everything in 2 parts: nothing to add"
    )


def test_a_fill_that_came_further_replaces_a_shorter_one(filled, tmp_path, begin_fill):
    part = tmp_path / "part.db"
    shutil.copy(filled, part)
    begun = begin_fill(part, 9)
    begun.close()
    target = Catalogue(filled, a=1.6)
    (added,) = target.merge(part)
    assert (added.periods, added.words) == ("9", target.count(p=9, status=STORED))
    assert [fill.done for fill in target.fills()][-1:] == [False]
    Catalogue(part, a=1.6).fill([9])
    rest = target.merge(part)
    assert [each.periods for each in rest] == ["9"]
    assert target.fills()[-1].done
    assert content(filled) == content(part)
    assert target.verify(p=9, sample=50).sound


def opened(catalogue, a=1.0):
    return catalogue.escape("top:-0.3:0.3", trajectories=100, bounces=5, a=a)


@pytest.mark.slow
def test_open_stadiums_are_merged(tmp_path, monkeypatch):
    monkeypatch.setattr(rates, "GRIDS", (40, 60))
    first, second, target = (Catalogue.create(tmp_path / name) for name in ("1.db", "2.db", "all.db"))
    made = [opened(first), opened(second), opened(second, a=2.0)]
    added = target.merge([first.path, second.path])
    assert [(each.part, each.a, each.other) for each in added] == [
        ("1.db", 1.0, "1 open stadium"),
        ("2.db", 2.0, "1 open stadium"),
    ]
    monkeypatch.setattr("orbitdb.filling.find_escape.find_escape", lambda *_: pytest.fail("computed again"))
    read = opened(target)
    assert (read.rates(), read.columns("time")) == (made[0].rates(), made[0].columns("time"))
    query = "SELECT started, parameters FROM run JOIN open_stadium ON run = id WHERE a = 1"
    assert ask(target.path, query) == ask(first.path, query)
    assert target.merge([first.path, second.path]) == []


CONTRADICTIONS = {
    "UPDATE orbit SET length = length + 1e-6 WHERE cycle = (SELECT id FROM cycle WHERE word = '0113')":
        "0113 at a = 1.6 has other numbers",
    "UPDATE orbit SET status = 'dynamical' WHERE cycle = (SELECT id FROM cycle WHERE word = '0113')":
        "0113 at a = 1.6 has other numbers",
    "UPDATE entropy_bound SET lower = 1.3, upper = 1.4": "the bounds on the entropy at a = 2 exclude",
    "UPDATE change SET a = a * 1.001": "births or deaths of",
    "UPDATE level SET k = k + 1e-3": "level 1 of parity ee at a = 1 differs",
    "UPDATE sweep SET n_c = n_c + 1": "the sweep of period 6 at a = 1.6 has other counts",
}  # fmt: skip


@pytest.mark.parametrize("change", CONTRADICTIONS)
def test_a_part_that_contradicts_is_refused(parts, tmp_path, change):
    target = tmp_path / "whole.db"
    before = content(target)
    part = parts["level" in change or "sweep" in change]
    alter(part, change)
    alter(part, "INSERT INTO stadium (a) VALUES (7.5)")
    with pytest.raises(
        StoreError, match=f"contradicts the catalogue: {CONTRADICTIONS[change]}.*nothing of it was"
    ):
        Catalogue(target).merge(part)
    assert content(target) == before
    assert (7.5,) not in ask(target, "SELECT a FROM stadium")


def test_other_files_are_refused(parts, tmp_path):
    target = Catalogue(tmp_path / "whole.db")
    before = content(target.path)
    with pytest.raises(InputError, match="is the catalogue itself"):
        target.merge(target.path)
    with pytest.raises(StoreError, match="no catalogue at"):
        target.merge(tmp_path / "nothing.db")
    with pytest.raises(InputError, match="a snapshot only answers questions"), target.snapshot() as then:
        then.merge(parts)
    ((root,),) = ask(parts[0], "SELECT rootpage FROM sqlite_schema WHERE name = 'orbit'")
    with parts[0].open("r+b") as file:
        file.seek((root - 1) * PAGE_SIZE)
        file.write(b"\x55" * PAGE_SIZE)
    with pytest.raises(StoreError, match=rf"{parts[0].name} is damaged; nothing of it was merged"):
        target.merge(parts[0])
    with closing(sqlite3.connect(parts[1])) as plain:
        plain.execute("PRAGMA user_version = 10")
    with pytest.raises(StoreError, match=r"part-2.db has the older schema 10: run `Catalogue\.migrate"):
        target.merge(parts[1])
    assert content(target.path) == before


def test_certificates_come_only_with_the_rows_that_they_prove(parts, tmp_path):
    target = Catalogue.create(tmp_path / "all.db")
    target.fill(3, a=0.5)
    alter(target.path, "UPDATE orbit SET length = length + 1e-16, residual = residual + 1e-16")
    (*_, added) = [each for each in target.merge(parts[1]) if each.a == 0.5]
    assert (added.words, ask(target.path, "SELECT count(*) FROM certificate")) == (32, [(0,)])


KILLED = """
import os, signal, sys
from orbitdb import Catalogue
from orbitdb.store import merging
merging._Merge.births = lambda self: os.kill(os.getpid(), signal.SIGKILL)
Catalogue(sys.argv[1]).merge(sys.argv[2:])
"""


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no SIGKILL")
def test_nothing_is_half_merged_by_a_process_that_is_killed(parts, tmp_path):
    target = Catalogue.create(tmp_path / "all.db")
    done = subprocess.run([sys.executable, "-c", KILLED, target.path, *parts])
    assert done.returncode == -signal.SIGKILL
    assert not any(content(target.path).values())
    target.merge(parts)
    assert content(target.path) == content(tmp_path / "whole.db")


def test_ranges_of_levels_that_are_missing_are_found():
    stored = [(1.0, 2.0), (3.0, 4.0)]
    assert list(merging._uncovered(stored, 0.0, 5.0)) == [(0.0, 1.0), (2.0, 3.0), (4.0, 5.0)]
    assert list(merging._uncovered(stored, 1.5, 3.5)) == [(2.0, 3.0)]
    assert list(merging._uncovered(stored, 1.2, 1.8)) == []
    assert list(merging._uncovered([], 1.0, 2.0)) == [(1.0, 2.0)]


def test_a_part_of_a_catalogue_is_a_file(parts, tmp_path, cli):
    whole, part = tmp_path / "whole.db", tmp_path / "made.db"
    assert cli("export", str(part), "--a", "1.6", "--p", "2-4", "--db", str(whole)).code == 0
    found = content(part)
    assert {row[0] for row in found["orbit"]} == {1.6}
    assert max(len(row[1]) for row in found["orbit"]) == 4
    assert found["birth_fill"] == content(whole)["birth_fill"][:3]
    assert not any(found[table] for table in ("level", "trajectory", "entropy_bound", "sweep"))
    Catalogue(whole).copy(tmp_path / "at-1.db", a=[1.0, 3.3])
    assert content(tmp_path / "at-1.db")["level"] == content(whole)["level"]
    before = content(whole)
    assert Catalogue(whole).merge([part, tmp_path / "at-1.db"]) == []
    assert content(whole) == before
    assert cli("export", str(tmp_path / "no.db"), "--a", "7", "--db", str(whole)).says(
        1, "nothing of this is stored"
    )
    assert not (tmp_path / "no.db").exists()
