"""The database file: its schema, refusals, estimates of size and time, and results that are stored."""

import json
from hashlib import sha256
from types import SimpleNamespace

import pytest
from contents import alter, ask, made
from quick import slow_but
from there import there

from orbitdb.catalogue import Catalogue
from orbitdb.errors import SelectionError, StoreError
from orbitdb.filling.estimate import SWEEP, Need, about, check_room, duration, need
from orbitdb.filling.fill import fill_periods
from orbitdb.filling.sweeps import sweep_periods
from orbitdb.selection import Selection
from orbitdb.sql_text import bound_names
from orbitdb.store.file import migrate, reading
from orbitdb.store.periods import room
from orbitdb.store.tables import APPLICATION_ID, PAGE_SIZE, SCHEMA_VERSION, TABLES
from orbitdb.store.views import VIEWED as COLUMNS
from orbitdb.symbols.pruning import count_admissible, count_pruned
from orbitdb.text import gigabytes


def test_a_new_file_has_the_tables_and_marks_of_a_catalogue(tmp_path):
    path = tmp_path / "new.db"
    assert migrate(path) == (0, SCHEMA_VERSION)
    assert migrate(path) == (SCHEMA_VERSION, SCHEMA_VERSION)
    assert ask(path, "SELECT version_num FROM alembic_version") == [(f"{SCHEMA_VERSION:04}",)]
    assert ask(path, "PRAGMA application_id") == [(APPLICATION_ID,)]
    assert ask(path, "PRAGMA journal_mode") == [("wal",)]
    assert sorted(row[1] for row in ask(path, "PRAGMA table_info(catalogue)")) == sorted(COLUMNS)
    tables = dict(ask(path, "SELECT name, sql FROM sqlite_master WHERE type = 'table'"))
    assert all("STRICT" in tables[name] for name in TABLES)


def test_foreign_databases_folders_and_missing_files_are_refused(tmp_path):
    other = tmp_path / "other.db"
    alter(other, "CREATE TABLE somebody (elses INTEGER)")
    with pytest.raises(StoreError, match="another program"):
        Catalogue.create(other)
    with pytest.raises(StoreError, match="folder"):
        Catalogue(tmp_path)
    with pytest.raises(StoreError, match=r"fill\(p=11\)"):
        Catalogue(tmp_path / "missing.db")


def test_a_file_with_other_columns_has_another_version(tmp_path):
    """If this fails, raise SCHEMA_VERSION: files that lack the new columns would be called damaged.

    Views do not matter, because every reading connection makes its own.
    """
    migrate(tmp_path / "new.db")
    columns = (
        "SELECT m.name, c.name FROM sqlite_master AS m, pragma_table_info(m.name) AS c "
        "WHERE m.type = 'table' ORDER BY m.name, c.cid"
    )
    digest = sha256(repr(ask(tmp_path / "new.db", columns)).encode()).hexdigest()
    assert (SCHEMA_VERSION, digest[:12]) == (11, "5ae0d6ec84f8")


def test_a_newer_schema_is_refused(filled):
    alter(filled, f"PRAGMA user_version = {SCHEMA_VERSION + 1}")
    with pytest.raises(StoreError, match="upgrade orbitdb"):
        Catalogue.create(filled)


def test_reading_never_writes(filled):
    before = filled.read_bytes()
    with pytest.raises(StoreError, match="cannot be written"), reading(filled) as connection:
        connection.exec_driver_sql("DELETE FROM orbit")
    assert filled.read_bytes() == before


@pytest.mark.parametrize("names", [["word", "colour"], ["word; DROP TABLE orbit"]])
def test_unknown_columns_are_refused_with_a_list_of_columns(filled, names):
    with pytest.raises(SelectionError, match="the columns are"):
        list(Catalogue(filled).rows(Selection(), columns=names))
    with pytest.raises(SelectionError, match=r"the columns are|order"):
        list(Catalogue(filled).rows(Selection(), order=names[-1]))


def test_the_names_of_values_in_an_expression_are_found():
    assert bound_names("p > :least and code <> ':no' and length < :most") == {"least", "most"}
    assert bound_names("p > 2") == set()


def test_stored_periods_are_not_estimated_again(filled, tmp_path):
    everything = sum(map(count_admissible, range(2, 11)))
    assert need(tmp_path / "none.db", 1.6, range(2, 11), 1).words == everything
    rest = count_admissible(9) + count_admissible(10)
    assert need(filled, 1.6, range(2, 11), 1).words == rest
    assert need(filled, 1.0, range(2, 11), 1).words == everything
    assert need(filled, 1.0, [8], 1) == need(tmp_path / "none.db", 1.0, [8], 1)


