"""Jump by typing: digits lead to the first row of a period, or to a code that begins with them."""

import time
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from typing import TYPE_CHECKING

from orbitdb.cli.tui.table.pages import Pages
from orbitdb.store.asking.sql import never
from orbitdb.store.reading.matching import first_beginning, first_of_period, position_of
from orbitdb.symbols.words import SYMBOLS, WordError, least_rotation, parse_primitive

if TYPE_CHECKING:
    from orbitdb.cli.tui.table.panel import RowsPanel

PAUSE = 2.0
"""Seconds after which a digit starts again."""

Found = tuple[int | None, str]
"""The number of a row, or None, and its contents."""


def place_of(pages: Pages, typed: str, cancelled: Callable[[], bool] = never) -> Found:
    """Return the first row for the typed digits, and describe it.

    A number of one or two digits is a period if the rows have it. Everything else is a code: a word in any
    rotation, or the beginning of the code of a row. If ``cancelled`` returns True, `CancelledError` is
    raised.
    """
    assert pages.catalogue is not None
    period = int(typed) if len(typed) <= 2 and typed[0] != "0" else 0
    with pages.catalogue.moment() as moment:
        connection = moment.connection
        place = first_of_period(connection, pages.chosen, period) if period else None
        if place is not None:
            return place, f"period {period}"
        if not set(typed) <= set(SYMBOLS):
            return None, f"no period {period}" if period else f"no code {typed}"
        with suppress(WordError):
            place = position_of(connection, pages.chosen, least_rotation(parse_primitive(typed)))
        if place is None:
            place = first_beginning(connection, pages.chosen, typed, cancelled)
    return place, f"code {typed}" if place is not None else f"no code {typed}"


class Jumping:
    """The digits typed so far, and the row that they lead to."""

    def __init__(self, panel: "RowsPanel") -> None:
        self._panel = panel
        self._typed = ""
        self._typed_at = 0.0
        self._begun_at = self._landed = 0
        self._led_to: str | None = ""  # None during the search

    @property
    def under_way(self) -> bool:
        """Whether the cursor is where the digits led."""
        return bool(self._typed) and self._landed == self._panel.table.cursor

    @property
    def note(self) -> str:
        """The target of the digits, until the cursor moves on."""
        told = f"{self._typed} …" if self._led_to is None else self._led_to
        return told if self.under_way else ""

    def type(self, digit: str) -> None:
        """Go to the first row of a period, or whose code begins with the typed digits."""
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
        """Follow digits typed before the rows arrived."""
        if self._led_to is None and self.under_way:
            self._jump(self._typed)

    def _jump(self, typed: str) -> None:
        table = self._panel.table
        self._typed, self._landed, self._led_to = typed, table.cursor, None
        if not typed:
            self._land((self._begun_at, ""))
        elif not self._panel.reads:
            self._panel.screen.in_thread("jump", partial(place_of, table.source.pages, typed), self._arrive)
        self._panel.say_position()

    def _arrive(self, found: Found) -> None:
        """Go there, unless the cursor has moved on."""
        if self.under_way:
            self._land(found)

    def _land(self, found: Found) -> None:
        place, self._led_to = found
        table = self._panel.table
        table.cursor = self._landed = table.cursor if place is None else place
        self._panel.say_position()
