"""The help: the keys of a screen in groups, and the columns of its table."""

from collections.abc import Iterable, Sequence
from typing import ClassVar

from rich.console import Group as Stack
from rich.console import RenderableType
from rich.table import Table
from rich.text import Text
from textual.app import ComposeResult
from textual.binding import BindingType
from textual.containers import Horizontal
from textual.dom import DOMNode
from textual.widgets import Static

from orbitdb.cli.tui.keys import Group, groups_of, key
from orbitdb.cli.tui.screens import Dialog, ScrollBox
from orbitdb.column import Column
from orbitdb.columns import IN_CATALOGUE


def columns_told() -> Group:
    """Return the columns that a filter can use, with their meanings."""
    return "columns that a filter can use", [(each.name, _told(each)) for each in IN_CATALOGUE]


def _told(column: Column) -> str:
    """Return a line with the meaning of a column, its unit, and the name of its error column."""
    unit = f" ({column.unit})" if column.unit not in ("", "1") else ""
    bound = f", ± {column.bound}" if column.bound.endswith("_error") else ""
    return f"{column.brief}{unit}{bound}"


class KeysDialog(Dialog[None]):
    """A list of the keys of the given widgets and screens and, if `columns` is set, of the columns."""

    BINDINGS: ClassVar[list[BindingType]] = [key("question_mark,q", "dismiss(None)")]

    def __init__(self, nodes: Iterable[DOMNode | None], columns: bool) -> None:
        super().__init__()
        self.groups = groups_of(getattr(node, "KEYS", {}) for node in nodes)
        self._columns = columns

    def compose(self) -> ComposeResult:
        """Lay out the groups of keys in two columns."""
        with ScrollBox(classes="dialog large") as box:
            box.border_title = "keys"
            box.border_subtitle = "escape closes"
            half = (len(self.groups) + 1) // 2
            with Horizontal(classes="halves"):
                yield Static(_listed(self.groups[:half]))
                yield Static(_listed(self.groups[half:]))
            if self._columns:
                yield Static(_listed([columns_told()]))


def _listed(groups: Sequence[Group]) -> Stack:
    parts: list[RenderableType] = []
    for title, told in groups:
        table = Table.grid(padding=(0, 2, 0, 0))
        for name, meaning in told:
            table.add_row(Text(name), Text(meaning))
        parts += [Text(title, "bold"), table, ""]
    return Stack(*parts)
