"""The filters that are kept by name: one of them is taken, or the present one is kept."""

from collections.abc import Callable, Mapping
from typing import ClassVar

from rich.text import Text
from textual.app import ComposeResult
from textual.binding import BindingType
from textual.containers import Vertical
from textual.widgets import Label, OptionList
from textual.widgets.option_list import Option

from orbitdb.cli.tui.dialogs.basic import NameList
from orbitdb.cli.tui.screens import ESCAPE, Dialog, key
from orbitdb.plaintext import printable

KEEP = ""
"""The answer that the present filter is to be kept; no filter has this name."""


class FiltersDialog(Dialog[str | None]):
    """Choose a filter by its name.

    Parameters
    ----------
    filters : mapping of str to str
        What each one chooses, in words.
    forget : callable
        Forgets one for good.
    present : str
        What is chosen now.
    """

    BINDINGS: ClassVar[list[BindingType]] = [ESCAPE, key("x,delete", "forget")]

    def __init__(self, filters: Mapping[str, str], forget: Callable[[str], None], present: str) -> None:
        super().__init__()
        self._filters, self._forget, self._present = dict(filters), forget, present

    def compose(self) -> ComposeResult:
        """Show the names, and what the one under the cursor chooses."""
        with Vertical(classes="dialog bottom") as box:
            box.border_title = "filters"
            box.border_subtitle = "enter takes it, x forgets it"
            yield NameList(
                Option("keep the present one …"),
                *(Option(Text(printable(name))) for name in self._filters),
            )
            yield Label("", classes="complaint -note", markup=False)

    @property
    def _under_cursor(self) -> str:
        """The name under the cursor."""
        return [KEEP, *self._filters][self.query_one(OptionList).highlighted or 0]

    def on_mount(self) -> None:
        """Begin at the first filter, if there is one."""
        self.query_one(OptionList).highlighted = min(len(self._filters), 1)

    def on_option_list_option_highlighted(self) -> None:
        """Say what it chooses."""
        self.query_one(Label).update(self._filters.get(self._under_cursor, self._present))

    def on_option_list_option_selected(self) -> None:
        """Take it."""
        self.dismiss(self._under_cursor)

    def action_forget(self) -> None:
        """Forget the filter under the cursor."""
        name, options = self._under_cursor, self.query_one(OptionList)
        if name == KEEP:
            return
        self._forget(name)
        place = options.highlighted or 0
        del self._filters[name]
        options.remove_option_at_index(place)
        options.highlighted = min(place, len(self._filters))
        self.on_option_list_option_highlighted()
