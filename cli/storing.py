"""Helpers for the commands that store data: periods, schema, estimates, and where to solve."""

import logging
import os
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from orbitdb.cli.options import count_option, refuse_idle
from orbitdb.cli.output import note, progress
from orbitdb.errors import InputError
from orbitdb.text import several

if TYPE_CHECKING:
    from orbitdb.filling.estimate import Need
    from orbitdb.filling.workers import Workers
    from orbitdb.store.file import Migration


def bring(path: Path) -> "Migration":
    """Create a catalogue, or upgrade an older one to the latest schema and say so."""
    from orbitdb.store.file import migrate

    with progress("updating the catalogue to the latest schema"):
        done = migrate(path)
    if 0 < done.before < done.after:
        note(f"{path}: schema {done.before} -> {done.after}")
    return done


def asked_periods(context: typer.Context, p: str, first: int) -> tuple[int, ...]:
    """Return the periods of --p and --from in ascending order; refuse periods that cannot be filled."""
    from orbitdb.store.selection import fillable, periods_up_to

    if "-" in p[1:] or "," in p:
        refuse_idle(context, f"with --p {p}", "first")
    spans = periods_up_to(p, first)
    periods = fillable(spans)
    if not periods:
        raise InputError(f"--from {first} is above --p {p}: give --from {p} or less")
    return periods


def written(periods: Sequence[int]) -> str:
    """Format periods given in ascending order, as a range if there is no gap."""
    gapless = 1 < len(periods) == periods[-1] - periods[0] + 1
    return f"{periods[0]}..{periods[-1]}" if gapless else ", ".join(map(str, periods))


def announce(span: str, coming: "Need", db: Path, dry_run: bool) -> None:
    """Write a note with the estimate for a large fill or sweep; with --dry-run, for any."""
    from orbitdb.filling.estimate import LARGE, about
    from orbitdb.text import gigabytes

    if dry_run or coming.words >= LARGE:
        room = f" and {gigabytes(coming.bytes)}" if coming.bytes else ""
        note(f"{span}: {several(coming.words, 'word')} to solve, {about(coming.seconds)}{room}, in {db}")


_HIGHEST = typer.Option("--p", metavar="PERIODS", help="The highest period, or periods such as 2-8.")
Highest = Annotated[str, _HIGHEST]
SomeHighest = Annotated[str | None, _HIGHEST]
Lowest = Annotated[int, count_option("--from", help="The lowest period.")]
"""`asked_periods` reads --p and --from together."""

_MOST_JOBS = 1024

_JOBS = "Number of worker processes [default: one per core if there is enough work]."
Jobs = Annotated[int | None, count_option("--jobs", least=1, most=_MOST_JOBS, help=_JOBS)]
DryRun = Annotated[bool, typer.Option("--dry-run", help="Only say what would be done.")]


@dataclass(frozen=True)
class Solvers:
    """The options that say where to solve: in local processes, or on a dask cluster."""

    jobs: Jobs = None
    scheduler: Annotated[
        str | None,
        typer.Option(
            metavar="ADDRESS|FILE", help="Solve on the dask cluster with this scheduler (address or file)."
        ),
    ] = None

    def __post_init__(self) -> None:
        if self.scheduler is not None and self.jobs is not None:
            raise InputError("--jobs is for local processes; a dask cluster has its own: leave out --jobs")

    def number(self) -> int:
        """Return the number of processes that estimates assume; for a cluster, the maximum."""
        from orbitdb.filling.workers import number_of

        return _MOST_JOBS if self.scheduler else number_of(self.jobs)

    @contextmanager
    def cluster(self) -> "Iterator[Workers | None]":
        """Connect to the dask cluster, if one is given; yield it, or None."""
        if self.scheduler is None:
            yield None
            return
        from orbitdb.filling.cluster import Cluster

        with _quiet_dask(), Cluster(os.path.expanduser(self.scheduler)) as cluster:
            workers, threads = cluster.size()
            size = f"{several(workers, 'worker')} with {several(threads, 'thread')}"
            note(f"{self.scheduler}: {size if workers else 'no workers yet; waiting for the first'}")
            yield cluster


@contextmanager
def _quiet_dask() -> Iterator[None]:
    """Keep dask's log off stderr; the command reports failures in one line."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        logging.disable()
        try:
            yield
        finally:
            logging.disable(logging.NOTSET)
