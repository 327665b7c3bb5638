"""``orbitdb info`` and ``orbitdb migrate``: where and what the database is."""

from typing import Any

import typer

from orbitdb.cli import options
from orbitdb.cli.options import Format
from orbitdb.cli.render import note, write, write_facts

INFO_EXAMPLES = """
Examples:

  orbitdb info

  orbitdb info --json
"""
MIGRATE_EXAMPLES = """
Example:

  orbitdb migrate --db old.db
"""
COLUMNS = ("a", "p", "state", "N_t", "N_c", "boundary", "unresolved", "seconds")


def register(app: typer.Typer) -> None:
    """Add the commands."""
    app.command(epilog=INFO_EXAMPLES)(info)
    app.command(epilog=MIGRATE_EXAMPLES)(migrate)


def info(
    format_: options.OutputFormat = Format.TABLE,
    json: options.Json = False,
    db: options.Database = None,
) -> None:
    """Show where the catalogue is, and what is filled."""
    from orbitdb.store.catalogue import Catalogue
    from orbitdb.store.database import check_file

    with Catalogue(db).at_one_moment() as catalogue:
        rows: list[tuple[Any, ...]] = [
            (a, fill.p, fill.state, fill.n_t, fill.n_c, fill.boundary, fill.unresolved, fill.seconds)
            for a in catalogue.a_values()
            for fill in catalogue.fills(a)
        ]
    form = options.chosen(format_, json)
    if form is Format.TABLE:
        size = catalogue.path.stat().st_size / 1e6
        write_facts([
            ("catalogue", str(catalogue.path.resolve())),
            ("size", f"{size:.1f} MB"),
            ("schema", str(check_file(catalogue.path))),
        ])  # fmt: skip
        print()
    write(COLUMNS, rows, form)


def migrate(db: options.Database = None) -> None:
    """Bring a catalogue to the newest schema, or make an empty one."""
    from orbitdb.store.database import default_path
    from orbitdb.store.migrate import migrate as bring

    path = db or default_path()
    before, after = bring(path)
    if before == after:
        note(f"{path}: schema {after}, the newest; nothing to do")
    else:
        note(f"{path}: schema {before} -> {after}" if before else f"{path}: made, schema {after}")
