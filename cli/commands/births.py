"""``orbitdb births``: where in a the words begin and cease to be orbits."""

import time
from collections.abc import Iterable, Mapping, Sequence
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from orbitdb.cli import options
from orbitdb.cli.options import Format, count_option
from orbitdb.cli.progress.line import progress
from orbitdb.cli.render import note, write
from orbitdb.cli.storing import Solvers, bring
from orbitdb.errors import InputError

if TYPE_CHECKING:
    from orbitdb.catalogue.catalogue import Catalogue
    from orbitdb.filling.resuming import Progress

EXAMPLES = """
Examples:

  orbitdb births --p 11

  orbitdb births --json

  orbitdb births --deaths
"""
LIFE_COLUMNS = ("p", "word", "class_size", "born", "dies", "dies_error", "reborn")
COLUMNS = ("p", "classes", "births", "deaths", "always", "least", "largest")

_WEIGHT = 10
"""How much longer the births of a word take than its orbit at one a, for what pays in processes."""


def births(
    context: typer.Context,
    p: Annotated[int | None, count_option("--p", help="The highest period to find births of.")] = None,
    first: Annotated[int, count_option("--from", help="The lowest period to find births of.")] = 2,
    deaths: Annotated[
        bool, typer.Option("--deaths", help="Show the lives that end, one a line, in place of the periods.")
    ] = False,
    jobs: Annotated[
        int | None,
        count_option("--jobs", help="Processes that find them [default: all cores where it pays]."),
    ] = None,
    format_: options.OutputFormat = Format.TABLE,
    json: options.Json = False,
    db: options.Database = None,
) -> None:
    """Find where in a all words begin and cease to be orbits, and store it: one line a period.

    classes: symmetry classes; births: how often one begins to be an orbit; deaths: classes that cease to
    be one at least once; always: classes that are orbits from a = 0 on; least, largest: first and last
    birth. Goes on where it was stopped; without --p it shows what is stored.
    """
    from orbitdb.catalogue.catalogue import Catalogue
    from orbitdb.store.file.database import default_path
    from orbitdb.symbols.enumeration import MAX_PERIOD

    path = db or default_path()
    if p is None:
        options.refuse_idle(context, "without --p", "jobs")
    else:
        if not 2 <= first <= p <= MAX_PERIOD:
            raise InputError(
                f"periods {first} to {p}: find births from 2 or more to {MAX_PERIOD} or less, in rising order"
            )
        _fill(range(first, p + 1), path, Solvers.chosen(None, None, jobs))
    form = options.chosen(format_, json)
    with closing(Catalogue(path)) as opened, opened.at_one_moment() as catalogue:
        found = [each for each in catalogue.birth_fills() if first <= each.p <= (p or MAX_PERIOD)]
        ended = _ended(catalogue, [each.p for each in found if each.whole]) if deaths else []
    for each in found:
        if not each.whole:
            note(f"births of period {each.p} are partial: 'orbitdb births --p {each.p}' completes them")
    found = [each for each in found if each.whole]
    rows = [[getattr(each, name) for name in COLUMNS] for each in found]
    if deaths and rows:
        write(LIFE_COLUMNS, ended, form)
        note(f"{len(ended)} lives end, of {sum(each.classes or 0 for each in found)} classes")
    elif not write(LIFE_COLUMNS if deaths else COLUMNS, rows, form):
        note(f"no births in {path}: 'orbitdb births --p 11' finds them")
        raise typer.Exit(1)


def _ended(catalogue: "Catalogue", periods: Sequence[int]) -> list[tuple[object, ...]]:
    """Return the lives of classes that end, by period and death, and where the next one begins."""
    rows: list[tuple[object, ...]] = []
    for p in periods:
        lives = catalogue.births(p)
        ended = {life.word for life in lives if life.dies is not None}
        again: dict[str, list[float]] = {word: [] for word in ended}
        for life in lives:  # by their births
            if life.word in ended:
                again[life.word].append(life.born)
        rows += sorted(
            (p, life.word, life.class_size, life.born, life.dies, life.dies_error,
             min((born for born in again[life.word] if born > life.dies), default=None))
            for life in lives if life.dies is not None
        )  # fmt: skip
    return rows


def _fill(periods: range, path: Path, solvers: Solvers) -> None:
    from orbitdb.catalogue.catalogue import Catalogue
    from orbitdb.filling.birth_blocks import BLOCK
    from orbitdb.filling.births import fill_births
    from orbitdb.symbols.counting import count_admissible

    start, span = time.monotonic(), f"p = {periods[0]}..{periods[-1]}"
    totals = {p: count_admissible(p) for p in periods}
    bring(path)
    with closing(Catalogue(path)) as catalogue:
        stored = {each.p: each.words for each in catalogue.birth_fills()}
    work = _WEIGHT * sum(count - stored.get(p, 0) for p, count in totals.items())
    with solvers.at_work(work, _WEIGHT * BLOCK) as workers:
        _show(fill_births(path, periods, workers), totals, f"births, {span}")
    note(f"births, {span}: {time.monotonic() - start:.1f} s, in {path}")


def _show(steps: "Iterable[Progress]", totals: Mapping[int, int], text: str) -> None:
    """Take the steps of the work, and show how far all its periods are."""
    with progress(text) as shown:
        for step in steps:
            before = sum(count for p, count in totals.items() if p < step.p)
            shown.tell(f"births, p = {step.p} of {max(totals)}", before + step.words, sum(totals.values()))
