"""Running free expressions: for a limited time, and on texts of limited size."""

import sqlite3
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import sqlalchemy as sa

from orbitdb.store.asking import expressions as free

LONGEST_PATTERN = 500
_LONGEST_TEXT = 10_000_000
"""Room for a row with every text of a word of a million symbols."""

_STEPS_BETWEEN_LOOKS = 10_000
TABLES_OF_VIEW = {"sequence", "cycle", "stadium", "orbit", "change"}


def never() -> bool:
    """Say that the result is still wanted."""
    return False


class Patience:
    """How long a query may still work; the time of those who use its rows does not count.

    Parameters
    ----------
    left : float, optional
        Seconds; by default `where.SECONDS`.
    cancelled : callable, optional
        Asked now and then whether nobody waits any more.
    """

    def __init__(self, left: float | None = None, cancelled: Callable[[], bool] = never) -> None:
        self._left = free.SECONDS if left is None else left
        self._started = time.monotonic()
        self._cancelled = cancelled

    @property
    def ended(self) -> bool:
        """Whether there is no time left, or nobody who waits."""
        return time.monotonic() - self._started > self._left or self._cancelled()

    @contextmanager
    def working(self) -> Iterator[None]:
        """Let the clock run."""
        self._started = time.monotonic()
        try:
            yield
        finally:
            if not self.ended:
                self._left -= time.monotonic() - self._started
                self._started = time.monotonic()


@contextmanager
def confined(
    connection: sa.Connection, patience: Patience, authorize: free.Authorizer | None = None
) -> Iterator[None]:
    """Let a connection run a checked expression, for a limited time and with texts of limited size.

    What it may do besides computing is reading the view, unless another authorizer says so.
    """
    driver = connection.connection.driver_connection
    assert isinstance(driver, sqlite3.Connection)
    sizes = {
        sqlite3.SQLITE_LIMIT_LENGTH: _LONGEST_TEXT,
        sqlite3.SQLITE_LIMIT_LIKE_PATTERN_LENGTH: LONGEST_PATTERN,
    }
    before = {limit: driver.setlimit(limit, size) for limit, size in sizes.items()}
    driver.set_authorizer(authorize or authorize_checked)
    driver.set_progress_handler(lambda: patience.ended, _STEPS_BETWEEN_LOOKS)
    try:
        with patience.working():
            yield
    finally:
        driver.set_progress_handler(None, 0)
        driver.set_authorizer(None)
        for limit, size in before.items():
            driver.setlimit(limit, size)


def authorize_checked(
    action: int, first: str | None, second: str | None, base: str | None, view: str | None
) -> int:
    """Allow, too, what a query over a checked expression needs: the view and its tables."""
    if action == sqlite3.SQLITE_READ and first in TABLES_OF_VIEW:
        return sqlite3.SQLITE_OK
    return free.authorize(action, first, second, base, view)


def authorize_joined(
    action: int, first: str | None, second: str | None, base: str | None, view: str | None
) -> int:
    """Allow, too, that the answers are joined: a checked expression cannot do it itself."""
    if action == sqlite3.SQLITE_FUNCTION and second == "group_concat":
        return sqlite3.SQLITE_OK
    return authorize_checked(action, first, second, base, view)
