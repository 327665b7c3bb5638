"""What a process deletes while another one fills, sweeps or finds births: neither spoils the other's work."""

import sqlite3
import sys
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path

import pytest
from contents import ask, content, is_sound, made
from processes import go_on, kill_group, pausing, run, start, wait_until_paused
from quick import slow_but

from orbitdb import Catalogue
from orbitdb.billiard.stadium import StadiumError
from orbitdb.filling.fill import fill_periods

pytestmark = pytest.mark.skipif(
    sys.platform == "win32", reason="the processes are stopped with POSIX signals"
)

WORK = {
    "sweep": ("sweep", "--p", "6-7", "--a", "2", "--jobs", "1"),
    "newton": ("fill", "--p", "7", "--a", "2", "--jobs", "2"),
    "relaxation": ("fill", "--p", "5", "--a", "2", "--method", "relaxation", "--jobs", "1"),
}


@contextmanager
def paused(path: Path, *arguments: str, before: int) -> Iterator[list[str]]:
    """Delete or fill while a command waits before one of its transactions; then let it end without an error.

    Yields a list which afterwards has the lines that the command wrote to stderr.
    """
    process = start(*arguments, "--db", path, command=pausing(before))
    lines: list[str] = []
    try:
        wait_until_paused(process)
        yield lines
        code, err = go_on(process)
        assert code == 0, err
        lines += err.splitlines()
    finally:
        if process.poll() is None:
            kill_group(process)


def checked(path: Path) -> None:
    """Check that no row refers to a row that is missing, and that `verify` finds no fault."""
    assert is_sound(path)
    assert ask(path, "PRAGMA foreign_key_check") == []
    found = Catalogue(path).verify()
    assert found.sound, found


def swept(path: Path, a: float) -> list[tuple[object, ...]]:
    """Return the counts and sums of the sweeps at a."""
    return [(s.p, s.done, s.tally, s.sums.numbers()) for s in Catalogue(path).sweeps(a=a) if s.sums]


def table(path: Path, a: float) -> str:
    return str(Catalogue(path).table(a=a).to_pandas().to_csv())


@pytest.fixture(scope="module")
def undisturbed(made_once) -> Path:
    """What should be stored in the end: p = 2..4 at a = 0.5, and the work at a = 2."""

    def make(path: Path) -> None:
        assert run(*WORK["sweep"], "--db", path, command=pausing(0)).returncode == 0  # before a fill
        made(path, fill_periods(path, 0.5, range(2, 5)), fill_periods(path, 2.0, range(2, 8)))

    return made_once("undisturbed", make)


@pytest.mark.parametrize(
    ("name", "before"),
    slow_but(
        [("sweep", 2)],
        [*(("sweep", n) for n in (2, 3, 5)), ("newton", 2), ("newton", 5), ("relaxation", 3)],
    ),
)
def test_work_begun_at_one_a_never_appears_at_another(undisturbed, tmp_path, name, before):
    """Another a is deleted and the one that is being worked on, too; then a third one is filled."""
    path = made(tmp_path / "orbits.db", fill_periods(tmp_path / "orbits.db", 3.0, range(2, 5)))
    with paused(path, *WORK[name], before=before):
        for a in (3.0, 2.0):
            Catalogue(path).delete(a)
        list(fill_periods(path, 0.5, range(2, 5)))
        number = ask(path, "SELECT id FROM stadium")
    assert table(path, 0.5) == table(undisturbed, 0.5)
    assert ask(path, "SELECT id, a FROM stadium WHERE a = 0.5") == [(*number[0], 0.5)]
    assert set(ask(path, "SELECT a FROM stadium")) == {(0.5,), (2.0,)}
    assert len(set(ask(path, "SELECT id FROM stadium"))) == 2
    if name == "sweep":
        assert swept(path, 2.0) == swept(undisturbed, 2.0)
        assert ask(path, "SELECT count(*) FROM sweep_block") == [(0,)]
    else:
        highest = int(WORK[name][2])
        assert [(fill.p, fill.done) for fill in Catalogue(path).fills(a=2.0)] == [
            (p, True) for p in range(2, highest + 1)
        ]
        assert table(path, 2.0) == str(
            Catalogue(undisturbed).table(a=2.0, p=f"2-{highest}").to_pandas().to_csv()
        )
    checked(path)


