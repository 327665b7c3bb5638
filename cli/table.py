"""``orbitdb table``: the paper's Table 1."""

import math
from typing import Any

import typer

from orbitdb.cli import options
from orbitdb.cli.options import Format
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
    a: options.HalfLength = 1.6,
    p: options.Periods = None,
    format_: options.OutputFormat = Format.TABLE,
    json: options.Json = False,
    db: options.Database = None,
) -> None:
    """Show the paper's Table 1 for the filled periods: numbers of sequences and orbits, and the entropy.

    N_t: sequences left by the geometric rules; N_c: orbits; N: points of period p and its divisors;
    K_0 = ln N / p; classes: orbits up to symmetry; boundary: orbits through a joint, not counted.
    """
    from orbitdb.fixed_points import divisors, missing_divisors
    from orbitdb.selection import parse_periods
    from orbitdb.stadium import Stadium
    from orbitdb.store.catalogue import Catalogue
    from orbitdb.store.filling import DONE

    fills = {fill.p: fill for fill in Catalogue(db).fills(Stadium(a).a) if fill.state == DONE}
    spans = ((2, max(fills, default=2)),) if p is None else parse_periods(p)
    wanted = [period for period in sorted(fills) if any(low <= period <= high for low, high in spans)]
    rows: list[tuple[Any, ...]] = []
    for period in wanted:
        fill = fills[period]
        missing = missing_divisors(period, fills)
        if missing:
            note(f"p = {period}: N needs the periods {', '.join(map(str, missing))}, which are not filled")
        points = None if missing else sum(d * (fills[d].n_c or 0) for d in divisors(period) if d > 1)
        entropy = math.log(points) / period if points else None
        rows.append(
            (period, fill.n_t, fill.n_c, points, entropy, fill.classes, fill.boundary, fill.unresolved)
        )
    if not write(COLUMNS, rows, options.chosen(format_, json)):
        note(f"nothing is filled at a = {a:g}: run 'orbitdb fill --p 11 --a {a:g}'")
        raise typer.Exit(1)
