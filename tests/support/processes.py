"""Run orbitdb as users do, in separate processes, which can be stopped, killed or kept waiting."""

import contextlib
import io
import json
import os
import random
import signal
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

Done = subprocess.CompletedProcess[str]
Going = subprocess.Popen[str]
COMMAND = [sys.executable, "-P", "-c", "from orbitdb.cli.main import run; run()"]

_SMALL = """
import sys
from orbitdb.filling import fill
from orbitdb.cli.main import run
from orbitdb.store import sqlite
sqlite.BUSY_TIMEOUT = 60.0  # seconds; with three fills on a busy machine, some wait longer than 5
for name in fill.METHODS:
    fill.METHODS[name] = fill.Method(fill.METHODS[name].solve, {words})
print("ready", flush=True)
run()
"""


def small_blocks(words: int = 64) -> list[str]:
    """Return a command with blocks of `words` words, which prints ``ready`` after its imports."""
    return [sys.executable, "-P", "-c", _SMALL.format(words=words)]


_PAUSING = """
import os, signal
from orbitdb.cli.main import run
from orbitdb.filling import fill, sweeps
from orbitdb.store.writer import Writer
for name in fill.METHODS:
    fill.METHODS[name] = fill.Method(fill.METHODS[name].solve, 64)
fill.BIRTHS_BLOCK, sweeps.CLASSES, sweeps.SMALL = 64, 64, 1
plain, begun = Writer.transaction, 0
def transaction(self):
    global begun
    begun += 1
    if begun == {before}:
        os.kill(os.getpid(), signal.SIGSTOP)
    return plain(self)
Writer.transaction = transaction
run()
"""


def pausing(before: int) -> list[str]:
    """Return a command with small blocks that stops itself before one of its transactions, counted from 1.

    The first ones store the cursors, and each further one a block or the end of a period.
    """
    return [sys.executable, "-P", "-c", _PAUSING.format(before=before)]


def wait_until_paused(process: Going) -> None:
    """Wait until a command started with `pausing` has stopped itself; `go_on` continues it."""
    found = os.waitid(os.P_PID, process.pid, os.WSTOPPED | os.WEXITED | os.WNOWAIT)
    assert found is not None
    assert found.si_code == os.CLD_STOPPED, process.communicate()


def go_on(process: Going) -> tuple[int, str]:
    """Continue a paused command; return its exit code and stderr."""
    os.kill(process.pid, signal.SIGCONT)
    _, err = process.communicate(timeout=200)
    return process.returncode, err


def run(*arguments: str | Path, command: Sequence[str] = COMMAND, **options: Any) -> Done:
    """Run a command until it ends."""
    return subprocess.run(
        [*command, *map(str, arguments)], capture_output=True, text=True, check=False, timeout=300, **options
    )


def start(*arguments: str | Path, command: Sequence[str] = COMMAND, **options: Any) -> Going:
    """Start a command in its own process group, as a shell does."""
    return subprocess.Popen(
        [*command, *map(str, arguments)],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        **options,
    )


def wait_until_ready(process: Going) -> None:
    """Wait for the first line of a command started with `small_blocks`."""
    assert process.stdout is not None
    assert process.stdout.readline() == "ready\n"


def alive(session: int) -> list[int]:
    """Return the running processes of a session: a command that was started here, and its workers."""
    listed = subprocess.run(["ps", "-eo", "pid=,sess=,stat="], capture_output=True, text=True, check=True)
    members = [line.split() for line in listed.stdout.splitlines()]
    return [int(pid) for pid, of, state in members if int(of) == session and not state.startswith("Z")]


def nobody_left(process: Going) -> bool:
    """Tell whether all processes of a command end soon after it."""
    deadline = time.monotonic() + 30
    while alive(process.pid) and time.monotonic() < deadline:
        time.sleep(0.02)
    return not alive(process.pid)


def workers_of(process: int) -> list[int]:
    """Return the worker processes of a process."""
    command = ["ps", "-o", "pid=", "--ppid", str(process)]
    listed = subprocess.run(command, capture_output=True, text=True, check=False).stdout
    found = []
    for pid in map(int, listed.split()):
        with contextlib.suppress(OSError):  # may have ended
            if "filling.workers" in Path(f"/proc/{pid}/cmdline").read_text():
                found.append(pid)
    return found


def kill_group(process: Going) -> None:
    """Kill a command and all its processes at once, like a crashing machine."""
    for pid in alive(process.pid):
        with contextlib.suppress(ProcessLookupError):  # a worker ends with its command
            os.kill(pid, signal.SIGKILL)
    process.communicate()


def seeded(seed: int) -> random.Random:
    """Return a random generator; the seed is printed, so that it is shown if the test fails."""
    print(f"seed {seed}")
    return random.Random(seed)


_SEVERAL = f"""
import json, sys
sys.path.insert(0, {str(Path(__file__).parent)!r})
from pathlib import Path
from processes import run_here
for each in run_here(json.loads(sys.argv[1]), Path(sys.argv[2])):
    print(json.dumps(each))
"""


def run_here(commands: Sequence[Sequence[str]], path: Path) -> Iterator[tuple[list[str], int, str]]:
    """Run commands in turn; yield each with its exit code and stderr."""
    from orbitdb.cli.main import execute

    for arguments in commands:
        out, err = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            code = execute([*arguments, "--db", str(path)])
        yield [*arguments], code, err.getvalue()


def run_several(
    commands: Sequence[Sequence[str]], path: Path, **options: Any
) -> list[tuple[list[str], int, str]]:
    """Run commands in turn in one process; return each with its exit code and stderr."""
    asked = json.dumps([list(arguments) for arguments in commands])
    done = run(asked, path, command=[sys.executable, "-P", "-c", _SEVERAL], **options)
    assert done.returncode == 0, done.stderr
    return [tuple(json.loads(line)) for line in done.stdout.splitlines()]


def commands() -> list[str]:
    """Return the names of all commands."""
    from orbitdb.cli.app import program

    known = [command for command in program().registered_commands if not command.hidden]
    return [command.name or str(getattr(command.callback, "__name__", "")) for command in known]
