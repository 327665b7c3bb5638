"""The table: a scrolling view of all rows that reads only those on the screen."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import accumulate
from typing import Any, ClassVar

from rich.segment import Segment
from rich.style import Style
from textual import events
from textual.binding import BindingType
from textual.geometry import Size
from textual.message import Message
from textual.reactive import reactive
from textual.scroll_view import ScrollView
from textual.strip import Strip

from orbitdb.cli.output import number
from orbitdb.cli.tui.screens import key
from orbitdb.cli.tui.view import COLUMNS, EVERY, NONE, Column, Ordering, Pages, Row

_LONGEST_CODE = 24
_MARK = "*"
"""The sign after the code of a marked orbit."""


class PagedTable(ScrollView, can_focus=True):
    """The rows of a `Pages`, with a cursor on a row and one of its columns.

    A click on a heading sorts by that column.
    """

    COMPONENT_CLASSES: ClassVar[set[str]] = {"table--header", "table--cursor", "table--cell", "table--dim"}
    BINDING_GROUP_TITLE = "Rows"
    BINDINGS: ClassVar[list[BindingType]] = [
        key("j,down", "move(1)", "next row"),
        key("k,up", "move(-1)", "previous row"),
        key("pagedown,ctrl+f", "page(1)", "next page"),
        key("pageup,ctrl+b", "page(-1)", "previous page"),
        key("g,home", "first", "first row"),
        key("G,end", "last", "last row"),
        key("l,right", "column(1)", "next column"),
        key("h,left", "column(-1)", "previous column"),
    ]

    cursor: reactive[int] = reactive(0, repaint=False)
    column: reactive[int] = reactive(0)
    ordering: reactive[Ordering] = reactive(Ordering())
    columns: reactive[tuple[Column, ...]] = reactive(COLUMNS)
    marked: reactive[frozenset[str]] = reactive(frozenset())

    @dataclass
    class HeadingClicked(Message):
        """Asks to sort by the column whose heading was clicked."""

        column: str

    def __init__(self, id: str | None = None) -> None:
        super().__init__(id=id)
        self.source = NONE
        self._first = 1  # the first column after the code that is on the screen
        self._codes = NONE, range(0), COLUMNS[0].width  # the width of the codes, and the rows measured

    def show(self, source: Pages, cursor: int = 0) -> None:
        """Show other rows, with the cursor on the row at the given index."""
        self.source = source
        self._measure()
        self.set_reactive(PagedTable.cursor, max(0, min(cursor, len(source) - 1)))
        self._scroll_to_cursor()
        self.refresh()

    @property
    def row(self) -> Row | None:
        """The row under the cursor; None if there are no rows."""
        return self.source.row(self.cursor) if len(self.source) else None

    @property
    def cell(self) -> tuple[str, Any] | None:
        """The name of the column under the cursor, and its value; None if there are no rows."""
        if (row := self.row) is None:
            return None
        name = self._known()[self.column].name
        return name, row[self.source.fields.index(name)]

    def validate_cursor(self, cursor: int) -> int:
        return max(0, min(cursor, len(self.source) - 1))

    def validate_column(self, column: int) -> int:
        return max(0, min(column, len(self._known()) - 1))

    def watch_cursor(self, old: int, cursor: int) -> None:
        """Scroll to the cursor, and redraw the row that it left and the row that it reached."""
        self._scroll_to_cursor()
        for place in (old, cursor):
            self.refresh_line(place + 1)  # below the heading

    def watch_column(self, column: int) -> None:
        """Scroll so far that the column under the cursor is visible."""
        present = self._known()
        if 0 < column < self._first and present[column] not in self._visible()[0]:
            self._first = column
        while self._first < column and not any(present[column] in part for part in self._visible()):
            self._first += 1

    def watch_columns(self) -> None:
        self._first, self.column = 1, 0

    def _scroll_to_cursor(self) -> None:
        height = max(self.size.height - 1, 1)
        top = self.scroll_offset.y
        if not top <= self.cursor < top + height:
            target = self.cursor if self.cursor < top else self.cursor - height + 1
            self.scroll_to(y=target, animate=False, force=True, immediate=True)

    def _measure(self) -> None:
        self.virtual_size = Size(self.scrollable_content_region.width, len(self.source) + 1)

    def on_resize(self, event: events.Resize) -> None:
        self._measure()
        self._scroll_to_cursor()
        self.watch_column(self.column)

    def action_move(self, steps: int) -> None:
        self.cursor += steps

    def action_page(self, pages: int) -> None:
        self.cursor += pages * max(self.size.height - 2, 1)

    def action_first(self) -> None:
        self.cursor = 0

    def action_last(self) -> None:
        self.cursor = len(self.source) - 1

    def action_column(self, steps: int) -> None:
        """Move the cursor by a number of columns; the code stays in place when they scroll."""
        self.column += steps
        if not self.column and self._first > 1:
            self._first = 1
            self.refresh()

    def on_click(self, event: events.Click) -> None:
        """Sort by the column of the heading that was clicked, or go to the cell that was clicked."""
        offset = event.get_content_offset(self)
        if offset is None:
            return
        if offset.y > 0:
            self.cursor = self.scroll_offset.y + offset.y - 1
        x = 0
        for column, width in self._shown():
            if x <= offset.x < x + width:
                if offset.y > 0:
                    self.column = self._known().index(column) if column in self._known() else 0
                else:
                    self.post_message(self.HeadingClicked(column.name))
            x += width + 1

    def _shown(self) -> list[tuple[Column, int]]:
        """Return the columns that fit, including the sort column if possible, with their widths."""
        pinned, window = self._visible()
        return [(COLUMNS[0], self._code_width()), *((column, column.width) for column in pinned + window)]

    def _visible(self) -> tuple[list[Column], list[Column]]:
        """Return the sort column, if it would not be visible otherwise, and the columns that fit after it."""
        present, room = self._known(), self.scrollable_content_region.width - self._code_width()
        after = present[min(self._first, max(len(present) - 1, 1)) :]
        window = _fitting(after, room)
        pinned = EVERY[self.ordering.column]
        left = room - pinned.width - 1
        if pinned in (*window, COLUMNS[0]) or pinned.name not in self.source.fields or left < 0:
            return [], window
        return [pinned], _fitting([column for column in after if column != pinned], left)

    def _code_width(self) -> int:
        places = self._places()
        if self._codes[:2] != (self.source, places):  # this runs for every line
            widths = [COLUMNS[0].width, *(len(self.source.row(place)[0]) for place in places)]
            self._codes = self.source, places, max(widths)
        half = self.scrollable_content_region.width // 2  # the facts show the code in full
        return min(self._codes[2], max(half, COLUMNS[0].width), _LONGEST_CODE)

    def _known(self) -> list[Column]:
        """Return those of the columns that these rows have."""
        return [column for column in self.columns if column.name in self.source.fields]

    def _places(self) -> range:
        top = self.scroll_offset.y
        return range(top, min(top + max(self.size.height - 1, 0), len(self.source)))

    def render_line(self, y: int) -> Strip:
        base, shown = self.rich_style, self._shown()
        if y == 0:
            style = base + self.get_component_rich_style("table--header", partial=True)
            return self._line([(column, width, self._heading(column)) for column, width in shown], style)
        place = self.scroll_offset.y + y - 1
        if place >= len(self.source):
            return Strip.blank(self.scrollable_content_region.width, base)
        row = self.source.row(place)
        values = dict(zip(self.source.fields, row, strict=True))
        style = base
        if values["status"] != "orbit":
            style += self.get_component_rich_style("table--dim", partial=True)
        if place == self.cursor:
            style += self.get_component_rich_style("table--cursor", partial=True)
        cells = [(column, width, number(column.name, values.get(column.name))) for column, width in shown]
        return self._line(cells, style, _MARK if row[0] in self.marked else " ", place == self.cursor)

    def _heading(self, column: Column) -> str:
        if column.name != self.ordering.column:
            return column.name
        return column.name + ("▼" if self.ordering.descending else "▲")

    def _line(
        self, cells: list[tuple[Column, int, str]], style: Style, after_code: str = " ", current: bool = False
    ) -> Strip:
        """Return a line with the given cells; that of the current column is marked on the current row."""
        present = self._known()
        underlined = present[self.column] if current and self.column < len(present) else None
        marked = style + self.get_component_rich_style("table--cell", partial=True)
        segments = []
        for place, (column, width, text) in enumerate(cells):
            cut = text if len(text) <= width else text[: width - 1] + "…"
            shown = cut.ljust(width) if column.text else cut.rjust(width)
            segments.append(Segment(shown, marked if column == underlined else style))
            segments.append(Segment(" " if place else after_code, style))
        return Strip(segments).adjust_cell_length(self.scrollable_content_region.width, style)


def _fitting(columns: Sequence[Column], room: int) -> list[Column]:
    """Return as many of the columns as fit, from the first one on, with a blank before each."""
    ends = accumulate(column.width + 1 for column in columns)
    return [column for column, end in zip(columns, ends, strict=True) if end <= room]
