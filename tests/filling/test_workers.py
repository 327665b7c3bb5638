"""Any number of processes makes the same catalogue, and all processes end after use."""

import os
import signal
import sys
import threading
import time
from dataclasses import replace
from functools import partial
from typing import Any, Self

import pytest
from contents import rows
from processes import run, workers_of
from quick import slow_but
from workforce import Deadly, Failing, filled_by, killed_while_sending, later

from orbitdb.billiard.arithmetic import arithmetic
from orbitdb.billiard.stadium import Stadium
from orbitdb.catalogue import Catalogue
from orbitdb.entropy_bounds.bounds import BALLS, DOUBLES, enclose, search
from orbitdb.errors import InputError, WorkError
from orbitdb.filling.fill import METHODS, cut_into_blocks, fill_periods, solve_block
from orbitdb.filling.sweeps import solve_swept
from orbitdb.filling.workers import HERE, Processes, Task, Workers, cores
from orbitdb.orbits.births import find_changes
from orbitdb.store.file import migrate
from orbitdb.symbols.enumeration import Span
from orbitdb.symbols.pruning import count_admissible

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="needs POSIX signals")


@pytest.mark.usefixtures("small_blocks")
@pytest.mark.parametrize(
    ("jobs", "periods"), [(2, (5,)), pytest.param(3, (7, 8), marks=pytest.mark.slow)], ids=["2", "3"]
)
def test_rows_do_not_depend_on_the_number_of_processes(tmp_path, jobs, periods):
    alone = filled_by(HERE, tmp_path / "alone.db", periods=periods)
    with Processes(jobs) as workers:
        shared = filled_by(workers, tmp_path / "shared.db", periods=periods)
        assert rows(shared) == rows(alone)
        assert workers.jobs == jobs
        filled_by(workers, shared, a=1.0, periods=periods)  # from the classes already stored
    assert not workers_of(os.getpid())
    assert rows(shared) == rows(filled_by(HERE, alone, a=1.0, periods=periods))


class Counted:
    """An iterator of blocks that counts those taken from it."""

    def __init__(self, blocks: list[Task[int]]) -> None:
        self.left, self.taken = iter(blocks), 0

    def __iter__(self) -> Self:
        return self

    def __next__(self) -> Task[int]:
        self.taken += 1
        return next(self.left)


@pytest.mark.slow
def test_results_come_in_order_and_few_blocks_run_ahead():
    slow: list[Task[int]] = [partial(later, 0.02 * (n % 3), n) for n in range(20)]
    with Processes(2) as workers:
        blocks = Counted(slow)
        for number, answer in enumerate(workers.solved(blocks)):
            assert answer == number
            assert blocks.taken <= number + 6  # five in progress, and one that may be the end
        given_up = workers.solved(iter(slow))
        assert next(given_up) == 0
        assert list(workers.solved(slow[:4])) == [0, 1, 2, 3]  # not those of the work given up


def test_results_come_in_order_while_workers_come_and_go(monkeypatch):
    sizes = iter([4, 2, 0, 0, 7])
    monkeypatch.setattr(Workers, "_ahead", lambda self: next(sizes, 1))
    assert list(Workers().solved(partial(int, n) for n in range(20))) == [*range(20)]


def test_a_dead_worker_ends_the_work_with_one_line():
    blocks: list[Task[None]] = [Deadly(), *[partial(time.sleep, 60)] * 9]
    with (
        Processes(2) as workers,
        pytest.raises(WorkError, match=r"a worker process died; .* continues") as raised,
    ):
        list(workers.solved(blocks))
    assert "\n" not in str(raised.value)
    assert not workers_of(os.getpid())


@pytest.mark.parametrize("part", slow_but([0.5], [0, 1e-5, 0.5, 0.999999]))
def test_a_worker_killed_while_it_sends_a_result_ends_the_work(part):
    with Processes(2) as workers:
        blocks: list[Task[Any]] = [partial(int, 5), partial(killed_while_sending, part)]
        going = workers.solved(blocks)
        assert next(going) == 5
        with pytest.raises(WorkError, match="a worker process died"):
            next(going)
        with pytest.raises(WorkError, match="a worker process died"):
            list(workers.solved([partial(int, 5)] * 3))


def test_what_a_block_prints_does_not_reach_the_result(capfd):
    with Processes(1) as workers:
        blocks: list[Task[Any]] = [partial(print, "printed"), partial(int, 7)]
        assert list(workers.solved(blocks)) == [None, 7]
    assert capfd.readouterr() == ("", "printed\n")


