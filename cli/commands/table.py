"""``orbitdb table``: the paper's Table 1."""

import math
from typing import Any

import typer

from orbitdb.cli import options
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
    """
    from orbitdb.averages.fixed_points import divisors, missing_divisors

    with reading(db, a, options.Choice(p=p)) as (catalogue, chosen):
        lacking = note_gaps(catalogue, chosen, left_out=True)
        fills = {fill.p: fill for fill in catalogue.fills(chosen.a) if fill.whole}
    rows: list[tuple[Any, ...]] = []
    for period, fill in fills.items():
        if not chosen.includes(period):
            continue
        missing = missing_divisors(period, fills)
        if missing:
            note(f"p = {period}: N needs the periods {', '.join(map(str, missing))}, which are not filled")
        points = None if missing else sum(d * (fills[d].n_c or 0) for d in divisors(period) if d > 1)
        entropy = math.log(points) / period if points else None
        rows.append(
            (period, fill.n_t, fill.n_c, points, entropy, fill.classes, fill.boundary, fill.unresolved)
        )
    if not write(COLUMNS, rows, options.chosen(format_, json)):
        if not lacking:
            note(f"no {chosen.describe()}")
        raise typer.Exit(1)
