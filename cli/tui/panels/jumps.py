"""Jumps in the rows: typed digits go to a period, or to a code that begins with them."""

import time
from collections.abc import Callable
from contextlib import suppress
from functools import partial

from orbitdb.cli.tui.panels.paged_table import PagedTable
from orbitdb.cli.tui.screens import Working
from orbitdb.cli.tui.stored import Pages
from orbitdb.symbols.words import SYMBOLS, WordError, least_rotation, parse_primitive

PAUSE = 2.0
"""Seconds without a key after which a digit begins a new number."""

Place = tuple[int | None, str]
"""The index of a row, or None, and a description of what was found there."""


def place_of(pages: Pages, typed: str, cancelled: Callable[[], bool]) -> Place:
    """Return the index of the first row that the typed digits stand for, and a description of it.

    A number of one or two digits is a period if there are rows of that period. Anything else is a code: a
    word in any rotation, or the beginning of the code of a row. Once `cancelled` returns True, this raises
    `CancelledError`.
    """
    assert pages.catalogue is not None
    period = int(typed) if len(typed) <= 2 and typed[0] != "0" else 0
    with pages.catalogue.snapshot(cancelled):
        place = pages.first_of_period(period) if period else None
        if place is not None:
            return place, f"period {period}"
        if not set(typed) <= set(SYMBOLS):
            return None, f"no period {period}" if period else f"no code {typed}"
        with suppress(WordError):
            place = pages.position(least_rotation(parse_primitive(typed)))
        if place is None:
            place = pages.first_that_begins(typed)
    return place, f"code {typed}" if place is not None else f"no code {typed}"


class Jumps(Working):
    """Base class of the panel of the rows: typed digits lead the cursor of its `table` to a row."""

    table: PagedTable
    _typed, _typed_at = "", 0.0
    _begun_at = _landed = 0
    _led_to = ""

    def say_place(self) -> None:
        """Show the position of the cursor, and where the digits led."""
        raise NotImplementedError

    @property
    def reads(self) -> bool:
        """Whether the rows are on their way."""
        raise NotImplementedError

    @property
    def under_way(self) -> bool:
        """Whether digits have been typed and the cursor is still on the row they led to."""
        return bool(self._typed) and self._landed == self.table.cursor

    @property
    def note(self) -> str:
        """Where the digits led; empty once the cursor has moved on."""
        return self._led_to if self.under_way else ""

    def type(self, digits: str) -> None:
        """Add typed or pasted digits, and go to the row that they stand for."""
        now = time.monotonic()
        if not self.under_way or now - self._typed_at > PAUSE:
            self._typed, self._begun_at = "", self.table.cursor
        self._typed_at = now
        self._jump(f"{self._typed}{digits}")

    def action_digit(self, digit: int) -> None:
        self.type(str(digit))

    def action_take_back(self) -> None:
        if self.under_way:
            self._jump(self._typed[:-1])

    def give_up_digits(self) -> None:
        """Return to the row where typing began."""
        if self.under_way:
            self._jump("")

    def forget_digits(self) -> None:
        """Begin anew with the next digit, because the digits led to a row of another subset."""
        self._typed = ""

    def go_on(self) -> None:
        """Look up digits that were typed before the rows arrived."""
        if self.under_way and self._led_to.endswith("…"):
            self._jump(self._typed)

    def _jump(self, typed: str) -> None:
        self._typed, self._landed, self._led_to = typed, self.table.cursor, f"{typed} …"
        if not typed:
            self.table.cursor = self._begun_at
        elif not self.reads:
            self.in_thread("jump", partial(place_of, self.table.source, typed), self._arrive)
        self.say_place()

    def _arrive(self, place: Place) -> None:
        """Go to the row that was found, unless the cursor has moved on."""
        if self.under_way:
            index, self._led_to = place
            self.table.cursor = self._landed = self.table.cursor if index is None else index
            self.say_place()
