"""The dialog that chooses which columns the table shows, and in which order."""

from collections.abc import Sequence
from typing import ClassVar

from rich.text import Text
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Vertical
from textual.widgets import OptionList
from textual.widgets.option_list import Option

from orbitdb.cli.tui.screens import Dialog
from orbitdb.cli.tui.table.columns import EVERY, USUAL
from orbitdb.columns import IN_CATALOGUE

_BRIEF = {column.name: column.brief for column in IN_CATALOGUE}
_WIDTH = max(map(len, EVERY))

Names = tuple[str, ...]


class ColumnDialog(Dialog[Names | None]):
    """Mark the columns to be shown, and move them; the code is always the first.

    Parameters
    ----------
    shown : sequence of str
        The columns that are shown now, in their order.
    """

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("escape", "dismiss(None)", "Close", show=False),
        Binding("space", "mark", show=False, priority=True),
        Binding("enter", "take", show=False, priority=True),
        Binding("J", "shift(1)", show=False),
        Binding("K", "shift(-1)", show=False),
        Binding("r", "usual", show=False),
        Binding("j", "cursor('down')", show=False),
        Binding("k", "cursor('up')", show=False),
    ]

    def __init__(self, shown: Sequence[str]) -> None:
        super().__init__()
        self._arrange(shown)

    def _arrange(self, shown: Sequence[str]) -> None:
        self._marked = set(shown) - {"code"}
        first = [name for name in shown if name != "code"]
        self._names = first + [name for name in EVERY if name not in (*first, "code")]

    def compose(self) -> ComposeResult:
        """Show all columns with what they mean."""
        with Vertical(classes="dialog bottom") as box:
            box.border_title = "columns"
            box.border_subtitle = "space marks, J K move, r: the usual, enter takes"
            yield OptionList(*(Option(self._told(name)) for name in self._names))

    def _told(self, name: str) -> Text:
        mark = "x" if name in self._marked else " "
        return Text(f"[{mark}] {name:{_WIDTH}}  {_BRIEF[name]}")

    @property
    def _list(self) -> OptionList:
        return self.query_one(OptionList)

    def on_mount(self) -> None:
        """Begin at the first column."""
        self._list.highlighted = 0

    def _show(self, *places: int) -> None:
        for place in places:
            self._list.replace_option_prompt_at_index(place, self._told(self._names[place]))

    def action_cursor(self, direction: str) -> None:
        """Move as in the table."""
        getattr(self._list, f"action_cursor_{direction}")()

    def action_mark(self) -> None:
        """Show the column, or leave it out."""
        place = self._list.highlighted or 0
        self._marked ^= {self._names[place]}
        self._show(place)

    def action_shift(self, step: int) -> None:
        """Move the column, which is shown then."""
        place = self._list.highlighted or 0
        other = place + step
        if not 0 <= other < len(self._names):
            return
        self._names[place], self._names[other] = self._names[other], self._names[place]
        self._marked.add(self._names[other])
        self._show(place, other)
        self._list.highlighted = other

    def action_usual(self) -> None:
        """Show what is shown where nothing was chosen."""
        self._arrange(USUAL)
        self._show(*range(len(self._names)))
        self._list.highlighted = 0

    def on_option_list_option_selected(self) -> None:
        """Mark with the mouse, too."""
        self.action_mark()

    def action_take(self) -> None:
        """Take the columns that are marked, in their order."""
        self.dismiss(("code", *(name for name in self._names if name in self._marked)))
