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

from orbitdb.cli.output import code_text, number
from orbitdb.cli.tui.help import purpose
from orbitdb.cli.tui.screens import key
from orbitdb.cli.tui.stored import NONE, SHOWABLE, USUAL, Ordering, Pages, Row
from orbitdb.errors import AlteredError, DeletedError

_WIDTHS = {
    "code": 8, "p": 3, "length": 11, "status": 9, "lyapunov": 11, "margin": 9, "error": 8, "born": 11,
    "dies": 11, "solver": 10, "rules": 7, "cycle": 12,
}  # fmt: skip
"""Widths of the columns whose values are wider than their names."""

_WHOLE_SYMMETRY = 19
"""Width of that column where there is room for all seven symmetries, with a blank before them."""
_LONGEST_CODE = 24
_MORE = "›"
"""The sign at the end of the headings that more columns follow."""
_MARK = "*"
"""The sign after the code of a marked orbit."""


class PagedTable(ScrollView, can_focus=True):
    """The rows of a `Pages`, with a cursor on a row and one of its columns.

    A click on a heading sorts by that column.
    """

    COMPONENT_CLASSES: ClassVar[set[str]] = {"table--header", "table--cursor", "table--cell", "table--dim"}
    BINDINGS: ClassVar[list[BindingType]] = purpose(
        "move",
        key("j,down", "move(1)", "next row"),
        key("k,up", "move(-1)", "previous row"),
        key("pagedown,ctrl+f", "page(1)", "next page"),
        key("pageup,ctrl+b", "page(-1)", "previous page"),
        key("g,home", "end(False)", "first row"),
        key("G,end", "end(True)", "last row"),
        key("l,right", "column(1)", "next column"),
        key("h,left", "column(-1)", "previous column"),
    )

    cursor: reactive[int] = reactive(0, repaint=False)
    column: reactive[int] = reactive(0)
    ordering: reactive[Ordering] = reactive(Ordering())
    left_out: reactive[frozenset[str]] = reactive(frozenset())
    columns: reactive[tuple[str, ...]] = reactive(USUAL)
    marked: reactive[frozenset[str]] = reactive(frozenset())

    @dataclass
    class HeadingClicked(Message):
        """Asks to sort by the column whose heading was clicked."""

        column: str

    @dataclass
    class Deleted(Message):
        """Says that rows are missing, for a `reason`, an error's message; none are shown any more."""

        reason: str

    def __init__(self, id: str | None = None) -> None:
        super().__init__(id=id)
        self.source = NONE
        self._first = 1  # the first column after the code that is on the screen
        self._codes = NONE, range(0), _WIDTHS["code"]  # the width of the codes, and the rows measured

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
        return self._read(self.cursor)

    def _read(self, place: int) -> Row | None:
        """Return the row at an index; None if there are fewer rows, or rows have been deleted."""
        try:
            return self.source.row(place) if place < len(self.source) else None
        except (AlteredError, DeletedError) as error:
            self.show(NONE)
            self.screen.post_message(
                self.Deleted(str(error))
            )  # whoever asked, which could stop it on its way
            return None

    @property
    def current(self) -> str:
        """The name of the column under the cursor."""
        return self._present()[self.column] if self.column < len(self._present()) else "code"

    @property
    def cell(self) -> tuple[str, Any] | None:
        """The name of the column under the cursor, and its value; None if there are no rows."""
        if (row := self.row) is None:
            return None
        name = self.current
        return name, row[self.source.fields.index(name)]

    def validate_cursor(self, cursor: int) -> int:
        return max(0, min(cursor, len(self.source) - 1))

    def validate_column(self, column: int) -> int:
        return max(0, min(column, len(self._present()) - 1))

    def watch_cursor(self, old: int, cursor: int) -> None:
        """Scroll to the cursor, and redraw the row that it left and the row that it reached."""
        self._scroll_to_cursor()
        for place in (old, cursor):
            self.refresh_line(place + 1)  # below the heading

    def watch_column(self, column: int) -> None:
        """Scroll so far that the column under the cursor is visible."""
        present = self._present()
        if 0 < column < self._first and present[column] not in self._visible()[0]:
            self._first = column
        while self._first < column and not any(present[column] in part for part in self._visible()):
            self._first += 1

    def watch_columns(self) -> None:
        self._first, self.column = 1, 0

    def watch_left_out(self, before: frozenset[str]) -> None:
        """Keep the cursor on its column, if that is still there."""
        old = self._present(before)
        name = old[self.column] if self.column < len(old) else "code"
        present = self._present()
        self._first, self.column = 1, present.index(name) if name in present else 0

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
        self._first = 1  # what a narrower window hid may have room now
        self.watch_column(self.column)

    def action_move(self, steps: int) -> None:
        self.cursor += steps

    def action_page(self, pages: int) -> None:
        self.cursor += pages * max(self.size.height - 2, 1)

    def action_end(self, last: bool) -> None:
        self.cursor = last * len(self.source)

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
        for name, width in self._shown():
            if x <= offset.x < x + width:
                if offset.y > 0:
                    self.column = self._present().index(name) if name in self._present() else 0
                else:
                    self.post_message(self.HeadingClicked(name))
            x += width + 1

    def _shown(self) -> list[tuple[str, int]]:
        """Return the columns that fit, including the sort column if possible, with their widths."""
        pinned, window = self._visible()
        widths = {"code": self._code_width()} | {name: width_of(name) for name in pinned + window}
        used = sum(widths.values()) + len(widths) - widths.get("symmetry", 0)
        if "symmetry" in widths and used + _WHOLE_SYMMETRY <= self.scrollable_content_region.width:
            widths["symmetry"] = _WHOLE_SYMMETRY
        return [*widths.items()]

    def _visible(self) -> tuple[list[str], list[str]]:
        """Return the sort column, if it would not be visible otherwise, and the columns that fit after it."""
        present = self._present()
        room = self.scrollable_content_region.width - self._code_width() - 1  # `_MORE` may follow
        after = present[min(self._first, max(len(present) - 1, 1)) :]
        window, pinned = _fitting(after, room), self.ordering.column
        left = room - width_of(pinned) - 1
        if pinned in (*window, "code", *self.left_out) or pinned not in self.source.fields or left < 0:
            return [], window
        return [pinned], _fitting([name for name in after if name != pinned], left)

    def _code_width(self) -> int:
        places, least = self._places(), _WIDTHS["code"]
        if self._codes[:2] != (self.source, places):  # this runs for every line
            codes = [code_text(row[0]) for place in places if (row := self._read(place)) is not None]
            widest = max(map(len, codes), default=least)
            self._codes = self.source, places, max(widest, least)
        half = self.scrollable_content_region.width // 2  # the facts show the code in full
        return min(self._codes[2], max(half, least), _LONGEST_CODE)

    def _present(self, left_out: frozenset[str] | None = None) -> list[str]:
        """Return those of the columns that these rows have, except those `left_out`."""
        hidden = self.left_out if left_out is None else left_out
        return [name for name in self.columns if name in self.source.fields and name not in hidden]

    def _places(self) -> range:
        top = self.scroll_offset.y
        return range(top, min(top + max(self.size.height - 1, 0), len(self.source)))

    def render_line(self, y: int) -> Strip:
        base, shown = self.rich_style, self._shown()
        if y == 0:
            style = self.get_component_rich_style("table--header")
            line = self._line([(name, width, self._heading(name)) for name, width in shown], style)
            width = self.scrollable_content_region.width
            if shown[-1][0] == self._present()[-1] or not len(self.source):
                return line
            return Strip([*line.crop(0, width - 1), Segment(_MORE, style)])
        place = self.scroll_offset.y + y - 1
        if (row := self._read(place)) is None:
            return Strip.blank(self.scrollable_content_region.width, base)
        values = dict(zip(self.source.fields, row, strict=True))
        style = base if values["status"] == "orbit" else self.get_component_rich_style("table--dim")
        if place == self.cursor:
            style = self.get_component_rich_style("table--cursor")
        cells = [
            (name, width, code_text(row[0]) if name == "code" else number(name, values.get(name)))
            for name, width in shown
        ]
        return self._line(cells, style, _MARK if row[0] in self.marked else " ", place == self.cursor)

    def _heading(self, name: str) -> str:
        if name != self.ordering.column:
            return name
        return name + ("▼" if self.ordering.descending else "▲")

    def _line(
        self, cells: list[tuple[str, int, str]], style: Style, after_code: str = " ", current: bool = False
    ) -> Strip:
        """Return a line with the given cells; that of the current column is marked on the current row."""
        present = self._present()
        underlined = present[self.column] if current and self.column < len(present) else None
        marked = style + self.get_component_rich_style("table--cell", partial=True)
        segments = []
        for place, (name, width, text) in enumerate(cells):
            apart = "" if _is_number(name) or not place else " "  # from numbers, which end where texts begin
            cut = apart + (text if len(apart + text) <= width else text[: width - len(apart) - 1] + "…")
            shown = cut.rjust(width) if _is_number(name) else cut.ljust(width)
            segments.append(Segment(shown, marked if name == underlined else style))
            segments.append(Segment(" " if place else after_code, style))
        return Strip(segments).adjust_cell_length(self.scrollable_content_region.width, style)


def width_of(name: str) -> int:
    """Return the width of a column, with room for the arrow of the order, and for a blank before texts."""
    return max(_WIDTHS.get(name, 0), len(name) + 1) + (not _is_number(name))


def _is_number(name: str) -> bool:
    return SHOWABLE[name].kind in ("number", "integer")


def _fitting(names: Sequence[str], room: int) -> list[str]:
    """Return as many of the columns as fit, from the first one on, with a blank before each."""
    ends = accumulate(width_of(name) + 1 for name in names)
    return [name for name, end in zip(names, ends, strict=True) if end <= room]
