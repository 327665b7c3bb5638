"""Running SQL expressions for a limited time, and on texts of limited size."""

import sqlite3
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import sqlalchemy as sa

from orbitdb.store.asking import where as free
from orbitdb.store.asking.selection import SelectionError
from orbitdb.store.file.schema import VIEWS
from orbitdb.store.file.tables import driver

LONGEST_PATTERN = 500
_LONGEST_TEXT = 10_000_000
"""Room for a row with every text of a word of a million symbols."""

STEPS_BETWEEN_LOOKS = 200_000
"""Of SQLite, some milliseconds: a look waits for Python, which may be busy with the screen."""
_STEPS_BETWEEN_SIGNALS = 1_000_000
TABLES_OF_VIEW = {"cycle", "element", "stadium", "orbit", "change", "pruned"}


def never() -> bool:
    """Say that the result is still wanted."""
    return False


class CancelledError(Exception):
    """Nobody waits for the answer any more."""


class Patience:
    """How long a query may still work: some seconds from now on, and as long as somebody waits.

    The `deadline` is when it ends, as `time.monotonic` tells it; whoever fetches rows in parts adds the
    time between them.
    """

    def __init__(self, seconds: float | None = None, cancelled: Callable[[], bool] = never) -> None:
        self.deadline = time.monotonic() + (free.SECONDS if seconds is None else seconds)
        self.cancelled = cancelled

    @property
    def ended(self) -> bool:
        """Whether there is no time left, or nobody who waits."""
        return time.monotonic() > self.deadline or self.cancelled()


@contextmanager
def heeding(connection: sa.Connection, patience: Patience) -> Iterator[None]:
    """Let a connection answer a query, or fetch some of its rows, as long as somebody waits.

    It raises `CancelledError` if nobody waits any more.
    """
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
    """Let a connection answer for a limited time, that of the whole query, and with texts of limited size.

    Behind the block it is free for other queries, though rows may be left to be fetched in another block.
    What it may do besides computing is reading the views and their tables, or what `authorize` allows. It
    raises `CancelledError` if nobody waits any more, and for all else that SQLite says what `refusal` makes
    of it.
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
        if "interrupted" in message and not patience.ended:
            raise KeyboardInterrupt from error  # SQLite, asked for the time, swallows it
        raise refusal(message) from error
    finally:
        own.set_authorizer(None)
        for limit, size in before.items():
            own.setlimit(limit, size)
