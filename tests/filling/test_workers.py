"""Any number of processes makes the same catalogue, and all processes end after use."""

import os
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import Future
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from contents import rows
from processes import workers_of
from workforce import Deadly, Failing, filled_by

from orbitdb.arithmetic import arithmetic
from orbitdb.billiard.stadium import Stadium
from orbitdb.entropy.bounds import enclose, search
from orbitdb.entropy.proof import Proof
from orbitdb.errors import WorkError
from orbitdb.filling.births import solve_births
from orbitdb.filling.fill import METHODS, cut_into_blocks, solve_block
from orbitdb.filling.sweeps import solve_swept
from orbitdb.filling.workers import HERE, Processes, Task, begun_ahead, cores
from orbitdb.symbols.enumeration import Span
from orbitdb.symbols.pruning import count_admissible

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="needs POSIX signals")


def blocked_signals(process: int) -> int:
    """Return the mask of the signals that a process blocks."""
    status = Path(f"/proc/{process}/status")
    lines = status.read_text().splitlines() if status.exists() else []
    return sum(int(line.split()[1], 16) for line in lines if line.startswith("SigBlk"))


@pytest.mark.usefixtures("small_blocks")
@pytest.mark.parametrize(
    ("jobs", "periods"), [(2, (5,)), pytest.param(3, (7, 8), marks=pytest.mark.slow)], ids=["2", "3"]
)
def test_rows_do_not_depend_on_the_number_of_processes(tmp_path, jobs, periods):
    alone = filled_by(HERE, tmp_path / "alone.db", periods=periods)
    with Processes(jobs) as workers:
        shared = filled_by(workers, tmp_path / "shared.db", periods=periods)
        assert rows(shared) == rows(alone)
        assert 0 in map(blocked_signals, workers_of(os.getpid()))  # one may still be starting
        assert workers.jobs == jobs
        filled_by(workers, shared, a=1.0, periods=periods)  # from the classes already stored
    assert not workers_of(os.getpid())
    assert rows(shared) == rows(filled_by(HERE, alone, a=1.0, periods=periods))


def spans_of(blocks: list[Task[Any]]) -> list[Span]:
    return [block().span for block in blocks]


class Backwards:
    """Finishes the last block first."""

    def __init__(self) -> None:
        self.waiting: list[tuple[Task[Any], Future[Any]]] = []
        self.most = 0

    def submit(self, block: Task[Any]) -> Future[Any]:
        self.waiting.append((block, BackwardsFuture(self)))
        self.most = max(self.most, len(self.waiting))
        return self.waiting[-1][1]

    def work(self) -> None:
        while self.waiting:
            block, future = self.waiting.pop()
            future.set_result(block())


class BackwardsFuture(Future[Any]):
    def __init__(self, pool: Backwards) -> None:
        super().__init__()
        self.pool = pool

    def result(self, timeout: float | None = None):
        if not self.done():
            self.pool.work()
        return super().result(timeout)


@pytest.mark.usefixtures("small_blocks")
def test_results_come_in_order_and_few_blocks_run_ahead():
    blocks = list(cut_into_blocks(1.6, "newton", 8))
    assert len(blocks) > 8
    pool = Backwards()
    found = [each.result() for each in begun_ahead(map(pool.submit, blocks), lambda: 5)]
    assert [result.span for result in found] == spans_of(blocks)
    assert pool.most == 6


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/io").exists(), reason="needs Linux")
def test_a_worker_killed_while_answering_costs_only_its_block(tmp_path):
    """The storing process is stopped, so that the answer fills the pipe and gets stuck."""
    folder = Path(filled_by.__code__.co_filename).parent
    script = "import sys; from workforce import fill_when_let; fill_when_let(*sys.argv[1:])"
    env = os.environ | {"PYTHONPATH": str(folder)}
    path, first = tmp_path / "shared.db", tmp_path / "solved-0"
    going = subprocess.Popen([sys.executable, "-c", script, path, "12"], env=env)
    try:
        while not first.exists() or not first.read_text().endswith("\n"):
            assert going.poll() is None
            time.sleep(0.01)
        os.kill(going.pid, signal.SIGSTOP)
        victim = int(first.read_text())
        before = sent(victim)
        (tmp_path / "go").touch()
        while sent(victim) == before:
            time.sleep(0.01)
        os.kill(victim, signal.SIGKILL)
        os.kill(going.pid, signal.SIGCONT)
        assert going.wait(300) == 0
    finally:
        going.kill()
    times = [len(each.read_text().split()) for each in sorted(tmp_path.glob("solved-*"))]
    assert (times[0], {*times[1:]}) == (2, {1})
    assert rows(path) == rows(filled_by(HERE, tmp_path / "alone.db", periods=(12,)))


