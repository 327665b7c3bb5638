"""Journals: none remains after a clean end, none is read into another file, and none outlives its file."""

import shutil
import sys
import time
from contextlib import closing
from pathlib import Path

import pytest
from contents import ask
from processes import run, start

from orbitdb import Catalogue, StoreError
from orbitdb.filling.fill import fill_periods
from orbitdb.store.asking.selection import Selection
from orbitdb.store.file.database import driver
from orbitdb.store.reading.moment import reading
from orbitdb.store.writing.writer import Writer
from orbitdb.verification.verify import verification_steps

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="an open file cannot be replaced there")

COMMANDS = {
    "fill": ("fill", "--p", "12", "--jobs", "1"),
    "sweep": ("sweep", "--p", "14", "--jobs", "1"),
    "births": ("births", "--p", "11", "--jobs", "1"),
    "levels": ("levels", "--k", "0:24", "--jobs", "1"),
    "verify": ("verify", "--rigorous", "--p", "2-11"),
}
"""Commands that write repeatedly for a few seconds."""


def write(path, times=1, a=2.5):
    """Store a stadium in each of several transactions of the same run."""
    with closing(Writer(path, {"command": "test"})) as writer:
        for n in range(times):
            with writer.writing() as connection:
                writer.run_id(connection)
                writer.stadium_id(connection, a + n)
            yield


def journal_of_a_kill(path, folder, times=1):
    """Return a file and its journal as a process that is killed after some transactions leaves them."""
    folder.mkdir()
    writing = write(path, times)
    for _ in range(times):
        next(writing)
    copies = copied(path, folder)
    writing.close()
    return copies


def copied(path, folder):
    """Copy a file and its journal."""
    return [Path(shutil.copy(path.with_name(path.name + end), folder)) for end in ("", "-wal")]


@pytest.mark.parametrize(
    "command",
    [("query", "13"), ("births", "--p", "5"), ("sweep", "--p", "9"), ("bounds", "--time", "0.1"),
     ("verify", "--rigorous", "--p", "2-5"), ("fill", "--p", "8"), ("table",), ("info",)],
)  # fmt: skip
def test_a_command_leaves_no_journal(cli, filled, command):
    assert cli(*command, "--db", str(filled)).code == 0
    assert [each.name for each in filled.parent.iterdir() if each.name.startswith(filled.name)] == [
        filled.name
    ]


def test_a_question_that_was_not_read_to_its_end_leaves_no_journal(filled):
    with reading(filled) as moment:  # an interrupted command still refers to its query
        query = driver(moment.connection).execute("SELECT * FROM class")
    assert not filled.with_name(f"{filled.name}-wal").exists(), query


LOST = """
import sys
from pathlib import Path
from orbitdb.cli.main import run
from orbitdb.store.file.database import to_read
lost = to_read(Path(sys.argv.pop()))()
lost.itself = lost  # so that nothing frees it
lost.execute("SELECT * FROM cycle").fetchone()
run()
"""


def test_a_connection_that_an_interrupted_command_lost_leaves_no_journal(filled):
    done = run("columns", filled, command=[sys.executable, "-P", "-c", LOST])
    assert done.returncode == 0, done.stderr
    assert [each.name for each in filled.parent.iterdir()] == [filled.name]


@pytest.mark.parametrize("last", ["reader", "writer"])
def test_the_last_to_close_the_file_removes_the_journal(filled, last):
    catalogue, writing = Catalogue(filled, a=1.6), write(filled, 2)
    next(writing)
    assert len(catalogue) > 0
    for closed in (writing, catalogue) if last == "reader" else (catalogue, writing):
        closed.close()
    assert [each.name for each in filled.parent.iterdir()] == [filled.name]
    assert ask(filled, "SELECT a FROM stadium") == [(1.6,), (2.5,)]


def test_the_journal_of_a_killed_process_is_recovered(filled, tmp_path, cli):
    path, journal = journal_of_a_kill(filled, tmp_path / "killed", times=3)
    assert journal.stat().st_size > 0
    assert cli("info", "--db", str(path)).code == 0
    assert [each.name for each in (tmp_path / "killed").iterdir()] == [filled.name]
    assert ask(path, "SELECT count(*) FROM stadium") == [(4,)]


