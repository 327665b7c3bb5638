"""The statuses that are shown, picked from a list."""

from collections.abc import Sequence
from typing import ClassVar

from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Vertical
from textual.screen import ModalScreen
from textual.widgets import Label, SelectionList
from textual.widgets.selection_list import Selection as Entry

from orbitdb.cli.tui.choices import SHOWN
from orbitdb.orbits.orbit import Status

Statuses = tuple[Status, ...]


class StatusDialog(ModalScreen[Statuses | None]):
    """Mark the statuses to be shown; none marked stands for every one.

    Parameters
    ----------
    current : sequence of Status
        Those that are chosen now.
    """

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("escape", "dismiss(None)", "Close", show=False),
        Binding("enter", "take", show=False, priority=True),
        Binding("j", "cursor('down')", show=False),
        Binding("k", "cursor('up')", show=False),
    ]

    def __init__(self, current: Sequence[Status]) -> None:
        super().__init__()
        self._current = current

    def compose(self) -> ComposeResult:
        """Show the statuses with what they mean."""
        with Vertical(classes="dialog bottom") as box:
            box.border_title = "statuses"
            box.border_subtitle = "space marks, enter takes; none marked: every status"
            yield SelectionList[Status](
                *(Entry(status.sentence, status, status in self._current) for status in SHOWN)
            )
            yield Label("", classes="complaint -note", markup=False)

    def action_cursor(self, direction: str) -> None:
        """Move as in the table."""
        getattr(self.query_one(SelectionList), f"action_cursor_{direction}")()

    def on_mount(self) -> None:
        """Say what is chosen now."""
        self._say()

    def on_selection_list_selected_changed(self) -> None:
        """Say what is marked."""
        self._say()

    def _say(self) -> None:
        """Say what is marked, for those who see no colours, too."""
        self.query_one(Label).update(f"marked: {', '.join(self._marked()) or 'none'}")

    def _marked(self) -> Statuses:
        marked = self.query_one(SelectionList).selected
        return tuple(status for status in SHOWN if status in marked)

    def action_take(self) -> None:
        """Take what is marked."""
        self.dismiss(self._marked())
