"""The keys that work now, by purpose: the last line of a screen, and a page that can be searched."""

from collections.abc import Iterator
from dataclasses import replace
from itertools import groupby
from operator import itemgetter
from typing import Any, NamedTuple

from textual.app import App
from textual.binding import ActiveBinding, Binding, BindingType
from textual.content import Content
from textual.screen import Screen
from textual.style import Style
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
    """Return what a key does, as a phrase."""
    return binding.tooltip or binding.description


class Explained(NamedTuple):
    """The keys of an action, with its purpose and a phrase that says what it does."""

    purpose: str
    keys: str
    phrase: str


def keys_of(app: App[Any], screen: Screen[object]) -> list[Explained]:
    """Return the keys that work on a screen."""
    return [
        Explained(
            name,
            " ".join(dict.fromkeys(app.get_key_display(each.binding) for each in action)),
            explained(action[0].binding),
        )
        for name, actions in keys_by_purpose(screen)
        for action in actions
    ]


def page_of(keys: list[Explained], sought: str = "") -> Content:
    """Return the keys whose purpose, key or phrase contains a text, each purpose with its title."""
    found = [each for each in keys if any(sought.casefold() in text.casefold() for text in each)]
    width = max((len(each.keys) for each in keys), default=0)
    lines = []
    for name, group in groupby(found, itemgetter(0)):
        lines.append(Content.styled(name, "$muted"))
        lines += [
            Content.assemble((f"  {each.keys:>{width}}", "bold $key"), f"  {each.phrase}") for each in group
        ]
        lines.append(Content(""))
    return Content("\n").join(lines or [Content("no key does that")])


class KeysLine(Static):
    """The last line of a screen: its most used keys, each of which can be clicked.

    Textual's own `Footer` keeps every line that it has ever shown in memory.
    """

    def on_mount(self) -> None:
        self.screen.bindings_updated_signal.subscribe(self, self.show)
        self.show()

    def show(self, _: object = None) -> None:
        shown = {
            each.binding.action: each.binding
            for each in self.screen.active_bindings.values()
            if each.enabled and each.binding.show
        }
        parts = []
        for each in shown.values():  # a link has the colour of all links, so the key stands before it
            click = Style.from_meta({"@click": f"app.simulate_key({each.key.partition(',')[0]!r})"})
            name = self.app.get_key_display(each)
            parts.append(Content.assemble((name, "bold $key"), (f" {each.description}", click)))
        self.update(Content(" ").join(parts))
