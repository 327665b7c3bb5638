"""What a killed export leaves beside its file is cleared by the next one; other files are left alone."""

import os
import signal
import sys
from pathlib import Path

import pytest
from processes import Going, kill_group, start

pytestmark = [pytest.mark.slow, pytest.mark.skipif(sys.platform == "win32", reason="needs POSIX signals")]

_STOPPED = """
import os, signal
from pathlib import Path
from orbitdb import output_files
from orbitdb.cli.main import run
plain = os.{step}
def stopping(*names, **options):
    if os.{step} is stopping and any(str(name).endswith("{ending}") for name in names):
        os.{step} = plain
        os.kill(os.getpid(), signal.SIGSTOP)
    return plain(*names, **options)
os.{step} = stopping
run()
"""

DATASET = ("export", "data", "--dataset", "--force", "--p", "2-4")
ROWS = ("export", "rows.csv", "--force", "--p", "2-4")


def stopped(folder: Path, catalogue: Path, arguments: tuple[str, ...], step: str, ending: str) -> Going:
    """Return an export that waits before one step with a file or folder whose name has the given ending."""
    program = [sys.executable, "-P", "-c", _STOPPED.format(step=step, ending=ending)]
    process = start(*arguments, "--db", catalogue, command=program, cwd=folder)
    found = os.waitid(os.P_PID, process.pid, os.WSTOPPED | os.WEXITED | os.WNOWAIT)
    assert found is not None
    assert found.si_code == os.CLD_STOPPED, process.communicate()
    return process


def names(folder: Path) -> list[str]:
    return sorted(each.name for each in folder.iterdir())


def contents(folder: Path) -> dict[str, bytes]:
    """Return the files of a dataset, without those that name its date."""
    return {each.name: each.read_bytes() for each in folder.iterdir() if each.suffix in (".parquet", ".csv")}


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder, where all exports write."""
    own = tmp_path / "here"
    own.mkdir()
    monkeypatch.chdir(own)
    return own


@pytest.mark.parametrize(
    ("arguments", "step", "ending", "kept"),
    [
        (ROWS, "replace", ".part", ["rows.csv", "rows.csv-metadata.json"]),
        (DATASET, "rename", ".part", ["data"]),
        (DATASET, "rename", ".old", ["data"]),
        (DATASET, "rmdir", ".old", ["data"]),
    ],
)
@pytest.mark.parametrize("name", ["SIGKILL", "SIGTERM"])
def test_the_next_export_clears_what_a_killed_one_left(
    cli, varied, folder, arguments, step, ending, kept, name
):
    others = [".rows.csv.note.part", ".data.1x.old", f".rows.csv.{os.getppid()}.part"]
    for other in others:
        (folder / other).write_text("another's")
    assert cli(*arguments, "--db", str(varied)).code == 0
    process = stopped(folder, varied, arguments, step, ending)
    if name == "SIGKILL":
        kill_group(process)
        assert len(names(folder)) > len(others) + len(kept)
        assert cli(*arguments, "--db", str(varied)).code == 0
    else:
        process.send_signal(signal.SIGTERM)
        process.send_signal(signal.SIGCONT)
        process.communicate(timeout=60)
        assert process.returncode == 143
    assert names(folder) == sorted([*others, *kept])


def test_one_whole_dataset_is_there_after_any_kill(cli, varied, folder):
    """Between the two renames, the older one still has its other name, which the next export gives back."""
    assert cli(*DATASET, "--db", str(varied)).code == 0
    before = contents(folder / "data")
    for step, ending in (("rename", ".old"), ("rename", ".part"), ("mkdir", ".part")):
        kill_group(stopped(folder, varied, DATASET, step, ending))
        whole = [each for each in folder.iterdir() if contents(each) == before]
        assert whole
    assert contents(folder / "data") == before
