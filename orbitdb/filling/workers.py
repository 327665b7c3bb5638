"""Where blocks are solved: in this process, or in several processes at once.

Results come in the order of the blocks, however long each takes, and only so many blocks are under
way that memory stays bounded whatever the period.
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
Result = TypeVar("Result")

_AHEAD = 2
"""Blocks under way for each worker, so that none waits for the writer."""

_WORTH_PROCESSES = 1.0
"""Seconds of work from which on starting further processes pays."""
_STARTING = 0.1
"""Seconds of work that starting further processes takes, about."""

_DEATHS = 3
"""How often workers may die on one block."""

_HELD_BACK = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)]


Task: TypeAlias = Callable[[], Result]
"""What solves a block of any kind; it goes to other processes, and what it returns comes from there."""


class Workers:
    """What solves blocks; by itself, one after the other in this process.

    Attributes
    ----------
    jobs : int
        How many it solves at once.
    """

    jobs = 1

    def solved(self, blocks: Iterable[Task[Result]]) -> Iterator[Result]:
        """Yield what became of blocks, in their order."""
        return (block() for block in blocks)


HERE = Workers()


def begun_ahead(begun: Iterable[Begun], ahead: Callable[[], int]) -> Iterator[Begun]:
    """Yield what was begun in its order, with more under way.

    Parameters
    ----------
    begun : iterable
        Begins with a block at every step, and promises its result.
    ahead : callable
        Says how many may be under way beside the one that is waited for; it is asked before every one, as
        there may be more workers by then.
    """
    waiting: deque[Begun] = deque()
    for each in begun:
        waiting.append(each)
        while len(waiting) > ahead():
            yield waiting.popleft()
    yield from waiting


def answered(version: str, result: Result) -> Result:
    """Return the result of a worker of this version.

    Raises
    ------
    WorkError
        If it is of another one.
    """
    if version != __version__:
        raise WorkError(f"a worker runs orbitdb {version}: install {__version__} there, too")
    return result


class Processes(Workers):
    """Solves blocks in processes of their own; to be used as a context.

    A process that dies costs no more than its block, which is solved again by a new one.

    Parameters
    ----------
    jobs : int
        Number of processes.

    Notes
    -----
    A thread for each process gives it blocks and takes the results, through a pipe that nobody else uses: a
    process that is killed holds no lock that others wait for, and its end of the pipe closes with it.
    """

    def __init__(self, jobs: int) -> None:
        self.jobs = jobs
        self._threads = ThreadPoolExecutor(jobs)
        self._own = threading.local()
        self._all: list[_Process] = []
        self._ended = False

    def __enter__(self) -> Self:
        """Start the processes, which takes them some tenths of a second, before there are blocks to solve."""
        for _ in range(self.jobs):
            self._threads.submit(self._process)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """End all processes at once: nobody waits for what is under way."""
        self._ended = True
        for process in self._all:
            process.end()
        self._threads.shutdown(cancel_futures=True)

    def solved(self, blocks: Iterable[Task[Result]]) -> Iterator[Result]:
        """Yield what became of blocks, in their order.

        Raises
        ------
        WorkError
            If processes die again and again on one block.
        """
        begun = (self._threads.submit(self._answer, block) for block in blocks)
        for answer in begun_ahead(begun, lambda: _AHEAD * self.jobs):
            found = answered(*pickle.loads(answer.result()))
            if isinstance(found, Exception):
                raise found
            yield found

    def _answer(self, block: Task[Any]) -> bytes:
        """Have a block solved by the process of this thread, or by a new one if it dies."""
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
            f"worker processes died {_DEATHS} times on one block: if memory is short, use fewer with --jobs"
        )

    def _process(self) -> "_Process":
        """Return the process of this thread, which is started if there is none."""
        if not hasattr(self._own, "process"):
            self._own.process = _Process()
            self._all.append(self._own.process)
            if self._ended:  # since this began
                self._own.process.end()
        process: _Process = self._own.process
        return process


class _Process:
    """A process that solves blocks, started in a thread that is not the main one.

    Ctrl-C and the like are held back in that thread: so they reach no process that is just being started.
    """

    def __init__(self) -> None:
        if hasattr(signal, "pthread_sigmask"):
            signal.pthread_sigmask(signal.SIG_BLOCK, _HELD_BACK)  # from the tracker, too
            resource_tracker.ensure_running()  # as it starts, it lets signals through that are held back
            signal.pthread_sigmask(signal.SIG_BLOCK, _HELD_BACK)
        fresh = multiprocessing.get_context("spawn")  # a fork would share open databases
        self._line, other = fresh.Pipe()
        self._process = fresh.Process(target=_work, args=(other,), daemon=True)
        self._process.start()
        other.close()

    def answer(self, block: Task[Any]) -> bytes:
        """Have a block solved; return what `_work` says, or raise EOFError or OSError if it has died."""
        self._line.send_bytes(pickle.dumps(block))
        return self._line.recv_bytes()

    def end(self) -> None:
        """End the process at once."""
        self._process.kill()
        self._process.join()


def _work(line: Connection) -> None:
    """Solve block after block; answer with the version of this orbitdb and the result or an error.

    Signals are left to the process that stores; if that is killed, this one ends at once.
    """
    for number in _HELD_BACK:  # but for SIGTERM, by which Python ends the children of a process that ends
        signal.signal(number, signal.SIG_DFL if number == signal.SIGTERM else signal.SIG_IGN)
    if hasattr(signal, "pthread_sigmask"):
        signal.pthread_sigmask(signal.SIG_UNBLOCK, _HELD_BACK)  # the process began with the mask above
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
    """Give what does the work of so many seconds, about: given workers, or processes that end after use.

    Work that takes no longer than starting processes does is done here, whatever is asked for. Without a
    number of jobs there are as many as cores, if the work is worth it.
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
