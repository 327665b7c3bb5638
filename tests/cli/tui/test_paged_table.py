"""The table alone: after any keys and clicks each of its lines is that of a plain list of rows."""

import asyncio
import random

from textual.app import App, ComposeResult

from orbitdb.catalogue.catalogue import Catalogue
from orbitdb.cli.render import number
from orbitdb.cli.tui.table.columns import COLUMNS, Column, fields_of
from orbitdb.cli.tui.table.paged_table import PagedTable
from orbitdb.cli.tui.table.pages import Ordering, Pages
from orbitdb.store.asking.selection import Selection

MOVES = {"j": 1, "down": 1, "k": -1, "up": -1, "g": -(10**6), "home": -(10**6), "G": 10**6, "end": 10**6}
SHIFTS = {"l": 1, "right": 1, "h": -1, "left": -1}


class Alone(App[None]):
    """A terminal with nothing but the table."""

    CSS = "PagedTable > .table--cursor { background: red; }"

    def __init__(self) -> None:
        super().__init__()
        self.clicked: list[str] = []

    def compose(self) -> ComposeResult:
        yield PagedTable()

    def on_paged_table_heading_clicked(self, message: PagedTable.HeadingClicked) -> None:
        self.clicked.append(message.column)


def fitting(first: int, width: int) -> list[Column]:
    """Return the columns behind the code that there is room for, p among them: rows are sorted by it."""

    def those(columns, room):
        return [each for n, each in enumerate(columns) if sum(c.width + 1 for c in columns[: n + 1]) <= room]

    room, period = width - COLUMNS[0].width, COLUMNS[1]
    window = those(COLUMNS[first:], room)
    return window if period in window else [period, *those(COLUMNS[first:], room - period.width - 1)]


def cell(column: Column, value: object) -> str:
    text = number(column.name, value)
    cut = text if len(text) <= column.width else f"{text[: column.width - 1]}…"
    return f"{cut:{'<' if column.text else '>'}{column.width}}"


def test_lines_are_those_of_a_list_wherever_keys_lead(filled_once):
    catalogue, chosen = Catalogue(filled_once, 1.6), Selection(periods=((2, 5),))
    names = fields_of(COLUMNS, "p")
    rows = [dict(zip(names, row, strict=True)) for row in catalogue.rows(chosen, names)]
    pages = Pages(catalogue, catalogue.choose(chosen, str(Ordering())), names)
    source = random.Random(7)
    keys = ["k", *"jjjjjjjjj", "k", "pagedown", "G", "j", "pageup", "k", "g", *"llllllllllllll", "h"]
    keys += source.choices([*MOVES, *SHIFTS, "pagedown", "pageup", "click"], k=25)

    async def run() -> None:
        app, cursor, top, first = Alone(), 0, 0, 1
        async with app.run_test(size=(70, 12)) as pilot:
            table = app.query_one(PagedTable)
            table.focus()
            table.show(pages)
            table.marked = frozenset({rows[3]["code"], rows[8]["code"]})
            await pilot.pause()
            height, width = table.size.height - 1, table.scrollable_content_region.width
            for key in keys:
                if key == "click":
                    y = source.randrange(1, height + 1)
                    await pilot.click(table, offset=(3, y))
                    cursor = top + y - 1
                else:
                    await pilot.press(key)
                    cursor += MOVES.get(key, 0) + {"pagedown": height - 1, "pageup": 1 - height}.get(key, 0)
                    last = len(COLUMNS) - len(set(fitting(first, width)).intersection(COLUMNS[first:]))
                    first = max(1, min(first + SHIFTS.get(key, 0), last))
                cursor = max(0, min(cursor, len(rows) - 1))
                top = min(cursor, max(top, cursor - height + 1))
                shown = fitting(first, width)
                heading, *lines = (table.render_line(y) for y in range(height + 1))
                headings = [each.heading for each in (COLUMNS[0], *shown)]
                assert heading.text.replace("p▲", "p").split() == headings
                for row, line in zip(rows[top:], lines, strict=False):
                    cells = " ".join(cell(each, row[each.name]) for each in shown)
                    mark = "*" if row["code"] in table.marked else " "
                    assert line.text.rstrip() == f"{row['code']:<8}{mark}{cells}".rstrip()
                styles = [str(next(iter(line)).style) for line in lines]
                assert table.cursor == cursor
                assert styles.count(styles[cursor - top]) == 1
            await pilot.click(table, offset=(1, 0))
            assert app.clicked == ["code"]

    asyncio.run(run())
