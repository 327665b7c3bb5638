"""``orbitdb fill``, ``sweep`` and ``births``: orbits, sums over them, and their births."""

import logging
import os
import time
import warnings
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from operator import attrgetter
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from orbitdb.cli import options
from orbitdb.cli.notes import confirm, note, notes, progress
from orbitdb.cli.options import MOST_JOBS, Database, HalfLength, Jobs, takes_only
from orbitdb.cli.output import Output, code_text
from orbitdb.cli.snapshots import bring, given_a, given_codes, primitive_words
from orbitdb.errors import InputError
from orbitdb.text import format_float, gigabytes, several

if TYPE_CHECKING:
    from orbitdb.catalogue import Catalogue
    from orbitdb.filling.estimate import Need
    from orbitdb.filling.workers import Workers


EXAMPLES = {
    "fill": (
        "fill --p 11",
        "fill --p 12-13 --a 1",
        "fill --p 15 --jobs 4",
        "fill --p 10 --method relaxation --scheduler tcp://node1:8786",
        "fill --code '1^20(02)^5 3'",
    ),
    "sweep": (
        "sweep --p 16",
        "sweep --p 12 --a 1 --json",
        "sweep --p 12-14 --jobs 2",
        "sweep --p 19 --scheduler tcp://node1:8786",
    ),
    "births": ("births --p 11", "births --json", "births --deaths"),
}


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

    def number(self) -> int | None:
        """Return the number of processes that estimates assume; for a cluster, the maximum."""
        return MOST_JOBS if self.scheduler else self.jobs

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


def written(periods: Sequence[int]) -> str:
    """Format periods given in ascending order, as a range if there is no gap."""
    gapless = 1 < len(periods) == periods[-1] - periods[0] + 1
    return f"{periods[0]}..{periods[-1]}" if gapless else ", ".join(map(str, periods))


def planned(
    periods: Sequence[int], a: float | None, solvers: Solvers, db: Path, dry_run: bool, **how: Any
) -> "tuple[Catalogue, str, Need]":
    """Return a catalogue, what is to be done in it, and what that takes (`Catalogue.estimate`).

    A large fill or sweep is announced. With --dry-run, any is.
    """
    from orbitdb.catalogue import Catalogue
    from orbitdb.filling.estimate import LARGE, about

    (at,) = given_a(db, a)
    catalogue, span = Catalogue(db, at, missing_ok=True), f"p = {written(periods)} at a = {format_float(at)}"
    coming = catalogue.estimate(periods, jobs=solvers.number(), **how)
    if dry_run or coming.words >= LARGE:
        room = f" and up to {gigabytes(coming.bytes)}" if coming.bytes else ""
        note(f"{span}: {several(coming.words, 'word')} to solve, {about(coming.seconds)}{room}, in {db}")
    return catalogue, span, coming


def _announce_pruned(span: str, coming: "Need", db: Path, yes: bool) -> None:
    """Say how many geometrically pruned words will be stored; ask whether to store very many."""
    from orbitdb.filling.estimate import MANY_PRUNED, about

    words, room = several(coming.words, "geometrically pruned word"), gigabytes(coming.bytes)
    note(f"{span}: {words} to store, {about(coming.seconds)} and up to {room}, in {db}")
    if coming.words >= MANY_PRUNED and not yes:
        confirm(f"store {words}, up to {room}, in {db}", "nothing was stored")


@contextmanager
def working(
    catalogue: "Catalogue", db: Path, solvers: Solvers, span: str, seconds: float
) -> Iterator[dict[str, Any]]:
    """Yield the arguments of `Catalogue.fill` and `.sweep` that say who solves and what shows progress."""
    warn_of(catalogue)
    with solvers.cluster() as workers:
        bring(db)
        with progress(span, expected=seconds) as shown:
            yield {"jobs": solvers.jobs, "workers": workers, "progress": shown}


