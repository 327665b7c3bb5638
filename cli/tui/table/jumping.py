"""Jumping by typing: digits lead to the first row of a period, or to a code that begins so."""

import time
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from typing import TYPE_CHECKING

from orbitdb.cli.tui.screens import in_thread
from orbitdb.cli.tui.table.pages import Pages
from orbitdb.store.asking.confinement import never
from orbitdb.symbols.words import SYMBOLS, WordError, least_rotation, parse_primitive

if TYPE_CHECKING:
    from orbitdb.cli.tui.table.panel import RowsPanel

PAUSE = 2.0
"""Seconds behind which a digit begins anew."""

Found = tuple[int | None, str]
"""The number of a row, or None, and what is in it."""


def place_of(pages: Pages, typed: str, cancelled: Callable[[], bool] = never) -> Found:
    """Return where what was typed leads to, and say what that is.

    A number of one or two digits is a period, if the rows have it. Everything else is a code: a word in
    any rotation, or else how the code of a row begins.

    Parameters
    ----------
    pages : Pages
        The rows in their order; the first that fits is meant.
    typed : str
        Digits.
    cancelled : callable, optional
        Asked now and then whether nobody waits any more.

    Raises
    ------
    CancelledError
        If nobody does.
    """
    from orbitdb.store.reading.places import first_beginning, first_of_period

    period = int(typed) if len(typed) <= 2 and typed[0] != "0" else 0
    with pages.catalogue.reading() as connection:
        place = first_of_period(connection, pages.chosen, period) if period else None
    if place is not None:
        return place, f"period {period}"
    if not set(typed) <= set(SYMBOLS):
        return None, f"no period {period}" if period else f"no code {typed}"
    with suppress(WordError):
        place = pages.position(least_rotation(parse_primitive(typed)))
    if place is None:
        with pages.catalogue.reading() as connection:
            place = first_beginning(connection, pages.chosen, typed, cancelled)
    return place, f"code {typed}" if place is not None else f"no code {typed}"


class Jumping:
    """The digits that have been typed one after the other, and the row that they lead to."""

    def __init__(self, panel: "RowsPanel") -> None:
        self._panel = panel
        self._typed = self._led_to = ""
        self._typed_at = 0.0
        self._waits = False
        self._begun_at: int | None = None
        self._landed: int | None = None

    @property
    def under_way(self) -> bool:
        """Whether the cursor is where digits have led to."""
        return bool(self._typed) and self._landed == self._panel.table.cursor

    @property
    def note(self) -> str:
        """Where the digits have led to, until the cursor moves on."""
        return self._led_to if self.under_way else ""

    def type(self, digit: str) -> None:
        """Go to the first row of a period, or whose code begins with what was typed."""
        now = time.monotonic()
        if not self.under_way or now - self._typed_at > PAUSE:
            self._typed, self._begun_at = "", self._panel.table.cursor
        self._typed_at = now
        self._jump(self._typed + digit)

    def take_back(self) -> None:
        """Take the last digit back."""
        if self.under_way:
            self._jump(self._typed[:-1])

    def give_up(self) -> None:
        """Go back to where the digits began."""
        self._jump("")

    def go_on(self) -> None:
        """Go where digits lead that came before the rows."""
        if self._waits and self.under_way:
            self._jump(self._typed)

    def _jump(self, typed: str) -> None:
        self._typed, self._landed = typed, self._panel.table.cursor
        self._waits = bool(typed)
        if not typed:
            self._land(self._begun_at, "")
            return
        self._led_to = f"{typed} …"
        self._panel.say_position()
        pages = self._panel.table.source.pages
        if pages is not None and pages.whole:  # else the other rows are still being read
            take = partial(self._arrive, pages, typed)
            in_thread(self._panel.screen, "jump", partial(place_of, pages, typed), take)

    def _arrive(self, pages: Pages, typed: str, found: Found) -> None:
        """Go there, unless the cursor has moved on, or there are other rows."""
        here = pages is self._panel.table.source.pages and typed == self._typed
        if here and self._waits and self.under_way:
            self._waits = False
            self._land(*found)

    def _land(self, place: int | None, told: str) -> None:
        table = self._panel.table
        self._led_to = told
        self._landed = table.cursor if place is None else place
        table.cursor = self._landed
        self._panel.say_position()
