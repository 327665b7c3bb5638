"""Blocks solved on a cluster of machines, through dask.distributed.

Results stay on the workers until they are wanted: what is kept in the memory of the process that stores does
not grow with the cluster. (The executor that dask's client offers, `get_executor`, fetches every result as
soon as there is one, and its futures wait for ever if a result cannot be read.)
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
from orbitdb.filling.workers import Result, Task, Workers, answered, begun_ahead

if TYPE_CHECKING:
    from distributed import Client
    from distributed import Future as DaskTask

_AHEAD = 2
"""Blocks under way for each thread of the cluster, so that none waits for the writer."""

PATIENCE = 8.0
"""Seconds until a scheduler must have answered."""

_one_at_a_time = threading.Lock()


class Cluster(Workers):
    """Solves blocks on the workers of a dask cluster; to be used as a context.

    Workers may come and go. dask begins again with the blocks of one that is lost.

    Parameters
    ----------
    scheduler : str
        Address of its scheduler, such as ``tcp://host:8786``, or path of the file that the scheduler
        has written (``--scheduler-file``). TLS is used as dask's configuration says.

    Attributes
    ----------
    jobs : int
        Processes that it had when it was connected to, or 1.
    """

    def __init__(self, scheduler: str) -> None:
        self.scheduler = scheduler
        self._client: Client

    def __enter__(self) -> Self:
        """Connect to the scheduler.

        Raises
        ------
        InputError
            If there is none, or dask is not installed.
        """
        self._client = _connect(self.scheduler)
        self.jobs = max(self.size()[0], 1)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._client.close()  # the scheduler forgets the blocks that are under way

    def solved(self, blocks: Iterable[Task[Result]]) -> Iterator[Result]:
        """Yield what became of blocks, in their order.

        Raises
        ------
        WorkError
            If the connection is lost, a block kills worker after worker, or workers cannot solve.
        """
        begun = map(self._begun, blocks)
        for task in begun_ahead(begun, lambda: _AHEAD * max(self.size()[1], 1)):
            try:
                version, found = task.result()
            except Exception as error:
                raise _failure(error) from error
            yield answered(version, found)

    def size(self) -> tuple[int, int]:
        """Count the workers there are, each of which solves one block at a time, and their threads."""
        try:
            threads = self._running().nthreads().values()
        except Exception as error:
            raise _failure(error) from error
        return len(threads), sum(threads)

    def _begun(self, block: Task[Any]) -> "DaskTask":
        """Begin with a block."""
        try:
            return self._running().submit(pickle.loads, pickle.dumps(_Call(block)), key=f"orbitdb-{uuid4()}")
        except Exception as error:
            raise _failure(error) from error

    def _running(self) -> "Client":
        if self._client.status != "running":
            raise ConnectionError  # else a question would wait for the scheduler to come back
        return self._client


class _Call:
    """A block that is solved where it is unpickled.

    So a worker that has no orbitdb fails at one task and can say so; a task that it cannot even receive
    would end it, and every other worker behind it.
    """

    def __init__(self, block: Task[Any]) -> None:
        self.block = block

    def __reduce__(self) -> tuple[Callable[[Task[Any]], tuple[str, Any]], tuple[Task[Any]]]:
        return _solve_alone, (self.block,)


def _solve_alone(block: Task[Any]) -> tuple[str, Any]:
    """Solve a block while no other thread of this process does: ball arithmetic's precision is shared.

    Return also the version of this orbitdb.
    """
    with _one_at_a_time:
        return __version__, block()


def _connect(scheduler: str) -> "Client":
    try:
        from distributed import Client
        from distributed.comm import connect
        from distributed.security import Security
    except ImportError as error:
        raise InputError(f"{error}: to work on a cluster, pip install 'orbitdb[dask]'") from error

    async def call(address: str) -> None:
        """Call the scheduler; Client would wait for ever for a server of another kind to speak."""
        arguments = security.get_connection_args("client")
        comm = await asyncio.wait_for(connect(address, timeout=PATIENCE, **arguments), PATIENCE)
        comm.abort()

    security = Security()
    address = _address(scheduler)
    try:
        with ThreadPoolExecutor(1) as apart:  # here an event loop may be running, as in a notebook
            apart.submit(asyncio.run, call(address)).result()
        return Client(address, timeout=PATIENCE, security=security, set_as_default=False)
    except Exception as error:
        reason = "" if isinstance(error, OSError) else f" ({_line(error)})"
        raise InputError(
            f"no dask scheduler answers at {address}{reason}: give the address that it shows when it starts, "
            "such as tcp://host:8786, or its --scheduler-file"
        ) from error


def _address(scheduler: str) -> str:
    """Return the address that a scheduler's file holds, or the address given."""
    if not os.path.isfile(scheduler):
        return scheduler
    try:
        return str(json.loads(Path(scheduler).read_text())["address"])
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise InputError(f"{scheduler} is not a file that a dask scheduler has written") from error


def _failure(error: Exception) -> WorkError:
    """Say why the cluster has not solved a block."""
    from distributed import KilledWorker

    if isinstance(error, KilledWorker):
        times = error.allowed_failures + 1
        return WorkError(
            f"workers of the cluster died {times} times on one block: see their logs; if memory is short, "
            "start fewer on a machine"
        )
    if isinstance(error, ModuleNotFoundError):
        return WorkError(
            f"a worker of the cluster cannot start ({_line(error)}): install orbitdb {__version__} there"
        )
    if isinstance(error, CancelledError | OSError):
        return WorkError(
            "the connection to the dask scheduler is lost; what was stored is safe: run the same command "
            "again when the scheduler is back, and it goes on from there"
        )
    return WorkError(f"the cluster could not solve a block: {type(error).__name__}: {_line(error)}")


def _line(error: Exception) -> str:
    """Return what an error says, in one line."""
    return next(iter(str(error).splitlines()), "") or type(error).__name__
