"""Several processes share a file, with parallel fills, readers during a fill, and locks."""

import re
import sqlite3
import sys
import threading
import time
from contextlib import closing, suppress
from types import SimpleNamespace

import pytest
from contents import ask, content, is_sound
from processes import run, run_here, small_blocks, start, wait_until_ready
from sqlalchemy.pool import StaticPool
from there import there

from orbitdb.catalogue import Catalogue
from orbitdb.store import sqlite
from orbitdb.store.cursors import OvertakenError
from orbitdb.store.file import open_to_write
from orbitdb.store.file_kind import check_file
from orbitdb.store.journal import checkpoint
from orbitdb.store.paths import journal_files
from orbitdb.store.sqlite import make_engine
from orbitdb.store.tables import SCHEMA_VERSION
from orbitdb.store.writer import Writer

pytestmark = pytest.mark.skipif(
    sys.platform == "win32", reason="the processes are stopped with POSIX signals"
)


IMPATIENT = [
    sys.executable,
    "-P",
    "-c",
    "from orbitdb.store import sqlite; sqlite.BUSY_TIMEOUT = 0.05;from orbitdb.cli.main import run; run()",
]


*PYTHON, PROGRAM = small_blocks(32)
AT_ONCE = [*PYTHON, f"from orbitdb.store import writer; writer.JOURNAL_LIMIT = 0\n{PROGRAM}"]
"""A command that moves the journal into the file after every block."""


def all_end_well(*processes) -> None:
    for process in processes:
        _, err = process.communicate(timeout=200)
        assert process.returncode == 0, err
        assert len([line for line in err.splitlines() if not line.startswith("waiting for")]) == 1


_WRITE = """
import sqlite3, sys
plain = sqlite3.connect(sys.argv[1])
plain.execute("INSERT INTO stadium (a) VALUES (2.5)")
plain.commit()
plain.close()
"""


def test_checking_a_file_releases_no_lock(filled):
    """Otherwise another process could close the file as if it were the last, and remove the journal."""
    writer = Writer(filled, {})
    with writer.transaction() as connection:
        writer.stadium_id(connection, 1.0)
    assert check_file(filled) == SCHEMA_VERSION
    assert run(filled, command=[sys.executable, "-P", "-c", _WRITE]).returncode == 0
    with writer.transaction() as connection:
        writer.stadium_id(connection, 3.0)
    assert Catalogue(filled).a_values() == [1.0, 1.6, 2.5, 3.0]
    writer.close()


def test_a_run_that_was_rolled_back_is_stored_again(filled):
    writer = Writer(filled, {})
    with suppress(OvertakenError), writer.transaction() as connection:
        writer.run_id(connection)
        raise OvertakenError
    with writer.transaction() as connection:
        number = writer.run_id(connection)
    writer.close()
    assert ask(filled, f"SELECT count(*) FROM run WHERE id = {number}") == [(1,)]


@pytest.mark.slow
def test_several_processes_can_create_one_file(tmp_path):
    path = tmp_path / "new.db"
    processes = [start("fill", "--p", "5", "--db", path) for _ in range(3)]
    all_end_well(*processes)
    assert is_sound(path)
    assert {fill.p: fill.words for fill in Catalogue(path).fills(a=1.6)} == {2: 1, 3: 8, 4: 32, 5: 96}


def test_changing_the_journal_mode_waits_for_a_lock(filled, monkeypatch):
    """SQLite does not wait there. The other process finishes as soon as this one waits."""
    with closing(sqlite3.connect(filled, isolation_level=None)) as other:
        assert other.execute("PRAGMA journal_mode = DELETE").fetchone() == ("delete",)
        other.execute("BEGIN IMMEDIATE")
        waits = []

        def sleep(seconds: float) -> None:
            waits.append(seconds)
            other.execute("ROLLBACK")

        monkeypatch.setattr(sqlite, "time", SimpleNamespace(monotonic=time.monotonic, sleep=sleep))
        monkeypatch.setattr(sqlite, "BUSY_TIMEOUT", 0.5)
        writer = Writer(filled, {"command": "test"})
        with writer.transaction() as connection:
            assert connection.exec_driver_sql("PRAGMA journal_mode").scalar() == "wal"
        writer.close()
    assert len(waits) == 1


@pytest.mark.slow
def test_a_fill_waits_for_a_lock(filled):
    with closing(sqlite3.connect(filled, isolation_level=None, check_same_thread=False)) as other:
        other.execute("BEGIN IMMEDIATE")
        process = start("fill", "--p", "8", "--a", "1", "--db", filled, command=small_blocks())
        wait_until_ready(process)
        giving_back = threading.Timer(1.5, other.execute, ["ROLLBACK"])
        giving_back.start()
        all_end_well(process)
        giving_back.join()


