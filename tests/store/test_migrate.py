"""Catalogues of older schemas: copied, brought to the newest one, and sound afterwards."""

import sqlite3
import subprocess
import sys
from contextlib import closing
from pathlib import Path

import pytest
from contents import content
from older import make_older, without_subsets
from processes import start

from orbitdb.errors import StoreError
from orbitdb.filling.periods import fill_periods
from orbitdb.filling.single_word import fill_word
from orbitdb.filling.sweeps import sweep_periods
from orbitdb.store.asking.selection import Selection
from orbitdb.store.file.layout import SCHEMA_VERSION
from orbitdb.store.file.migrate import migrate
from orbitdb.store.reading.catalogue import Catalogue
from orbitdb.symbols.words import least_rotation, parse

LONG = parse("1^30 5^29")


@pytest.fixture
def older(varied: Path, tmp_path: Path) -> tuple[Path, dict]:
    """A catalogue of schema 1 with two a, a long word, pruned words and a fill in the making; its content."""
    path = tmp_path / "old.db"
    path.write_bytes(varied.read_bytes())
    fill_word(path, LONG, 1.6)
    before = content(path)
    make_older(path)
    return path, before


@pytest.mark.slow
def test_an_older_catalogue_is_copied_and_made_new(older, cli):
    path, before = older
    with pytest.raises(StoreError, match="orbitdb migrate"):
        Catalogue(path)
    outcome = cli("migrate", "--db", str(path))
    backup = path.with_name("old.db.schema-1")
    assert outcome.code == 0
    assert outcome.err == f"{path}: schema 1 -> {SCHEMA_VERSION}; as it was, it is kept in {backup}\n"
    assert content(path) == before
    assert Catalogue(path).find(LONG, 1.6).length == before_length(before, LONG)
    assert {f.p: f.words for f in Catalogue(path).fills(1.6)} == {2: 1, 3: 8, 4: 32, 5: 96, 6: 252}
    with closing(sqlite3.connect(backup)) as plain:
        assert plain.execute("PRAGMA user_version").fetchone() == (1,)
        assert plain.execute("PRAGMA integrity_check").fetchone() == ("ok",)
    assert cli("verify", "--db", str(path)).code == 0


def before_length(before: dict, word: str) -> float:
    least = least_rotation(word)
    return next(row[6] for row in before["catalogue"] if least in (row[2], row[3]))


@pytest.mark.slow
def test_bounds_leave_an_older_catalogue_as_it_is_unless_they_are_to_be_stored(older, cli):
    path, _ = older
    before = path.read_bytes()
    shown = cli("bounds", "--window", "3", "--db", str(path))
    assert shown.code == 0
    assert shown.err == f"not kept: {path} has the older schema 1; " \
        "--store, or 'orbitdb migrate', brings it to the newest\n"  # fmt: skip
    assert path.read_bytes() == before
    assert [each.name for each in path.parent.iterdir()] == ["old.db"]
    stored = cli("bounds", "--window", "3", "--store", "--db", str(path))
    assert (stored.code, stored.err.split(";")[0]) == (0, f"{path}: schema 1 -> {SCHEMA_VERSION}")


def test_a_fill_brings_an_older_catalogue_to_the_newest_schema(older, cli):
    path, _ = older
    outcome = cli("fill", "--p", "3", "--a", "2", "--db", str(path))
    assert outcome.code == 0
    assert "old.db.schema-1" in outcome.err
    assert cli("verify", "--db", str(path)).code == 0


@pytest.mark.slow
@pytest.mark.usefixtures("small_blocks")
def test_a_stopped_fill_goes_on_after_the_migration(older, tmp_path):
    path, _ = older
    migrate(path)
    going = fill_periods(path, 1.6, [8])
    stored = [next(going).words for _ in range(3)][-1]
    going.close()
    make_older(path)
    assert migrate(path).before == 1
    (half,) = (fill for fill in Catalogue(path).fills(1.6) if fill.p == 8)
    assert half.state == "filling"
    assert 0 < half.words <= stored
    for _ in fill_periods(path, 1.6, [7, 8]):
        pass
    assert {f.p: f.words for f in Catalogue(path).fills(1.6)}[8] == 2096


