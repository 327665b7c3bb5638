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
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import ExitStack, suppress
from multiprocessing import resource_tracker
from multiprocessing.connection import Connection
from tempfile import TemporaryFile
from traceback import format_exc
from types import TracebackType
from typing import IO, Any, Protocol, Self, TypeVar

from orbitdb import __version__
from orbitdb.errors import WorkError

Result = TypeVar("Result")
Result_co = TypeVar("Result_co", covariant=True)

_AHEAD = 2
"""Blocks under way for each worker, so that none waits for the writer."""

_DEATHS = 3
"""How often workers may die on one block."""

_PIECE = 1 << 16
"""Bytes of an answer that are sent at a time."""

_HELD_BACK = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)]


class Task(Protocol[Result_co]):
    """A block of any kind: it knows how it is solved, and goes to other processes as it is."""

    def solved(self) -> Result_co:
        """Return what becomes of it."""


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


def in_order(
    submit: Callable[[Task[Any]], Future[Result]], blocks: Iterable[Task[Any]], ahead: Callable[[], int]
) -> Iterator[Result]:
    """Solve blocks that may be finished in any order; yield the results in the order of the blocks.

    Parameters
    ----------
    submit : callable
        Begins with a block, and promises its result.
    blocks : iterable of Task
    ahead : callable
        Says how many blocks may be under way beside the one that is waited for; it is asked before
        every block, as there may be more workers by then.
    """
    waiting: deque[Future[Result]] = deque()
    for block in blocks:
        waiting.append(submit(block))
        while len(waiting) > ahead():
            yield waiting.popleft().result()
    while waiting:
        yield waiting.popleft().result()


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


class Processes:
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
        self._all: list[_Process] = []
        self._idle: list[_Process] = []
        self._ended = False

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """End all processes at once: nobody waits for what is under way."""
        self._ended = True
        for process in self._all:
            process.end()
        self._threads.shutdown(cancel_futures=True)

    def start(self) -> None:
        """Start the processes, which takes them some tenths of a second, before there are blocks to solve."""
        for _ in range(self.jobs):
            self._threads.submit(lambda: self._idle.append(self._started()))

    def solved(self, blocks: Iterable[Task[Result]]) -> Iterator[Result]:
        """Yield what became of blocks, in their order.

        Raises
        ------
        WorkError
            If processes die again and again on one block.
        """
        answers, over = set[IO[bytes]](), threading.Event()

        def solve(block: Task[Any]) -> IO[bytes]:
            answer = self._answer(block)
            answers.add(answer)
            if over.is_set():
                answer.close()
            return answer

        try:
            for answer in in_order(
                lambda block: self._threads.submit(solve, block), blocks, lambda: _AHEAD * self.jobs
            ):
                with answer:
                    found = answered(*pickle.load(answer))
                answers.remove(answer)
                if isinstance(found, Exception):
                    raise found
                yield found
        finally:
            over.set()
            for answer in answers.copy():  # that nobody wants any more
                answer.close()

    def _answer(self, block: Task[Any]) -> IO[bytes]:
        """Give a block to an idle process, or to a new one if there is none or it dies; return the answer."""
        try:
            process = self._idle.pop()
        except IndexError:
            process = self._started()
        for _ in range(_DEATHS):
            try:
                answer = process.answer(block)
            except (EOFError, ConnectionError):
                process.end()
                if self._ended:
                    raise
                process = self._started()
            else:
                self._idle.append(process)
                return answer
        raise WorkError(
            f"worker processes died {_DEATHS} times on one block: if memory is short, use fewer with --jobs"
        )

    def _started(self) -> "_Process":
        process = _Process()
        self._all.append(process)
        if self._ended:  # since this began
            process.end()
        return process


class _Process:
    """A process that solves blocks, started in a thread that is not the main one.

    Ctrl-C and the like are held back in that thread: so they reach no process that is just being started.
    """

    def __init__(self) -> None:
        if hasattr(signal, "pthread_sigmask"):
            signal.pthread_sigmask(signal.SIG_BLOCK, _HELD_BACK)
            resource_tracker.ensure_running()  # as it starts, it lets signals through that are held back
            signal.pthread_sigmask(signal.SIG_BLOCK, _HELD_BACK)
        fresh = multiprocessing.get_context("spawn")  # a fork would share open databases
        self._line, other = fresh.Pipe()
        self._process = fresh.Process(target=_work, args=(other,), daemon=True)
        self._process.start()
        other.close()

    def answer(self, block: Task[Any]) -> IO[bytes]:
        """Have a block solved; return what `_work` says, in a file: answers may wait, and take no memory.

        Raises
        ------
        EOFError, ConnectionError
            If the process has died.
        """
        self._line.send_bytes(pickle.dumps(block))
        with ExitStack() as unless_whole:
            file = unless_whole.enter_context(TemporaryFile())
            while piece := self._received():
                file.write(piece)
            file.seek(0)
            unless_whole.pop_all()
            return file

    def _received(self) -> bytes:
        try:
            return self._line.recv_bytes()
        except OSError as error:
            if error.errno is None:  # the process has died in the middle of a piece
                raise EOFError from error
            raise

    def end(self) -> None:
        """End the process at once."""
        self._process.kill()
        self._process.join()


def _work(line: Connection) -> None:
    """Solve block after block; answer with the version of this orbitdb and the result or an error, in pieces.

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
                found = pickle.loads(data).solved()
            except Exception as error:
                error.add_note(format_exc())
                found = error
            answer = memoryview(pickle.dumps((__version__, found)))
            for start in range(0, len(answer), _PIECE):
                line.send_bytes(answer[start : start + _PIECE])
            line.send_bytes(b"")


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