def warn_of(catalogue: "Catalogue") -> None:
    """Note why the file should be filled elsewhere, if it should."""
    if catalogue.warning:
        note(catalogue.warning)


def fill(
    *,
    context: typer.Context,
    p: options.SomePeriodsToMake = None,
    a: HalfLength = None,
    code: Annotated[
        list[str] | None, typer.Option(help="Store only this word; repeatable; - reads words from stdin.")
    ] = None,
    geometric: Annotated[
        bool,
        typer.Option(
            "--geometric", help="Also store the geometrically pruned words, with the rules they break."
        ),
    ] = False,
    method: Annotated[
        Literal["newton", "relaxation"],
        typer.Option(help="How to solve; relaxation is the paper's way, slow."),
    ] = "newton",
    solvers: Solvers,
    dry_run: DryRun = False,
    yes: options.Yes = False,
    db: Database,
) -> None:
    """Fill a catalogue with all words of the given periods, and the orbits among them.

    An interrupted fill continues where it stopped; finished periods are skipped. --geometric first says how
    many words it stores, and asks if there are ten million or more.
    """
    from orbitdb.period_ranges import periods_to_make
    from orbitdb.symbols.pruning import count_pruned

    if code:
        takes_only(context, "with --code", "code", "a", "method", "dry_run")
        _fill_words(code, a, method, db, dry_run)
        return
    if p is None:
        raise InputError("say what to fill: --p 11 for the periods up to 11, or --code 1232131 for one word")
    periods = periods_to_make(p)
    if yes and not geometric:
        raise InputError("--yes answers the question of --geometric: leave out --yes")
    catalogue, span, coming = planned(periods, a, solvers, db, dry_run, method=method)
    needs = [coming]
    if geometric:
        needs.append(catalogue.estimate(periods, jobs=solvers.number(), geometric=True))
        _announce_pruned(span, needs[-1], db, yes or dry_run)
    if dry_run:
        return
    catalogue._check_room(*needs)
    start = time.monotonic()
    with working(catalogue, db, solvers, span, sum(need.seconds for need in needs)) as work:
        fills = catalogue.fill(periods, geometric=geometric, method=method, **work)
    pruned = sum(map(count_pruned, periods))
    n_t, n_c = (sum(getattr(fill, name) or 0 for fill in fills) for name in ("n_t", "n_c"))
    stored = f"{several(n_t, 'word')}, {several(n_c, 'orbit')}"
    stored += f", {several(pruned, 'geometrically pruned word')}" if geometric else ""
    note(f"{span}: {stored}, {time.monotonic() - start:.1f} s, in {db}")


_FEW_WORDS = 10
"""Up to this many words have a line each; more, or those from stdin, have one summary."""


def _fill_words(codes: Sequence[str], a: float | None, method: str, db: Path, dry_run: bool) -> None:
    from orbitdb.catalogue import Catalogue

    (at,) = given_a(db, a)
    words, start = primitive_words(given_codes(codes)), time.monotonic()
    if dry_run:
        note(f"{several(len(words), 'word')} to solve at a = {format_float(at)}, in {db}")
        return
    if not words:
        note("stdin contains no code")
        return
    bring(db)
    orbits = Catalogue(db, at).fill(code=words, method=method)
    if len(words) <= _FEW_WORDS and "-" not in codes:
        for orbit in orbits:
            kept = "" if orbit.stored else "; not stored"
            note(f"{code_text(orbit.code)}: {orbit.status.sentence}{kept}")
        return
    counts = Counter(orbit.status for orbit in orbits).most_common()
    by_status = ", ".join(f"{count} {status}" for status, count in counts)
    left = sum(not orbit.stored for orbit in orbits)
    stored = f"{by_status}{f', {left} not stored' if left else ''}"
    note(f"{several(len(words), 'word')}: {stored}, {time.monotonic() - start:.1f} s, in {db}")


