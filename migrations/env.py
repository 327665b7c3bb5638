"""Alembic's environment: it runs the revisions on a catalogue, in a single transaction.

The program passes its own connection (`orbitdb.store.file.upgrade`). The command ``alembic`` works on the
file that ``-x db=PATH`` names, or on the default catalogue.
"""

from alembic import context
from sqlalchemy import Connection

from orbitdb.store import tables
from orbitdb.store.file import finish, upgrading
from orbitdb.store.file_kind import check_file
from orbitdb.store.paths import absolute_path
from orbitdb.store.views import drop_views


def run(connection: Connection) -> None:
    """Run what the command asks for; then the file gets the views and the version of its tables."""
    context.configure(connection=connection, target_metadata=tables.metadata, render_as_batch=True)
    drop_views(connection)  # SQLite renames no table that a view reads
    with context.begin_transaction():
        context.run_migrations()
    if (revision := context.get_context().get_current_revision()) is not None:
        finish(connection, int(revision))


if (own := context.config.attributes.get("connection")) is not None:
    run(own)
else:
    path = absolute_path(context.get_x_argument(as_dictionary=True).get("db"))
    check_file(path)  # never another program's database
    with upgrading(path) as opened:
        run(opened)
