"""Where fills and sweeps are solved: in this process, in several, or on a dask cluster, as options say."""

import logging
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from enum import StrEnum
from typing import TYPE_CHECKING, Annotated, Self

import typer

from orbitdb.cli.endings import with_other_processes
from orbitdb.cli.options import count_option
from orbitdb.cli.render import note
from orbitdb.errors import InputError

if TYPE_CHECKING:
    from orbitdb.filling.cluster import Cluster, Size
    from orbitdb.filling.workers import Workers

MOST_JOBS = 1024
WORTH_PROCESSES = 400_000
"""Sequences from which on starting further processes pays."""


class Executor(StrEnum):
    """Whose processes solve."""

    PROCESSES = "processes"
    DASK = "dask"


Jobs = Annotated[
    int | None, count_option("--jobs", help="Processes that solve [default: all cores where it pays].")
]
ExecutorOption = Annotated[
    Executor | None,
    typer.Option("--executor", help="Solve in processes here [default], or on a dask cluster."),
]
Scheduler = Annotated[
    str | None,
    typer.Option(
        "--scheduler", metavar="ADDRESS|FILE", help="The scheduler of the dask cluster, or its file."
    ),
]
DryRun = Annotated[bool, typer.Option("--dry-run", help="Only say what would be done.")]


@dataclass(frozen=True)
class Solvers:
    """Where a fill is solved.

    Attributes
    ----------
    jobs : int or None
        Number of processes here; None for as many as pay.
    scheduler : str or None
        The dask cluster that solves instead: address of its scheduler, or the scheduler's file.
    """

    jobs: int | None
    scheduler: str | None

    @classmethod
    def chosen(cls, executor: Executor | None, scheduler: str | None, jobs: int | None) -> Self:
        """Return what the options say; an address alone means dask.

        Raises
        ------
        InputError
            If they contradict one another, or say too little.
        """
        if scheduler is not None and executor is Executor.PROCESSES:
            raise InputError("--scheduler is for --executor dask: leave one of them out")
        if scheduler is None and executor is Executor.DASK:
            raise InputError(
                "--executor dask: say where its scheduler is, such as --scheduler tcp://host:8786, or "
                "--scheduler scheduler.json, its file"
            )
        if scheduler is not None and jobs is not None:
            raise InputError("--jobs counts processes here, a dask cluster has its own: leave out --jobs")
        if jobs is not None and not 1 <= jobs <= MOST_JOBS:
            raise InputError(f"{jobs} jobs: give a number from 1 to {MOST_JOBS}")
        return cls(jobs, scheduler)

    def number(self) -> int:
        """Return how many processes a fill may count on; a cluster has always enough of them."""
        from orbitdb.filling.workers import cores

        return MOST_JOBS if self.scheduler else self.jobs or cores()

    @contextmanager
    def at_work(self, sequences: int, a_block: int) -> "Iterator[Workers]":
        """Start what solves so many sequences, or connect to it; end it after use.

        What is no more than a block is solved here, whoever else may be there.
        """
        from orbitdb.filling.workers import HERE, Processes, cores

        if self.scheduler is not None:
            with with_other_processes(), _quiet_dask(), _cluster(self.scheduler) as cluster:
                yield cluster
            return
        count = self.jobs or (cores() if sequences >= WORTH_PROCESSES else 1)
        if count == 1 or sequences <= a_block:
            yield HERE
            return
        with with_other_processes(), Processes(count) as processes:
            processes.start()
            yield processes


@contextmanager
def _cluster(scheduler: str) -> "Iterator[Cluster]":
    """Connect to a cluster and say what it has."""
    from orbitdb.filling.cluster import Cluster

    with Cluster(scheduler) as cluster:
        note(f"{scheduler}: {_told(cluster.size())}")
        yield cluster


def _told(size: "Size") -> str:
    """Say how large a cluster is, and where that is less than it seems."""
    if not size.workers:
        return "no workers yet; waiting for the first"
    if size.threads > size.workers:
        return (
            f"{size.workers} workers with {size.threads} threads; each solves with one of them: start more "
            "with --nthreads 1"
        )
    return f"{size.workers} workers"


@contextmanager
def _quiet_dask() -> Iterator[None]:
    """Keep dask's log off stderr: what goes wrong is told in one line."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        logging.disable()
        try:
            yield
        finally:
            logging.disable(logging.NOTSET)
