"""A full disk or a write-protected file gives a one-line error and exit code 3; nothing is half-written."""

import contextlib
import ctypes
import os
import shutil
import sqlite3
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path

import pytest
from contents import content, is_sound
from processes import run, run_several, small_blocks
from quick import fuzz_but

from orbitdb.catalogue import Catalogue

pytestmark = pytest.mark.slow

resource = pytest.importorskip("resource")

CAP_DAC_OVERRIDE, CAP_DAC_READ_SEARCH, PR_CAPBSET_DROP = 1, 2, 24

WRITING = (
    ["fill", "--p", "9"],
    ["fill", "--code", "1^30 3"],
    ["verify", "--prove", "--p", "2-4"],
)
READING = (
    ["query", "--p", "3"],
    ["query", "--code", "13"],
    ["table"],
    ["entropy"],
    ["bounds", "--edges", "4"],
    ["info"],
    ["export", "--format", "csv"],
    ["verify", "--p", "2-4"],
)


def fails(done: subprocess.CompletedProcess[str], said: str) -> None:
    assert done.returncode == 3, done.stderr
    assert "Traceback" not in done.stderr
    assert len(done.stderr.splitlines()) == 1, done.stderr
    assert done.stderr.startswith("orbitdb: ")
    assert said in done.stderr


def room(size: int) -> Callable[[], None]:
    """Limit the size of files, which has the effect of a full disk."""
    return lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))


@pytest.fixture
def disk(tmp_path: Path) -> Iterator[Callable[[int], Path]]:
    """Return a function that mounts a disk of a given size in kilobytes, or resizes it."""
    folder = tmp_path / "disk"
    folder.mkdir()
    kind = "mount", "-t", "tmpfs", "-o"

    def mount(size: int) -> Path:
        first = not folder.is_mount()
        options = ("size=%dk" if first else "remount,size=%dk") % size
        if subprocess.run([*kind, options, "tmpfs", folder], capture_output=True, check=False).returncode:
            pytest.skip("needs the right to mount a disk")
        return folder

    yield mount
    if folder.is_mount():
        subprocess.run(["umount", folder], check=True)


_UNAWARE = "from orbitdb.filling import estimate; estimate.BYTES = estimate._EMPTY = 0"


@pytest.mark.parametrize("size", fuzz_but([200], [200, 300]))
def test_a_fill_resumes_after_the_disk_was_full(filled, disk, size):
    """A disk that is too small is noticed before the fill begins; others may fill it later."""
    path = disk(size) / "orbits.db"
    arguments = "fill", "--p", "8", "--db", path
    *python, program = small_blocks(16)
    done = run(*arguments, command=[*python, f"{_UNAWARE}\n{program}" if size == 300 else program])
    fails(done, "no space left" if size == 300 else "no room")
    disk(2000)
    assert run(*arguments).returncode == 0
    assert content(path) == content(filled)


