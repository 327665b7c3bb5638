"""The statuses that are shown, picked from a list."""

from collections.abc import Sequence
from typing import ClassVar

from rich.text import Text
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Vertical
from textual.widgets import OptionList
from textual.widgets.option_list import Option

from orbitdb.cli.tui.choices import SHOWN
from orbitdb.cli.tui.screens import Dialog
from orbitdb.orbits.orbit import Status

Statuses = tuple[Status, ...]


class StatusDialog(Dialog[Statuses | None]):
    """Mark the statuses to be shown; none marked stands for every one.

    Parameters
    ----------
    current : sequence of Status
        Those that are chosen now.
    """

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("escape", "dismiss(None)", "Close", show=False),
        Binding("space", "mark", show=False, priority=True),
        Binding("enter", "take", show=False, priority=True),
        Binding("j", "cursor('down')", show=False),
        Binding("k", "cursor('up')", show=False),
    ]

    def __init__(self, current: Sequence[Status]) -> None:
        super().__init__()
        self._marked = set(current)

    def compose(self) -> ComposeResult:
        """Show the statuses with what they mean."""
        with Vertical(classes="dialog bottom") as box:
            box.border_title = "statuses"
            box.border_subtitle = "space marks, enter takes; none marked: every status"
            yield OptionList(*(Option(self._told(status)) for status in SHOWN))

    def _told(self, status: Status) -> Text:
        return Text(f"[{'x' if status in self._marked else ' '}] {status.sentence}")

    @property
    def _list(self) -> OptionList:
        return self.query_one(OptionList)

    def on_mount(self) -> None:
        """Begin at the first status."""
        self._list.highlighted = 0

    def action_cursor(self, direction: str) -> None:
        """Move as in the table."""
        getattr(self._list, f"action_cursor_{direction}")()

    def action_mark(self) -> None:
        """Mark the status, or unmark it."""
        place = self._list.highlighted or 0
        self._marked ^= {SHOWN[place]}
        self._list.replace_option_prompt_at_index(place, self._told(SHOWN[place]))

    def on_option_list_option_selected(self) -> None:
        """Mark with the mouse, too."""
        self.action_mark()

    def action_take(self) -> None:
        """Take what is marked."""
        self.dismiss(tuple(status for status in SHOWN if status in self._marked))
