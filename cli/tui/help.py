"""The keys that work now, by purpose, beside the screen."""

from collections.abc import Iterator
from dataclasses import replace
from typing import ClassVar

from rich.table import Table
from rich.text import Text
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import VerticalScroll
from textual.screen import Screen
from textual.widgets import Static

PURPOSES = ("move", "choose rows", "orbit", "other")


def purpose(name: str, *bindings: Binding) -> list[BindingType]:
    """Return bindings that the help lists under a purpose; it leaves out Textual's own, which have none."""
    return [replace(binding, id=name) for binding in bindings]


def keys_by_purpose(screen: Screen[object]) -> Iterator[tuple[str, dict[str, list[Binding]]]]:
    """Yield each purpose with the bindings of every action that serves it."""
    active = [
        each.binding for each in screen.active_bindings.values() if each.enabled and not each.binding.system
    ]
    for name in PURPOSES:
        actions: dict[str, list[Binding]] = {}
        for binding in active:
            if binding.id == name:
                actions.setdefault(binding.action, []).append(binding)
        if actions:
            yield name, actions


class KeysPanel(VerticalScroll, can_focus=False):
    """A list of the keys that work now."""

    COMPONENT_CLASSES: ClassVar[set[str]] = {"keys--key", "keys--purpose"}

    def compose(self) -> ComposeResult:
        yield Static()

    def on_mount(self) -> None:
        self.screen.bindings_updated_signal.subscribe(self, self.show)
        self.app.theme_changed_signal.subscribe(self, self.show)
        self.show()

    def show(self, _: object = None) -> None:
        named, plain = (
            self.get_component_rich_style(f"keys--{name}", partial=True) for name in ("key", "purpose")
        )
        table = Table.grid(padding=(0, 1, 0, 0))
        table.add_column(justify="right")
        for name, actions in keys_by_purpose(self.screen):
            table.add_row("", Text(name, plain))
            for bindings in actions.values():
                keys = " ".join(dict.fromkeys(map(self.app.get_key_display, bindings)))
                table.add_row(Text(keys, named), f"{bindings[0].description} {bindings[0].tooltip}".strip())
            table.add_row()
        self.query_one(Static).update(table)
