"""Pages of the table: rows, keys and clicks agree with a plain list."""

import random

import model
import pytest
from contents import alter
from hypothesis import given
from hypothesis import strategies as st
from questions import CRITERIA, KEYS, NAMES, expected, make_catalogue_to_ask
from textual.app import App, ComposeResult

from orbitdb.catalogue import Catalogue
from orbitdb.cli.output import number
from orbitdb.cli.tui.panels.paged_table import PagedTable, width_of
from orbitdb.cli.tui.stored import SHOWABLE, USUAL, Ordering, Pages
from orbitdb.errors import SelectionError, StoreError
from orbitdb.selection import Selection
from orbitdb.store.where import CancelledError

NATURAL = Ordering()
SHOWN = ("code", "p", "length", "status", "symmetry", "representative", "element", "maslov")
ORDERINGS = st.builds(Ordering, KEYS, st.booleans())
PLACES = st.lists(st.floats(0, 1, exclude_max=True), max_size=6)


@pytest.fixture(scope="module")
def asked(made_once):
    """A catalogue, and all its rows as a list."""
    path = made_once("asked", make_catalogue_to_ask)
    return Catalogue(path), model.rows_of(path)


@pytest.fixture
def catalogue(asked):
    return asked[0]


def pages_of(catalogue, selection, ordering=NATURAL, columns=SHOWN):
    opened = Catalogue(catalogue.path)
    return Pages.read(opened, selection, ordering, columns, opened)


@pytest.mark.slow
@given(criteria=CRITERIA, ordering=ORDERINGS, names=NAMES, places=PLACES)
def test_pages_agree_with_a_list_and_find_words(asked, criteria, ordering, names, places):
    catalogue, rows = asked
    columns = tuple(dict.fromkeys(("code", *(name for name in names if name != "coordinates"))))
    wanted = expected(rows, criteria, str(ordering))
    pages = pages_of(catalogue, Selection.from_criteria(**criteria), ordering, columns)
    assert len(pages) == len(wanted)
    ends = {0, 63, 64, len(wanted) - 1} & set(range(len(wanted)))
    for place in {*ends, *(int(part * len(wanted)) for part in places if wanted)}:
        assert [pages.row(place)] == model.columns_of([wanted[place]], columns)
        assert pages.position(wanted[place]["code"]) == place
    others = sorted({row["code"] for row in rows} - {row["code"] for row in wanted})
    for word in (*others[:: len(others) // 5 + 1], "1" * 30 + "3"):
        assert pages.position(word) is None


def test_reading_can_be_cancelled(catalogue):
    two = Selection(periods=((2, 2),))  # so few rows that the query ends before it checks for cancellation
    with pytest.raises(CancelledError), catalogue.snapshot(cancelled=lambda: True) as then:
        list(then.rows(two, columns=("code",)))


def test_a_bad_filter_is_refused(catalogue):
    with pytest.raises(SelectionError, match="lenght"):
        pages_of(catalogue, Selection(where="lenght > 3"), Ordering())


def test_a_row_that_disappeared_is_reported(catalogue, tmp_path):
    path = tmp_path / "altered.db"
    path.write_bytes(catalogue.path.read_bytes())
    pages = pages_of(Catalogue(path), Selection(), Ordering())
    alter(path, "DELETE FROM orbit")
    with pytest.raises(StoreError, match="deleted meanwhile"):
        pages.row(0)


MOVES = {"j": 1, "down": 1, "k": -1, "up": -1, "g": -(10**6), "home": -(10**6), "G": 10**6, "end": 10**6}
SHIFTS = {"l": 1, "right": 1, "h": -1, "left": -1}


class Alone(App[None]):
    """An app with only the table."""

    CSS = "PagedTable > .table--cursor { background: red; } PagedTable > .table--dim { color: green; }"

    def __init__(self) -> None:
        super().__init__()
        self.clicked: list[str] = []

    def compose(self) -> ComposeResult:
        yield PagedTable()

    def on_paged_table_heading_clicked(self, message: PagedTable.HeadingClicked) -> None:
        self.clicked.append(message.column)


def fitting(first: int, width: int) -> list[str]:
    """Return the columns after the code that fit, always including p, by which rows are sorted."""

    def those(names, room):
        ends = (sum(width_of(name) + 1 for name in names[: n + 1]) for n in range(len(names)))
        return [name for name, end in zip(names, ends, strict=True) if end <= room]

    room = width - width_of("code")  # with a column for the sign that more columns follow
    window = those(USUAL[first:], room)
    return window if "p" in window else ["p", *those(USUAL[first:], room - width_of("p") - 1)]


def cell(name: str, value: object, room: int) -> str:
    """Return the text of a cell; texts stand a blank apart from the numbers before them.

    All symmetries are shown if there is `room` for them beyond the usual width.
    """
    is_number = SHOWABLE[name].kind in ("number", "integer")
    text, width = ("" if is_number else " ") + number(name, value), width_of(name)
    if name == "symmetry" and (whole := len(" x,y,xy,T,xT,yT,xyT")) <= width + room:
        width = whole
    cut = text if len(text) <= width else f"{text[: width - 1]}…"
    return f"{cut:{'>' if is_number else '<'}{width}}"


@pytest.mark.slow
async def test_lines_agree_with_a_list_after_any_keys(filled_once):
    catalogue, chosen = Catalogue(filled_once, 1.6), Selection(periods=((2, 5),))
    names = USUAL
    rows = [dict(zip(names, row, strict=True)) for row in catalogue.rows(chosen, columns=names)]
    pages = pages_of(catalogue, chosen, Ordering(), names)
    source = random.Random(7)
    keys = [*"kjjk", "pagedown", *"Gj", *["pageup"] * 3, *"kglllllllllllh"]
    keys += source.choices([*MOVES, *SHIFTS, "pagedown", "pageup", "click"], k=8)

    app, cursor, top, column = Alone(), 0, 0, 0
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
                cursor, column = top + y - 1, 0
            else:
                await pilot.press(key)
                cursor += MOVES.get(key, 0) + {"pagedown": height - 1, "pageup": 1 - height}.get(key, 0)
                column = max(0, min(column + SHIFTS.get(key, 0), len(USUAL) - 1))
            cursor = max(0, min(cursor, len(rows) - 1))
            top = min(cursor, max(top, cursor - height + 1))
            heading, *lines = (table.render_line(y) for y in range(height + 1))
            shown = heading.text.replace("p▲", "p").replace("›", "").split()[1:]
            assert shown in (fitting(first, width) for first in range(1, len(USUAL)))
            room = width - width_of("code") - 1 - sum(width_of(name) + 1 for name in shown)
            name = USUAL[column]
            assert name in ("code", *shown)
            assert table.cell == (name, rows[cursor][name])
            for row, line in zip(rows[top:], lines, strict=False):
                cells = " ".join(cell(name, row[name], room) for name in shown)
                mark = "*" if row["code"] in table.marked else " "
                assert line.text.rstrip() == f"{row['code']:<8}{mark}{cells}".rstrip()
            styles = [str(next(iter(line)).style) for line in lines]
            assert table.cursor == cursor
            here = enumerate(rows[top : top + height], top)
            assert [("#008000" in each, "on #ff0000" in each) for each in styles] == [
                (row["status"] != "orbit" and place != cursor, place == cursor) for place, row in here
            ]
        await pilot.click(table, offset=(1, 0))
        await pilot.click(table, offset=(1, 1))
        assert (app.clicked, table.cursor) == (["code"], top)
