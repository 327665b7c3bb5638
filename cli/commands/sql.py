"""``orbitdb sql``: run a SELECT statement, for questions that no option answers."""

from typing import Annotated

import typer

from orbitdb.cli import options
from orbitdb.cli.output import Output
from orbitdb.cli.render import note

EXAMPLES = (
    "sql \"SELECT p, count(*) AS orbits FROM catalogue WHERE status = 'orbit' GROUP BY a, p\"",
    'sql "SELECT a, length FROM catalogue WHERE code = :word ORDER BY a" -P word=1123213 --json',
)


def sql(
    *,
    statement: Annotated[str, typer.Argument(metavar="SELECT", help="One SELECT statement, in quotes.")],
    parameters: options.Parameters = None,
    output: Output,
    db: options.Database,
) -> None:
    """Run one SELECT statement on the catalogue, over all values of a.

    The statement can read the views catalogue (one row per word; see 'orbitdb columns'), class (one row per
    class) and life (births and deaths). It cannot write, and is stopped after a minute. code('310') matches a
    word in any rotation.
    """
    from orbitdb.store.codes import hint, parse_parameters
    from orbitdb.store.moment import reading
    from orbitdb.store.where import run_statement

    values = parse_parameters(parameters or (), statement)
    with reading(db) as moment:
        names, rows = run_statement(moment.connection, statement, values)
        if (told := hint(statement)) is not None:
            note(told)
        if not output.write(names, rows):
            note("no rows")
            raise typer.Exit(1)
