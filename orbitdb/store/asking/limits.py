"""Limits on the time and the size of queries with SQL that users wrote."""

import sqlite3
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import sqlalchemy as sa

from orbitdb.store.asking import where as free
from orbitdb.store.asking.selection import SelectionError
from orbitdb.store.file.database import driver
from orbitdb.store.file.schema import VIEWS

SECONDS = 60.0
"""Time limit in seconds for a statement, or for a query with a free expression."""

LONGEST_PATTERN = 500
_LONGEST_TEXT = 10_000_000
"""Enough bytes for a row with all the texts of a word of a million symbols."""

STEPS_BETWEEN_LOOKS = 200_000
"""SQLite steps between checks, a few milliseconds; a check has to wait while Python is busy."""
_STEPS_BETWEEN_SIGNALS = 1_000_000
TABLES_OF_VIEW = {"cycle", "element", "stadium", "orbit", "change", "pruned"}


def never() -> bool:
    """Return False, because nobody cancels."""
    return False


class CancelledError(Exception):
    """The answer is no longer wanted."""


class Patience:
    """How long a query may still run: for a number of seconds from now, unless it is cancelled.

    The `deadline` is a time on the clock of `time.monotonic`. A caller that fetches rows in blocks adds the
    time that passes between the blocks.
    """

    def __init__(self, seconds: float | None = None, cancelled: Callable[[], bool] = never) -> None:
        self.deadline = time.monotonic() + (SECONDS if seconds is None else seconds)
        self.cancelled = cancelled

    @property
    def ended(self) -> bool:
        """Whether the time is up or the query has been cancelled."""
        return time.monotonic() > self.deadline or self.cancelled()


@contextmanager
def heeding(connection: sa.Connection, patience: Patience) -> Iterator[None]:
    """Let a connection run a query or fetch its rows; raise `CancelledError` once this is cancelled."""
    own = driver(connection)
    own.set_progress_handler(lambda: patience.ended, STEPS_BETWEEN_LOOKS)
    try:
        yield
    except (sa.exc.DBAPIError, sqlite3.Error, sqlite3.Warning) as error:
        if patience.cancelled():
            raise CancelledError from error
        raise
    finally:
        own.set_progress_handler(never, _STEPS_BETWEEN_SIGNALS)


@contextmanager
def confined(
    connection: sa.Connection,
    patience: Patience,
    refusal: Callable[[str], SelectionError],
    authorize: free.Authorizer | None = None,
) -> Iterator[None]:
    """Run a query under a time limit and a limit on the length of strings.

    To fetch more rows later, open another such context with the same `patience`. The query may evaluate
    expressions and read the views and their tables; `authorize` replaces these permissions. Raises
    `CancelledError` if the query is cancelled, and ``refusal(message)`` for any other error of SQLite.
    """
    own = driver(connection)
    sizes = {
        sqlite3.SQLITE_LIMIT_LENGTH: _LONGEST_TEXT,
        sqlite3.SQLITE_LIMIT_LIKE_PATTERN_LENGTH: LONGEST_PATTERN,
    }
    before = {limit: own.setlimit(limit, size) for limit, size in sizes.items()}
    own.set_authorizer(authorize or free.allowing(TABLES_OF_VIEW | VIEWS.keys(), own=VIEWS.keys()))
    try:
        with heeding(connection, patience):
            yield
    except (sa.exc.DBAPIError, sqlite3.Error, sqlite3.Warning) as error:
        message = str(getattr(error, "orig", error))
        if "interrupted" in message:
            if not patience.ended:
                raise KeyboardInterrupt from error  # SQLite swallows one that its progress handler raises
            message = f"it took more than {SECONDS:g} s"
        raise refusal(message) from error
    finally:
        own.set_authorizer(None)
        for limit, size in before.items():
            own.setlimit(limit, size)