def test_stored_sweeps_are_not_estimated_again_and_set_the_rate(filled, monkeypatch):
    whole = need(filled, 1.0, range(2, 10), 1, SWEEP)
    assert need(filled, 1.6, range(2, 10), 1, SWEEP).words == count_admissible(9)  # the others are filled
    assert whole.words == sum(map(count_admissible, range(2, 10)))
    made(filled, sweep_periods(filled, 1.0, range(2, 9)))
    rest = need(filled, 1.0, range(2, 10), 4, SWEEP)
    assert (rest.words, rest.bytes) == (count_admissible(9), 0)
    assert rest.alone / whole.seconds == pytest.approx(rest.words / whole.words)
    monkeypatch.setattr("orbitdb.filling.estimate.ENOUGH", 500)
    large = [sweep for sweep in Catalogue(filled).sweeps(a=1.0) if sweep.p in (7, 8)]
    rate = sum(sweep.processor for sweep in large) / (712 + 2096)
    found = need(filled, 1.0, [9], 4, SWEEP)
    assert (found.alone, 4 * found.seconds) == pytest.approx([rate * rest.words] * 2)


def test_writing_limits_the_gain_from_many_processes(tmp_path):
    """The gain depends on the method, because relaxation takes long to solve orbits and writes little."""
    for method, gain in (("newton", 3.5), ("relaxation", 600)):
        alone, many = (need(tmp_path / "none.db", 1.6, [9], jobs, method).seconds for jobs in (1, 10**6))
        assert gain < alone / many < 1.3 * gain


@pytest.mark.slow
@pytest.mark.parametrize(("a", "least"), slow_but([(1e6, 0.8)], [(1e6, 0.8), (1.6, 0.6), (1e-6, 0.4)]))
def test_a_file_is_at_most_as_large_as_estimated(tmp_path, a, least):
    path, before = tmp_path / "orbits.db", 0
    whole = need(path, a, range(2, 12), 1).bytes
    for top in (4, 9, 11):
        coming = need(path, a, range(2, top + 1), 1).bytes
        made(path, fill_periods(path, a, range(2, top + 1)))
        assert path.stat().st_size <= before + coming
        before = path.stat().st_size
    assert least * whole < before <= whole


def test_estimates_know_how_fast_this_machine_was(filled, monkeypatch):
    """The largest fills count, for small ones take more time per word; the disk may be the slowest part."""
    monkeypatch.setattr("orbitdb.filling.estimate.ENOUGH", 500)
    words = count_admissible(12)
    alter(
        filled, "UPDATE fill SET enumerating = words, solving = words, storing = words, seconds = 9 * words"
    )
    rates = "enumerating = 1e-6 * words, solving = 2e-6 * words, storing = 3e-6 * words"
    for wall in (1e-6, 9e-6):
        alter(filled, f"UPDATE fill SET {rates}, seconds = {wall} * words WHERE p > 6")
        alone, many = (need(filled, 1.6, [12], jobs).seconds for jobs in (1, 10**6))
        assert alone == pytest.approx(max(6e-6, wall) * words)
        assert many == pytest.approx(3e-6 * words)


def test_estimates_are_shown_briefly():
    times = [duration(seconds) for seconds in (0.034, 1.4, 119, 120, 21_000, 1e6)]
    assert times == ["0.034 s", "1 s", "119 s", "2 minutes", "5.8 hours", "12 days"]
    assert [about(0.0046), about(1.0), about(17.3)] == ["under a second", "about 1 s", "about 17 s"]
    sizes = [gigabytes(count) for count in (20, 44_100, 1e6, 12_340_000, 527e6, 1.66e9, 99.6e9, 2e11)]
    assert sizes == ["1 kB", "44 kB", "1 MB", "12 MB", "527 MB", "1.7 GB", "100 GB", "200 GB"]


def test_a_full_disk_is_reported_before_anything_is_written(cli, tmp_path, monkeypatch):
    monkeypatch.setattr("orbitdb.filling.estimate.BYTES", 1e15)
    outcome = cli("fill", "--p", "5")
    assert outcome.code == 3
    assert len(outcome.err.splitlines()) == 1
    assert "137 words and their journal take up to about 137000000 GB" in outcome.err
    assert not (tmp_path / "orbits.db").exists()
    with pytest.raises(StoreError, match="on another disk"):
        check_room(tmp_path / "missing" / "folders" / "orbits.db", Need(1, 10**18, 1.0, 1.0))


