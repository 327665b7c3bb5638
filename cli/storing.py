"""What commands that store share: the periods asked for, the newest schema, progress, and who solves."""

import logging
import warnings
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from orbitdb.cli.options import count_option, refuse_idle
from orbitdb.cli.progress import Progress, progress
from orbitdb.cli.render import note
from orbitdb.errors import InputError
from orbitdb.numerals import whole
from orbitdb.plaintext import several

if TYPE_CHECKING:
    from orbitdb.filling.estimate import Need
    from orbitdb.filling.resuming import Progress as Step
    from orbitdb.filling.workers import Workers
    from orbitdb.store.file.migrate import Migration

_LEAST = 2
"""No orbit has fewer bounces."""


def bring(path: Path) -> "Migration":
    """Make a catalogue, or bring an older one to the newest schema and say where its copy is."""
    from orbitdb.store.file.migrate import migrate

    with progress("bringing the catalogue to the newest schema"):
        done = migrate(path)
    if done.backup is not None:
        note(f"{path}: schema {done.before} -> {done.after}; a copy of the old file is in {done.backup}")
    return done


def asked_periods(context: typer.Context, p: str, first: int) -> tuple[int, ...]:
    """Return the periods that --p and --from ask for, in rising order, or refuse what cannot be filled."""
    from orbitdb.store.asking.parsing import parse_periods
    from orbitdb.symbols.enumeration import MAX_PERIOD

    if "-" in p[1:] or "," in p:
        refuse_idle(context, f"with --p {p}", "first")
        spans = parse_periods(p)
    else:
        try:
            spans = ((first, whole(p)),)
        except ValueError:
            raise InputError(f"--p {p!r:.40}: write periods as 11, 2-8 or 2,3,5-7") from None
    for low, high in spans:
        if (least := min(low, high)) < _LEAST:
            raise InputError(f"period {least}: the least period is {_LEAST}")
        if (most := max(low, high)) > MAX_PERIOD:
            raise InputError(f"period {most}: the highest period is {MAX_PERIOD}")
        if low > high:
            raise InputError(f"periods {low} to {high} run backwards: give --from {high} or less")
    return tuple(sorted({p for low, high in spans for p in range(low, high + 1)}))


def written(periods: Sequence[int]) -> str:
    """Write periods in rising order, as a range if none is left out."""
    gapless = len(periods) == periods[-1] - periods[0] + 1
    return f"{periods[0]}..{periods[-1]}" if gapless else ", ".join(map(str, periods))


def announce(span: str, coming: "Need", db: Path, dry_run: bool) -> None:
    """Say what a large fill or sweep is going to take, and what any would take that is not to be done."""
    from orbitdb.filling.estimate import LARGE, about, gigabytes

    if dry_run or coming.words >= LARGE:
        room = f" and {gigabytes(coming.bytes)}" if coming.bytes else ""
        note(f"{span}: {several(coming.words, 'word')} to come, {about(coming.seconds)}{room}, in {db}")


def show_steps(
    shown: Progress, steps: "Iterable[Step]", what: str, totals: Mapping[int, int], known: int = 0
) -> None:
    """Take the steps of a fill, and show how far all its periods are, of which some words were known."""
    total = sum(totals.values())
    shown.tell(what, known, total)
    for step in steps:
        before = sum(count for p, count in totals.items() if p < step.p)
        shown.tell(f"{what}, p = {step.p:>2} of {max(totals)}", before + step.words, total)


_MOST_JOBS = 1024
_WORTH_PROCESSES = 1.0
"""Seconds of work from which on starting further processes pays."""
_STARTING = 0.1
"""Seconds of work that starting further processes takes, about."""

_JOBS = "Worker processes [default: all cores if there is enough work]."
Jobs = Annotated[int | None, count_option("--jobs", least=1, most=_MOST_JOBS, help=_JOBS)]
DryRun = Annotated[bool, typer.Option("--dry-run", help="Only say what would be done.")]


@dataclass(frozen=True)
class Solvers:
    """The options that say where is solved: in processes here, or on a dask cluster.

    They are refused if they contradict one another, or say too little.
    """

    jobs: Jobs = None
    executor: Annotated[
        Literal["processes", "dask"] | None,
        typer.Option(help="Solve in processes here [default], or on a dask cluster."),
    ] = None
    scheduler: Annotated[
        str | None,
        typer.Option(metavar="ADDRESS|FILE", help="The scheduler of the dask cluster, or its file."),
    ] = None

    def __post_init__(self) -> None:
        if self.scheduler is not None and self.executor == "processes":
            raise InputError("--scheduler is for --executor dask: leave one of them out")
        if self.scheduler is None and self.executor == "dask":
            raise InputError(
                "--executor dask: say where its scheduler is, such as --scheduler tcp://host:8786, or "
                "--scheduler scheduler.json, its file"
            )
        if self.scheduler is not None and self.jobs is not None:
            raise InputError("--jobs counts processes here, a dask cluster has its own: leave out --jobs")

    def number(self) -> int:
        """Return how many processes a fill may count on; a cluster has always enough of them."""
        from orbitdb.filling.workers import cores

        return _MOST_JOBS if self.scheduler else self.jobs or cores()

    @contextmanager
    def at_work(self, seconds: float) -> "Iterator[Workers]":
        """Start what does the work of so many seconds, about, or connect to it; end it after use.

        Work that takes no longer than starting does is done here, whatever is asked for.
        """
        from orbitdb.filling.workers import HERE, Processes, cores

        if self.scheduler is not None:
            from orbitdb.filling.cluster import Cluster

            with _quiet_dask(), Cluster(self.scheduler) as cluster:
                note(f"{self.scheduler}: {_told(*cluster.size())}")
                yield cluster
            return
        count = self.jobs or (cores() if seconds >= _WORTH_PROCESSES else 1)
        if count == 1 or seconds < _STARTING:
            yield HERE
            return
        with Processes(count) as processes:
            yield processes


def _told(workers: int, threads: int) -> str:
    """Say how large a cluster is, and where that is less than it seems."""
    if not workers:
        return "no workers yet; waiting for the first"
    if threads > workers:
        return (
            f"{workers} workers with {threads} threads; each solves with one of them: start more "
            "with --nthreads 1"
        )
    return f"{workers} workers"


@contextmanager
def _quiet_dask() -> Iterator[None]:
    """Keep dask's log off stderr: the command says in one line what goes wrong."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        logging.disable()
        try:
            yield
        finally:
            logging.disable(logging.NOTSET)
