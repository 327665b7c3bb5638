"""``orbitdb entropy``: the topological entropy over a chosen subset of orbits."""

from orbitdb.cli import options
from orbitdb.cli.arguments import several
from orbitdb.cli.choice import Choice
from orbitdb.cli.output import Output, note_results, rows_of
from orbitdb.cli.progress import progress
from orbitdb.cli.reading import averaged, reading

EXAMPLES = ("entropy", "entropy --p 2-9 --reversal self --json", "entropy --a all --format csv")


def entropy(
    *,
    a: options.StoredHalfLengths = None,
    choice: Choice,
    output: Output,
    db: options.Database,
) -> None:
    """Compute the topological entropy of the chosen orbits, by period.

    N: points on orbits of period p or a divisor of p; K_0 = ln N / p; h_zeta: from the leading zero of
    the zeta function truncated at p, which converges much faster, with its change from p - 1, which is no
    error bound. The proved bounds come from 'orbitdb bounds', or are found on the spot.
    """
    from orbitdb.catalogue.results import PROVED

    with progress("reading orbits"), reading(db, a, averaged(choice)) as (catalogue, stadiums):
        found = [catalogue.entropy(chosen) for chosen in stadiums]
    note_results(found, several(a), output.table)
    output.write(*rows_of(found, several(a), hidden=PROVED if output.table else ()))
