"""``orbitdb sql``: what no option asks."""

from contextlib import closing
from typing import Annotated

import typer

from orbitdb.cli import options
from orbitdb.cli.options import Format
from orbitdb.cli.render import note, write

EXAMPLES = """
Examples:

  orbitdb sql "SELECT p, count(*) AS orbits FROM catalogue WHERE status = 'orbit' GROUP BY a, p"

  orbitdb sql "SELECT a, length FROM catalogue WHERE code = :word ORDER BY a" -P word=1123213 --json
"""


def sql(
    statement: Annotated[str, typer.Argument(metavar="SELECT", help="One SELECT, in quotes.")],
    parameters: options.Parameters = None,
    format_: options.OutputFormat = Format.TABLE,
    json: options.Json = False,
    db: options.Database = None,
) -> None:
    """Answer one SELECT of SQL, over every a in the catalogue.

    It may read the views catalogue (see 'orbitdb columns') and life, and nothing else, for a minute at
    most; nothing can be written. code('310') finds a word in any rotation.
    """
    from orbitdb.catalogue.catalogue import Catalogue
    from orbitdb.store.asking.codes import hint
    from orbitdb.store.asking.parsing import parse_parameter
    from orbitdb.store.reading.statements import run_statement

    values = dict(parse_parameter(parameter) for parameter in parameters or ())
    with closing(Catalogue(db)) as catalogue, catalogue.reading() as connection:
        names, rows = run_statement(connection, statement, values)
        if (told := hint(statement)) is not None:
            note(told)
        if not write(names, rows, options.chosen(format_, json)):
            note("no rows")
            raise typer.Exit(1)
