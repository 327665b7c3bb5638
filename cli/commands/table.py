"""``orbitdb table``: the paper's Table 1."""

import math
from typing import Any

import typer

from orbitdb.cli import enclosed, options
from orbitdb.cli.options import Format
from orbitdb.cli.reading import note_gaps, reading
from orbitdb.cli.render import note, write

EXAMPLES = """
Examples:

  orbitdb table

  orbitdb table --a 1 --p 2-8 --json
"""

COLUMNS = ("p", "N_t", "N_c", "N", "K_0", "classes", "boundary", "unresolved")


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command(epilog=EXAMPLES)(table)


def table(
    a: options.StoredHalfLength = None,
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
    from orbitdb.averages.fixed_points import divisors, missing_divisors

    with reading(db, a, options.Choice(p=p)) as (catalogue, chosen):
        counted = catalogue.counts(chosen)
        lacking = note_gaps(catalogue, chosen, left_out=True, counted=counted)
        proved = enclosed.enclosure(catalogue, chosen.a)
    rows: list[tuple[Any, ...]] = []
    for period in counted.chosen:
        here, missing = counted.known[period], missing_divisors(period, counted.known)
        if missing:
            note(f"p = {period}: N needs the periods {', '.join(map(str, missing))}, which are not filled")
        points = None if missing else sum(d * counted.known[d].n_c for d in divisors(period) if d > 1)
        entropy = math.log(points) / period if points else None
        rows.append(
            (period, here.n_t, here.n_c, points, entropy, here.classes, here.boundary, here.unresolved)
        )
    form = options.chosen(format_, json)
    if proved is not None and rows and form is Format.TABLE:
        note(proved[1])
    if not write(COLUMNS, rows, form):
        if not lacking:
            note(f"no {chosen.describe()}")
        raise typer.Exit(1)
