"""Solve blocks in this process or in several processes at once (`orbitdb.filling.cluster`: on a cluster).

Results come in the order of the blocks. The number of blocks in progress is limited, to limit the memory.
"""

import os
import pickle
import signal
import sys
import traceback
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager, suppress
from itertools import islice
from queue import SimpleQueue
from subprocess import PIPE, Popen
from threading import Thread
from typing import IO, Any, NoReturn, Self, TypeAlias, TypeVar

from orbitdb.errors import InputError, WorkError, check_int

Answer = TypeVar("Answer")

AHEAD = 2
"""Number of blocks in progress per worker, so that no worker waits for the writer."""

_WORTH_PROCESSES = 1.0
"""Work of at least this many seconds is worth starting more processes."""
_STARTING = 0.1
"""Approximate time in seconds to start processes."""

_SIGNALS = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)]


Task: TypeAlias = Callable[[], Answer]
"""A function that solves a block, and that can be pickled and sent to another process."""


class Workers:
    """Solves blocks one after another in this process.

    Attributes
    ----------
    jobs : int
        Number of blocks solved at once.
    """

    jobs = 1

    def solved(self, blocks: Iterable[Task[Answer]]) -> Iterator[Answer]:
        """Yield the results of the blocks in order.

        Raises
        ------
        WorkError
            If processes die, the connection to a cluster is lost, or a cluster cannot solve a block.
        """
        left, begun = iter(blocks), deque[Any]()
        while True:
            more = max(0, self._ahead() + 1 - len(begun))
            begun.extend(map(self._begin, islice(left, more)))
            if not begun:
                return
            yield self._result(begun.popleft())

    def _ahead(self) -> int:
        """Return how many blocks besides the next result's may be in progress; this may change."""
        return 0

    def _begin(self, block: Task[Any]) -> Any:
        """Begin to solve a block, and return what `_result` needs to know."""
        return block

    def _result(self, begun: Any) -> Any:
        return begun()


HERE = Workers()


class Processes(Workers):
    """Context manager that solves blocks in processes that it starts, and ends at once after use.

    Blocks and results travel as pickles through the pipes of each process. One thread a process waits for
    its results, so that a process that dies is noticed even if it has sent half a result.

    Parameters
    ----------
    jobs : int
        Number of processes.
    """

    def __init__(self, jobs: int) -> None:
        self.jobs = jobs
        self._started: list[Popen[bytes]] = []
        self._idle: SimpleQueue[Popen[bytes]] = SimpleQueue()

    def __enter__(self) -> Self:
        """Start the processes.

        Raises
        ------
        WorkError
            If the system does not allow that many processes.
        """
        self._threads = ThreadPoolExecutor(self.jobs)
        try:
            for _ in range(self.jobs):
                self._started.append(_start())
                self._idle.put(self._started[-1])
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *error: object) -> None:
        """End all processes without waiting for blocks in progress."""
        self._threads.shutdown(wait=False, cancel_futures=True)
        for process in self._started:
            with suppress(OSError):  # it has died
                _pipes(process)[0].close()
        self._threads.shutdown()
        for process in self._started:
            _pipes(process)[1].close()
            process.wait()

    def _ahead(self) -> int:
        return AHEAD * self.jobs

    def _begin(self, block: Task[Any]) -> Future[Any]:
        return self._threads.submit(self._solve, block)

    def _result(self, begun: Future[Any]) -> Any:
        return begun.result()

    def _solve(self, block: Task[Any]) -> Any:
        """Let an idle process solve a block; return the result, or raise the error that the block raised."""
        task, process = pickle.dumps(block), self._idle.get()
        try:
            tasks, results = _pipes(process)
            pickle.dump(task, tasks)
            tasks.flush()
            solved, result = pickle.load(results)
        except (EOFError, pickle.UnpicklingError, OSError):
            raise WorkError(
                "a worker process died; nothing stored is lost, and the same command continues from there: "
                "if memory is short, use fewer processes, such as `jobs=2`"
            ) from None
        finally:
            self._idle.put(process)
        if not solved:
            raise result
        return result


_WORKER = "import sys; sys.path[:] = sys.argv[1:]; from orbitdb.filling.workers import work; work()"
"""Program of a worker process; its arguments are the folders that this process imports from."""


def _start() -> Popen[bytes]:
    """Start a process that runs `work`, in a group of its own, which Ctrl-C in a terminal does not reach."""
    command = [sys.executable, "-P", "-c", _WORKER, *map(str, sys.path)]
    try:
        return Popen(command, stdin=PIPE, stdout=PIPE, process_group=0)
    except OSError as error:
        raise WorkError(
            f"a worker process cannot start ({error.strerror}): use fewer processes, such as `jobs=2`"
        ) from error


def _pipes(process: Popen[bytes]) -> tuple[IO[bytes], IO[bytes]]:
    """Return the pipes that lead to a worker process and back."""
    assert process.stdin is not None
    assert process.stdout is not None
    return process.stdin, process.stdout


def work() -> NoReturn:
    """Solve the blocks that arrive on stdin and write the results to stdout.

    The process ends as soon as stdin is closed, even within a block: by the process that stores the results,
    or because that process has ended. It ignores signals, which are left to the other process.
    """
    for number in _SIGNALS:
        signal.signal(number, signal.SIG_IGN)
    results, sys.stdout = sys.stdout.buffer, sys.stderr  # nothing else may be printed between the results
    tasks: SimpleQueue[bytes] = SimpleQueue()
    Thread(target=_receive, args=(tasks,), daemon=True).start()
    while True:
        result = _solved(tasks.get())
        try:
            results.write(result)
            results.flush()
        except OSError:
            os._exit(1)


def _receive(tasks: SimpleQueue[bytes]) -> None:
    """Put tasks from stdin in a queue; end the process when stdin is closed."""
    try:
        while True:
            tasks.put(pickle.load(sys.stdin.buffer))
    finally:
        os._exit(1)


def _solved(task: bytes) -> bytes:
    """Return whether a block was solved, and the result or the error, as a pickle."""
    try:
        return pickle.dumps((True, pickle.loads(task)()), pickle.HIGHEST_PROTOCOL)
    except Exception as error:
        error.add_note(f"In a worker process:\n{traceback.format_exc()}")
        return pickle.dumps((False, error))


def cores() -> int:
    """Return the number of processors that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def number_of(jobs: int | None, workers: Workers | None = None) -> int:
    """Return the number of the given workers, or of processes to use, by default one per core.

    Raises `InputError` for anything else.
    """
    if workers is not None:
        if not isinstance(workers, Workers):
            raise InputError(
                f"workers = {workers!r:.40}: give an open Cluster, or jobs=3 for three processes"
            )
        return workers.jobs
    if jobs is None:
        return cores()
    return check_int("jobs", jobs)


@contextmanager
def at_work(seconds: float, jobs: int | None = None, workers: Workers | None = None) -> Iterator[Workers]:
    """Provide workers for about `seconds` of work: the given workers, or processes that end after use.

    Short work is done in this process. If `jobs` is not given, longer work uses all cores.
    """
    number = number_of(jobs, workers)
    if workers is not None:
        yield workers
        return
    if number == 1 or seconds < (_STARTING if jobs else _WORTH_PROCESSES):
        yield HERE
        return
    with Processes(number) as processes:
        yield processes
