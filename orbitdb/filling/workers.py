"""Solve blocks in this process, or in several processes at once.

Results come in the order of the blocks. The number of blocks in progress is limited, to limit the memory.
"""

import os
import signal
import sys
import threading
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing import connection, parent_process, resource_tracker
from multiprocessing.context import SpawnContext, SpawnProcess
from types import ModuleType, TracebackType
from typing import Any, Self, TypeAlias, TypeVar

from orbitdb.errors import InputError, WorkError

Begun = TypeVar("Begun")
Answer = TypeVar("Answer")

_AHEAD = 2
"""Number of blocks in progress per worker, so that no worker waits for the writer."""

_WORTH_PROCESSES = 1.0
"""Work of at least this many seconds is worth starting more processes."""
_STARTING = 0.1
"""Approximate time in seconds to start processes."""

_BETWEEN_LOOKS = 1.0
"""Seconds between two looks at whether all processes are alive."""

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
        """Yield the results of the blocks in order."""
        return (block() for block in blocks)


HERE = Workers()


def begun_ahead(begun: Iterable[Begun], ahead: Callable[[], int]) -> Iterator[Begun]:
    """Yield futures in order, while further blocks are in progress.

    Each step of `begun` starts a block and yields its future. `ahead` returns how many blocks besides the
    next may be in progress; it is called each time, because the number of workers may grow.
    """
    waiting: deque[Begun] = deque()
    for future in begun:
        waiting.append(future)
        while len(waiting) > ahead():
            yield waiting.popleft()
    yield from waiting


class Processes(Workers):
    """Context manager that solves blocks in processes that it starts, and ends them at once after use.

    Parameters
    ----------
    jobs : int
        Number of processes.
    """

    def __init__(self, jobs: int) -> None:
        self.jobs = jobs
        self._context = _Context()
        self._pool = ProcessPoolExecutor(jobs, self._context, _begin)

    def __enter__(self) -> Self:
        """Start the processes now, because that takes a few tenths of a second."""
        try:
            for _ in range(self.jobs):
                self._pool.submit(int)
        except BaseException:
            self._end()
            raise
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._end()

    def _end(self) -> None:
        """End all processes without waiting for blocks in progress."""
        self._context.kill()
        self._pool.shutdown(cancel_futures=True)

    def solved(self, blocks: Iterable[Task[Answer]]) -> Iterator[Answer]:
        """Yield the results of the blocks in order.

        Raises
        ------
        WorkError
            If a process dies.
        """
        try:
            begun = (self._pool.submit(_solve, block) for block in blocks)
            for future in begun_ahead(begun, lambda: _AHEAD * self.jobs):
                self._wait(future)
                yield future.result()
        except BrokenProcessPool:
            raise _died() from None

    def _wait(self, future: Future[Any]) -> None:
        """Wait for a result; raise `WorkError` if a process died.

        The pool itself would wait forever for a process that died while it was sending a result.
        """
        while not wait([future], _BETWEEN_LOOKS).done:
            if connection.wait(self._context.sentinels(), 0):
                raise _died()


def _died() -> WorkError:
    return WorkError(
        "a worker process died; what was stored is safe, and the same command goes on from there: if memory "
        "is short, use fewer processes with --jobs"
    )


class _Context(SpawnContext):
    """Keeps the processes that a pool starts, and the pipe through which they send results."""

    def __init__(self) -> None:
        super().__init__()
        self._made: list[_Process] = []

    def Process(self, *given: Any, **named: Any) -> "_Process":  # type: ignore[override]  # noqa: N802
        """Return a new process."""
        self._made.append(_Process(*given, **named))
        return self._made[-1]

    def SimpleQueue(self) -> Any:  # noqa: N802
        """Return the pipe of the results, which is all that a pool uses a simple queue for."""
        self._results = super().SimpleQueue()
        return self._results

    def sentinels(self) -> list[Any]:
        """Return objects that become ready when a process ends."""
        return [process.sentinel for process in self._made if process.pid is not None]

    def kill(self) -> None:
        """Kill all processes, and let no thread wait for the rest of a result that one was sending."""
        for process in self._made:
            if process.pid is not None:
                process.kill()
        self._results._writer.close()


class _Process(SpawnProcess):
    """A process that does not run the user's script, and that signals do not reach while it starts."""

    def start(self) -> None:
        """Start the process."""
        with _apart():
            super().start()


_one_at_a_time = threading.Lock()


@contextmanager
def _apart() -> Iterator[None]:
    """Hide the user's script, which a new process would run, and let it start with signals blocked."""
    masked = hasattr(signal, "pthread_sigmask")
    with _one_at_a_time:
        main = sys.modules["__main__"]
        if masked:
            resource_tracker.ensure_running()  # it unblocks signals when it starts
            before = signal.pthread_sigmask(signal.SIG_BLOCK, _SIGNALS)
        try:
            sys.modules["__main__"] = ModuleType("__main__")
            yield
        finally:
            sys.modules["__main__"] = main
            if masked:
                signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _begin() -> None:
    """Leave signals to the process that stores the results, and end as soon as it does."""
    for number in _SIGNALS:
        signal.signal(number, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def _solve(block: Task[Answer]) -> Answer:
    return block()


def cores() -> int:
    """Return the number of processors that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def number_of(jobs: int | None) -> int:
    """Return the number of processes to use, by default one per core; raise `InputError` if it is below 1."""
    if jobs is not None and jobs < 1:
        raise InputError(f"jobs = {jobs}: give 1 or more, or None for one per core")
    return jobs or cores()


@contextmanager
def at_work(seconds: float, jobs: int | None = None, workers: Workers | None = None) -> Iterator[Workers]:
    """Provide workers for about `seconds` of work: the given workers, or processes that end after use.

    Short work is done in this process. If `jobs` is not given, longer work uses all cores.
    """
    if workers is not None:
        yield workers
        return
    count = number_of(jobs)
    if count == 1 or seconds < (_STARTING if jobs else _WORTH_PROCESSES):
        yield HERE
        return
    with Processes(count) as processes:
        yield processes
