"""The folder between processes: gone with them, even if they are killed."""

import os
import sys
import tempfile
from pathlib import Path

import pytest
from processes import COMMAND, kill_group, run, start

from orbitdb.filling.scratch import scratch_folder

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="folders cannot be locked")

PARCEL = "0" * 32
_HOLD = """
import sys
from orbitdb.filling.scratch import scratch_folder
with scratch_folder() as folder:
    (folder / sys.argv[1]).touch()
    print(folder, flush=True)
    sys.stdout.flush()
    import time
    time.sleep(100)
"""


@pytest.fixture
def temporary(tmp_path, monkeypatch) -> Path:
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.setattr(tempfile, "tempdir", None)
    return tmp_path


def test_it_is_gone_afterwards(temporary):
    with scratch_folder() as folder:
        (folder / PARCEL).touch()
        with scratch_folder() as other:
            assert folder.exists()
            assert other.parent == folder.parent == temporary
    assert not list(temporary.iterdir())


@pytest.mark.timeout(60)
def test_what_a_killed_process_left_is_cleared_and_nothing_else(temporary):
    held, killed = (start(PARCEL, command=[*COMMAND[:-1], _HOLD]) for _ in range(2))
    folders = [Path(process.stdout.readline().strip()) for process in (held, killed)]
    kill_group(killed)
    mine = [temporary / "orbitdb-parcels-mine", temporary / "orbitdb-results", temporary / "other"]
    for folder in mine:
        folder.mkdir()
        (folder / "kept.txt").touch()
    (temporary / "orbitdb-parcels-link").symlink_to(temporary / "other")
    os.mkfifo(temporary / "orbitdb-parcels-pipe")  # who opens it waits for ever
    assert all(folder.exists() for folder in folders)
    with scratch_folder():
        assert [folder.exists() for folder in folders] == [True, False]
    assert all((folder / "kept.txt").exists() for folder in mine)
    kill_group(held)


@pytest.mark.slow
def test_the_next_fill_clears_up(temporary):
    arguments = ("fill", "--jobs", "2", "--db")
    process = start(*arguments, temporary / "orbits.db", "--p", "13")
    while not list(temporary.glob("orbitdb-parcels-*/*")):
        assert process.poll() is None
    kill_group(process)
    assert list(temporary.glob("orbitdb-parcels-*/*"))
    assert run(*arguments, temporary / "other.db", "--p", "11").returncode == 0
    assert not list(temporary.glob("orbitdb-parcels-*"))
