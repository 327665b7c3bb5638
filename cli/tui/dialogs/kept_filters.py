"""The filters that are kept by name: one of them is taken, or the present one is kept."""

from collections.abc import Callable, Mapping
from typing import ClassVar

from textual.binding import BindingType
from textual.widgets import OptionList

from orbitdb.cli.tui.dialogs.basic import ChoiceDialog
from orbitdb.cli.tui.screens import key

KEEP = ""
"""The answer that the present filter is to be kept; no filter has this name."""


class FiltersDialog(ChoiceDialog):
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

    BINDINGS: ClassVar[list[BindingType]] = [key("x,delete", "forget")]

    def __init__(self, filters: Mapping[str, str], forget: Callable[[str], None], present: str) -> None:
        names = {KEEP: "keep the present one …"} | {name: name for name in filters}
        super().__init__("filters", names, next(iter(filters), KEEP), {KEEP: present} | dict(filters))
        self._forget = forget

    def on_mount(self) -> None:
        """Say what the keys do."""
        self.query_one(".dialog").border_subtitle = "enter takes it, x forgets it"

    def action_forget(self) -> None:
        """Forget the filter under the cursor."""
        name, options = self.under_cursor, self.query_one(OptionList)
        if name != KEEP:
            self._forget(name)
            place = self.names.index(name)
            self.names.remove(name)
            options.remove_option_at_index(place)
            options.highlighted = min(place, len(self.names) - 1)
            self.on_option_list_option_highlighted()
