"""``orbitdb births``: where in a the words begin and cease to be orbits."""

import time
from contextlib import closing
from pathlib import Path
from typing import Annotated

import typer

from orbitdb.cli import options
from orbitdb.cli.commands.info import bring
from orbitdb.cli.endings import until_interrupted
from orbitdb.cli.options import Format, count_option
from orbitdb.cli.progress import progress
from orbitdb.cli.render import note, write
from orbitdb.errors import InputError

EXAMPLES = """
Examples:

  orbitdb births --p 11

  orbitdb births --json
"""
COLUMNS = ("p", "classes", "births", "deaths", "always", "least", "largest")


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command(epilog=EXAMPLES)(births)


def births(
    p: Annotated[int | None, count_option("--p", help="The highest period to find births of.")] = None,
    first: Annotated[int, count_option("--from", help="The lowest period to find births of.")] = 2,
    format_: options.OutputFormat = Format.TABLE,
    json: options.Json = False,
    db: options.Database = None,
) -> None:
    """Find where in a all words begin and cease to be orbits, and store it: one line a period.

    classes: symmetry classes; births: how often one begins to be an orbit; deaths: classes that cease to
    be one at least once; always: classes that are orbits from a = 0 on; least, largest: first and last
    birth. Goes on where it was stopped; without --p it shows what is stored.
    """
    from orbitdb.store.file.database import default_path
    from orbitdb.store.reading.catalogue import Catalogue
    from orbitdb.symbols.enumeration import MAX_PERIOD

    path = db or default_path()
    if p is not None:
        if not 2 <= first <= p <= MAX_PERIOD:
            raise InputError(
                f"periods {first} to {p}: find births from 2 or more to {MAX_PERIOD} or less, in rising order"
            )
        _fill(range(first, p + 1), path)
    with closing(Catalogue(path)) as catalogue:
        found = [each for each in catalogue.birth_fills() if first <= each.p <= (p or MAX_PERIOD)]
    for each in found:
        if not each.whole:
            note(f"births of period {each.p} are partial: 'orbitdb births --p {each.p}' completes them")
    rows = [[getattr(each, name) for name in COLUMNS] for each in found if each.whole]
    if not write(COLUMNS, rows, options.chosen(format_, json)):
        note(f"no births in {path}: 'orbitdb births --p 11' finds them")
        raise typer.Exit(1)


def _fill(periods: range, path: Path) -> None:
    from orbitdb.filling.births import fill_births
    from orbitdb.symbols.counting import count_admissible

    start, span = time.monotonic(), f"p = {periods[0]}..{periods[-1]}"
    totals = {p: count_admissible(p) for p in periods}
    bring(path)
    with progress(f"births, {span}") as shown:
        for step in until_interrupted(fill_births(path, periods)):
            before = sum(count for p, count in totals.items() if p < step.p)
            shown.tell(f"births, p = {step.p} of {periods[-1]}", before + step.words, sum(totals.values()))
    note(f"births, {span}: {time.monotonic() - start:.1f} s, in {path}")
