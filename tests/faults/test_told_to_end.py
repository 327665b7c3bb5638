"""SIGTERM and SIGHUP at any moment give at most one line, and leave no process or file behind."""

import os
import shutil
import signal
import subprocess
import sys
from itertools import product
from pathlib import Path

import pytest
from processes import COMMAND, alive, kill_group, nobody_left, run, seeded, start
from quick import fuzz_but
from there import there

pytestmark = [pytest.mark.slow, pytest.mark.skipif(sys.platform == "win32", reason="needs POSIX signals")]

AT_WORK = "at work"
COMMANDS = {
    "verify": ("verify", "--jobs", "2", "--restarts", "500", "--db", AT_WORK),
    "verify-rigorous": ("verify", "--prove", "--db", AT_WORK),
    "verify-births": ("verify", "--births", "--restarts", "500", "--jobs", "2", "--db", AT_WORK),
    "verify-restarts": ("verify", "--restarts", "500", "--db", AT_WORK),
    "export": ("export", "rows.parquet", "-c", "+coordinates", "--status", "all", "--db", AT_WORK),
    "fill": ("fill", "--p", "15", "--jobs", "2", "--db", "new.db"),
    "sweep": ("sweep", "--p", "17", "--jobs", "2", "--db", "new.db"),
    "births": ("births", "--p", "13", "--jobs", "2", "--db", "new.db"),
    "bounds": ("bounds", "--a", "0.5", "--edges", "30", "--seconds", "999", "--db", "new.db"),
    "bounds-over-a": (
        "bounds",
        "--a",
        "0.3:3:200",
        "--edges",
        "14",
        "--seconds",
        "999",
        "--jobs",
        "2",
        "--db",
        "new.db",
    ),
    "simulate": ("simulate", "--bounces", "1000000000", "--no-store"),
    "bench": ("bench", "--p", "12"),
    "plot": ("plot", "births", "-o", "picture.pdf", "--db", AT_WORK),
}


class Started:
    """A running command with its own working folder and temporary folder."""

    def __init__(self, folder: Path, arguments: tuple[str, ...], catalogue: Path) -> None:
        self.folder, self.temporary = folder / "here", folder / "temporary"
        self.catalogue = catalogue
        self.folder.mkdir()
        self.temporary.mkdir()
        asked = (catalogue if each == AT_WORK else each for each in arguments)
        self.process = start(*asked, cwd=self.folder, env={**os.environ, "TMPDIR": str(self.temporary)})

    def told(self, name: str, group: bool = False) -> list[str]:
        """Signal the command, alone or, as a closed terminal does, with its group; return its output.

        No process and no file may be left afterwards.
        """
        assert self.process.poll() is None
        (os.killpg if group else os.kill)(self.process.pid, signal.Signals[name])
        self.process.wait(60)
        left = alive(self.process.pid)
        _, err = self.process.communicate(timeout=60)
        assert nobody_left(self.process)
        assert not [pid for pid in left if pid in alive(self.process.pid)]
        assert list(self.temporary.iterdir()) == []
        files = [each.name for each in self.folder.iterdir()]
        self.written = files in (["picture.pdf"], ["rows.parquet"])  # it was ending by itself
        assert files in ([], ["new.db"]) or self.written  # and no journal
        assert [each.name for each in self.catalogue.parent.iterdir()] == [self.catalogue.name]
        announced = ("to solve, about", "times are in seconds")
        return [line for line in err.splitlines() if not any(words in line for words in announced)]


@pytest.fixture
def stored(made_once, tmp_path):
    """A catalogue of this test alone, because the journals of others would be beside it."""

    def make(path):
        for arguments in (("fill", "--p", "8", "--geometric"), ("births", "--p", "8")):
            assert run(*arguments, "--db", path).returncode == 0

    folder = tmp_path / "stored"
    folder.mkdir()
    return Path(shutil.copy(made_once("told", make), folder))


def at_a_moment(folder, arguments, catalogue, moment):
    """Return a command that has run for `moment` seconds, or for half as long if it ends before that."""
    while True:
        own = folder / f"{moment}"
        own.mkdir()
        started = Started(own, arguments, catalogue)
        try:
            started.process.wait(moment)
        except subprocess.TimeoutExpired:
            return started
        assert started.process.returncode == 0
        started.process.communicate()
        moment /= 2


@pytest.mark.parametrize(
    ("name", "turn"),
    fuzz_but([(name, at % 4) for at, name in enumerate(COMMANDS)], list(product(COMMANDS, range(8)))),
)
def test_signals_end_a_command_cleanly_at_any_moment(stored, tmp_path, name, turn):
    signalled, group = ("SIGTERM", "SIGHUP")[turn % 2], turn % 4 > 1
    started = at_a_moment(tmp_path, COMMANDS[name], stored, seeded(turn).uniform(0.0, 1.5))
    try:
        said = started.told(signalled, group)
    finally:
        if started.process.poll() is None:
            kill_group(started.process)
    number = signal.Signals[signalled]
    if started.written:
        assert started.process.returncode in (0, 128 + number)
        return
    if started.process.returncode == -number:  # before the handler was installed
        assert said == []
        return
    if name == "plot" and started.process.returncode == -signal.SIGABRT:
        pytest.xfail(f"seen once, and never explained: plot aborted, and said {said}")
    assert started.process.returncode == 128 + number, said
    assert [line.partition(";")[0] for line in said] == ["orbitdb: terminated"]


_IN_A_CALLBACK = """
import sys, time
class Waiting:
    def __del__(self):
        print("in a callback", flush=True)
        time.sleep(60)
class Finder:
    def find_spec(self, name, *rest):
        if name == "orbitdb.catalogue":
            Waiting()
sys.meta_path.insert(0, Finder())
from orbitdb.cli.main import run
run()
"""


@pytest.mark.parametrize(("name", "word"), [("SIGINT", "interrupted"), ("SIGTERM", "terminated")])
def test_a_signal_that_arrives_in_a_callback_is_not_lost(name, word):
    process = start("bounds", "--seconds", "60", command=[sys.executable, "-P", "-c", _IN_A_CALLBACK])
    assert there(process.stdout).readline() == "in a callback\n"
    process.send_signal(signal.Signals[name])
    _, err = process.communicate(timeout=50)
    assert (process.returncode, err) == (128 + signal.Signals[name], f"orbitdb: {word}\n")


def test_no_partial_file_stays(stored, tmp_path):
    started = Started(tmp_path, COMMANDS["export"], stored)
    while not list(started.folder.glob(".*.part")):
        assert started.process.poll() is None
    assert started.told("SIGTERM") == ["orbitdb: terminated"]
    assert started.process.returncode == 143


def test_an_ignored_hangup_stays_ignored(tmp_path):
    """This is how nohup runs a command."""
    ignoring = ["sh", "-c", 'trap "" HUP; exec "$@"', "sh", *COMMAND]
    started = start("fill", "--p", "15", "--db", tmp_path / "new.db", command=ignoring)
    assert there(started.stderr).readline()  # the announcement of its work
    started.send_signal(signal.SIGHUP)
    with pytest.raises(subprocess.TimeoutExpired):
        started.wait(0.5)
    started.send_signal(signal.SIGTERM)
    assert started.wait(60) == 143
    started.communicate()
