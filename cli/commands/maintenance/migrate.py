"""``orbitdb migrate``: an older catalogue is brought to the newest schema."""

from orbitdb.cli import options
from orbitdb.cli.render import note
from orbitdb.cli.storing import bring

EXAMPLES = ("migrate --db old.db",)


def migrate(db: options.Database) -> None:
    """Bring a catalogue to the newest schema, or make an empty one.

    An older catalogue is copied first; a message says where the copy is.
    """
    before, after, _ = bring(db)
    if before == after:
        note(f"{db}: schema {after}, the newest; nothing to do")
    elif not before:
        note(f"{db}: created, schema {after}")
