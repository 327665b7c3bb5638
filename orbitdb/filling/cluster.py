"""Solve blocks on a cluster of machines, through dask.distributed."""

import json
import operator
import os
import pickle
from collections.abc import Iterator
from concurrent.futures import CancelledError, ThreadPoolExecutor
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

from orbitdb import __version__
from orbitdb.display import load
from orbitdb.errors import InputError, WorkError
from orbitdb.filling.workers import AHEAD, Task, Workers

if TYPE_CHECKING:
    from distributed import Client
    from distributed import Future as DaskTask

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

    def __exit__(self, *error: object) -> None:
        self._client.close()  # the scheduler drops the blocks in progress

    def size(self) -> tuple[int, int]:
        """Return the numbers of workers and of all their threads."""
        with _failures():
            threads = self._running().nthreads().values()
        return len(threads), sum(threads)

    def _ahead(self) -> int:
        return AHEAD * max(self.size()[1], 1)  # the number of workers may grow

    def _begin(self, block: Task[Any]) -> "DaskTask":
        with _failures():
            client, task = self._running(), pickle.dumps(partial(_solve_there, block))
            return client.submit(operator.call, client.submit(pickle.loads, task, pure=False), pure=False)

    def _result(self, begun: "DaskTask") -> Any:
        with _failures():
            version, answer = begun.result()
        if version != __version__:
            raise WorkError(f"a worker runs orbitdb {version}: install {__version__} there, too")
        return answer

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
    if ":" in scheduler and not os.path.isfile(scheduler):
        return scheduler
    try:
        return str(json.loads(Path(scheduler).read_text())["address"])
    except FileNotFoundError:
        raise InputError(
            f"there is no file {scheduler}: give the scheduler's file, or its address such as tcp://host:8786"
        ) from None
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
