"""``orbitdb births``: the half lengths at which words begin and cease to be orbits."""

import time
from collections.abc import Sequence
from operator import attrgetter
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from orbitdb.cli import options
from orbitdb.cli.output import Output
from orbitdb.cli.progress import progress
from orbitdb.cli.render import note
from orbitdb.cli.storing import Jobs, Lowest, SomeHighest, asked_periods, bring, written

if TYPE_CHECKING:
    from orbitdb.store.moment import Moment

EXAMPLES = ("births --p 11", "births --json", "births --deaths")
LIFE_COLUMNS = ("p", "word", "class_size", "born", "dies", "dies_error", "reborn")
COLUMNS = ("p", "classes", "births", "deaths", "always", "least", "largest")


def births(
    *,
    context: typer.Context,
    asked: SomeHighest = None,
    first: Lowest = 2,
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
    from orbitdb.store.moment import reading
    from orbitdb.symbols.enumeration import MAX_PERIOD

    periods: Sequence[int]
    if asked is None:
        options.refuse_idle(context, "without --p", "jobs")
        periods = range(first, MAX_PERIOD + 1)
    else:
        periods = asked_periods(context, asked, first)
        _fill(periods, db, jobs)
    with reading(db) as moment:
        found = [each for each in moment.birth_fills() if each.p in periods]
        ended = _ended(moment, [each.p for each in found if each.whole]) if deaths else []
    for each in found:
        if not each.whole:
            note(f"births of period {each.p} are incomplete: 'orbitdb births --p {each.p}' completes them")
    whole = [each for each in found if each.whole]
    if deaths and whole:
        output.write(LIFE_COLUMNS, ended)
        note(f"{len(ended)} lives end among {sum(each.classes or 0 for each in whole)} classes")
    elif not output.write(LIFE_COLUMNS if deaths else COLUMNS, map(attrgetter(*COLUMNS), whole)):
        note(f"no births in {db}: 'orbitdb births --p 11' finds them")
        raise typer.Exit(1)


def _ended(moment: "Moment", periods: Sequence[int]) -> list[tuple[object, ...]]:
    """Return the lives that end, by period and word, each with the beginning of the word's next life."""
    rows: list[tuple[object, ...]] = []
    for p in periods:
        lives = moment.births(p)
        again: dict[str, list[float]] = {life.word: [] for life in lives if life.dies is not None}
        for life in lives:
            if life.word in again and life.born is not None:
                again[life.word].append(life.born)
        rows += [
            (p, life.word, life.class_size, life.born, life.dies, life.dies_error,
             min((born for born in again[life.word] if born > life.dies), default=None))
            for life in sorted(lives, key=lambda each: (each.word, each.born or 0.0)) if life.dies is not None
        ]  # fmt: skip
    return rows


def _fill(periods: Sequence[int], db: Path, jobs: int | None) -> None:
    from orbitdb.catalogue import Catalogue

    start, span = time.monotonic(), f"births, p = {written(periods)}"
    bring(db)
    with Catalogue(db) as catalogue, progress(span) as shown:
        catalogue.fill_births(periods, jobs=jobs, progress=shown)
    note(f"{span}: {time.monotonic() - start:.1f} s, in {db}")
