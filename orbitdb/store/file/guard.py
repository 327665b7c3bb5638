"""Refuse files with active contents or with the journal of another file, and explain SQLite's errors.

SQLite runs parts of a file: triggers, views, virtual tables, generated columns, CHECK and DEFAULT
expressions, and indexes on expressions. So the schema is first read as text, which runs nothing. The tables
must be those of `orbitdb.store.file.schema`, and nothing else may be active. This takes about 0.3 ms. The
views in a file are for other programs; orbitdb makes its own for each reading connection (`own_views`).

SQLite keeps the latest changes in a journal, ``orbits.db-wal``, until it moves them into the file. It finds
the journal by name alone. If a killed process leaves a journal behind, and another file is then copied over
the catalogue, SQLite would apply the journal to that file. To detect this, every transaction of
`orbitdb.store.writing.writer.Writer` increases a count in the row of its run. A journal belongs to a file if
it continues the runs in the file.
"""

import json
import os
import sqlite3
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager, suppress
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

from orbitdb.errors import StoreError
from orbitdb.store.file.schema import REVISIONS, TABLES, VIEWS
from orbitdb.store.file.tokens import meaningful

_ACTIVE = {"CHECK", "GENERATED", "AS", "VIRTUAL", "WHERE"}

_OURS = {("table", name): text.split() for name, text in TABLES.items()}
"""The words of each table's CREATE statement."""

_KNOWN = _OURS | {("table", "alembic_version"): REVISIONS.split()}


class TamperedError(StoreError):
    """The schema of a file is not that of a catalogue.

    `parts` is the number of its tables, views, indexes and triggers; `faults` names those that are wrong,
    such as ``trigger t``.
    """

    def __init__(self, message: str, parts: int, faults: list[str]) -> None:
        super().__init__(message)
        self.parts = parts
        self.faults = faults


def refuse_tampered(connection: sqlite3.Connection, path: object, newest: bool) -> None:
    """Raise `TamperedError` if a file just opened has active parts or, if `newest`, the wrong tables.

    With `newest`, the tables must be those of the latest schema; a file to be migrated has older ones.
    """
    schema = connection.execute("SELECT type, name, sql FROM sqlite_master").fetchall()
    found = {(kind, name): (text or "").split() for kind, name, text in schema}
    others = [row for row in schema if _KNOWN.get(row[:2]) != found[row[:2]]]
    faults = [f"{kind} {name}" for kind, name, text in others if _acts(kind, text or "")]
    if newest and not faults:
        faults = [" ".join(which) for which in _OURS if _OURS[which] != found.get(which)]
    if faults:
        raise TamperedError(
            f"{path} is not as orbitdb made it ({faults[0]}); nothing in it was run: restore a copy, "
            "or fill a new one",
            len(schema),
            faults,
        )


def own_views(connection: sqlite3.Connection) -> None:
    """Create this version's views for a connection; they hide the views in the file."""
    connection.execute("PRAGMA temp_store = MEMORY")
    for text in VIEWS.values():
        connection.execute(text.replace("CREATE VIEW", "CREATE TEMP VIEW", 1))


def other_views(connection: sqlite3.Connection) -> list[str]:
    """Return the names of this version's views that are missing in a file or differ there."""
    found = connection.execute("SELECT name, sql FROM main.sqlite_master WHERE type = 'view'")
    texts = {name: (text or "").split() for name, text in found}
    return [name for name, text in VIEWS.items() if texts.get(name) != text.split()]


def renew_views(connection: sqlite3.Connection) -> None:
    """Update the views in a file, which other programs use, within the current transaction."""
    query = "SELECT 1 FROM main.sqlite_master WHERE type <> 'view' AND lower(name) = ?"
    for name in other_views(connection):
        if connection.execute(query, (name,)).fetchone() is None:  # unless something else has this name
            connection.execute(f"DROP VIEW IF EXISTS main.{name}")
            connection.execute(VIEWS[name])


def _acts(kind: str, text: str) -> bool:
    """Tell whether SQLite would run a part of a schema that no query names."""
    if kind not in ("table", "index"):
        return kind != "view"
    if not text:  # the index of a constraint
        return False
    found = meaningful(text)
    computes = any(one.keyword == "DEFAULT" and behind.text == "(" for one, behind in pairwise(found))
    if computes or any(token.keyword in _ACTIVE for token in found):
        return True
    return kind == "index" and sum(token.text == "(" for token in found) > 1


COUNT_COMMIT = (
    "UPDATE run SET parameters = json_set(parameters, '$.commits',"
    " coalesce(json_extract(parameters, '$.commits'), 0) + 1) WHERE id = ?"
)
"""SQL that adds 1 to the number of transactions in the row of a run."""


