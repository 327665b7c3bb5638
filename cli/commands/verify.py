"""``orbitdb verify``: is the catalogue what it says."""

import time
from collections.abc import Generator, Iterable, Iterator
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from orbitdb.cli import options
from orbitdb.cli.choice import Choice, with_choice
from orbitdb.cli.options import Format
from orbitdb.cli.progress.line import progress
from orbitdb.cli.render import note, note_partial, write
from orbitdb.cli.storing import Jobs, Solvers
from orbitdb.errors import InputError, StoreError
from orbitdb.plaintext import several

if TYPE_CHECKING:
    from orbitdb.catalogue.catalogue import Catalogue
    from orbitdb.store.asking.selection import Selection
    from orbitdb.store.reading.fills import Fill
    from orbitdb.verification.check import Check, Step

EXAMPLES = """
Examples:

  orbitdb verify

  orbitdb verify --p 2-11 --a 1.6 --rigorous

  orbitdb verify --sample 1000 --restarts 10 --seed 7 --json
"""

_WORK = 8
"""Sequences that are found and solved in the time in which one is checked."""

COLUMNS = ("check", "rows", "failures", "worst", "share", "first")


@with_choice
def verify(
    *,
    context: typer.Context,
    a: Annotated[
        float | None,
        options.number_option("--a", help="Half length of a straight wall [default: all stored]."),
    ] = None,
    choice: Choice,
    sample: Annotated[
        int | None,
        options.count_option("--sample", least=1, help="Look at so many classes, drawn at random."),
    ] = None,
    restarts: Annotated[
        int,
        options.count_option(
            "--restarts", least=0, most=1000, help="Solve every word again from so many random starts."
        ),
    ] = 0,
    seed: Annotated[int, options.count_option("--seed", least=0, help="Of sample and restarts.")] = 0,
    rigorous: Annotated[
        bool,
        typer.Option("--rigorous", help="Prove every row in ball arithmetic and store the certificate."),
    ] = False,
    again: Annotated[
        bool, typer.Option("--again", help="With --rigorous: prove what has a certificate, too.")
    ] = False,
    births: Annotated[
        bool,
        typer.Option("--births", help="Prove that no birth or death is missing for a from 0.02 to 1000."),
    ] = False,
    jobs: Jobs = None,
    format_: options.OutputFormat = Format.TABLE,
    json: options.Json = False,
    db: options.Database = None,
) -> None:
    """Compute the catalogue again from its words alone and compare.

    One line a promise: rows looked at, rows that break it, the worst deviation found, its share of what
    rounding and the row's error bound allow (above 1 is a failure), and the first row that is wrong.
    The exit code is 1 if there is one. Counts are checked for whole periods, rows for the chosen ones;
    of a period that is partial, what is stored.
    """
    from orbitdb.billiard.stadium import Stadium
    from orbitdb.catalogue.catalogue import Catalogue
    from orbitdb.store.file.database import default_path
    from orbitdb.store.file.guard import TamperedError
    from orbitdb.verification.check import Check
    from orbitdb.verification.verify import report
    from orbitdb.verification.verify import verify as steps

    if again and not rigorous:
        raise InputError("--again proves certified rows again: it goes with --rigorous")
    if sample is None and not restarts:
        options.refuse_idle(context, "without --sample or --restarts", "seed")
    start, form = time.monotonic(), options.chosen(format_, json)
    try:
        catalogue = Catalogue(db)
    except TamperedError as error:
        broken = Check("schema", error.parts, len(error.faults), first=error.faults[0])
        note(str(error))
        _report([broken], db or default_path(), start, restarts, form)
        return
    partial: dict[float, list[Fill]] = {}
    unfilled: list[str] = []

    solvers = Solvers.chosen(None, None, jobs)

    def work() -> "Generator[Step]":
        with catalogue.at_one_moment() as still:
            stadiums = still.a_values() if a is None else [Stadium(a).a]
            chosen = [choice.at(each) for each in stadiums]
            partial.update((selection.a, still.partial(selection)) for selection in chosen)
            if a is not None or choice.p is not None:
                unfilled.extend(filter(None, (_unfilled(still, each) for each in chosen)))
            known = sum(
                fill.words for each in chosen for fill in still.fills(each.a) if each.includes(fill.p)
            )
            with solvers.at_work(_WORK * (known if sample is None else sample), 0) as workers:
                here = workers if workers.jobs > 1 else None
                yield from steps(still, chosen, sample, restarts, seed, births, here)
        if rigorous:
            from orbitdb.verification.rigorous import certify

            for selection in chosen:
                yield from certify(catalogue.path, selection, sample, seed, again)

    with closing(work()) as steps_taken:  # with whom it has set to work, if it ends before its time
        found = report(_watched(steps_taken))
    for each, fills in partial.items():
        note_partial(fills, each)
    for gap in unfilled:
        note(gap)
    _report(found, catalogue.path, start, restarts, form)


