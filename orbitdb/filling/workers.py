"""Solve blocks in this process or in several processes at once (`orbitdb.filling.cluster`: on a cluster).

Results come in the order of the blocks. The number of blocks in progress is limited, to limit the memory.
"""

import os
import pickle
import signal
import sys
import threading
import weakref
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from itertools import count, islice
from multiprocessing import connection, get_context, parent_process, resource_tracker
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from traceback import format_exception
from types import ModuleType
from typing import Any, Self, TypeAlias, TypeVar

from orbitdb.errors import InputError, WorkError, need_whole

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
    """Context manager that solves blocks in processes that it starts, and kills after use.

    Each process has a pipe of its own. If it dies, even while it sends a result, its pipe ends.

    Parameters
    ----------
    jobs : int
        Number of processes.
    """

    def __init__(self, jobs: int) -> None:
        self.jobs = jobs
        self._processes: list[BaseProcess] = []
        self._unsolved: dict[Connection, int] = {}  # number of blocks that each process has
        self._numbers, self._last = count(), -1
        self._answers: dict[int, tuple[Any, Exception | None]] = {}
        self._end = weakref.finalize(self, _kill, self._processes, self._unsolved)  # at the latest at exit

    def __enter__(self) -> Self:
        context = get_context("spawn")
        with _apart():
            for _ in range(self.jobs):
                pipe, far_end = context.Pipe()
                process = context.Process(target=_serve, args=(far_end,), daemon=True)
                process.start()
                far_end.close()
                self._processes.append(process)
                self._unsolved[pipe] = 0
        return self

    def __exit__(self, *error: object) -> None:
        self._end()

    def solved(self, blocks: Iterable[Task[Answer]]) -> Iterator[Answer]:
        """Yield the results of the blocks in order; drop those of an earlier call that was given up."""
        self._last = next(self._numbers)
        self._answers.clear()
        return super().solved(blocks)

    def _ahead(self) -> int:
        return AHEAD * self.jobs

    def _begin(self, block: Task[Any]) -> int:
        """Send a block to the process that has the fewest; return its number."""
        number, pipe = next(self._numbers), min(self._unsolved, key=self._unsolved.__getitem__)
        with _alive():
            pipe.send((number, block))
        self._unsolved[pipe] += 1
        return number

    def _result(self, begun: int) -> Any:
        while begun not in self._answers:
            ready = connection.wait([*self._unsolved])
            for pipe in (pipe for pipe in self._unsolved if pipe in ready):
                with _alive():
                    number, answer = pipe.recv()
                self._unsolved[pipe] -= 1
                if number > self._last:
                    self._answers[number] = answer
        answer, error = self._answers.pop(begun)
        if error is not None:
            raise error
        return answer


@contextmanager
def _alive() -> Iterator[None]:
    """Say that a process died if its pipe ends."""
    try:
        yield
    except (EOFError, OSError):
        raise WorkError(
            "a worker process died; nothing stored is lost, and the same command continues from there: "
            "if memory is short, use fewer processes with --jobs"
        ) from None


def _kill(processes: Iterable[BaseProcess], pipes: Iterable[Connection]) -> None:
    for process in processes:
        process.kill()
        process.join()
    for pipe in pipes:
        pipe.close()


_one_at_a_time = threading.Lock()


@contextmanager
def _apart() -> Iterator[None]:
    """Hide the user's script, which a new process would run, and let it start with signals blocked."""
    masks = hasattr(signal, "pthread_sigmask")
    with _one_at_a_time:
        main = sys.modules["__main__"]
        if masks:
            before = signal.pthread_sigmask(signal.SIG_BLOCK, _SIGNALS)
            resource_tracker.ensure_running()  # SIGHUP would end it, and it unblocks other signals
            signal.pthread_sigmask(signal.SIG_BLOCK, _SIGNALS)
        try:
            sys.modules["__main__"] = ModuleType("__main__")
            yield
        finally:
            sys.modules["__main__"] = main
            if masks:
                signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _serve(pipe: Connection) -> None:
    """Solve blocks in a process until it is killed or its parent ends; signals are left to the parent."""
    for number in _SIGNALS:
        signal.signal(number, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()
    with suppress(EOFError, OSError), ThreadPoolExecutor(1) as sending:
        while True:
            number, block = pipe.recv()
            answer, failure = None, None
            try:
                answer = block()
            except Exception as error:
                error.add_note("".join(format_exception(error)))
                failure = error
            result = pickle.dumps((number, (answer, failure)))
            sending.submit(pipe.send_bytes, result)  # the next block need not wait until it is read


def _end_with_parent() -> None:
    if (parent := parent_process()) is not None:
        parent.join()
        os._exit(1)


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
    need_whole("jobs", jobs)
    return jobs


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
