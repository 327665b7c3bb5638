"""``orbitdb entropy``: the topological entropy over a chosen subset of orbits."""

from orbitdb.cli import options
from orbitdb.cli.arguments import several
from orbitdb.cli.choice import Choice, with_choice
from orbitdb.cli.options import Format
from orbitdb.cli.progress.line import progress
from orbitdb.cli.reading import averaged, reading_all
from orbitdb.cli.rows import write_results

EXAMPLES = """
Examples:

  orbitdb entropy

  orbitdb entropy --p 2-9 --reversal self --json

  orbitdb entropy --a all --format csv
"""


@with_choice
def entropy(
    *,
    a: options.StoredHalfLengths = None,
    choice: Choice,
    format_: options.OutputFormat = Format.TABLE,
    json: options.Json = False,
    db: options.Database = None,
) -> None:
    """Compute the topological entropy of the chosen orbits, by period.

    N: points on orbits of period p and its divisors; K_0 = ln N / p; h_zeta: from the leading zero of
    the zeta function cut off at p, which converges much faster, with its change from p - 1, which is no
    error. The proved bounds are those that 'orbitdb bounds' has stored, or some found on the spot.
    """
    from orbitdb.catalogue.results import PROVED

    form = options.chosen(format_, json)
    with progress("reading orbits"), reading_all(db, a, averaged(choice)) as (catalogue, stadiums):
        found = [catalogue.entropy(chosen) for chosen in stadiums]
    write_results(found, several(a), form, hidden=PROVED)