_KEYS = ("name", *COLUMNS[1:])


def _report(found: "list[Check]", path: Path, start: float, restarts: int, form: Format) -> None:
    """Write what was found, say in one line what came of it, and leave with code 1 if it is not good."""
    write(COLUMNS, ([getattr(check, key) for key in _KEYS] for check in found), form)
    rows = {check.name: check.rows for check in found}
    classes = rows.get("values", 0)
    if (unsettled := restarts * rows.get("statuses", 0) - rows.get("restarts", 0)) > 0:
        note(f"{unsettled} restarts did not come to rest and tell nothing")
    broken = [check.name for check in found if check.failures]
    if broken:
        from orbitdb.verification.verify import PROMISES

        for name in broken:
            note(f"{name}: not every row keeps that {PROMISES[name]}")
        raise typer.Exit(1)
    changes, proved, levels = (rows.get(name, 0) for name in ("births", "entropy", "levels"))
    if lives := rows.get("lives", 0) + rows.get("undecided", 0):
        note(
            f"no birth or death of {rows.get('lives', 0)} of {lives} classes is missing from a = 0.02 to 1000"
        )
    swept = rows.get("sweeps", 0)
    if not any((classes, changes, swept, proved, levels)):
        note(f"nothing to look at in {path}: the file is sound, but no class is stored that was asked for")
        raise typer.Exit(1)
    if anew := swept - rows.get("sums", 0):
        note(_of_sums(anew))
    if (foreign := rows.get("statuses", 0) - rows.get("bits", 0)) > 0:
        note(f"{foreign} rows are of another method, version or machine: their last bits were not compared")
    seen = {("class", "classes"): classes, ("birth or death", "births and deaths"): changes,
            ("swept period", "swept periods"): swept,
            ("bound on the entropy", "bounds on the entropy"): proved,
            ("quantum level", "quantum levels"): levels}  # fmt: skip
    told = ", ".join(several(count, *what) for what, count in seen.items() if count)
    note(f"{path}: all is well with {told}, {time.monotonic() - start:.1f} s")


def _unfilled(catalogue: "Catalogue", chosen: "Selection") -> str | None:
    """Say which of the periods asked for are neither filled nor swept."""
    try:
        subsets = (None, *catalogue.swept_subsets(chosen.a))
        swept = tuple(each.p for subset in subsets for each in catalogue.sweeps(chosen.a, subset))
    except StoreError:
        return None  # it is among what is checked
    from orbitdb.catalogue.gaps import without

    rest = without(chosen, swept) if swept else chosen
    return None if rest is None else catalogue.unfilled(rest)


def _of_sums(count: int) -> str:
    """Say which sums of sweeps nothing was compared with."""
    from orbitdb.verification.sweeps import SWEPT_ANEW

    what = "the sums of a swept period were" if count == 1 else f"the sums of {count} swept periods were"
    return f"{what} not computed again: those of whole periods up to {SWEPT_ANEW} are"


def _watched(steps: "Iterable[Step]") -> "Iterator[Step]":
    """Pass the steps on, and show how far they are if somebody watches."""
    with progress("the catalogue") as shown:
        for step in steps:
            shown.tell(step.stage, step.done, step.total if step.total > 1 else 0)
            yield step
