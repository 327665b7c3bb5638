"""After kills and signals, stored rows survive, nothing is half-done, and the same command resumes."""

import os
import signal
import sys
import time
from pathlib import Path

import pytest
from contents import agrees, content, is_sound
from processes import kill_group, nobody_left, run, seeded, small_blocks, start, wait_until_ready, workers_of
from quick import fuzz_but

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="needs POSIX signals")

GOES_ON = "nothing that was stored is lost, and the same command continues from there"
UNWATCHED = "words to solve"


def killed_and_resumed(path: Path, jobs: list[str], kills: int, longest: float) -> None:
    """Kill a fill at random moments, check the file each time, then let the fill finish."""
    moments = seeded(20260720)
    for turn in range(kills):
        count = jobs[turn % len(jobs)]
        process = start("fill", "--p", "8", "--jobs", count, "--db", path, command=small_blocks(8))
        wait_until_ready(process)
        time.sleep(moments.uniform(0.0, longest * int(count)))
        kill_group(process)
        if path.exists() and path.stat().st_size:
            assert is_sound(path)
            agrees(path)
    done = run("fill", "--p", "8", "--db", path)
    assert done.returncode == 0, done.stderr


@pytest.mark.slow
def test_a_fill_killed_four_times_loses_nothing(filled, tmp_path):
    path = tmp_path / "killed.db"
    killed_and_resumed(path, ["1", "2"], 4, 0.4)
    assert content(path) == content(filled)
    assert run("verify", "--db", path).returncode == 0


def stop(process, name: str, group: bool) -> str:
    """Send a signal to the process or to its whole group, as a terminal does; return its stderr."""
    (os.killpg if group else os.kill)(process.pid, signal.Signals[name])
    _, err = process.communicate(timeout=60)
    return err


@pytest.mark.slow
@pytest.mark.parametrize("turn", fuzz_but([0, 1, 2], range(4)))
def test_ctrl_c_ends_a_fill_at_any_moment(tmp_path, turn):
    """Ctrl-C, once or twice, while processes start, work or end, gives one line and leaves no process."""
    moments, path = seeded(turn), tmp_path / "orbits.db"
    jobs = str(1 + turn // 2 % 2)
    process = start("fill", "--p", "13", "--jobs", jobs, "--db", path, command=small_blocks(512))
    wait_until_ready(process)
    time.sleep(moments.uniform(0.05, 2.5))
    if turn % 2:
        os.killpg(process.pid, signal.SIGINT)
        time.sleep(moments.uniform(0.0, 0.3))
    err = stop(process, "SIGINT", group=True)
    assert process.returncode == 130
    assert [line for line in err.splitlines() if UNWATCHED not in line] == [
        f"orbitdb: interrupted; {GOES_ON}"
    ]
    assert nobody_left(process)
    assert is_sound(path)
    agrees(path)


_LATE = """
import sys, time
if "filling.workers" in " ".join(sys.orig_argv):
    time.sleep(2)
"""


@pytest.mark.slow
def test_a_starting_worker_is_silent_about_ctrl_c(tmp_path):
    (tmp_path / "sitecustomize.py").write_text(_LATE)
    where = os.pathsep.join([str(tmp_path), *filter(None, [os.environ.get("PYTHONPATH")])])
    command = ["env", f"PYTHONPATH={where}", *small_blocks(512)]
    process = start("fill", "--p", "13", "--jobs", "2", "--db", tmp_path / "orbits.db", command=command)
    wait_until_ready(process)
    while not workers_of(process.pid):
        assert process.poll() is None
    time.sleep(0.3)
    err = stop(process, "SIGINT", group=True)
    assert (process.returncode, err) == (130, f"orbitdb: interrupted; {GOES_ON}\n")
    assert nobody_left(process)


@pytest.mark.slow
def test_workers_end_with_their_parent(tmp_path):
    """They end at once, even within a block that takes minutes."""
    slowly = ["fill", "--p", "12-12", "--method", "relaxation", "--jobs", "2"]
    process = start(*slowly, "--db", tmp_path / "orbits.db", command=small_blocks(1 << 16))
    wait_until_ready(process)
    while len(workers_of(process.pid)) < 2:
        assert process.poll() is None
    time.sleep(1)
    process.kill()
    process.wait()
    assert nobody_left(process)
    process.communicate()