def test_room_for_pruned_words_is_looked_for_before_anything_is_written(cli, tmp_path, monkeypatch):
    monkeypatch.setattr("orbitdb.filling.estimate.PRUNED_BYTES", 1e15)
    outcome = cli("fill", "--p", "4", "--geometric")
    assert outcome.code == 3
    assert "399 words and their journal take up to about 358000000 GB" in outcome.err
    assert not (tmp_path / "orbits.db").exists()
    catalogue = Catalogue.create(tmp_path / "new.db")
    with pytest.raises(StoreError, match="no room for"):
        catalogue.fill("2-4", geometric=True)
    assert not catalogue.fills()


@pytest.mark.slow
def test_a_stored_pruned_word_takes_no_more_than_estimated(tmp_path):
    catalogue = Catalogue.create(tmp_path / "new.db")
    catalogue.fill("2-7")
    before, coming = (tmp_path / "new.db").stat().st_size, catalogue.estimate("2-7", geometric=True)
    catalogue.fill("2-7", geometric=True)
    assert coming.words == sum(map(count_pruned, range(2, 8)))
    assert 0.6 * coming.bytes < (tmp_path / "new.db").stat().st_size - before < coming.bytes


def test_the_journal_needs_as_much_room_as_the_rows(tmp_path, monkeypatch):
    monkeypatch.setattr("shutil.disk_usage", lambda _: SimpleNamespace(free=150))
    check_room(tmp_path / "orbits.db", Need(1, 75, 1.0, 1.0))
    with pytest.raises(StoreError, match="no room for"):
        check_room(tmp_path / "orbits.db", Need(1, 76, 1.0, 1.0))


def test_a_large_fill_first_states_its_cost(cli):
    for command, needed in (("fill", "15 s and up to 460 MB"), ("sweep", "7 s")):
        outcome = cli(command, "--p", "15", "--jobs", "1", "--dry-run")
        assert outcome.code == 0
        assert f"8497721 words to solve, about {needed}, in " in outcome.err


def test_bytes_per_row_add_up_to_the_file(filled, cli):
    with reading(filled) as connection:
        taken = room(connection)
    (classes, per_class), (orbits, per_orbit) = (
        (n, there(size)) for n, size in (taken["classes"], taken["solved"])
    )
    assert 80 < per_class < 200
    assert 80 < per_orbit < 250
    assert ask(filled, "PRAGMA page_size") == [(PAGE_SIZE,)]
    assert ask(filled, "SELECT count(*) FROM cycle") == [(classes,)]
    ((trees,),) = ask(filled, "SELECT count(*) FROM sqlite_master WHERE rootpage > 0")
    rows = classes * per_class + orbits * per_orbit
    assert rows < filled.stat().st_size < 1.1 * rows + PAGE_SIZE * trees
    shown = cli("info", "--db", str(filled)).out
    assert f"{classes}, {per_class:.0f} bytes each" in shown
    (last,) = [row for row in json.loads(cli("info", "--db", str(filled), "--json").out) if row["p"] == 8]
    assert last["stored"] == last["N_t"] == 2096
    assert min(last["enumerating"], last["solving"], last["storing"]) > 0


def test_an_orbit_at_every_a_has_no_birth_in_any_view(filled, cli):
    assert cli("births", "--p", "4", "--db", str(filled)).code == 0
    of_lives = ask(filled, "SELECT word, born FROM life WHERE p <= 4 ORDER BY word")
    of_words = "SELECT code, born FROM catalogue WHERE p <= 4 AND code = representative ORDER BY code"
    assert of_lives == ask(filled, of_words)
    assert None in dict(of_lives).values()
    assert [life.born for life in Catalogue(filled).births(2)] == [None]


def test_a_file_with_earlier_views_has_the_columns_of_this_version(filled):
    """`quarter_lyapunov` came without a new schema."""
    alter(filled, "DROP VIEW catalogue", "CREATE VIEW catalogue AS SELECT 1 AS code")
    catalogue = Catalogue(filled, a=1.6)
    (row,) = catalogue.rows(p=2, columns=("code", "quarter_lyapunov", "quarter_maslov"))
    assert row == ("13", there(catalogue["13"].lyapunov) / 2, 3)
