"""Solve blocks in this process, in several processes at once, or on a cluster of machines.

Results come in the order of the blocks. The number of blocks in progress is limited, to limit the memory.
"""

import json
import operator
import os
import pickle
import signal
import sys
import threading
import weakref
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import CancelledError, ThreadPoolExecutor
from contextlib import contextmanager, suppress
from functools import partial
from itertools import count, islice
from multiprocessing import connection, get_context, parent_process, resource_tracker
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from pathlib import Path
from traceback import format_exception
from types import ModuleType, TracebackType
from typing import TYPE_CHECKING, Any, Self, TypeAlias, TypeVar

from orbitdb import __version__
from orbitdb.errors import InputError, WorkError, need_whole
from orbitdb.extras import load

if TYPE_CHECKING:
    from distributed import Client
    from distributed import Future as DaskTask

Answer = TypeVar("Answer")

_AHEAD = 2
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
        """Yield the results of the blocks in order."""
        return (block() for block in blocks)


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
        self._numbers = count()
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

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._end()

    def solved(self, blocks: Iterable[Task[Answer]]) -> Iterator[Answer]:
        """Yield the results of the blocks in order.

        Raises
        ------
        WorkError
            If a process dies.
        """
        left, begun = iter(blocks), deque[int]()
        answers: dict[int, tuple[Answer, Exception | None]] = {}
        while True:
            try:
                begun.extend(map(self._begin, islice(left, _AHEAD * self.jobs + 1 - len(begun))))
                while begun and begun[0] not in answers:
                    answers.update(self._received())
            except (EOFError, OSError):
                raise WorkError(
                    "a worker process died; nothing stored is lost, and the same command continues from "
                    "there: if memory is short, use fewer processes with --jobs"
                ) from None
            if not begun:
                return
            answer, error = answers.pop(begun.popleft())
            if error is not None:
                raise error
            yield answer

    def _begin(self, block: Task[Any]) -> int:
        """Send a block to the process that has the fewest; return its number."""
        number, pipe = next(self._numbers), min(self._unsolved, key=self._unsolved.__getitem__)
        pipe.send((number, block))
        self._unsolved[pipe] += 1
        return number

    def _received(self) -> Iterator[tuple[int, tuple[Any, Exception | None]]]:
        """Wait for results; yield each with the number of its block."""
        ready = connection.wait([*self._unsolved])
        for pipe in (pipe for pipe in self._unsolved if pipe in ready):
            yield pipe.recv()
            self._unsolved[pipe] -= 1


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


SCHEDULER_PATIENCE = 8.0
"""Seconds to wait for an answer from the scheduler of a cluster."""


class Cluster(Workers):
    """Context manager that solves blocks on the workers of a dask cluster, through dask.distributed.

    Workers may come and go; dask repeats the blocks of a worker that is lost. Results stay on the workers
    until they are needed, so the memory of the storing process does not grow with the cluster. (dask's own
    executor, `Client.get_executor`, fetches every result at once, and its futures hang if a result cannot be
    read.)

    Parameters
    ----------
    scheduler : str
        Address of the scheduler, such as ``tcp://host:8786``, or path of the file that it wrote
        (``--scheduler-file``). TLS is set in dask's configuration.

    Attributes
    ----------
    jobs : int
        Number of threads of the workers when the connection was made, at least 1.
    """

    def __init__(self, scheduler: str) -> None:
        self.scheduler = scheduler
        self._client: Client

    def __enter__(self) -> Self:
        """Connect to the scheduler.

        Raises
        ------
        InputError
            If no scheduler answers.
        ModuleNotFoundError
            If dask is not installed (extra ``dask``).
        """
        self._client = _connect(self.scheduler)
        self.jobs = max(self.size()[1], 1)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._client.close()  # the scheduler drops the blocks in progress

    def solved(self, blocks: Iterable[Task[Answer]]) -> Iterator[Answer]:
        """Yield the results of the blocks in order.

        Raises
        ------
        WorkError
            If the connection is lost, or a block kills several workers or cannot be solved.
        """
        left = iter(blocks)
        begun: deque[DaskTask] = deque()
        while True:
            ahead = _AHEAD * max(self.size()[1], 1)  # the number of workers may grow
            begun.extend(map(self._begin, islice(left, ahead + 1 - len(begun))))
            if not begun:
                return
            with _failures():
                version, answer = begun.popleft().result()
            if version != __version__:
                raise WorkError(f"a worker runs orbitdb {version}: install {__version__} there, too")
            yield answer

    def size(self) -> tuple[int, int]:
        """Return the numbers of workers and of all their threads."""
        with _failures():
            threads = self._running().nthreads().values()
        return len(threads), sum(threads)

    def _begin(self, block: Task[Any]) -> "DaskTask":
        with _failures():
            client, task = self._running(), pickle.dumps(partial(_solve_there, block))
            return client.submit(operator.call, client.submit(pickle.loads, task, pure=False), pure=False)

    def _running(self) -> "Client":
        if self._client.status != "running":
            raise ConnectionError  # otherwise a call would wait until the scheduler is back
        return self._client


