"""Connections to SQLite that can wait for locks, be interrupted, and leave no journal behind."""

import atexit
import sqlite3
import threading
import time
import weakref
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

from orbitdb.store.file.guard import Place, beside, place

BUSY_TIMEOUT = 5.0
"""Seconds that SQLite waits for a lock."""

_TURNS = 12
"""Number of such waits after which a writer gives up; parallel fills hold the lock most of the time."""

_STEPS_BETWEEN_LOOKS = 1_000_000


def waiting(ask: Callable[[], object]) -> None:
    """Call `ask` until it gets a lock or the time is up; Ctrl-C works between attempts."""
    deadline = time.monotonic() + _TURNS * BUSY_TIMEOUT
    while True:
        try:
            ask()
            return
        except sqlite3.OperationalError as error:
            if error.sqlite_errorcode != sqlite3.SQLITE_BUSY or time.monotonic() >= deadline:
                raise
        time.sleep(0.01)  # because SQLite itself does not wait before it changes the journal mode


_open: "weakref.WeakSet[Connection]" = weakref.WeakSet()


@atexit.register
def _close_all() -> None:
    """Close the connections that an interruption has left open, so that no journal remains.

    While other threads run, a connection can be in use, and closing it would wait for its query.
    """
    if threading.active_count() == 1:
        for connection in list(_open):
            with suppress(sqlite3.Error):
                connection.close()


class Connection(sqlite3.Connection):
    """A connection that leaves no journal behind when it closes.

    SQLite keeps the journal while a query is open, such as an interrupted one. It also leaves the journal
    behind if the file is no longer at its path, and would take it for that of the next file with this name.
    """

    def __init__(self, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options)
        self._cursors: weakref.WeakSet[sqlite3.Cursor] = weakref.WeakSet()
        self._file: tuple[Path, Place | None] | None = None
        self._journal: dict[Path, Place | None] = {}
        _open.add(self)

    def remember_place(self, path: Path) -> None:
        """Remember which file and which journal are open; SQLite keeps them open until `close`."""
        self._file = path, place(path)
        self._journal = {part: place(part) for part in beside(path)}

    def cursor(self, factory: Any = sqlite3.Cursor) -> Any:
        """Return a cursor, which `close` closes."""
        cursor = super().cursor(factory)
        self._cursors.add(cursor)
        return cursor

    def execute(self, *arguments: Any) -> sqlite3.Cursor:
        """Execute a statement with a new cursor."""
        cursor: sqlite3.Cursor = self.cursor().execute(*arguments)
        return cursor

    def close(self) -> None:
        """End all queries, close the file, and remove its journal if the file is no longer in its place."""
        for cursor in list(self._cursors):
            cursor.close()
        super().close()
        if self._file is not None and (now := place(self._file[0])) != self._file[1]:
            for part, was in self._journal.items():
                if now is None or place(part) == was:
                    part.unlink(missing_ok=True)


def open_database(uri: str) -> Connection:
    """Connect to a database; Ctrl-C interrupts long queries."""
    connection = sqlite3.connect(
        uri, BUSY_TIMEOUT, uri=True, isolation_level=None, check_same_thread=False, factory=Connection
    )
    connection.execute("PRAGMA trusted_schema = OFF")
    connection.set_progress_handler(lambda: 0, _STEPS_BETWEEN_LOOKS)  # so that Python can handle signals
    return connection