@pytest.mark.slow
@pytest.mark.parametrize("command", ["fill --p 8", "sweep --p 9", "delete --yes"])
def test_a_blocked_writer_says_once_that_it_waits(filled, command):
    """It says so while it waits: the other process only ends after it has read this."""
    with closing(sqlite3.connect(filled, isolation_level=None)) as other:
        other.execute("BEGIN IMMEDIATE")
        process = start(*command.split(), "--a", "1.6", "--db", filled, command=IMPATIENT)
        assert there(process.stderr).readline() == f"waiting for another process that writes to {filled}\n"
        time.sleep(0.3)  # several further turns
        other.execute("ROLLBACK")
    _, err = process.communicate(timeout=200)
    assert process.returncode == 0, err
    assert "waiting" not in err


@pytest.mark.slow
def test_a_lock_held_too_long_is_reported(filled):
    before = content(filled)
    with closing(sqlite3.connect(filled, isolation_level=None)) as other:
        other.execute("BEGIN IMMEDIATE")
        done = run("fill", "--p", "8", "--a", "1", "--db", filled, command=IMPATIENT)
        other.execute("ROLLBACK")
    assert done.returncode == 3
    assert done.stderr.splitlines() == [
        f"waiting for another process that writes to {filled}",
        f"orbitdb: {filled} is in use by another process that writes: try again when it has finished",
    ]
    assert content(filled) == before


@pytest.mark.slow
def test_readers_work_during_a_fill(tmp_path):
    """Queries, averages and verification are repeated while a fill stores periods block by block."""
    path = tmp_path / "orbits.db"
    Catalogue.create(path).fill(5, a=1.6)
    filling = start("fill", "--p", "8", "--jobs", "2", "--db", path, command=small_blocks(32))
    wait_until_ready(filling)
    asked = ["query", "--p", "2-11", "--status", "all", "--limit", "1"], ["entropy", "--json"], ["verify"]
    counts = []
    while filling.poll() is None:
        for _, code, err in run_here(asked, path):
            assert code == 0, err
            counts += [int(n) for n in re.findall(r"(\d+) words", err)]
    all_end_well(filling)
    assert counts == sorted(counts)
    assert Catalogue(path).verify().sound


def test_nobody_can_commit_while_the_journal_is_moved(filled):
    """Before version 3.51.3, SQLite could lose what is committed at that moment."""
    tried = []

    def commit(statement: str) -> None:
        if "checkpoint" in statement:
            with closing(sqlite3.connect(filled, timeout=0)) as third:
                try:
                    third.execute("BEGIN IMMEDIATE")
                except sqlite3.OperationalError as error:
                    tried.append(str(error))

    with closing(open_to_write(filled)) as driver, closing(open_to_write(filled)) as other:
        for each in (driver, other):
            assert each.execute("PRAGMA wal_autocheckpoint").fetchone() == (0,)
        driver.execute("INSERT INTO stadium (a) VALUES (2.5)")
        journal, _ = journal_files(filled)
        size = filled.stat().st_size, journal.stat().st_size
        assert size[1] > 0
        other.set_trace_callback(commit)
        checkpoint(make_engine(lambda: driver, "BEGIN IMMEDIATE", StaticPool), other)
        assert tried == ["database is locked"]
        alone = f"file:{filled}?mode=ro&immutable=1"  # without the journal
        with closing(sqlite3.connect(alone, uri=True)) as plain:
            assert plain.execute("SELECT a FROM stadium").fetchall() == [(1.6,), (2.5,)]


@pytest.mark.slow
def test_four_fills_that_move_the_journal_after_every_block_lose_nothing(filled, tmp_path):
    """Two of them fill the same periods; others read meanwhile."""
    path = tmp_path / "new.db"
    Catalogue.create(path).fill(3, a=1.6)
    fills = [
        start("fill", "--p", "8", "--a", a, "--jobs", "1", "--db", path, command=AT_ONCE)
        for a in ("1.6", "1.6", "2", "0.5")
    ]
    while any(process.poll() is None for process in fills):
        asked = ["query", "--p", "2-8", "--status", "all", "--a", "all", "--limit", "1"], ["table"]
        assert [code for _, code, _ in run_here(asked, path)] == [0, 0]
    for process in fills:
        there(process.stdout).readline()
    all_end_well(*fills)
    assert is_sound(path)
    assert [each.name for each in tmp_path.iterdir() if "new.db" in each.name] == ["new.db"]
    catalogue = Catalogue(path)
    assert catalogue.verify().sound
    for a in (2.0, 0.5):
        catalogue.delete(a)
    assert content(path) == content(filled)
    assert ask(path, "PRAGMA foreign_key_check") == []