def sweep(
    *,
    p: options.PeriodsToMake,
    a: HalfLength = None,
    solvers: Solvers,
    dry_run: DryRun = False,
    output: Output,
    db: Database,
) -> None:
    """Count the orbits of further periods and compute the sums that averages need, without storing rows.

    'orbitdb table', 'entropy' and 'lyapunov' use a sweep for periods that are not filled. A sweep takes less
    time than a fill and hardly any disk space. If interrupted, it continues where it stopped; periods that
    are swept or filled are skipped.
    """
    from orbitdb.period_ranges import periods_to_make, written_periods

    periods = periods_to_make(p)
    catalogue, span, coming = planned(periods, a, solvers, db, dry_run, sweep=True)
    if dry_run:
        return
    start = time.monotonic()
    with working(catalogue, db, solvers, span, coming.seconds) as work:
        sweeps = catalogue.sweep(periods, **work)
    note(f"{span}: {several(coming.words, 'word')}, {time.monotonic() - start:.1f} s, in {db}")
    rows = [sweep.row() for sweep in sweeps]
    if filled := sorted(set(periods).difference(row["p"] for row in rows)):
        note(f"{written_periods(filled)} at a = {format_float(catalogue.a)}: filled, so no sweep is needed")
    if rows:
        output.write(list(rows[0]), ([*row.values()] for row in rows))


BIRTH_COLUMNS = ("p", "classes", "births", "deaths", "always", "least", "largest")


def births(
    *,
    context: typer.Context,
    p: options.SomePeriodsToMake = None,
    deaths: Annotated[
        bool, typer.Option("--deaths", help="List the lives that end, one per line, instead of the periods.")
    ] = False,
    jobs: Jobs = None,
    output: Output,
    db: options.Database,
) -> None:
    """Find the values of a at which each word begins or ceases to be an orbit.

    The result is stored and shown, one row per period. classes is the number of symmetry classes, births the
    number of times that one of them begins to be an orbit, and deaths the number of classes that cease to be
    orbits at least once. always counts the classes that are orbits down to a = 0. least and largest are the
    smallest and the largest a of a birth. An interrupted run continues where it stopped. Without --p, you see
    the births that are stored.
    """
    from orbitdb.answers.results import ENDED
    from orbitdb.catalogue import Catalogue
    from orbitdb.period_ranges import LEAST_PERIOD, periods_to_make
    from orbitdb.symbols.enumeration import MAX_PERIOD

    periods: Sequence[int]
    if p is None:
        options.refuse_idle(context, "without --p", "jobs")
        periods = range(LEAST_PERIOD, MAX_PERIOD + 1)
    else:
        periods = periods_to_make(p)
        _fill_births(periods, db, jobs)
    with Catalogue(db).snapshot() as then:
        fills = [fill for fill in then.birth_fills() if fill.p in periods]
        whole = [fill for fill in fills if fill.done]
        ended = [row for fill in whole for row in then.births(fill.p).ended()] if deaths else []
    notes(line for fill in fills for line in fill.notes)
    if deaths and whole:
        output.write(ENDED, ended)
        note(f"{len(ended)} lives end among {sum(fill.classes or 0 for fill in whole)} classes")
    elif not output.write(ENDED if deaths else BIRTH_COLUMNS, map(attrgetter(*BIRTH_COLUMNS), whole)):
        note(f"no births in {db}: `catalogue.fill_births(p=11)` finds them")
        raise typer.Exit(1)


def _fill_births(periods: Sequence[int], db: Path, jobs: int | None) -> None:
    from orbitdb.catalogue import Catalogue

    start, span = time.monotonic(), f"births, p = {written(periods)}"
    bring(db)
    with Catalogue(db) as catalogue, progress(span) as shown:
        warn_of(catalogue)
        catalogue.fill_births(periods, jobs=jobs, progress=shown)
    note(f"{span}: {time.monotonic() - start:.1f} s, in {db}")
