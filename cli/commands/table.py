"""``orbitdb table``: the paper's Table 1."""

import math
from typing import TYPE_CHECKING, Any

import typer

from orbitdb.cli import enclosed, options
from orbitdb.cli.half_lengths import Answer, joined, several
from orbitdb.cli.options import Format
from orbitdb.cli.reading import note_gaps, reading_all
from orbitdb.cli.render import note, write

if TYPE_CHECKING:
    from orbitdb.store.asking.selection import Selection
    from orbitdb.store.reading.catalogue import Catalogue

EXAMPLES = """
Examples:

  orbitdb table

  orbitdb table --a 1 --p 2-8 --json

  orbitdb table --a all --p 11
"""

COLUMNS = ("p", "N_t", "N_c", "N", "K_0", "classes", "boundary", "unresolved")


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command(epilog=EXAMPLES)(table)


def table(
    a: options.StoredHalfLengths = None,
    p: options.Periods = None,
    format_: options.OutputFormat = Format.TABLE,
    json: options.Json = False,
    db: options.Database = None,
) -> None:
    """Show the paper's Table 1 for the filled periods: numbers of sequences and orbits, and the entropy.

    N_t: sequences left by the geometric rules; N_c: orbits; N: points of period p and its divisors;
    K_0 = ln N / p; classes: orbits up to symmetry; boundary: orbits through a joint, not counted.
    Where 'orbitdb bounds' has enclosed the topological entropy, a note says so.
    Periods that are not filled at this a are counted from births, if 'orbitdb births' has found them.
    """
    with reading_all(db, a, options.Choice(p=p)) as (catalogue, stadiums):
        found = [_counted(catalogue, chosen) for chosen in stadiums]
        proved = [enclosed.enclosure(catalogue, chosen.a) for chosen in stadiums]
    form = options.chosen(format_, json)
    for (answer, _), enclosure in zip(found, proved, strict=True):
        if enclosure is not None and answer.rows and form is Format.TABLE:
            note(enclosed.told(enclosure, answer.a, several(a)))
    if not write(*joined([answer for answer, _ in found], several(a)), form):
        for chosen, (_, lacking) in zip(stadiums, found, strict=True):
            if not lacking:
                note(f"no {chosen.describe()}")
        raise typer.Exit(1)


def _counted(catalogue: "Catalogue", chosen: "Selection") -> tuple[Answer, bool]:
    """Return the rows at one a, and whether periods are missing, which is told."""
    from orbitdb.averages.fixed_points import divisors, missing_divisors

    counted = catalogue.counts(chosen)
    lacking = note_gaps(catalogue, chosen, left_out=True, counted=counted)
    rows: list[tuple[Any, ...]] = []
    for period in counted.chosen:
        here, missing = counted.known[period], missing_divisors(period, counted.known)
        if missing:
            note(f"p = {period}: N needs p = {', '.join(map(str, missing))}: not filled")
        points = None if missing else sum(d * counted.known[d].n_c for d in divisors(period) if d > 1)
        entropy = math.log(points) / period if points else None
        rows.append(
            (period, here.n_t, here.n_c, points, entropy, here.classes, here.boundary, here.unresolved)
        )
    return Answer(chosen.a, COLUMNS, rows), lacking
