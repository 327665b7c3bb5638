"""Solve blocks in this process, in several processes at once, or on a cluster of machines.

Results come in the order of the blocks. The number of blocks in progress is limited, to limit the memory.
"""

import json
import os
import pickle
import signal
import sys
import threading
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import CancelledError, Future, ProcessPoolExecutor, ThreadPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing import connection, get_context, parent_process, resource_tracker
from pathlib import Path
from types import ModuleType, TracebackType
from typing import TYPE_CHECKING, Any, Self, TypeAlias, TypeVar
from uuid import uuid4

from orbitdb import __version__
from orbitdb.errors import InputError, WorkError
from orbitdb.extras import load

if TYPE_CHECKING:
    from distributed import Client
    from distributed import Future as DaskTask

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
        with _apart():  # it starts Python's tracker of resources
            self._pool = ProcessPoolExecutor(jobs, get_context("spawn"), _begin)

    def __enter__(self) -> Self:
        """Start the processes now, because that takes a few tenths of a second."""
        try:
            for _ in range(self.jobs):
                self._submit(int)
        except BaseException:
            self._end()
            raise
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._end()

    def _end(self) -> None:
        """End all processes without waiting for blocks in progress, or for the rest of a result."""
        for process in self._pool._processes.values():
            process.kill()
        self._pool._result_queue._writer.close()  # type: ignore[attr-defined]
        self._pool.shutdown(cancel_futures=True)

    def _submit(self, block: Task[Answer]) -> Future[Answer]:
        with _apart():  # each call may start a process
            return self._pool.submit(block)

    def solved(self, blocks: Iterable[Task[Answer]]) -> Iterator[Answer]:
        """Yield the results of the blocks in order.

        Raises
        ------
        WorkError
            If a process dies.
        """
        try:
            for future in begun_ahead(map(self._submit, blocks), lambda: _AHEAD * self.jobs):
                while not wait([future], _BETWEEN_LOOKS).done:
                    self._check()
                yield future.result()
        except BrokenProcessPool:
            raise WorkError(
                "a worker process died; nothing stored is lost, and the same command continues from there: "
                "if memory is short, use fewer processes with --jobs"
            ) from None

    def _check(self) -> None:
        """Notice a process that died while sending a result; the pool would wait for the rest of it."""
        if connection.wait([process.sentinel for process in self._pool._processes.values()], 0):
            raise BrokenProcessPool


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


def _begin() -> None:
    """Leave signals to the process that stores the results, and end as soon as it does."""
    for number in _SIGNALS:
        signal.signal(number, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    if (parent := parent_process()) is not None:
        parent.join()
        os._exit(1)


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
        begun = map(self._begun, blocks)
        for task in begun_ahead(begun, lambda: _AHEAD * max(self.size()[1], 1)):
            try:
                version, answer = task.result()
            except Exception as error:
                raise _failure(error) from error
            if version != __version__:
                raise WorkError(f"a worker runs orbitdb {version}: install {__version__} there, too")
            yield answer

    def size(self) -> tuple[int, int]:
        """Return the numbers of workers and of all their threads."""
        try:
            threads = self._running().nthreads().values()
        except Exception as error:
            raise _failure(error) from error
        return len(threads), sum(threads)

    def _begun(self, block: Task[Any]) -> "DaskTask":
        try:
            return self._running().submit(pickle.loads, pickle.dumps(_Call(block)), key=f"orbitdb-{uuid4()}")
        except Exception as error:
            raise _failure(error) from error

    def _running(self) -> "Client":
        if self._client.status != "running":
            raise ConnectionError  # otherwise a call would wait until the scheduler is back
        return self._client


class _Call:
    """A block that is solved by unpickling it.

    A worker without orbitdb then fails only at this task, and reports it. A task that a worker could not even
    receive would kill that worker, and then the others one by one.
    """

    def __init__(self, block: Task[Any]) -> None:
        self.block = block

    def __reduce__(self) -> tuple[Callable[[Task[Any]], tuple[str, Any]], tuple[Task[Any]]]:
        return _solve_there, (self.block,)


def _solve_there(block: Task[Any]) -> tuple[str, Any]:
    """Solve a block; return the version of orbitdb and the result."""
    return __version__, block()


def _connect(scheduler: str) -> "Client":
    load("distributed", "a cluster", "dask")
    import asyncio

    from distributed import Client
    from distributed.comm import connect
    from distributed.security import Security

    async def call(address: str) -> None:
        """Check that a scheduler answers, because Client would hang if some other server answered."""
        arguments = security.get_connection_args("client")
        comm = await asyncio.wait_for(
            connect(address, timeout=SCHEDULER_PATIENCE, **arguments), SCHEDULER_PATIENCE
        )
        comm.abort()

    security = Security()
    address = _address(scheduler)
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


def _failure(error: Exception) -> WorkError:
    """Return an error that says why the cluster did not solve a block."""
    from distributed import KilledWorker

    if isinstance(error, KilledWorker):
        times = error.allowed_failures + 1
        return WorkError(
            f"workers of the cluster died {times} times on the same block: see their logs; if memory is "
            "short, start fewer on each machine"
        )
    if isinstance(error, ModuleNotFoundError):
        return WorkError(
            f"a worker of the cluster cannot start ({_line(error)}): install orbitdb {__version__} there"
        )
    if isinstance(error, CancelledError | OSError):
        return WorkError(
            "the connection to the dask scheduler was lost; nothing stored is lost: when the scheduler is "
            "back, run the same command again, and it continues from there"
        )
    return WorkError(f"the cluster could not solve a block: {type(error).__name__}: {_line(error)}")


def _line(error: Exception) -> str:
    return next(iter(str(error).splitlines()), "") or type(error).__name__
