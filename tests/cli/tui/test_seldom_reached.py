"""Ways through the screen that are seldom taken: other keys, the mouse, rows that go meanwhile."""

import shutil

import pytest
from screens import ask, drive, press, settle, shown, table_of
from textual.widgets import OptionList

from orbitdb.catalogue.catalogue import Catalogue
from orbitdb.cli.tui.orbit.drawing import OrbitDrawing
from orbitdb.cli.tui.orbit.pictures import phase_points
from orbitdb.cli.tui.screens import QuestionDialog
from orbitdb.cli.tui.statistics.counts_screen import CountsScreen
from orbitdb.cli.tui.table import jumping
from orbitdb.cli.tui.table.jumping import place_of
from orbitdb.cli.tui.table.pages import NONE, Pages
from orbitdb.orbits.births.lives import solve_word
from orbitdb.store.asking.selection import Selection


def test_digits_that_repeat_a_shorter_word_lead_nowhere_by_themselves(varied):
    catalogue = Catalogue(varied)
    pages = Pages(catalogue, catalogue.choose(Selection()), ("code",))
    assert place_of(pages, "131313") == (None, "no code 131313")


def test_a_word_without_an_orbit_has_no_bounces_to_draw():
    assert phase_points(solve_word("00123", 1.6)).shape == (0, 2)


@pytest.mark.slow
def test_codes_and_particles_that_begin_anew(filled):
    async def steps(app, pilot):
        main = app.screen
        # a code that repeats a shorter word
        await ask(pilot, "c", "1313")
        assert main.orbit.code == "13"
        assert any("1313 repeats 13" in note.message for note in app._notifications)
        # a new orbit takes the particle that runs to its beginning
        drawing = main.query_one(OrbitDrawing)
        drawing.particle = 3.0
        await press(pilot, "j")
        assert drawing.particle == 0.0

    drive(filled, steps)


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
        assert (len(table.row[0]), main.rows.jumping.note) == (8, "period 8")

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
        answers = []
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
def test_where_nothing_is_chosen_nothing_is_marked_or_followed(filled):
    async def steps(app, pilot):
        main, table = app.screen, table_of(app)
        # nothing is chosen, so that there is nothing to mark or to follow
        main.selection = Selection(where="p < 0")
        await settle(pilot)
        before = main.marked
        main.orbit = None
        await press(pilot, "asterisk", "greater_than_sign", "less_than_sign")
        assert main.orbit is None
        assert main.marked == before
        assert len(table.source) == 0

    drive(filled, steps)


@pytest.mark.slow
def test_a_catalogue_that_comes_later_is_read_and_what_nobody_foresaw_is_not_hidden(filled_once, tmp_path):
    path = tmp_path / "new.db"

    async def steps(app, pilot):
        assert app.catalogue is None
        shutil.copy(filled_once, path)
        await press(pilot, "ctrl+r")
        assert len(table_of(app).source) == app.catalogue.count(Selection()) > 0
        app.call_later(lambda: 1 / 0)
        await pilot.pause()

    with pytest.raises(ZeroDivisionError):
        drive(path, steps)
