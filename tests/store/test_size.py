"""What a fill needs, said before it begins, and what a catalogue takes."""

import json
import sqlite3
from contextlib import closing
from types import SimpleNamespace

import pytest
from there import there

from orbitdb.catalogue.catalogue import Catalogue
from orbitdb.errors import StoreError
from orbitdb.filling.estimate import (
    Need,
    about,
    check_room,
    duration,
    gigabytes,
    need,
)
from orbitdb.filling.periods import fill_periods
from orbitdb.store.file.migrate import migrate
from orbitdb.store.file.schema import PAGE_SIZE
from orbitdb.store.reading.records import room
from orbitdb.symbols.counting import count_admissible


def test_what_is_stored_is_not_needed_again(filled, tmp_path):
    everything = sum(map(count_admissible, range(2, 11)))
    assert need(tmp_path / "none.db", 1.6, range(2, 11), 1).words == everything
    rest = count_admissible(9) + count_admissible(10)
    assert need(filled, 1.6, range(2, 11), 1).words == rest
    assert need(filled, 1.0, range(2, 11), 1).words == everything
    assert need(filled, 1.0, [8], 1) == need(tmp_path / "none.db", 1.0, [8], 1)


@pytest.mark.slow
def test_the_room_is_estimated_to_a_factor_of_two(tmp_path):
    path = tmp_path / "orbits.db"
    expected = need(path, 1.6, range(2, 11), 1).bytes
    migrate(path)
    for _ in fill_periods(path, 1.6, range(2, 11)):
        pass
    assert path.stat().st_size / 2 < expected < 2 * path.stat().st_size


def test_the_time_is_that_of_the_large_fills_alone(filled, monkeypatch):
    monkeypatch.setattr("orbitdb.filling.estimate.ENOUGH", 500)
    large = [fill for fill in Catalogue(filled).fills(1.6) if fill.words >= 500]
    assert len(large) >= 2
    spent = sum(fill.enumerating + fill.solving + fill.storing for fill in large)
    each = spent / sum(fill.words for fill in large)
    assert need(filled, 1.6, [12], 1).seconds == pytest.approx(each * count_admissible(12))
    storing = sum(fill.storing for fill in large) / sum(fill.words for fill in large)
    assert need(filled, 1.6, [12], 10**6).seconds == pytest.approx(storing * count_admissible(12))


@pytest.mark.parametrize(
    ("seconds", "said"),
    [
        (0.034, "0.034 s"),
        (1.4, "1 s"),
        (119, "119 s"),
        (120, "2 minutes"),
        (21_000, "5.8 hours"),
        (1e6, "12 days"),
    ],
)
def test_times_are_told_in_their_units(seconds, said):
    assert duration(seconds) == said


def test_estimates_are_told_in_few_words():
    assert [about(0.0046), about(17.3)] == ["under a second", "about 17 s"]
    sizes = [gigabytes(count) for count in (20, 44_100, 1e6, 12_340_000, 527e6, 1.66e9, 99.6e9, 2e11)]
    assert sizes == ["1 kB", "44 kB", "1 MB", "12 MB", "527 MB", "1.7 GB", "100 GB", "200 GB"]


def test_a_disk_that_is_too_small_is_told_before_anything_is_written(cli, tmp_path, monkeypatch):
    monkeypatch.setattr("orbitdb.filling.estimate.BYTES", 1e15)
    outcome = cli("fill", "--p", "5")
    assert outcome.code == 3
    assert len(outcome.err.splitlines()) == 1
    assert "137 words take about 137000000 GB" in outcome.err
    assert not (tmp_path / "orbits.db").exists()
    with pytest.raises(StoreError, match="on another disk"):
        check_room(tmp_path / "missing" / "folders" / "orbits.db", Need(1, 10**18, 1.0))


def test_the_journal_needs_room_beside_the_rows(tmp_path, monkeypatch):
    monkeypatch.setattr("shutil.disk_usage", lambda _: SimpleNamespace(free=150))
    check_room(tmp_path / "orbits.db", Need(1, 75, 1.0))
    with pytest.raises(StoreError, match="no room for"):
        check_room(tmp_path / "orbits.db", Need(1, 76, 1.0))


def test_a_large_fill_says_first_what_it_takes(cli):
    for command, needed in (("fill", "15 s and 348 MB"), ("sweep", "7 s")):
        outcome = cli(command, "--p", "15", "--jobs", "1", "--dry-run")
        assert outcome.code == 0
        assert f"8497721 words to come, about {needed}, in " in outcome.err


def test_bytes_a_row_add_up_to_the_file(filled, cli):
    with Catalogue(filled).reading() as connection:
        taken = room(connection)
    (classes, per_class), (orbits, per_orbit) = (
        (n, there(size)) for n, size in (taken["classes"], taken["orbits"])
    )
    assert 80 < per_class < 200
    assert 80 < per_orbit < 250
    with closing(sqlite3.connect(filled)) as plain:
        assert plain.execute("PRAGMA page_size").fetchone() == (PAGE_SIZE,)
        assert plain.execute("SELECT count(*) FROM cycle").fetchone() == (classes,)
        trees = plain.execute("SELECT count(*) FROM sqlite_master WHERE rootpage > 0").fetchone()[0]
    rows = classes * per_class + orbits * per_orbit
    assert rows < filled.stat().st_size < 1.1 * rows + PAGE_SIZE * trees
    shown = cli("info", "--db", str(filled)).out
    assert f"{classes}, {per_class:.0f} bytes each" in shown
    (last,) = [row for row in json.loads(cli("info", "--db", str(filled), "--json").out) if row["p"] == 8]
    assert last["stored"] == last["N_t"] == 2096
    assert min(last["enumerating"], last["solving"], last["storing"]) > 0