def _solve_there(block: Task[Any]) -> tuple[str, Any]:
    """Solve a block; return the version of orbitdb and the result.

    The block is sent as bytes. A worker without orbitdb then fails only at this task, and reports it. A task
    that a worker could not even receive would kill that worker, and then the others one by one.
    """
    return __version__, block()


def _connect(scheduler: str) -> "Client":
    load("distributed", "a cluster", "dask")
    import asyncio

    from distributed import Client
    from distributed.comm import connect
    from distributed.security import Security

    async def call(address: str) -> None:
        """Check that a scheduler answers, because Client would hang if some other server answered."""
        call = connect(address, timeout=SCHEDULER_PATIENCE, **security.get_connection_args("client"))
        (await asyncio.wait_for(call, SCHEDULER_PATIENCE)).abort()

    security, address = Security(), _address(scheduler)
    try:
        with ThreadPoolExecutor(1) as apart:  # an event loop may be running here, as in a notebook
            apart.submit(asyncio.run, call(address)).result()
        return Client(address, timeout=SCHEDULER_PATIENCE, security=security, set_as_default=False)
    except Exception as error:
        reason = "" if isinstance(error, OSError) else f" ({_line(error)})"
        raise InputError(
            f"no dask scheduler answers at {address}{reason}: give the address that it shows when it starts, "
            "such as tcp://host:8786, or its --scheduler-file"
        ) from error


def _address(scheduler: str) -> str:
    """Return the address of the scheduler, read from its file if a file is given."""
    if not os.path.isfile(scheduler):
        return scheduler
    try:
        return str(json.loads(Path(scheduler).read_text())["address"])
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise InputError(f"{scheduler} was not written by a dask scheduler") from error


@contextmanager
def _failures() -> Iterator[None]:
    """Say in one line why the cluster did not solve a block."""
    from distributed import KilledWorker

    try:
        yield
    except KilledWorker as error:
        times = error.allowed_failures + 1
        reason = (
            f"workers of the cluster died {times} times on the same block: see their logs; if memory is "
            "short, start fewer on each machine"
        )
    except ModuleNotFoundError as error:
        reason = f"a worker of the cluster cannot start ({_line(error)}): install orbitdb {__version__} there"
    except (CancelledError, OSError):
        reason = (
            "the connection to the dask scheduler was lost; nothing stored is lost: when the scheduler is "
            "back, run the same command again, and it continues from there"
        )
    except Exception as error:
        reason = f"the cluster could not solve a block: {type(error).__name__}: {_line(error)}"
    else:
        return
    raise WorkError(reason)


def _line(error: Exception) -> str:
    return next(iter(str(error).splitlines()), "") or type(error).__name__