class Place(NamedTuple):
    """The identity of a file, whatever its name."""

    device: int
    inode: int


def place(path: Path) -> Place | None:
    """Return the identity of the file that is now at a path, or None if there is none."""
    try:
        found = path.stat()
    except OSError:
        return None
    return Place(found.st_dev, found.st_ino)


def need_place(path: Path, was: Place | None, told: str) -> None:
    """Raise `StoreError`, with a message that ends with `told`, if a path no longer has the same file."""
    now = place(path)
    if now != was:
        what = "moved or deleted" if now is None else "replaced by another file"
        raise StoreError(f"{path} was {what} while this command {told}")


def beside(path: Path) -> tuple[Path, Path]:
    """Return the paths of a file's journal and of the journal's index."""
    real = Path(os.path.realpath(path))
    return real.with_name(real.name + "-wal"), real.with_name(real.name + "-shm")


def refuse_foreign(
    path: Path, only_file: Callable[[], sqlite3.Connection], with_journal: Callable[[], sqlite3.Connection]
) -> None:
    """Raise `StoreError` if the journal next to a file belongs to another file.

    `only_file` opens the file without its journal, `with_journal` with it. Their connections must not be able
    to write, because the last one to close would otherwise move the journal into the file.
    """
    journal, index = beside(path)
    with suppress(OSError):
        if journal.stat().st_size and not _continues(only_file, with_journal):
            raise StoreError(
                f"{journal.name} is not the journal of {path}, but of a file that had this name before: move "
                f"{journal.name} and {index.name} away, and leave {path.name} where it is"
            )


def _continues(
    only_file: Callable[[], sqlite3.Connection], with_journal: Callable[[], sqlite3.Connection]
) -> bool:
    """Tell whether the last run recorded in a file without its journal is still there if the journal is read.

    Meanwhile, the read transaction keeps writers from moving more of the journal into the file.
    """
    with closing(with_journal()) as whole, closing(only_file()) as alone:
        try:
            whole.execute("BEGIN")
            known = _runs(whole)
        except sqlite3.OperationalError as error:
            if "no such table" not in str(error):
                return True  # locked, or without permission; opening it will say so
            known = {}
        except (sqlite3.DatabaseError, ValueError):
            known = {}
        try:
            runs = _runs(alone)
        except (sqlite3.Error, ValueError):
            return True  # nothing to compare: damaged, or the first pages are still in the journal
    if not runs:
        return True
    last = max(runs)
    (was, commits), (now, more) = runs[last], known.get(last, (None, 0))
    return was == now and commits <= more


def _runs(connection: sqlite3.Connection) -> dict[int, tuple[object, int]]:
    """Return for each run, by id, what identifies it and its number of transactions."""
    found: dict[int, tuple[object, int]] = {}
    for number, started, version, parameters in connection.execute("SELECT * FROM run"):
        asked = json.loads(parameters)
        commits = int(asked.pop("commits", 0))
        found[number] = ((started, version, json.dumps(asked, sort_keys=True)), commits)
    return found


@contextmanager
def plain_errors(path: Path) -> Iterator[None]:
    """Turn errors of SQLite into a `StoreError` that says what to do."""
    try:
        yield
    except Exception as error:
        cause = getattr(error, "orig", error)  # the error that SQLAlchemy wrapped
        if not isinstance(cause, sqlite3.Error | UnicodeDecodeError):
            raise
        if str(cause) == "interrupted":  # by a signal
            raise KeyboardInterrupt from error
        told = "malformed" if isinstance(cause, UnicodeDecodeError) else str(cause)  # text that is not UTF-8
        raise StoreError(remedy(path, told)) from error


def remedy(path: Path, message: str) -> str:
    """Return one line that says what an error of SQLite means and what to do."""
    remedies = {
        "locked": f"{path} is in use by another process that writes: try again when it has finished",
        "readonly": f"{path} cannot be written: check its permissions, or name another file with --db",
        "unable to open": f"{path} cannot be opened: check its permissions, and those of its folder",
        "disk is full": f"no space left for {path}: free some, then run the same command again to continue",
        "malformed": f"{path} is damaged: restore a copy, or move it away and fill a new one",
        "decode to UTF-8": f"{path} is damaged: restore a copy, or move it away and fill a new one",
        "not a database": f"{path} is not an orbitdb catalogue: name another file with --db",
        "disk I/O": f"{path} cannot be read or written (disk I/O error): check that the disk has room",
    }
    for part, remedy in remedies.items():
        if part in message:
            return remedy
    return f"{path}: {message}"
