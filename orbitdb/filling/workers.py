"""Solve blocks in this process, or in several processes at once.

Results come in the order of the blocks. The number of blocks in progress is limited, to limit the memory.
"""

import multiprocessing
import os
import pickle
import signal
import threading
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from multiprocessing import resource_tracker
from multiprocessing.connection import Connection
from traceback import format_exc
from types import TracebackType
from typing import Any, Self, TypeAlias, TypeVar

from orbitdb import __version__
from orbitdb.errors import WorkError

Begun = TypeVar("Begun")
Answer = TypeVar("Answer")

_AHEAD = 2
"""Number of blocks in progress per worker, so that no worker waits for the writer."""

_WORTH_PROCESSES = 1.0
"""Work of at least this many seconds is worth starting more processes."""
_STARTING = 0.1
"""Approximate time in seconds to start processes."""

_DEATHS = 3
"""A block is given up when this many workers have died on it."""

_HELD_BACK = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)]


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
    for each in begun:
        waiting.append(each)
        while len(waiting) > ahead():
            yield waiting.popleft()
    yield from waiting


def answered(version: str, result: Answer) -> Answer:
    """Return the result of a worker; raise `WorkError` if it runs another version of orbitdb."""
    if version != __version__:
        raise WorkError(f"a worker runs orbitdb {version}: install {__version__} there, too")
    return result


class Processes(Workers):
    """Context manager that solves blocks in processes that it starts.

    If a process dies, only its block is lost, and a new process solves it again.

    Parameters
    ----------
    jobs : int
        Number of processes.

    Notes
    -----
    For each process, a thread sends blocks through a pipe that no other process shares. A killed process
    therefore holds no lock that others wait for, and its end of the pipe closes.
    """

    def __init__(self, jobs: int) -> None:
        self.jobs = jobs
        self._threads = ThreadPoolExecutor(jobs)
        self._own = threading.local()
        self._all: list[_Process] = []
        self._ended = False

    def __enter__(self) -> Self:
        """Start the processes now, because that takes a few tenths of a second."""
        try:
            with _signals_held_back():  # or threads and processes could be left half started
                for _ in range(self.jobs):
                    self._threads.submit(self._process)
        except BaseException:
            self._end()
            raise
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._end()

    def _end(self) -> None:
        """End all processes at once, without waiting for blocks in progress."""
        self._ended = True
        for process in self._all:
            process.end()
        self._threads.shutdown(cancel_futures=True)

    def solved(self, blocks: Iterable[Task[Answer]]) -> Iterator[Answer]:
        """Yield the results of the blocks in order.

        Raises
        ------
        WorkError
            If several processes die on the same block.
        """
        begun = (self._threads.submit(self._answer, block) for block in blocks)
        for answer in begun_ahead(begun, lambda: _AHEAD * self.jobs):
            found = answered(*pickle.loads(answer.result()))
            if isinstance(found, Exception):
                raise found
            yield found

    def _answer(self, block: Task[Any]) -> bytes:
        """Let the process of this thread solve a block; start a new process if it dies."""
        for _ in range(_DEATHS):
            process = self._process()
            try:
                return process.answer(block)
            except (EOFError, OSError):
                process.end()
                if self._ended:
                    raise
                del self._own.process
        raise WorkError(
            f"worker processes died {_DEATHS} times on the same block: if memory is short, use fewer with "
            "--jobs"
        )

    def _process(self) -> "_Process":
        if not hasattr(self._own, "process"):
            self._own.process = _Process()
            self._all.append(self._own.process)
            if self._ended:  # while it was starting
                self._own.process.end()
        process: _Process = self._own.process
        return process


class _Process:
    """A process that solves blocks, started by a thread other than the main thread.

    The thread blocks Ctrl-C and similar signals, so that they cannot reach the process while it starts.
    """

    def __init__(self) -> None:
        if hasattr(signal, "pthread_sigmask"):
            signal.pthread_sigmask(signal.SIG_BLOCK, _HELD_BACK)  # inherited by the tracker
            resource_tracker.ensure_running()  # which unblocks signals when it starts
            signal.pthread_sigmask(signal.SIG_BLOCK, _HELD_BACK)
        fresh = multiprocessing.get_context("spawn")  # a fork would share open databases
        self._line, other = fresh.Pipe()
        self._process = fresh.Process(target=_work, args=(other,), daemon=True)
        self._process.start()
        other.close()

    def answer(self, block: Task[Any]) -> bytes:
        """Return the answer of `_work` for a block; raise EOFError or OSError if the process died."""
        self._line.send_bytes(pickle.dumps(block))
        return self._line.recv_bytes()

    def end(self) -> None:
        """End the process at once."""
        self._process.kill()
        self._process.join()


@contextmanager
def _signals_held_back() -> Iterator[None]:
    """Delay Ctrl-C and similar signals until the end of a block."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, _HELD_BACK)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _work(line: Connection) -> None:
    """Solve block after block; answer each with the version of orbitdb, and the result or an error.

    Signals are left to the process that stores the results. If it is killed, this process ends at once.
    """
    for number in _HELD_BACK:  # except SIGTERM, with which Python ends children at exit
        signal.signal(number, signal.SIG_DFL if number == signal.SIGTERM else signal.SIG_IGN)
    if hasattr(signal, "pthread_sigmask"):
        signal.pthread_sigmask(signal.SIG_UNBLOCK, _HELD_BACK)  # the mask of the thread that started it
    threading.Thread(target=_end_with_parent, daemon=True).start()
    with suppress(EOFError, OSError):  # the other end is gone
        while True:
            data = line.recv_bytes()
            try:
                found = pickle.loads(data)()
            except Exception as error:
                error.add_note(format_exc())
                found = error
            line.send_bytes(pickle.dumps((__version__, found)))


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def cores() -> int:
    """Return the number of processors that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@contextmanager
def at_work(seconds: float, jobs: int | None = None, workers: Workers | None = None) -> Iterator[Workers]:
    """Provide workers for about `seconds` of work: the given workers, or processes that end after use.

    Short work is done in this process. If `jobs` is not given, longer work uses all cores.
    """
    if workers is not None:
        yield workers
        return
    count = jobs or (cores() if seconds >= _WORTH_PROCESSES else 1)
    if count == 1 or seconds < _STARTING:
        yield HERE
        return
    with Processes(count) as processes:
        yield processes