def test_the_number_of_a_deleted_stadium_is_never_used_again(tmp_path):
    path = made(tmp_path / "orbits.db", fill_periods(tmp_path / "orbits.db", 3.0, [2]))
    ((before,),) = ask(path, "SELECT id FROM stadium")
    Catalogue(path).delete(3.0)
    list(fill_periods(path, 0.5, [2]))
    ((number, a),) = ask(path, "SELECT id, a FROM stadium")
    assert (number > before, a) == (True, 0.5)


@pytest.mark.slow
@pytest.mark.parametrize("before", slow_but([3], [2, 3, 5]))
def test_a_fill_stores_the_classes_that_another_process_deletes(filled, tmp_path, before):
    """A fill leaves out the classes that another a has stored, until they are deleted there."""
    path = made(tmp_path / "own.db", fill_periods(tmp_path / "own.db", 1.6, range(2, 9)))
    with paused(path, "fill", "--p", "8", "--a", "2", "--jobs", "1", before=before):
        Catalogue(path).delete(1.6)
        with closing(sqlite3.connect(path)) as plain:
            assert plain.execute("PRAGMA foreign_key_check").fetchall() == []
    alone = made(tmp_path / "alone.db", fill_periods(tmp_path / "alone.db", 2.0, range(2, 9)))
    assert content(path) == content(alone)
    checked(path)


@pytest.mark.slow
@pytest.mark.parametrize("p", [5, 8])
@pytest.mark.parametrize("before", [3, 5])
def test_a_fill_begins_a_period_again_that_another_process_deletes(filled, before, p):
    """The other process deletes what is being filled, or what was filled before."""
    undisturbed = content(filled)
    Catalogue(filled).delete(1.6, p=8)
    with paused(filled, "fill", "--p", "2-8", "--jobs", "1", before=before):
        Catalogue(filled).delete(1.6, p=p)
        assert ask(filled, f"SELECT count(*) FROM fill WHERE p = {p}") == [(0,)]
    assert content(filled) == undisturbed
    checked(filled)


@pytest.mark.slow
@pytest.mark.parametrize("before", [2, 5])
def test_births_stay_whole_beside_a_deletion(filled, born_once, before):
    with paused(filled, "births", "--p", "6", "--jobs", "1", before=before):
        Catalogue(filled).delete(1.6)
    births = (
        "SELECT word, number, change.a, kind FROM change JOIN cycle ON cycle.id = cycle ORDER BY word, number"
    )
    assert ask(filled, births) == ask(born_once, births)
    assert ask(filled, "SELECT count(*) FROM stadium") == [(0,)]
    checked(filled)


@pytest.mark.slow
def test_a_fill_that_uses_the_classes_of_births_keeps_them_beside_a_deletion(born_once, tmp_path):
    path = tmp_path / "orbits.db"
    path.write_bytes(born_once.read_bytes())
    list(fill_periods(path, 1.6, range(2, 7)))
    with paused(path, "fill", "--p", "6", "--a", "2", "--jobs", "1", before=3):
        Catalogue(path).delete(1.6, p=6)
    assert ask(path, "SELECT count(*) FROM cycle") == ask(born_once, "SELECT count(*) FROM cycle")
    checked(path)


@pytest.mark.parametrize("a", [None, "1.6", True])
def test_what_to_delete_must_be_said(filled, a):
    before = content(filled)
    with pytest.raises(StadiumError, match="is not a half length"):
        Catalogue(filled).delete(a)
    assert content(filled) == before
