"""Dialogs with a list of names: to choose one name, or to mark several and change their order."""

from collections.abc import Callable, Collection, Mapping, Sequence
from typing import ClassVar

from rich.text import Text
from textual.app import ComposeResult
from textual.binding import BindingType
from textual.containers import Vertical
from textual.events import Key
from textual.widgets import OptionList

from orbitdb.cli.tui.columns import EVERY, USUAL
from orbitdb.cli.tui.keys import key
from orbitdb.cli.tui.screens import Dialog, Result
from orbitdb.plaintext import printable

KEEP = ""
"""The answer that saves the current filter; no saved filter has this name."""

Names = tuple[str, ...]


class NameList(OptionList):
    """A list in which j and k move the cursor, as in the table."""

    BINDINGS: ClassVar[list[BindingType]] = [key("j", "cursor_down"), key("k", "cursor_up")]


class ListDialog(Dialog[Result]):
    """A list of names, each shown as its text; the cursor starts at the name `current`."""

    def __init__(self, title: str, hint: str, texts: Mapping[str, str], current: str | None = None) -> None:
        super().__init__()
        self._title, self._hint, self._texts, self._current = title, hint, texts, current
        self._names = list(texts)
        self._typed, self._landed = "", -1  # the letters, and the index they led to

    def compose(self) -> ComposeResult:
        """Lay out the list."""
        with Vertical(classes="dialog bottom" if self._hint else "dialog small") as box:
            box.border_title, box.border_subtitle = self._title, self._hint
            yield NameList(*map(self._told, self._names))

    def on_mount(self) -> None:
        """Put the cursor on the current choice."""
        self._list.highlighted = self._names.index(self._current) if self._current in self._names else 0

    def on_key(self, event: Key) -> None:
        """Move the cursor to the first entry that begins with the typed letters; other keys work as usual."""
        letter = event.character if event.is_printable else None
        typed = self._typed if self._list.highlighted == self._landed else ""
        for text in (typed + letter, letter) if letter else ():
            for place, name in enumerate(self._names):
                if self._texts[name].startswith(text):
                    self._typed, self._landed, self._list.highlighted = text, place, place
                    event.stop()
                    event.prevent_default()
                    return

    def _told(self, name: str) -> Text:
        return Text(printable(self._texts[name]))

    @property
    def _list(self) -> OptionList:
        return self.query_one(OptionList)

    @property
    def _place(self) -> int:
        return self._list.highlighted or 0


class ChoiceDialog(ListDialog[str | None]):
    """Choose a name from a list."""

    def on_option_list_option_selected(self) -> None:
        """Close with the chosen name."""
        self.dismiss(self._names[self._place])


class FiltersDialog(ChoiceDialog):
    """Choose, save or delete a named filter; each name is shown with the meaning of its filter."""

    BINDINGS: ClassVar[list[BindingType]] = [key("delete,backspace", "forget")]

    def __init__(self, filters: Mapping[str, str], forget: Callable[[str], None], present: str) -> None:
        width = max(map(len, filters), default=0)
        texts = {name: f"{name:{width}}  {told}" for name, told in filters.items()}
        texts = {KEEP: f"save the current filter … ({present})"} | texts
        super().__init__("filters", "enter accepts, delete removes", texts, next(iter(filters), KEEP))
        self._forget = forget

    def action_forget(self) -> None:
        """Delete the filter under the cursor."""
        place = self._place
        if self._names[place] != KEEP:
            self._forget(self._names.pop(place))
            self._list.remove_option_at_index(place)
            self._list.highlighted = min(place, len(self._names) - 1)


class MarksDialog(ListDialog[Names | None]):
    """Mark any number of names in a list; `marked` are those marked at the start."""

    BINDINGS: ClassVar[list[BindingType]] = [
        key("space", "mark", priority=True),
        key("enter", "take", priority=True),
    ]

    def __init__(self, title: str, hint: str, texts: Mapping[str, str], marked: Collection[str]) -> None:
        super().__init__(title, hint, texts)
        self._marked = set(marked)

    def _told(self, name: str) -> Text:
        return Text(f"[{'x' if name in self._marked else ' '}] {self._texts[name]}")

    def _show(self, *places: int) -> None:
        for place in places:
            self._list.replace_option_prompt_at_index(place, self._told(self._names[place]))

    def action_mark(self) -> None:
        """Mark or unmark the name under the cursor."""
        self._marked ^= {self._names[self._place]}
        self._show(self._place)

    on_option_list_option_selected = action_mark  # a click does the same

    def action_take(self) -> None:
        """Close with the marked names, in the order of the list."""
        self.dismiss(tuple(name for name in self._names if name in self._marked))


class ColumnDialog(MarksDialog):
    """Choose which columns to show, and in which order; the code is always first."""

    BINDINGS: ClassVar[list[BindingType]] = [
        key("J", "shift(1)"),
        key("K", "shift(-1)"),
        key("R", "usual"),
    ]

    def __init__(self, shown: Sequence[str]) -> None:
        width = max(map(len, EVERY))
        texts = {name: f"{name:{width}}  {column.brief}" for name, column in EVERY.items()}
        super().__init__("columns", "space marks, J K move, R resets, enter accepts", texts, ())
        self._arrange(shown)

    def _arrange(self, shown: Sequence[str]) -> None:
        first = [name for name in shown if name != "code"]
        self._marked = set(first)
        self._names = first + [name for name in EVERY if name not in (*first, "code")]

    def action_shift(self, step: int) -> None:
        """Move the column under the cursor up or down by a step, and mark it to be shown."""
        place, other = self._place, self._place + step
        if 0 <= other < len(self._names):
            self._names[place], self._names[other] = self._names[other], self._names[place]
            self._marked.add(self._names[other])
            self._show(place, other)
            self._list.highlighted = other

    def action_usual(self) -> None:
        """Restore the default columns."""
        self._arrange(USUAL)
        self._show(*range(len(self._names)))
        self._list.highlighted = 0
