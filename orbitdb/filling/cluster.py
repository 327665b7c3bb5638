"""Solve blocks on a cluster of machines, through dask.distributed.

Results stay on the workers until they are needed, so the memory of the storing process does not grow with the
cluster. (dask's own executor, `Client.get_executor`, fetches every result at once, and its futures hang if a
result cannot be read.)
"""

import asyncio
import json
import os
import pickle
import threading
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import CancelledError, ThreadPoolExecutor
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self
from uuid import uuid4

from orbitdb import __version__
from orbitdb.errors import InputError, WorkError
from orbitdb.extras import load
from orbitdb.filling.workers import Answer, Task, Workers, begun_ahead

if TYPE_CHECKING:
    from distributed import Client
    from distributed import Future as DaskTask

_AHEAD = 2
"""Number of blocks in progress per thread of the cluster, so that no thread waits for the writer."""

PATIENCE = 8.0
"""Seconds to wait for an answer from the scheduler."""

_one_at_a_time = threading.Lock()


class Cluster(Workers):
    """Context manager that solves blocks on the workers of a dask cluster.

    Workers may come and go; dask repeats the blocks of a worker that is lost.

    Parameters
    ----------
    scheduler : str
        Address of the scheduler, such as ``tcp://host:8786``, or path of the file that it wrote
        (``--scheduler-file``). TLS is set in dask's configuration.

    Attributes
    ----------
    jobs : int
        Number of workers when the connection was made, at least 1.
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
        self.jobs = max(self.size()[0], 1)
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
        """Return the numbers of workers and of all their threads; each worker solves one block at a time."""
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
        return _solve_alone, (self.block,)


def _solve_alone(block: Task[Any]) -> tuple[str, Any]:
    """Solve a block while no other thread does; return the version of orbitdb and the result.

    Threads must take turns, because they share the precision of ball arithmetic.
    """
    with _one_at_a_time:
        return __version__, block()


def _connect(scheduler: str) -> "Client":
    load("distributed", "a cluster", "dask")
    from distributed import Client
    from distributed.comm import connect
    from distributed.security import Security

    async def call(address: str) -> None:
        """Check that a scheduler answers, because Client would hang if some other server answered."""
        arguments = security.get_connection_args("client")
        comm = await asyncio.wait_for(connect(address, timeout=PATIENCE, **arguments), PATIENCE)
        comm.abort()

    security = Security()
    address = _address(scheduler)
    try:
        with ThreadPoolExecutor(1) as apart:  # an event loop may be running here, as in a notebook
            apart.submit(asyncio.run, call(address)).result()
        return Client(address, timeout=PATIENCE, security=security, set_as_default=False)
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
            "the connection to the dask scheduler was lost; what was stored is safe: when the scheduler is "
            "back, run the same command again, and it continues from there"
        )
    return WorkError(f"the cluster could not solve a block: {type(error).__name__}: {_line(error)}")


def _line(error: Exception) -> str:
    return next(iter(str(error).splitlines()), "") or type(error).__name__
