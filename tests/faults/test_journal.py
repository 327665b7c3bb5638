"""Journals: none remains after a clean end, none is read into another file, and none outlives its file."""

import shutil
import sqlite3
import sys
from contextlib import closing
from pathlib import Path

import pytest
from contents import ask
from processes import go_on, pausing, run, start, wait_until_paused
from quick import slow_but

from orbitdb import Catalogue, StoreError
from orbitdb.filling.fill import fill_periods
from orbitdb.selection import Selection
from orbitdb.store.deleting import delete
from orbitdb.store.file import open_to_write, reading, upgrading
from orbitdb.store.paths import journal_files
from orbitdb.store.tables import PAGE_SIZE
from orbitdb.store.writer import Writer
from orbitdb.verification.verify import verified

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="an open file cannot be replaced there")

COMMANDS = {
    "fill": ("fill", "--p", "7", "--jobs", "1"),
    "sweep": ("sweep", "--p", "7", "--jobs", "1"),
    "births": ("births", "--p", "7", "--jobs", "1"),
    "levels": ("levels", "--k", "0:12", "--jobs", "1"),
    "verify": ("verify", "--prove", "--p", "2-11"),
}
"""Commands with several transactions, if blocks are small."""


def write(path, times=1, a=2.5, run=True):
    """Store a stadium in each of several transactions of the same run, or of none, as for a deletion."""
    with closing(Writer(path, {"command": "test"})) as writer:
        for n in range(times):
            with writer.transaction() as connection:
                if run:
                    writer.run_id(connection)
                writer.stadium_id(connection, a + n)
            yield


def journal_of_a_kill(path, folder, times=1, run=True):
    """Return a file and its journal as a process that is killed after some transactions leaves them."""
    folder.mkdir()
    writing = write(path, times, run=run)
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
    slow_but(
        ["query 13", "sweep --p 6"],
        ["query 13", "sweep --p 6", "births --p 5", "bounds --seconds 0.1", "verify --prove --p 2-5",
         "fill --p 8", "table", "info"],
    ),
)  # fmt: skip
def test_a_command_leaves_no_journal(cli, filled, command):
    assert cli(*command.split(), "--db", str(filled)).code == 0
    assert [each.name for each in filled.parent.iterdir() if each.name.startswith(filled.name)] == [
        filled.name
    ]


UNFINISHED = """
import sys
from orbitdb import Catalogue
rows = iter(Catalogue(sys.argv[1], a=1.6).rows())
print(next(rows)[0])
"""


@pytest.mark.slow
def test_rows_that_were_not_read_to_their_end_leave_no_journal_and_no_noise(filled):
    done = run(filled, command=[sys.executable, "-P", "-W", "error", "-c", UNFINISHED])
    assert (done.returncode, done.stdout, done.stderr) == (0, "13\n", "")
    assert [each.name for each in filled.parent.iterdir()] == [filled.name]


def test_another_file_may_take_the_place_of_one_that_is_open(filled, tmp_path):
    """Whether it is moved or copied there: the next question reads it, and no old journal stays."""
    catalogue, other = Catalogue(filled, a=1.6), Path(shutil.copy(filled, tmp_path / "other.db"))
    list(write(other))
    assert catalogue.a_values() == [1.6]
    list(write(filled, 1, a=3.5))
    assert catalogue.a_values() == [1.6, 3.5]
    shutil.copyfile(other, filled)
    assert catalogue.a_values() == [1.6, 2.5]
    list(write(other, 1, a=4.5))
    other.replace(filled)
    assert catalogue.a_values() == [1.6, 2.5, 4.5]
    catalogue.close()
    assert [each.name for each in tmp_path.iterdir() if filled.name in each.name] == [filled.name]


def test_a_list_read_to_its_end_does_not_bring_back_a_file_that_was_replaced(filled, tmp_path):
    catalogue, saved = Catalogue(filled, a=1.6), shutil.copy(filled, tmp_path / "saved.db")
    Catalogue.create(tmp_path / "other.db").fill(3, a=2.5)
    rows = iter(catalogue.rows())
    next(rows)
    (tmp_path / "other.db").replace(filled)
    assert catalogue.a_values() == [2.5]
    with pytest.raises(StoreError, match="was replaced by another file"):
        list(rows)
    assert catalogue.a_values() == [2.5]
    shutil.copyfile(saved, filled)
    assert catalogue.a_values() == [1.6]


def test_a_file_that_is_moved_away_keeps_the_journal_that_it_needs(filled, tmp_path):
    path, journal = journal_of_a_kill(filled, tmp_path / "killed")
    catalogue, away = Catalogue(path), tmp_path / "away.db"
    assert catalogue.a_values() == [1.6, 2.5]
    path.rename(away)
    with pytest.raises(StoreError, match="no catalogue at"):
        catalogue.a_values()
    catalogue.close()
    assert not journal.exists()  # the last question moved it into the file
    assert ask(away, "SELECT a FROM stadium") == [(1.6,), (2.5,)]


def test_an_open_handle_locks_nothing(filled):
    """Others write, delete and shrink the file, and the handle sees each change."""
    catalogue = Catalogue(filled, a=1.6)
    counts = [catalogue.count(p=8)]
    with closing(sqlite3.connect(filled, timeout=0)) as other:
        other.execute("VACUUM")
        counts.append(catalogue.count(p=8))
        with other:
            other.execute("DELETE FROM fill WHERE p = 8")
        assert [fill.p for fill in catalogue.fills()] == [2, 3, 4, 5, 6, 7]
    delete(filled, 1.6, [(8, 8)])
    assert [*counts, catalogue.count(p=8)] == [1424, 1424, 0]


