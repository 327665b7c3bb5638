"""The keys that work now, by purpose, beside the screen."""

from collections.abc import Iterator
from dataclasses import replace
from itertools import groupby
from operator import itemgetter
from typing import ClassVar

from rich.style import Style
from rich.table import Table
from rich.text import Text
from textual.app import ComposeResult
from textual.binding import ActiveBinding, Binding, BindingType
from textual.containers import VerticalScroll
from textual.screen import Screen
from textual.widgets import Static

PURPOSES = ("move", "choose rows", "orbit", "other")


def purpose(name: str, *bindings: Binding) -> list[BindingType]:
    """Return bindings that the help lists under a purpose; it leaves out Textual's own, which have none."""
    return [replace(binding, id=name) for binding in bindings]


def keys_by_purpose(screen: Screen[object]) -> Iterator[tuple[str, list[list[ActiveBinding]]]]:
    """Yield each purpose with the bindings that serve it, those of the same action together."""
    active = [each for each in screen.active_bindings.values() if each.enabled and not each.binding.system]
    for name in PURPOSES:
        actions: dict[str, list[ActiveBinding]] = {}
        for each in active:
            if each.binding.id == name:
                actions.setdefault(each.binding.action, []).append(each)
        if actions:
            yield name, [*actions.values()]


def explained(binding: Binding) -> str:
    """Return what a key does."""
    return f"{binding.description} {binding.tooltip}".strip()


class KeysPanel(VerticalScroll, can_focus=False):
    """A list of the keys that work now."""

    COMPONENT_CLASSES: ClassVar[set[str]] = {"keys--key", "keys--purpose"}

    _listed: tuple[list[tuple[str, str, str]], list[Style]] | None = None

    def __init__(self, id: str | None = None) -> None:
        super().__init__(id=id)
        self._table = Static()  # known even if the panel is removed before it is mounted

    def compose(self) -> ComposeResult:
        yield self._table

    def on_mount(self) -> None:
        self.screen.bindings_updated_signal.subscribe(self, self.show)
        self.app.theme_changed_signal.subscribe(self, self.show)
        self.show()

    def show(self, _: object = None) -> None:
        """List the keys, unless the same ones are listed: a new list can give the focus to another widget."""
        styles = [self.get_component_rich_style(f"keys--{name}", partial=True) for name in ("key", "purpose")]
        listed = []
        for name, actions in keys_by_purpose(self.screen):
            for action in actions:
                bindings = [each.binding for each in action]
                keys = " ".join(dict.fromkeys(map(self.app.get_key_display, bindings)))
                listed.append((name, keys, explained(bindings[0])))
        if self._listed == (listed, styles):
            return
        self._listed = listed, styles
        table = Table.grid(padding=(0, 1, 0, 0))
        table.add_column(justify="right")
        for name, lines in groupby(listed, itemgetter(0)):
            table.add_row("", Text(name, styles[1]))
            for _, keys, text in lines:
                table.add_row(Text(keys, styles[0]), text)
            table.add_row()
        self._table.update(table)
