"""The guard: the file of a catalogue may hold data, but nothing active.

SQLite runs parts of a file: triggers, views, virtual tables, generated columns, CHECK and DEFAULT
expressions, indexes of expressions. The guard therefore first reads the schema of a file as text, which runs
nothing. The tables of the catalogue must be as in `orbitdb.store.file.schema`, and everything else must be
plain. This takes about 0.3 ms. The views in a file are for other programs. orbitdb makes its own for each
reading connection (`own_views`), and never runs those of the file.
"""

import sqlite3
from itertools import pairwise

from orbitdb.errors import StoreError
from orbitdb.store.file.schema import TABLES, VIEWS
from orbitdb.store.file.tokens import meaningful

_ACTIVE = {"CHECK", "GENERATED", "AS", "VIRTUAL", "WHERE"}

_OURS = {("table", name): text.split() for name, text in TABLES.items()}
"""The tables of a catalogue, each as the words of its statement."""


class TamperedError(StoreError):
    """The schema of a file is not that of a catalogue.

    `parts` counts its tables, views, indexes and triggers; `faults` names the wrong ones, such as
    ``trigger t``.
    """

    def __init__(self, message: str, parts: int, faults: list[str]) -> None:
        super().__init__(message)
        self.parts = parts
        self.faults = faults


def refuse_tampered(connection: sqlite3.Connection, path: object, newest: bool) -> None:
    """Refuse a file just opened that holds more than data, and name the first fault.

    If it need not have the newest schema, because it is about to be migrated, only active parts are refused.
    """
    schema = connection.execute("SELECT type, name, sql FROM sqlite_master").fetchall()
    found = {(kind, name): (text or "").split() for kind, name, text in schema}
    others = [row for row in schema if _OURS.get(row[:2]) != found[row[:2]]]
    faults = [f"{kind} {name}" for kind, name, text in others if _acts(kind, text or "")]
    if newest and not faults:
        faults = [" ".join(which) for which in _OURS if _OURS[which] != found.get(which)]
    if faults:
        raise TamperedError(
            f"{path} is not as orbitdb made it ({faults[0]}), and nothing of it was run: restore a copy, "
            "or fill a new one",
            len(schema),
            faults,
        )


def own_views(connection: sqlite3.Connection) -> None:
    """Make the views of this version for a connection, which replace those in the file."""
    connection.execute("PRAGMA temp_store = MEMORY")
    for text in VIEWS.values():
        connection.execute(text.replace("CREATE VIEW", "CREATE TEMP VIEW", 1))


def other_views(connection: sqlite3.Connection) -> list[str]:
    """Return the views in a file that differ from those of this version."""
    found = connection.execute("SELECT name, sql FROM main.sqlite_master WHERE type = 'view'")
    texts = {name: (text or "").split() for name, text in found}
    return [name for name, text in VIEWS.items() if texts.get(name) != text.split()]


def renew_views(connection: sqlite3.Connection) -> None:
    """Update the views in a file, which other programs use, within the current transaction."""
    query = "SELECT 1 FROM main.sqlite_master WHERE type <> 'view' AND lower(name) = ?"
    for name in other_views(connection):
        if connection.execute(query, (name,)).fetchone() is None:  # leaves a table of the same name alone
            connection.execute(f"DROP VIEW IF EXISTS main.{name}")
            connection.execute(VIEWS[name])


def _acts(kind: str, text: str) -> bool:
    """Tell whether a part of a schema is active, that is, runs without being asked."""
    if kind not in ("table", "index"):
        return kind != "view"
    found = meaningful(text)
    computes = any(one.keyword == "DEFAULT" and behind.text == "(" for one, behind in pairwise(found))
    if computes or any(token.keyword in _ACTIVE for token in found):
        return True
    return kind == "index" and sum(token.text == "(" for token in found) > 1