def test_a_handle_follows_its_path(filled, cli):
    catalogue = Catalogue(filled, a=1.6)
    filled.unlink()
    with pytest.raises(StoreError, match="no catalogue at"):
        catalogue.count(p=3)
    with pytest.raises(StoreError, match="no catalogue at"):
        catalogue.fill([3])
    assert not list(filled.parent.iterdir())
    Catalogue.create(filled).fill([3], a=1.6)
    assert catalogue.count(p="2-8") == 8
    filled.write_text("no catalogue")
    with pytest.raises(StoreError, match="not an orbitdb catalogue"):
        catalogue.count(p=3)


def test_a_relative_path_is_meant_where_it_was_given(filled, tmp_path, monkeypatch):
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    monkeypatch.chdir(tmp_path)
    catalogue = Catalogue(filled.name, a=1.6)
    monkeypatch.chdir(elsewhere)
    catalogue.fill(2, a=2.5)
    assert catalogue.a_values() == [1.6, 2.5]
    assert not list(elsewhere.iterdir())


def test_the_home_folder_may_be_written_as_a_tilde(filled, tmp_path, monkeypatch, cli):
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv("ORBITDB_DB", "~/orbits.db")
    assert Catalogue().path == Catalogue("~/orbits.db").path == filled
    assert cli("info", "--db", "~/orbits.db").code == 0
    assert cli("fill", "--p", "3", "--db", "~/new.db").code == 0
    assert (tmp_path / "new.db").exists()


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
    "which",
    [
        "another catalogue",
        "an older copy",
        "an earlier copy",
        "a later copy",
        "a copy from the same run",
        "a copy before a deletion",
        "a copy before VACUUM",
    ],
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
    elif which == "a copy before VACUUM":
        list(write(filled, run=False))
        (tmp_path / "killed").mkdir()
        with closing(open_to_write(filled)) as driver:
            driver.execute("VACUUM")
            path, journal = copied(filled, tmp_path / "killed")
    else:
        if which == "a later copy":
            list(write(other, 2, a=7.0))
        else:
            list(write(filled, 1, a=3.5))
        path, journal = journal_of_a_kill(
            filled, tmp_path / "killed", run=which != "a copy before a deletion"
        )
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


@pytest.mark.slow
def test_the_message_about_damage_names_the_journal_that_would_damage_a_copy(filled, tmp_path):
    path, journal = journal_of_a_kill(filled, tmp_path / "killed", times=3)
    sound, start = path.read_bytes(), 3 * PAGE_SIZE
    path.write_bytes(sound[:start] + bytes(len(sound) - start))
    done = run("query", "--p", "8", "--db", path)
    assert (done.returncode, done.stdout) == (3, "")
    assert done.stderr == (
        f"orbitdb: {path} is damaged: restore a copy, or move it away and fill a new one; "
        f"remove {journal} before you copy\n"
    )
    journal.unlink(missing_ok=True)  # as the message says, unless the command was the last to close it
    path.write_bytes(sound)
    assert run("query", "--p", "8", "--db", path).returncode == 0


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


@pytest.mark.parametrize("prove", [True, False])
@pytest.mark.parametrize("replaced", [True, False])
def test_verify_fails_if_its_file_is_replaced_or_deleted(filled, replaced, prove):
    good = shutil.copy(filled, filled.with_name("good.db"))
    content = good.read_bytes()

    def lose(*progress: object) -> None:
        if good.exists() and replaced:
            good.replace(filled)
        elif good.exists():
            filled.unlink()
            good.unlink()

    with pytest.raises(StoreError, match="replaced" if replaced else "deleted"):
        verified(filled, [Selection(1.6)], prove=prove, jobs=1, tell=lose)
    assert [each.name for each in filled.parent.iterdir()] == [filled.name] * replaced
    assert not replaced or filled.read_bytes() == content


def test_an_upgrade_of_a_replaced_file_is_an_error_and_leaves_no_journal(filled, tmp_path):
    other = Path(shutil.copy(filled, tmp_path / "other.db"))
    content = other.read_bytes()
    change = upgrading(filled)
    change.__enter__().exec_driver_sql("CREATE TABLE further (x)")
    other.replace(filled)
    with pytest.raises(StoreError, match="replaced by another file"):
        change.__exit__(None, None, None)
    assert not journal_files(filled)[0].exists()
    assert filled.read_bytes() == content


@pytest.mark.slow
@pytest.mark.parametrize("command", COMMANDS)
def test_no_command_writes_to_a_file_that_replaced_its_own(tmp_path, command):
    path, good = (tmp_path / name for name in ("rep.db", "good.db"))
    for each in (path, good):
        Catalogue.create(each).fill(11 if command == "verify" else 3, a=1.6)
    content = good.read_bytes()
    process = start(*COMMANDS[command], "--db", str(path), command=pausing(3))
    wait_until_paused(process)
    assert Path(f"{path}-wal").stat().st_size
    good.replace(path)
    code, err = go_on(process)
    assert code == 3, err
    assert "was replaced by another file" in err.splitlines()[-1]
    assert path.read_bytes() == content
    assert [each.name for each in tmp_path.iterdir()] == ["rep.db"]
