"""Several names marked in a list: the statuses that are shown, or the columns and their order."""

from collections.abc import Collection, Mapping, Sequence
from typing import ClassVar

from rich.text import Text
from textual.app import ComposeResult
from textual.binding import BindingType
from textual.containers import Vertical
from textual.widgets import OptionList
from textual.widgets.option_list import Option

from orbitdb.cli.tui.dialogs.basic import NameList
from orbitdb.cli.tui.screens import ESCAPE, Dialog, key
from orbitdb.cli.tui.table.columns import EVERY, USUAL

Names = tuple[str, ...]


class MarksDialog(Dialog[Names | None]):
    """Mark some of several names.

    Parameters
    ----------
    title, hint : str
        Above the list, and below it.
    texts : mapping of str to str
        What is shown of each name, in their order.
    marked : collection of str
        Those that are marked now.
    """

    BINDINGS: ClassVar[list[BindingType]] = [
        ESCAPE,
        key("space", "mark", priority=True),
        key("enter", "take", priority=True),
    ]

    def __init__(self, title: str, hint: str, texts: Mapping[str, str], marked: Collection[str]) -> None:
        super().__init__()
        self._title, self._hint, self._texts = title, hint, texts
        self._names, self._marked = list(texts), set(marked)

    def compose(self) -> ComposeResult:
        """Show all names with what they mean."""
        with Vertical(classes="dialog bottom") as box:
            box.border_title, box.border_subtitle = self._title, self._hint
            yield NameList(*(Option(self._told(name)) for name in self._names))

    def _told(self, name: str) -> Text:
        return Text(f"[{'x' if name in self._marked else ' '}] {self._texts[name]}")

    @property
    def _list(self) -> OptionList:
        return self.query_one(OptionList)

    def on_mount(self) -> None:
        """Begin at the first name."""
        self._list.highlighted = 0

    def _show(self, *places: int) -> None:
        for place in places:
            self._list.replace_option_prompt_at_index(place, self._told(self._names[place]))

    def action_mark(self) -> None:
        """Mark the name, or unmark it."""
        place = self._list.highlighted or 0
        self._marked ^= {self._names[place]}
        self._show(place)

    def on_option_list_option_selected(self) -> None:
        """Mark with the mouse, too."""
        self.action_mark()

    def action_take(self) -> None:
        """Take the names that are marked, in their order."""
        self.dismiss(tuple(name for name in self._names if name in self._marked))


class ColumnDialog(MarksDialog):
    """Mark the columns to be shown, and move them; the code is always the first.

    Parameters
    ----------
    shown : sequence of str
        The columns that are shown now, in their order.
    """

    BINDINGS: ClassVar[list[BindingType]] = [
        key("J", "shift(1)"),
        key("K", "shift(-1)"),
        key("r", "usual"),
    ]

    def __init__(self, shown: Sequence[str]) -> None:
        width = max(map(len, EVERY))
        texts = {name: f"{name:{width}}  {column.brief}" for name, column in EVERY.items()}
        super().__init__("columns", "space marks, J K move, r: the usual, enter takes", texts, ())
        self._arrange(shown)

    def _arrange(self, shown: Sequence[str]) -> None:
        first = [name for name in shown if name != "code"]
        self._marked = set(first)
        self._names = first + [name for name in EVERY if name not in (*first, "code")]

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
