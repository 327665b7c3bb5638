"""The page of all keys that work on a screen; it scrolls and can be searched."""

from typing import ClassVar

from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.widgets import Input, Static

from orbitdb.cli.tui.help import Explained, KeysLine, page_of, purpose
from orbitdb.cli.tui.screens import Field, OwnScreen, ScrollBox, TopLine, key


class KeysScreen(OwnScreen[None]):
    """Keys by purpose, each with what it does; the page shows those that contain what is sought."""

    AUTO_FOCUS = "#keys"
    BINDINGS: ClassVar[list[BindingType]] = purpose(
        "other",
        Binding("escape", "back", "back", tooltip="return to the screen"),
        key("q,question_mark", "dismiss", "back", tooltip="return to the screen"),
        Binding("slash", "seek", "search", tooltip="search the keys and what they do"),
    )

    def __init__(self, keys: list[Explained]) -> None:
        super().__init__()
        self._keys = keys

    def compose(self) -> ComposeResult:
        yield TopLine()
        yield Field(placeholder="/ searches", id="sought", compact=True)
        with ScrollBox(id="keys"):
            yield Static(page_of(self._keys))
        yield KeysLine()

    def on_mount(self) -> None:
        self.sub_title = "keys that work now"

    def on_input_changed(self, event: Input.Changed) -> None:
        self.query_one("#keys Static", Static).update(page_of(self._keys, event.value.strip()))

    def on_input_submitted(self) -> None:
        self.query_one("#keys").focus()

    def action_seek(self) -> None:
        self.query_one(Field).focus()

    def action_back(self) -> None:
        """Show all keys again, or leave the page if it shows them."""
        field = self.query_one(Field)
        if field.has_focus or field.value:
            field.value = ""
            self.query_one("#keys").focus()
        else:
            self.dismiss()