def test_a_result_that_cannot_be_sent_is_an_error_of_its_block_alone():
    with Processes(1) as workers:
        with pytest.raises(TypeError, match="cannot pickle"):
            list(workers.solved([threading.Lock]))
        assert list(workers.solved([partial(int, 7)])) == [7]


@pytest.mark.parametrize("program", ["/nowhere/python", "/bin/false"])
def test_processes_that_cannot_start_are_reported_in_one_line(monkeypatch, program):
    monkeypatch.setattr(sys, "executable", program)
    with pytest.raises(WorkError, match=r"a worker process (cannot start \(No such file|died)") as raised:  # noqa: SIM117
        with Processes(2) as workers:
            list(workers.solved([partial(int, 3)]))
    assert "\n" not in str(raised.value)


def test_a_file_in_the_working_folder_does_not_replace_a_module(tmp_path, monkeypatch):
    (tmp_path / "pickle.py").write_text("raise SystemExit('the wrong module')")
    monkeypatch.chdir(tmp_path)
    with Processes(1) as workers:
        assert list(workers.solved([partial(int, 7)])) == [7]


@pytest.mark.slow
@pytest.mark.usefixtures("small_blocks")
def test_a_worker_killed_between_blocks_ends_the_work_and_the_same_fill_goes_on(tmp_path):
    path = tmp_path / "shared.db"
    migrate(path)
    with Processes(2) as workers:
        steps = fill_periods(path, 1.6, (8,), workers=workers)
        next(steps)
        os.kill(workers_of(os.getpid())[0], signal.SIGKILL)
        with pytest.raises(WorkError, match="a worker process died"):
            list(steps)
    assert rows(filled_by(HERE, path, periods=(8,))) == rows(filled_by(HERE, tmp_path / "a.db", periods=(8,)))


@pytest.mark.slow
def test_a_script_without_a_guard_or_a_file_can_use_processes():
    """Workers do not run the script that started them."""
    script = """
from functools import partial
from typing import Any
from orbitdb.filling.workers import Processes
with Processes(2) as workers:
    print(list(workers.solved([partial(int, 3), partial(int, 4)])))
"""
    for arguments in (["-c", script], ["-"]):
        done = run(*arguments, command=[sys.executable], input=script)
        assert (done.stdout, done.stderr) == ("[3, 4]\n", "")


def test_only_processors_this_process_may_use_are_counted(monkeypatch):
    monkeypatch.setattr(os, "sched_getaffinity", {0: {5, 7, 11}}.get, raising=False)
    assert cores() == 3
    monkeypatch.delattr(os, "sched_getaffinity")
    assert cores() == os.cpu_count()


@pytest.mark.parametrize("jobs", [0, -1])
def test_a_number_of_jobs_below_1_is_refused(tmp_path, jobs):
    with pytest.raises(InputError, match=f"jobs = {jobs}: give a whole number, 1 or more"):
        Catalogue.create(tmp_path / "orbits.db").fill("2-3", jobs=jobs)


def test_an_error_before_the_first_block_is_raised_unchanged():
    before, workers = threading.enumerate(), Processes(2)
    with pytest.raises(KeyError), workers:
        raise KeyError
    assert {*threading.enumerate()} <= {*before}


@pytest.mark.slow
def test_an_error_in_a_block_is_raised_with_the_traceback_of_the_worker():
    with Processes(2) as workers:
        for _ in range(3):
            with pytest.raises(ZeroDivisionError, match="by nothing") as raised:
                list(workers.solved([Failing()]))
            assert "in __call__" in raised.value.__notes__[0]
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
        next(cut_into_blocks(1.6, "newton", 3)),
        partial(solve_block, find_changes, False, Span.of_period(3)),
        partial(solve_swept, 1.6, Span.of_period(3)),
        partial(enclose, 1.6, 3),
    ],
    ids=lambda block: block.func.__name__,
)
def test_results_of_tasks_name_their_arithmetic(block):
    assert block().arithmetic == arithmetic()


@pytest.mark.parametrize("prove", [False, True])
def test_a_task_encloses_the_entropy_like_a_search(prove):
    enclosed = enclose(1.6, 4, prove=prove)
    arithmetic = BALLS if prove else DOUBLES
    assert enclosed.levels == tuple(replace(one, arithmetic=arithmetic) for one in search(Stadium(1.6), 4))
    assert (enclosed.levels[-1].proved > 0, enclosed.levels[-1].left_open) == (prove, 0)
    assert len(enclose(1.6, width=0.5, prove=prove).levels) < len(enclosed.levels)
