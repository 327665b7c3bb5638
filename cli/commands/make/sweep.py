"""``orbitdb sweep``: enumerate, solve and add up, and keep counts and sums alone."""

import time
from dataclasses import replace
from typing import Annotated

import typer

from orbitdb.cli.choice import SweptChoice
from orbitdb.cli.options import Database, HalfLength, count_option
from orbitdb.cli.output import Output
from orbitdb.cli.progress import progress
from orbitdb.cli.render import note
from orbitdb.cli.storing import DryRun, Solvers, announce, asked_periods, bring, show_steps, written
from orbitdb.plaintext import several

EXAMPLES = (
    "sweep --p 16",
    "sweep --p 12 --a 1 --json",
    "sweep --p 14 --reversal self --range length=:20",
    "sweep --p 19 --scheduler tcp://node1:8786",
)

COLUMNS = ("p", "N_t", "N_c", "classes", "boundary", "unresolved", "seconds", "processor_seconds")


def sweep(
    *,
    context: typer.Context,
    asked: Annotated[
        str,
        typer.Option("--p", metavar="PERIODS", help="The highest period to sweep, or periods such as 2-8."),
    ],
    first: Annotated[int, count_option("--from", help="The lowest period to sweep.")] = 2,
    a: HalfLength = 1.6,
    choice: SweptChoice,
    solvers: Solvers,
    dry_run: DryRun = False,
    output: Output,
    db: Database,
) -> None:
    """Count the orbits of further periods and sum what averages need, without storing rows.

    'orbitdb table', 'entropy' and 'lyapunov' use a sweep where there is no fill. It takes less time than
    a fill and hardly any disk space. An interrupted sweep goes on where it stopped; finished periods are
    skipped. If you choose a subset, N_c and classes count its orbits, and N_t counts all words; boundary
    and unresolved count the chosen words whatever their --range, which applies to orbits only.
    """
    from orbitdb.billiard.stadium import Stadium
    from orbitdb.catalogue.catalogue import Catalogue
    from orbitdb.filling.estimate import sweep_need
    from orbitdb.filling.sweeps import SMALL, sweep_periods
    from orbitdb.orbits.orbit import Status
    from orbitdb.store.asking.sweepable import swept_text
    from orbitdb.symbols.counting import count_admissible

    chosen, periods = choice.at(Stadium(a).a), asked_periods(context, asked, first)
    span = f"p = {written(periods)} at a = {a:g}"
    coming = sweep_need(db, a, periods, solvers.number(), chosen)
    announce(span, coming, db, dry_run)
    if dry_run:
        return
    start = time.monotonic()
    with solvers.at_work(coming.words, SMALL) as workers:
        bring(db)
        with progress(span) as shown:
            words = {p: count_admissible(p) for p in periods}
            steps = sweep_periods(db, a, periods, workers, chosen)
            show_steps(shown, steps, "words", words, sum(words.values()) - coming.words)
    note(f"{span}: {several(coming.words, 'word')}, {time.monotonic() - start:.1f} s, in {db}")
    subset = (text,) if (text := swept_text(chosen)) else ()
    if subset:
        note(replace(chosen, statuses=(Status.ORBIT,)).describe())
    with Catalogue(db) as catalogue:
        found = [each for each in catalogue.sweeps(a, chosen) if each.p in periods]
    rows = []
    for each in found:
        counts = each.tally
        statuses = counts.words, counts.n_c, counts.classes, counts.boundary, counts.unresolved
        rows.append((each.p, *statuses, round(each.seconds, 2), round(each.processor, 2), *subset))
    output.write((*COLUMNS, "selection") if subset else COLUMNS, rows)
