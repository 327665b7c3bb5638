"""Typing digits on the main screen: the cursor goes to a period, or to a code."""

import time
from dataclasses import dataclass
from typing import ClassVar

from textual import work
from textual.binding import Binding, BindingType
from textual.message import Message
from textual.worker import get_current_worker

from orbitdb.cli.tui.following_screen import FollowingScreen
from orbitdb.cli.tui.table.jumping import place_of
from orbitdb.cli.tui.table.paged_table import PagedTable
from orbitdb.cli.tui.table.source import Followed, Pages
from orbitdb.errors import StoreError
from orbitdb.store.asking.confinement import CancelledError
from orbitdb.store.asking.selection import Selection

PAUSE = 2.0
"""Seconds behind which a digit begins anew."""


class JumpingScreen(FollowingScreen):
    """The main screen, on which digits that are typed one after the other lead to a row."""

    BINDINGS: ClassVar[list[BindingType]] = [
        *(Binding(digit, f"jump('{digit}')", show=False) for digit in "0123456789"),
        Binding("backspace", "jump_back", show=False),
    ]

    @dataclass
    class Sought(Message):
        """A worker has sought what was typed."""

        pages: Pages
        typed: str
        place: int | None
        told: str

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
        self._typed, self._landed = typed, table.cursor
        self._waits = bool(typed)
        if not typed:
            self._land(self._begun_at, "")
            return
        self._led_to = f"{typed} …"
        self.say_position()
        if isinstance(pages, Pages) and pages.whole:  # else the other rows are still being read
            self._seek(pages, typed)

    @work(thread=True, exclusive=True, group="jump", description="jump")
    def _seek(self, pages: Pages, typed: str) -> None:
        """Seek what was typed, unless another key comes."""
        worker = get_current_worker()
        try:
            place, told = place_of(pages, typed, lambda: worker.is_cancelled)
        except CancelledError:
            return
        except StoreError as error:
            self.post_message(self.Failed(str(error)))
            return
        if not worker.is_cancelled:
            self.post_message(self.Sought(pages, typed, place, told))

    def on_jumping_screen_sought(self, message: Sought) -> None:
        """Go there, unless the cursor has moved on."""
        sought = message.pages is self._pages and message.typed == self._typed
        if sought and self._waits and self._jumps:
            self._waits = False
            self._land(message.place, message.told)

    def _land(self, place: int | None, told: str) -> None:
        table = self.query_one(PagedTable)
        self._led_to = told
        self._landed = table.cursor if place is None else place
        table.cursor = self._landed
        self.say_position()
