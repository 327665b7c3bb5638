"""Where blocks are solved: in this process, or in several processes at once.

Results come in the order of the blocks, however long each takes, and only so many blocks are under
way that memory stays bounded whatever the period.
"""

import multiprocessing
import os
import pickle
import signal
import threading
from collections.abc import Iterable, Iterator
from concurrent.futures import BrokenExecutor, Executor, ProcessPoolExecutor
from contextlib import ExitStack, contextmanager, suppress
from multiprocessing import resource_tracker
from multiprocessing.connection import Connection
from pathlib import Path
from types import TracebackType
from typing import Generic, NamedTuple, Protocol, Self
from uuid import uuid4

from orbitdb.filling.blocks import Result, Task
from orbitdb.filling.pool import in_order
from orbitdb.filling.scratch import scratch_folder

_AHEAD = 2
"""Blocks under way for each worker, so that none waits for the writer."""

_HELD_BACK = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)]


class Workers(Protocol):
    """Something that solves blocks.

    Attributes
    ----------
    jobs : int
        How many it solves at once.
    """

    jobs: int

    def solved(self, blocks: Iterable[Task[Result]]) -> Iterator[Result]:
        """Yield what became of blocks, in their order."""


class Here:
    """Solves blocks one after the other in this process."""

    jobs = 1

    def solved(self, blocks: Iterable[Task[Result]]) -> Iterator[Result]:
        """Yield what became of blocks, in their order."""
        return (block.solved() for block in blocks)


HERE = Here()


class Processes:
    """Solves blocks in processes of their own; to be used as a context.

    A process that dies costs no more than the blocks under way, which are solved again by new ones.

    Parameters
    ----------
    jobs : int
        Number of processes.
    """

    def __init__(self, jobs: int) -> None:
        self.jobs = jobs
        self._started: _Started | None = None
        self._until_end = ExitStack()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._end()

    def solved(self, blocks: Iterable[Task[Result]]) -> Iterator[Result]:
        """Yield what became of blocks, in their order."""
        return in_order(self, blocks, lambda: _AHEAD * self.jobs)

    def start(self) -> None:
        """Start the processes, which takes them some tenths of a second, before there are blocks to solve.

        If one of them dies at once, the first block tells so.
        """
        self._prepare()
        with _signals_held_back(), suppress(BrokenExecutor, BrokenPipeError):
            executor = self._ready().executor
            for _ in range(self.jobs):  # it starts one for each task that finds none idle
                executor.submit(os.getpid)

    def submit(self, block: Task[Result]) -> "Parcel[Result]":
        """Begin with a block."""
        self._prepare()
        with _signals_held_back():  # this may start a process
            ready = self._ready()
            return Parcel(block, ready.folder, ready.executor)

    def _prepare(self) -> None:
        """Start what clears semaphores away behind this process, if need be.

        It is to outlive the closing of a terminal. As it starts, it lets signals through that are held back.
        """
        if self._started is None and hasattr(signal, "pthread_sigmask"):
            with _signals_held_back():
                resource_tracker.ensure_running()

    def _ready(self) -> "_Started":
        if self._started is None:
            folder = self._until_end.enter_context(scratch_folder())
            fresh = multiprocessing.get_context("spawn")  # a fork would share open databases
            end, lifeline = fresh.Pipe(duplex=False)
            executor = ProcessPoolExecutor(self.jobs, fresh, _begin_worker, (end,))
            self._started = _Started(executor, folder, lifeline)
        return self._started

    def renew(self) -> None:
        """Put new processes in the place of those of which one has died."""
        self._end()

    def _end(self) -> None:
        """End all processes at once: nobody waits for what is under way.

        Told by the executor they might not hear: one that was killed may have held the lock of its queue.
        """
        if self._started is not None:
            self._started.lifeline.close()
            self._started.executor.shutdown()
        self._until_end.close()
        self._started = None


class _Started(NamedTuple):
    """What starts processes when needed, the folder of their parcels, and the line that ends them."""

    executor: Executor
    folder: Path
    lifeline: Connection


class Parcel(Generic[Result]):
    """A block on its way to a worker and back, in files.

    Through the pipes of the executor goes no more than their name, which is written at one stroke: a
    process that dies while it writes something longer leaves the other end waiting for ever.
    """

    def __init__(self, block: Task[Result], folder: Path, executor: Executor) -> None:
        self._path = folder / uuid4().hex
        self._path.write_bytes(pickle.dumps(block))
        self._solved = executor.submit(_solve_parcel, self._path)

    def result(self) -> Result:
        """Wait for the worker and return what it found.

        Raises
        ------
        BrokenExecutor
            If a worker has died.
        """
        self._solved.result()
        found: Result = pickle.loads(self._path.read_bytes())
        self._path.unlink()
        return found


def _solve_parcel(path: Path) -> None:
    path.write_bytes(pickle.dumps(pickle.loads(path.read_bytes()).solved()))


@contextmanager
def _signals_held_back() -> Iterator[None]:
    """Deliver Ctrl-C and the like afterwards, lest they tear a process that is just being started."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    caught: list[int] = []  # in case another thread of this process, which has no such mask, takes a signal
    ours = {n: action for n in _HELD_BACK if callable(action := signal.getsignal(n))}
    main = threading.current_thread() is threading.main_thread()
    before = signal.pthread_sigmask(signal.SIG_BLOCK, _HELD_BACK)
    try:
        for number in ours if main else ():
            signal.signal(number, lambda n, _: caught.append(n))
        yield
    finally:
        for number, action in ours.items() if main else ():
            signal.signal(number, action)
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
        for number in caught:
            signal.raise_signal(number)


def _begin_worker(lifeline: Connection) -> None:
    """Leave signals to the process that stores, and end at once when it cuts the line or is killed."""
    for number in _HELD_BACK:
        signal.signal(number, signal.SIG_IGN)
    if hasattr(signal, "pthread_sigmask"):
        signal.pthread_sigmask(signal.SIG_UNBLOCK, _HELD_BACK)  # the process began with the mask above
    threading.Thread(target=_end_with, args=(lifeline,), daemon=True).start()


def _end_with(lifeline: Connection) -> None:
    with suppress(EOFError, OSError):
        lifeline.recv()
    os._exit(1)


def cores() -> int:
    """Return the number of processors that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