@pytest.mark.parametrize(
    "which", ["another catalogue", "an earlier copy", "a later copy", "a copy from the same run"]
)
def test_the_journal_of_another_file_is_refused(filled, tmp_path, cli, which):
    other = tmp_path / "other.db"
    shutil.copy(filled, other)
    if which == "another catalogue":
        other.unlink()
        Catalogue.create(other)
        list(fill_periods(other, 1.6, [2, 3, 4]))
    if which == "a copy from the same run":
        writing = write(filled, 4)
        for _ in range(2):
            next(writing)
        (tmp_path / "early").mkdir()
        path, journal = copied(filled, tmp_path / "early")
        list(writing)
        shutil.copy(filled, other)
    else:
        if which == "a later copy":
            list(write(other, 2, a=7.0))
        else:
            list(write(filled, 1, a=3.5))
        path, journal = journal_of_a_kill(filled, tmp_path / "killed")
        if which == "an earlier copy":
            list(write(other, 1, a=9.0))
    shutil.copy(other, path)
    before = [part.read_bytes() for part in (path, journal)]
    for command in (("query", "13"), ("fill", "--p", "4"), ("verify",), ("migrate",)):
        assert cli(*command, "--db", str(path)).says(3, f"{filled.name}-wal is not the journal of", "away")
    with pytest.raises(StoreError, match="is not the journal of"):
        Catalogue(path)
    assert [part.read_bytes() for part in (path, journal)] == before
    journal.unlink()
    assert cli("info", "--db", str(path)).code == 0
    assert ask(path, "SELECT a FROM stadium") == ask(other, "SELECT a FROM stadium")


@pytest.mark.parametrize("replaced", [True, False])
def test_a_fill_ends_if_its_file_is_replaced_or_deleted(filled, tmp_path, begin_fill, replaced):
    good = shutil.copy(filled, tmp_path / "good.db")
    content = good.read_bytes()
    going = begin_fill(filled, 9)
    if replaced:
        good.replace(filled)
    else:
        filled.unlink()
    with pytest.raises(StoreError, match="replaced" if replaced else "deleted"):
        list(going)
    assert [each.name for each in tmp_path.iterdir() if "orbits" in each.name] == ["orbits.db"] * replaced
    assert not replaced or filled.read_bytes() == content


def test_what_a_fill_stored_is_in_the_file_that_was_moved_away(filled, begin_fill):
    going, away = begin_fill(filled, 9), filled.with_name("away.db")
    count = "SELECT count(*) FROM orbit"
    stored = ask(filled, count)
    filled.rename(away)
    with pytest.raises(StoreError, match="deleted"):
        list(going)
    assert [each.name for each in filled.parent.iterdir()] == [away.name]
    assert ask(away, count) == stored


def test_a_question_leaves_no_journal_of_a_deleted_file(filled):
    with reading(filled):
        filled.unlink()
    assert not list(filled.parent.iterdir())


@pytest.mark.parametrize("rigorous", [True, False])
@pytest.mark.parametrize("replaced", [True, False])
def test_verify_fails_if_its_file_is_replaced_or_deleted(filled, replaced, rigorous):
    good = shutil.copy(filled, filled.with_name("good.db"))
    content = good.read_bytes()
    steps = verification_steps(filled, [Selection(1.6)], rigorous=rigorous, jobs=1)
    next(steps)
    if replaced:
        good.replace(filled)
    else:
        filled.unlink()
        good.unlink()
    with pytest.raises(StoreError, match="replaced" if replaced else "deleted"):
        list(steps)
    assert [each.name for each in filled.parent.iterdir()] == [filled.name] * replaced
    assert not replaced or filled.read_bytes() == content


@pytest.mark.slow
@pytest.mark.parametrize("command", COMMANDS)
def test_no_command_writes_to_a_file_that_replaced_its_own(tmp_path, command):
    path, good, journal = (tmp_path / name for name in ("rep.db", "good.db", "rep.db-wal"))
    for each in (path, good):
        assert run("fill", "--p", "11" if command == "verify" else "3", "--db", each).returncode == 0
    content = good.read_bytes()
    process = start(*COMMANDS[command], "--db", str(path))
    while process.poll() is None and not (journal.exists() and journal.stat().st_size):
        time.sleep(0.01)
    good.replace(path)
    _, err = process.communicate(timeout=200)
    assert process.returncode == 3, err
    assert "was replaced by another file" in err.splitlines()[-1]
    assert path.read_bytes() == content
    assert [each.name for each in tmp_path.iterdir()] == ["rep.db"]
