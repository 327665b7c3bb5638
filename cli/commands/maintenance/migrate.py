"""``orbitdb migrate``: an older catalogue is brought to the newest schema."""

from orbitdb.cli import options
from orbitdb.cli.render import note
from orbitdb.cli.storing import bring

EXAMPLES = """
Example:

  orbitdb migrate --db old.db
"""


def migrate(db: options.Database = None) -> None:
    """Bring a catalogue to the newest schema, or make an empty one.

    An older catalogue is copied first; a message says where the copy is.
    """
    from orbitdb.store.file.database import default_path

    path = db or default_path()
    before, after, _ = bring(path)
    if before == after:
        note(f"{path}: schema {after}, the newest; nothing to do")
    elif not before:
        note(f"{path}: created, schema {after}")
