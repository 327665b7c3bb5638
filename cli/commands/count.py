"""``orbitdb count``: how many words and classes there are."""

from typing import Annotated

import typer

from orbitdb.cli import options
from orbitdb.cli.completions import offered_columns
from orbitdb.cli.grids import many_a
from orbitdb.cli.notes import notes
from orbitdb.cli.options import SelectionOptions
from orbitdb.cli.output import Output
from orbitdb.cli.snapshots import chosen_codes, snapshot

EXAMPLES = (
    "count --p 11",
    "count --by p,status",
    "count --by time_reversal --where 'lambda_c < 0.4' --a all",
)


def count(
    *,
    by: Annotated[
        str | None,
        typer.Option(
            metavar="COLUMNS",
            help="One row for each combination of values of these columns, separated by commas.",
            autocompletion=offered_columns,
        ),
    ] = None,
    a: options.HalfLengths = None,
    code: options.OnlyCodes = None,
    choice: SelectionOptions,
    output: Output,
    db: options.Database,
) -> None:
    """Count the chosen words, and the symmetry classes that they belong to.

    The options choose words as those of query do. The columns of --by are those whose values all words of a
    class share, such as p, status or symmetry; words without a value come last. If --by names status, rules,
    born or dies, all statuses are counted unless --status is given.
    """
    from orbitdb.criteria import OF_STATUS
    from orbitdb.orbits.status import STORED

    names = [name.strip() for name in by.split(",")] if by else []
    usual = STORED if OF_STATUS.intersection(names) else None
    with snapshot(db, a, choice, usual, chosen_codes(code)) as (catalogue, selections):
        found = catalogue.count(selections if many_a(a) else selections[0], by=names)
    notes([*found.notes, *(found.facts if output.table else ())])
    if not output.write([*found.columns], found.rows()):
        raise typer.Exit(1)
