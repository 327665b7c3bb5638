"""The line below the rows, and jumps: typed digits go to a period, or to a code that begins with them."""

import time
from collections.abc import Callable
from functools import partial

from rich.text import Text
from textual.reactive import reactive
from textual.widget import Widget

from orbitdb.cli.tui.paged_table import PagedTable
from orbitdb.cli.tui.pages import Place, place_of
from orbitdb.cli.tui.screens import Working

PAUSE = 2.0
"""Seconds without a key after which a digit begins a new number."""


class Position(Widget, Working):
    """The line below the rows: where typed digits led, if any, and the position of the cursor.

    `aside` names the current word if it has no row. `total` is the number of rows without a filter; it is
    None until they are counted.
    """

    aside: reactive[str] = reactive("")
    total: reactive[int | None] = reactive(None)

    def __init__(self, table: PagedTable, reads: Callable[[], bool]) -> None:
        super().__init__(id="position")
        self._table, self._reads = table, reads
        self._typed = ""
        self._typed_at = 0.0
        self._begun_at = self._landed = 0
        self._led_to: str | None = ""  # None during the search

    def render(self) -> Text:
        """Return where the digits led, until the cursor moves on, and the position of the cursor."""
        rows = len(self._table.source)
        known = "…" if self.total is None else f"{rows:,}"
        place = f"row {self._table.cursor + 1:,} of {known}" if rows else "no rows"
        return Text(" │ ".join(filter(None, (self.note, self.aside or place))))

    @property
    def under_way(self) -> bool:
        """Whether digits have been typed and the cursor is still on the row they led to."""
        return bool(self._typed) and self._landed == self._table.cursor

    @property
    def note(self) -> str:
        """Where the digits led; empty once the cursor has moved on."""
        result = f"{self._typed} …" if self._led_to is None else self._led_to
        return result if self.under_way else ""

    def take(self, digits: str) -> None:
        """Add typed or pasted digits, and go to the row that they stand for."""
        now = time.monotonic()
        if not self.under_way or now - self._typed_at > PAUSE:
            self._typed, self._begun_at = "", self._table.cursor
        self._typed_at = now
        self._jump(f"{self._typed}{digits}")

    def action_take_back(self) -> None:
        """Remove the last digit."""
        if self.under_way:
            self._jump(self._typed[:-1])

    def give_up_digits(self) -> bool:
        """Return to the row where typing began; tell whether any digits had been typed."""
        typed = self.under_way
        if typed:
            self._jump("")
        return typed

    def go_on(self) -> None:
        """Look up digits that were typed before the rows arrived."""
        if self._led_to is None and self.under_way:
            self._jump(self._typed)

    def _jump(self, typed: str) -> None:
        self._typed, self._landed, self._led_to = typed, self._table.cursor, None
        if not typed:
            self._land((self._begun_at, ""))
        elif not self._reads():
            self.in_thread("jump", partial(place_of, self._table.source, typed), self._arrive)
        self.refresh()

    def _arrive(self, place: Place) -> None:
        """Go to the row that was found, unless the cursor has moved on."""
        if self.under_way:
            self._land(place)

    def _land(self, place: Place) -> None:
        index, self._led_to = place
        self._table.cursor = self._landed = self._table.cursor if index is None else index
        self.refresh()
