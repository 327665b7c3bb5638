"""Solve blocks in this process or in several processes at once (`orbitdb.filling.cluster`: on a cluster).

Results come in the order of the blocks. The number of blocks in progress is limited, to limit the memory.
"""

import os
import pickle
import shutil
import signal
import sys
import threading
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager, suppress
from itertools import islice
from multiprocessing import get_context, resource_tracker
from multiprocessing.connection import Connection
from pathlib import Path
from tempfile import NamedTemporaryFile, TemporaryDirectory, gettempdir
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
    """Context manager that solves blocks in processes that it starts, and ends at once after use.

    Results come as files in a temporary folder. If a process died while it sent a long result through its
    pipe, Python's pool would wait for the rest of it for ever.

    Parameters
    ----------
    jobs : int
        Number of processes.
    """

    def __init__(self, jobs: int) -> None:
        self.jobs = jobs

    def __enter__(self) -> Self:
        """Start the processes now, because that takes a few tenths of a second."""
        self._folder = TemporaryDirectory(prefix="orbitdb-", ignore_cleanup_errors=True)
        context = get_context("spawn")
        self._staying, self._stay = context.Pipe(duplex=False)
        with _apart():  # it starts Python's tracker of resources
            self._pool = ProcessPoolExecutor(self.jobs, context, _begin, (self._staying, self._folder.name))
        for _ in range(self.jobs):
            self._begin(int)
        return self

    def __exit__(self, *error: object) -> None:
        """End all processes without waiting for blocks in progress."""
        self._stay.close()
        self._pool.shutdown(cancel_futures=True)
        self._staying.close()
        self._folder.cleanup()

    def _ahead(self) -> int:
        return AHEAD * self.jobs

    def _begin(self, block: Task[Any]) -> Future[str]:
        with _alive(), _apart():  # each call may start a process
            return self._pool.submit(_solve, block, self._folder.name)

    def _result(self, begun: Future[str]) -> Any:
        try:
            with _alive():
                path = Path(begun.result())
            answer = pickle.loads(path.read_bytes())
            path.unlink()
        except OSError as error:
            raise WorkError(
                f"results cannot be kept in {gettempdir()} ({error.strerror}): free some room, or set TMPDIR"
            ) from error
        return answer


@contextmanager
def _alive() -> Iterator[None]:
    """Say what to do if a process died."""
    try:
        yield
    except BrokenProcessPool:
        raise WorkError(
            "a worker process died; nothing stored is lost, and the same command continues from there: "
            "if memory is short, use fewer processes with --jobs"
        ) from None


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


def _begin(staying: Connection, folder: str) -> None:
    """Leave signals to the process that stores the results, and end as soon as it does."""
    for number in _SIGNALS:
        signal.signal(number, signal.SIG_IGN)
    threading.Thread(target=_end, args=(staying, folder), daemon=True).start()


def _end(staying: Connection, folder: str) -> None:
    """End this process when the other end of a pipe is closed, by the other process or by its end."""
    with suppress(EOFError, OSError):
        staying.recv()
    shutil.rmtree(folder, ignore_errors=True)
    os._exit(1)


def _solve(block: Task[Any], folder: str) -> str:
    """Solve a block; return the path of a file with the result."""
    with NamedTemporaryFile(dir=folder, delete=False) as file:
        pickle.dump(block(), file, pickle.HIGHEST_PROTOCOL)
    return file.name


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
    return need_whole("jobs", jobs)


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
