"""``orbitdb info``, ``delete`` and ``migrate``: describe the catalogue, delete parts, update its schema."""

from itertools import groupby
from operator import itemgetter

import typer

from orbitdb.cli import options
from orbitdb.cli.notes import confirm, note
from orbitdb.cli.output import Output, write_facts
from orbitdb.cli.snapshots import bring
from orbitdb.text import format_float

EXAMPLES = {
    "info": ("info", "info --json"),
    "delete": ("delete --a 2.5", "delete --a 2.5 --p 12-13 --yes"),
    "migrate": ("migrate --db old.db",),
}
_SHOWN = 9
"""Number of columns shown to people; other formats add the processor times."""


def info(*, output: Output, db: options.Database) -> None:
    """Show where the catalogue is, what it contains, and the time and disk space that it took.

    stored is the number of words stored so far, and seconds the elapsed time. csv, tsv and json also have the
    processor times for enumerating, solving and storing, in seconds. A swept period stores no rows, and all
    its processor time is under solving.
    """
    from orbitdb.catalogue import Catalogue

    found = Catalogue(db).info(facts=output.table)
    if not output.table:
        shown = _SHOWN if output.for_people else len(found.columns)
        output.write(found.columns[:shown], [row[:shown] for row in found.rows])
        return
    write_facts(found.facts)
    for a, rows_at_a in groupby(found.rows, key=itemgetter(0)):
        print(f"\na = {format_float(a)}")
        output.write(found.columns[1:_SHOWN], [row[1:_SHOWN] for row in rows_at_a])


def delete(
    *,
    a: options.GivenHalfLength,
    p: options.Periods = None,
    yes: options.Yes = False,
    db: options.Database,
) -> None:
    """Delete what is stored at one half length: orbits, fills, sweeps, levels, bounds and trajectories.

    With --p, only the orbits, fills and sweeps of these periods go. Geometrically pruned words go with the
    last fill of their period. Births and deaths stay, because they belong to no half length. On a terminal
    you are asked first.
    """
    from orbitdb.catalogue import Catalogue

    catalogue = Catalogue(db)
    contents = catalogue.contents(a, p)
    where = f"at a = {format_float(a)} in {db}"
    if not contents:
        note(f"nothing {f'of period {p} ' if p else ''}is stored {where}")
        raise typer.Exit(1)
    if not yes:
        confirm(f"delete {contents} {where}", "nothing was deleted")
    note(f"deleted {catalogue.delete(a, p, only=None if yes else contents)} {where}")


def migrate(db: options.Database) -> None:
    """Update a catalogue to the latest schema, or create an empty one."""
    before, after = bring(db)
    if before == after:
        note(f"{db}: schema {after} is the latest; nothing to do")
    elif not before:
        note(f"{db}: created, schema {after}")
