"""``orbitdb table``: the paper's Table 1."""

import typer

from orbitdb.cli import options
from orbitdb.cli.arguments import several
from orbitdb.cli.choice import Choice
from orbitdb.cli.options import Format
from orbitdb.cli.reading import reading_all
from orbitdb.cli.rows import write_results

EXAMPLES = """
Examples:

  orbitdb table

  orbitdb table --a 1 --p 2-8 --json

  orbitdb table --a all --p 11
"""


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
    Periods that are not filled at this a are counted from births, if 'orbitdb births' has found them.
    """
    with reading_all(db, a, Choice(p=p)) as (catalogue, stadiums):
        found = [catalogue.table(chosen) for chosen in stadiums]
    write_results(found, several(a), options.chosen(format_, json))
