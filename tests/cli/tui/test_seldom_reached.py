"""Ways through the screen that are seldom taken: other keys, the mouse, rows that go meanwhile."""

import shutil

import pytest
from screens import drive, press, row_of, settle, shown, table_of
from textual.widgets import OptionList

from orbitdb.cli.tui.orbit.drawing import OrbitDrawing
from orbitdb.cli.tui.orbit.pictures import phase_points
from orbitdb.cli.tui.screens import QuestionDialog
from orbitdb.cli.tui.statistics.counts_screen import CountsScreen
from orbitdb.cli.tui.table import jumping
from orbitdb.cli.tui.table.pages import NONE
from orbitdb.orbits.single_word import solve_word
from orbitdb.store.asking.selection import Selection


def test_a_word_without_an_orbit_has_no_bounces_to_draw():
    assert phase_points(solve_word("00123", 1.6)).shape == (0, 2)


@pytest.mark.slow
def test_digits_that_are_typed_while_rows_are_read(filled, monkeypatch):
    monkeypatch.setattr(jumping, "PAUSE", float("inf"))

    async def steps(app, pilot):
        main, table = app.screen, table_of(app)
        # digits that are typed while the rows are still read lead on when they have been
        await press(pilot, "g")
        pages = table.source
        table.show(NONE)
        main.action_jump("8")
        assert (table.cursor, main.rows.jumping.note) == (0, "8 …")
        main.take_rows(pages)
        await settle(pilot)
        assert (len(row_of(app)[0]), main.rows.jumping.note) == (8, "period 8")

    drive(filled, steps)


@pytest.mark.slow
def test_the_mouse_beside_the_rows_and_windows_too_small_for_a_picture(filled):
    async def steps(app, pilot):
        main, table = app.screen, table_of(app)
        drawing = main.query_one(OrbitDrawing)
        # the frame around the rows is none of them
        row, ordering = table.cursor, main.ordering
        around = table.outer_size
        await pilot.click(table, offset=(around.width - 1, around.height - 1))
        await settle(pilot)
        assert (table.cursor, main.ordering) == (row, ordering)
        # no picture without room for one, and the next one is whole again
        size = app.size
        await pilot.resize_terminal(24, 10)
        await settle(pilot)
        narrow = [drawing.render_line(y).text.strip() for y in range(drawing.size.height + 1)]
        assert set(narrow) <= {""}
        await pilot.resize_terminal(*size)
        await settle(pilot)
        assert any(drawing.render_line(y).text.strip() for y in range(drawing.size.height))
        assert drawing.render_line(drawing.size.height).text.strip() == ""

    drive(filled, steps)


@pytest.mark.slow
def test_dialogs_and_counts_by_keys_and_mouse(filled):
    async def steps(app, pilot):
        # the counts scroll in a window of few lines
        await press(pilot, "d")
        assert isinstance(app.screen, CountsScreen)
        tallies = app.screen.query_one("#tallies")
        await press(pilot, "j", "j")
        assert tallies.scroll_y == 2
        await press(pilot, "k")
        assert tallies.scroll_y == 1
        await press(pilot, "escape")
        # the answer to a question, by the mouse
        answers: list[bool | None] = []
        for answer in ("no", "yes"):
            app.push_screen(QuestionDialog("leave?", yes="leave", no="stay"), answers.append)
            await settle(pilot)
            await pilot.click(f"#{answer}")
            await settle(pilot)
        assert answers == [False, True]
        # columns, marked by the mouse
        await press(pilot, "C")
        columns = app.screen.query_one(OptionList)
        columns.highlighted = 1
        await press(pilot, "end")
        assert "[ ] element" in shown(app)
        columns.action_select()
        await settle(pilot)
        assert "[x] element" in shown(app)
        await press(pilot, "escape")

    drive(filled, steps)


@pytest.mark.slow
def test_a_catalogue_that_comes_later_is_read_and_what_nobody_foresaw_is_not_hidden(filled_once, tmp_path):
    path = tmp_path / "new.db"

    async def steps(app, pilot):
        assert not app.catalogue
        shutil.copy(filled_once, path)
        await press(pilot, "ctrl+r")
        assert len(table_of(app).source) == app.catalogue.count(Selection()) > 0
        app.call_later(lambda: 1 / 0)
        await pilot.pause()

    with pytest.raises(ZeroDivisionError):
        drive(path, steps)