def test_a_catalogue_on_a_full_disk_can_still_be_read(filled, disk):
    """There is no room for the index of a journal, which SQLite makes even to read."""
    path = Path(shutil.copy(filled, disk(filled.stat().st_size // 1024 + 40)))
    before = content(path)
    with open(path.with_name("rest"), "wb", buffering=0) as rest, contextlib.suppress(OSError):
        while True:
            rest.write(bytes(1024))
    refused = (["delete", "--a", "1.6", "--p", "8", "--yes"], ["merge", str(filled)])
    for _ in range(2):
        found = run_several([*READING, *refused], path)
        assert [code for _, code, _ in found] == [0] * len(READING) + [3] * len(refused)
        for _, _, told in found[len(READING) :]:
            assert f"orbitdb: {path} " in told
            assert "delete other files" in told
            assert told.count("\n") == 1
    path.with_name("rest").unlink()
    assert content(path) == before


@pytest.mark.parametrize("size", fuzz_but([150_000], [0, 50_000, 225_000, 150_000]))
def test_a_fill_resumes_wherever_it_ran_out_of_room(filled, tmp_path, size):
    """The sizes interrupt the creation of the file, blocks of several periods, and the journal."""
    path = tmp_path / "new.db"
    arguments = "fill", "--p", "8", "--db", path
    fails(run(*arguments, command=small_blocks(16), preexec_fn=room(size)), "ulimit -f")
    assert run(*arguments).returncode == 0
    assert content(path) == content(filled)


@pytest.mark.parametrize(
    "name", fuzz_but(["new.csv", "new.parquet"], ["new.csv", "new.tsv", "new.jsonl", "new.parquet"])
)
def test_an_export_without_room_leaves_no_file(filled, disk, name):
    folder = disk(40)
    fails(run("export", folder / name, "-c", "+coordinates", "--db", filled), "No space left")
    assert list(folder.iterdir()) == []


def test_a_dataset_without_room_leaves_no_folder(filled, disk, tmp_path):
    folder = disk(100)
    fails(run("export", folder / "data", "--dataset", "--db", filled), "no room")
    assert list(folder.iterdir()) == []
    done = run("export", tmp_path / "data", "--dataset", "--db", filled, preexec_fn=room(40_000))
    fails(done, "data cannot be written (File too large); nothing was saved")
    assert not list(tmp_path.glob("*data*"))


def test_a_simulation_that_cannot_be_stored_is_shown(filled):
    with closing(sqlite3.connect(filled)) as beside:  # keeps the journal longer than the limit
        beside.execute("PRAGMA wal_autocheckpoint = 0")
        for seconds in range(20):
            with beside:
                beside.execute("UPDATE fill SET seconds = ?", (seconds,))
        assert filled.with_name("orbits.db-wal").stat().st_size > 40_000
        done = run("simulate", "--bounces", "20000", "--json", "--db", filled, preexec_fn=room(40_000))
    fails(done, "ulimit -f")
    assert "lambda_d" in done.stdout
    assert is_sound(filled)


def test_a_figure_can_be_drawn_without_a_writable_home(tmp_path):
    homeless = dict.fromkeys(("HOME", "XDG_CONFIG_HOME", "XDG_CACHE_HOME"), "/dev/null")
    done = run("plot", "orbit", "--code", "13", "--a", "1", "-o", tmp_path / "x.svg", env=homeless)
    assert (done.returncode, done.stderr.count("\n")) == (0, 1), done.stderr


def drop_rights() -> None:
    """Make permissions apply to root as well."""
    for right in (CAP_DAC_OVERRIDE, CAP_DAC_READ_SEARCH):
        ctypes.CDLL(None).prctl(PR_CAPBSET_DROP, right, 0, 0, 0)


@pytest.fixture
def locked(filled: Path) -> Iterator[Path]:
    """A catalogue in its own folder, which is made writable again after the test."""
    if sys.platform != "linux":
        pytest.skip("drops the rights of root as Linux does")
    folder = filled.with_name("locked")
    folder.mkdir()
    path = Path(shutil.copy(filled, folder))
    path.chmod(0)
    refused = subprocess.run(["cat", path], capture_output=True, preexec_fn=drop_rights, check=False)
    path.chmod(0o644)
    if not refused.returncode:
        pytest.skip("permissions do not hold here")
    yield path
    folder.chmod(0o755)


@pytest.mark.parametrize(
    ("file", "folder"), fuzz_but([(0o444, 0o755)], [(0o444, 0o555), (0o444, 0o755), (0o644, 0o555)])
)
def test_write_protected_catalogues_can_be_read_but_not_written(locked, file, folder):
    before = content(locked)
    locked.chmod(file)
    locked.parent.chmod(folder)
    asked = [*READING, ["simulate", "--bounces", "20000"]]
    found = run_several([*asked, *WRITING], locked, preexec_fn=drop_rights)
    assert [each.name for each in locked.parent.iterdir()] == [locked.name]
    assert [code for _, code, _ in found] == [0] * len(asked) + [3] * len(WRITING)
    assert all(err.count("\n") == 1 and "cannot be written" in err for _, code, err in found if code)
    shown = [command[0] for command, code, err in found if not code and "not saved: " in err]
    assert shown == ["bounds", "simulate"]
    locked.chmod(0)
    found = run_several([*READING, *WRITING], locked, preexec_fn=drop_rights)
    assert all(code == 3 and err.count("\n") == 1 and "permissions" in err for _, code, err in found)
    locked.parent.chmod(0o755)
    locked.chmod(0o644)
    assert content(locked) == before
    assert run("fill", "--p", "8", "--a", "1", "--db", locked, preexec_fn=drop_rights).returncode == 0


def test_write_protected_parts_can_be_merged_and_made(locked, tmp_path):
    locked.chmod(0o444)
    locked.parent.chmod(0o555)
    target, part = Catalogue.create(tmp_path / "all.db").path, tmp_path / "part.db"
    for command, path in (["merge", str(locked)], target), (["export", str(part), "--a", "1.6"], locked):
        assert run_several([command], path, preexec_fn=drop_rights)[0][1] == 0
    assert [each.name for each in locked.parent.iterdir()] == [locked.name]
    assert content(target) == content(part) == content(locked)


_READ_TWICE = """
import sys
from orbitdb import StoreError
from orbitdb.store.lookup import a_values
from orbitdb.store.file import Store
reader = Store(sys.argv[1])
try:
    with reader.reading() as connection:
        print(a_values(connection), flush=True)
        input()
except StoreError as error:
    print(error)
with reader.reading() as connection:
    print(a_values(connection))
"""


def test_a_reader_without_the_right_to_lock_notices_what_the_owner_writes(locked):
    locked.chmod(0o444)
    command = [sys.executable, "-P", "-c", _READ_TWICE, str(locked)]
    with subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, preexec_fn=drop_rights
    ) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "[1.6]\n"
        locked.chmod(0o644)
        assert run("fill", "--p", "3", "--a", "1", "--db", locked).returncode == 0
        out, _ = process.communicate("\n", timeout=60)
    assert out == f"{locked} was written while it was being read: try again\n[1.0, 1.6]\n"
    assert [each.name for each in locked.parent.iterdir()] == [locked.name]


def test_the_data_folder_is_made_or_named_if_it_cannot_be(locked):
    locked.parent.chmod(0o555)
    deeper = locked.parent / "deeper"
    environment = {name: value for name, value in os.environ.items() if name != "ORBITDB_DB"}
    environment["XDG_DATA_HOME"] = str(deeper)
    fails(run("fill", "--p", "3", env=environment, preexec_fn=drop_rights), "/orbitdb cannot be created")
    locked.parent.chmod(0o755)
    assert run("fill", "--p", "3", env=environment).returncode == 0
    assert (deeper / "orbitdb" / "orbits.db").exists()


def test_a_write_protected_folder_is_reported(locked):
    locked.parent.chmod(0o555)
    fails(
        run("fill", "--p", "3", "--db", locked.parent / "new.db", preexec_fn=drop_rights),
        "permissions, and those of its folder",
    )
    data = locked.parent / "data"
    fails(run("export", data, "--dataset", "--db", locked, preexec_fn=drop_rights), "cannot be written")
