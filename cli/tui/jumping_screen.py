"""Typing digits on the main screen: the cursor goes to a period, or to a code."""

import time
from typing import ClassVar

from textual.binding import Binding, BindingType

from orbitdb.cli.tui.following_screen import FollowingScreen
from orbitdb.cli.tui.jumping import place_of
from orbitdb.cli.tui.source import Followed, Head, Pages
from orbitdb.cli.tui.table import PagedTable
from orbitdb.store.asking.selection import Selection

PAUSE = 2.0
"""Seconds behind which a digit begins anew."""


class JumpingScreen(FollowingScreen):
    """The main screen, on which digits that are typed one after the other lead to a row."""

    BINDINGS: ClassVar[list[BindingType]] = [
        *(Binding(digit, f"jump('{digit}')", show=False) for digit in "0123456789"),
        Binding("backspace", "jump_back", show=False),
    ]

    def __init__(self, selection: Selection, code: str | None = None) -> None:
        super().__init__(selection, code)
        self._typed = self._led_to = ""
        self._typed_at = 0.0
        self._waits = False
        self._begun_at: int | None = None
        self._landed: int | None = None

    @property
    def position_note(self) -> str:
        """Where the digits have led to, until the cursor moves on."""
        return self._led_to if self._jumps else ""

    @property
    def _jumps(self) -> bool:
        """Whether the cursor is where digits have led to."""
        return bool(self._typed) and self._landed == self.query_one(PagedTable).cursor

    def action_jump(self, digit: str) -> None:
        """Go to the first row of a period, or whose code begins with what was typed."""
        now = time.monotonic()
        if not self._jumps or now - self._typed_at > PAUSE:
            self._typed, self._begun_at = "", self.query_one(PagedTable).cursor
        self._typed_at = now
        self._jump(self._typed + digit)

    def action_jump_back(self) -> None:
        """Take the last digit back."""
        if self._jumps:
            self._jump(self._typed[:-1])

    def action_back(self) -> None:
        """Go back to where the digits began, or else show the row under the cursor as it is stored."""
        if self._jumps:
            self._jump("")
        else:
            super().action_back()

    def show_rows(self, rows: Pages, cursor: int) -> None:
        """Show the rows that have been read, and go where digits lead that came too early."""
        super().show_rows(rows, cursor)
        if self._waits and self._jumps:
            self._jump(self._typed)

    def _jump(self, typed: str) -> None:
        table = self.query_one(PagedTable)
        pages = table.source.pages if isinstance(table.source, Followed) else table.source
        self._typed, self._waits = typed, isinstance(pages, Head)
        if isinstance(pages, Head):  # the other rows are still being read
            place, self._led_to = None, f"{typed} …"
        else:
            place, self._led_to = place_of(pages, typed) if typed else (self._begun_at, "")
        self._landed = table.cursor if place is None else place
        table.cursor = self._landed
        self.say_position()