def sent(process: int) -> int:
    """Return the number of bytes a process has written."""
    return int(Path(f"/proc/{process}/io").read_text().partition("wchar: ")[2].split()[0])


@pytest.mark.slow
@pytest.mark.usefixtures("small_blocks")
def test_a_worker_that_dies_while_starting_costs_only_time():
    blocks = list(cut_into_blocks(1.6, "newton", 5))
    with Processes(2) as workers:
        os.kill(next_worker(), signal.SIGKILL)
        found = list(workers.solved(iter(blocks)))
    assert [result.span for result in found] == spans_of(blocks)


@pytest.mark.slow
@pytest.mark.parametrize("which", [0, 1])
def test_an_idle_worker_survives_the_death_of_another_and_ends(which):
    blocks = list(cut_into_blocks(1.6, "newton", 4))
    with Processes(2) as workers:
        assert len(list(workers.solved(iter(blocks * 4)))) == 4 * len(blocks)
        os.kill(sorted(workers_of(os.getpid()))[which], signal.SIGKILL)
        assert len(list(workers.solved(iter(blocks * 4)))) == 4 * len(blocks)
        os.kill(sorted(workers_of(os.getpid()))[which], signal.SIGKILL)
    assert not workers_of(os.getpid())


def next_worker() -> int:
    """Wait for a worker to start, and return its id."""
    while not (there := workers_of(os.getpid())):
        time.sleep(0.01)
    return there[0]


def test_only_processors_this_process_may_use_are_counted(monkeypatch):
    monkeypatch.setattr(os, "sched_getaffinity", {0: {5, 7, 11}}.get, raising=False)
    assert cores() == 3
    monkeypatch.delattr(os, "sched_getaffinity")
    assert cores() == os.cpu_count()


def test_an_error_before_the_first_block_is_raised_unchanged():
    before, workers = threading.enumerate(), Processes(2)
    with pytest.raises(KeyError), workers:
        raise KeyError
    assert {*threading.enumerate()} <= {*before}


@pytest.mark.slow
def test_a_block_that_kills_every_worker_is_given_up():
    with Processes(1) as workers, pytest.raises(WorkError, match="died 3 times"):
        list(workers.solved(iter([Deadly()])))
    assert not workers_of(os.getpid())


@pytest.mark.slow
def test_a_worker_of_another_version_is_refused(monkeypatch):
    monkeypatch.setattr("orbitdb.filling.workers.__version__", "9.9")
    blocks = cut_into_blocks(1.6, "newton", 5)
    with Processes(1) as workers, pytest.raises(WorkError, match=r"install 9\.9 there"):
        list(workers.solved(blocks))


@pytest.mark.slow
def test_an_error_in_a_block_is_raised_with_its_remote_traceback():
    with Processes(2) as workers:
        for _ in range(3):
            with pytest.raises(ZeroDivisionError, match="by nothing") as told:
                list(workers.solved([Failing()]))
            assert "in __call__" in "".join(told.value.__notes__)
        assert len(list(workers.solved(cut_into_blocks(1.6, "newton", 4)))) > 0
        blocks: list[Task[None]] = [Failing(), *[partial(time.sleep, 20)] * 9]
        with pytest.raises(ZeroDivisionError):
            list(workers.solved(blocks))
    assert not workers_of(os.getpid())  # blocks still running are not waited for


def test_several_jobs_get_smaller_blocks_down_to_a_quarter():
    counts = {jobs: len(list(cut_into_blocks(1.6, "newton", 12, -1, jobs))) for jobs in (1, 2, 3, 8, 99)}
    assert counts[1] < counts[2] < counts[3] < counts[8] == counts[99] < 5 * counts[1]
    assert count_admissible(12) / counts[1] < 1.5 * METHODS["newton"].words
    behind = next(cut_into_blocks(1.6, "newton", 9, 10**8, 8))().span
    assert behind.after == 10**8


@pytest.mark.parametrize(
    "block",
    [
        partial(solve_block, 1.6, "newton", False, Span.whole(3)),
        partial(solve_births, Span.whole(3)),
        partial(solve_swept, 1.6, "", {}, Span.whole(3)),
        partial(enclose, 1.6, 3),
    ],
    ids=lambda block: block.func.__name__,
)
def test_results_of_tasks_name_their_arithmetic(block):
    assert block().arithmetic == arithmetic()


@pytest.mark.parametrize("prove", [False, True])
def test_a_task_encloses_the_entropy_like_a_search(prove):
    found = enclose(1.6, 4, proof=Proof() if prove else None)
    assert found.levels == tuple(search(Stadium(1.6), 4))
    if found.proof is not None:
        assert found.proof.proved > 0 < found.proof.seconds
        assert found.proof.left_open == 0
    assert (found.proof is not None) == prove
    assert len(enclose(1.6, width=0.5, proof=found.proof).levels) < len(found.levels)