@pytest.mark.slow
@pytest.mark.usefixtures("small_sweeps")
def test_sweeps_of_an_older_catalogue_are_those_of_all_orbits(tmp_path):
    """One that is done, and one that is stopped and goes on behind the migration."""
    path = tmp_path / "old.db"
    migrate(path)
    for _ in sweep_periods(path, 1.6, [6, 7]):
        pass
    whole = [(each.tally, each.sums) for each in Catalogue(path).sweeps(1.6)]
    with closing(sqlite3.connect(path)) as plain:
        plain.execute("DELETE FROM sweep WHERE p = 7")
        plain.commit()
    going = sweep_periods(path, 1.6, [7])
    assert [next(going).words for _ in range(4)][-1] > 100
    going.close()
    before = Catalogue(path).sweeps(1.6)
    without_subsets(path)
    with pytest.raises(StoreError, match="orbitdb migrate"):
        Catalogue(path)
    assert migrate(path) == (5, SCHEMA_VERSION, path.with_name("old.db.schema-5"))
    assert Catalogue(path).sweeps(1.6) == before
    for subset in (None, Selection(time_reversal="self")):
        for _ in sweep_periods(path, 1.6, [6, 7], selection=subset):
            pass
    assert [(each.tally, each.sums) for each in Catalogue(path).sweeps(1.6)] == whole
    with closing(sqlite3.connect(path)) as plain:
        assert plain.execute("PRAGMA foreign_key_check").fetchall() == []
        assert plain.execute("SELECT name FROM sqlite_master WHERE name LIKE 'old_%'").fetchall() == []


def test_a_migration_that_fails_leaves_the_file_as_it_was(older, monkeypatch):
    from orbitdb.store.file import migrate as module

    path, _ = older

    def broken(connection: object) -> None:
        connection.exec_driver_sql("UPDATE cycle SET walls = 0")
        raise RuntimeError("in the middle")

    monkeypatch.setattr(module, "_upgrade", broken)
    with pytest.raises(RuntimeError):
        migrate(path)
    monkeypatch.undo()
    with closing(sqlite3.connect(path)) as plain:
        assert plain.execute("PRAGMA user_version").fetchone() == (1,)
        assert plain.execute("SELECT count(*) FROM cycle WHERE walls > 0").fetchone() > (0,)
    assert migrate(path).after == SCHEMA_VERSION


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="needs POSIX signals")
def test_two_processes_migrate_at_once(older):
    path, before = older
    processes = [start("migrate", "--db", path) for _ in range(2)]
    for process in processes:
        _, err = process.communicate(timeout=100)
        assert process.returncode == 0, err
        assert len(err.splitlines()) == 1
    assert content(path) == before
    with closing(sqlite3.connect(path.with_name("old.db.schema-1"))) as plain:
        assert plain.execute("PRAGMA user_version").fetchone() == (1,)


_KILLED = """
import os, signal, sqlite3, sys
from pathlib import Path
from alembic import command
from orbitdb.store.file import migrate
path, connect = Path(sys.argv[1]), sqlite3.connect
def counted(*arguments, **options):
    connection = connect(*arguments, **options)
    connection.set_trace_callback(told)
    return connection
def told(statement):
    global left
    left -= 1
    if left < 0:
        os.kill(os.getpid(), signal.SIGKILL)
for line in sys.stdin:
    left = int(line)
    child = os.fork()  # else each would import all that it needs
    if not child:
        sqlite3.connect = counted
        migrate.migrate(path)
        os._exit(0)
    os.waitpid(child, 0)
    print(flush=True)
"""


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="needs POSIX signals")
def test_a_migration_that_is_killed_leaves_old_or_new(older):
    """Killed behind every few statements, from the copy to the commit and the last one."""
    path, before = older
    whole = path.read_bytes()
    versions, statements = set(), 0
    process = subprocess.Popen(
        [sys.executable, "-P", "-c", _KILLED, path], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    while versions != {1, SCHEMA_VERSION}:
        statements += 4
        for part in path.parent.glob("old.db*"):
            part.unlink()
        path.write_bytes(whole)
        print(statements, file=process.stdin, flush=True)
        assert process.stdout.readline() == "\n"
        with closing(sqlite3.connect(path)) as plain:
            assert plain.execute("PRAGMA integrity_check").fetchone() == ("ok",)
            (version,) = plain.execute("PRAGMA user_version").fetchone()
        versions.add(version)
        assert migrate(path).after == SCHEMA_VERSION
        assert content(path) == before
    process.communicate()
    assert process.returncode == 0
    assert statements > 20
