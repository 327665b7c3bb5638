"""The journal beside a catalogue: does it belong to the file, and is the file still in its place?

SQLite keeps the latest changes in ``orbits.db-wal`` until it moves them into the file. It finds the journal
by name alone. If a killed process left a journal, and another file was then copied over the catalogue, SQLite
would read the journal into that file. To notice this, each transaction of
`orbitdb.store.writing.writer.Writer` counts itself in the row of its run. A journal belongs to a file if it
continues the runs in the file itself.
"""

import json
import os
import sqlite3
from collections.abc import Callable
from contextlib import closing, suppress
from pathlib import Path
from typing import NamedTuple

from orbitdb.errors import StoreError

COUNT_COMMIT = (
    "UPDATE run SET parameters = json_set(parameters, '$.commits',"
    " coalesce(json_extract(parameters, '$.commits'), 0) + 1) WHERE id = ?"
)
"""SQL that counts a transaction in the row of its run."""


class Place(NamedTuple):
    """Identity of a file, whatever its name."""

    device: int
    inode: int


def place(path: Path) -> Place | None:
    """Return the file that has a path now, or None."""
    try:
        found = path.stat()
    except OSError:
        return None
    return Place(found.st_dev, found.st_ino)


def beside(path: Path) -> tuple[Path, Path]:
    """Return the paths of the journal and of its index."""
    real = Path(os.path.realpath(path))
    return real.with_name(real.name + "-wal"), real.with_name(real.name + "-shm")


def refuse_foreign(
    path: Path, only_file: Callable[[], sqlite3.Connection], with_journal: Callable[[], sqlite3.Connection]
) -> None:
    """Refuse a file next to the journal of another one.

    Parameters
    ----------
    path : Path
    only_file, with_journal : callable
        Connect to the file without its journal, and with it. Neither connection may write, because the last
        one to close would move the journal into the file.

    Raises
    ------
    StoreError
        If the journal does not continue the file.
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
    """Tell whether the last run of a file, read alone, is also a run of the file with its journal.

    The read transaction keeps writers from moving more of the journal into the file.
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
            return True  # nothing to compare: the beginning of the file is in its journal, or it is damaged
    if not runs:
        return True
    last = max(runs)
    (was, commits), (now, more) = runs[last], known.get(last, (None, 0))
    return was == now and commits <= more


def _runs(connection: sqlite3.Connection) -> dict[int, tuple[object, int]]:
    """Return each run with its number of transactions."""
    found: dict[int, tuple[object, int]] = {}
    for number, started, version, parameters in connection.execute("SELECT * FROM run"):
        asked = json.loads(parameters)
        commits = int(asked.pop("commits", 0))
        found[number] = ((started, version, json.dumps(asked, sort_keys=True)), commits)
    return found
