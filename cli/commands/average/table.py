"""``orbitdb table``: the paper's Table 1."""

from orbitdb.cli import options
from orbitdb.cli.arguments import several
from orbitdb.cli.choice import Choice
from orbitdb.cli.output import Output, note_results, rows_of
from orbitdb.cli.reading import reading

EXAMPLES = ("table", "table --a 1 --p 2-8 --json", "table --a all --p 11")


def table(
    *,
    a: options.StoredHalfLengths = None,
    p: options.Periods = None,
    output: Output,
    db: options.Database,
) -> None:
    """Show the paper's Table 1 for the filled periods: numbers of words and orbits, and the entropy.

    N_t: words that the geometric rules allow; N_c: orbits; N: points on orbits of period p or a divisor
    of p; K_0 = ln N / p; classes: orbits up to symmetry; boundary: orbits through a joint, not counted.
    Periods that are not filled at this a are counted from births, if 'orbitdb births' has found them.
    """
    with reading(db, a, Choice(p=p)) as (catalogue, stadiums):
        found = [catalogue.table(chosen) for chosen in stadiums]
    note_results(found, several(a), output.table)
    output.write(*rows_of(found, several(a)))
