"""What the screen says when something fails, and its less common paths."""

import shutil
import sys
from functools import partial

import pytest
from screens import ask, browsing, press, settle, shown, table_of, until
from textual.widgets import OptionList
from there import there

from orbitdb.catalogue import Catalogue
from orbitdb.cli.tui import statistics_screen as statistics
from orbitdb.cli.tui.counts_screen import CountsScreen
from orbitdb.cli.tui.export import save_orbit, write_rows
from orbitdb.cli.tui.main_screen import MainScreen
from orbitdb.cli.tui.panels.drawing import OrbitDrawing
from orbitdb.cli.tui.panels.filter_bar import View
from orbitdb.cli.tui.screens import QuestionDialog
from orbitdb.cli.tui.statistics_screen import StatisticsScreen
from orbitdb.cli.tui.stored import Kept
from orbitdb.orbits.solve import solve_word
from orbitdb.selection import Selection
from orbitdb.store.sqlite import never


def errors(app):
    return [note.message for note in app._notifications if note.severity == "error"]


def test_exports_without_their_extra_name_it_and_leave_no_file(varied, tmp_path, monkeypatch):
    catalogue, orbit = Catalogue(varied), solve_word("13", 1.6)
    few = Selection(periods=((2, 3),))
    for path, write, module, told in (
        (
            tmp_path / "x.parquet",
            partial(write_rows, catalogue, View(few), cancelled=never),
            "pyarrow",
            "parquet",
        ),
        (tmp_path / "x.png", partial(save_orbit, orbit, False), "matplotlib", "plot"),
    ):
        for loaded in ("orbitdb.plots.style", "pyarrow.parquet"):
            monkeypatch.delitem(sys.modules, loaded, raising=False)
        monkeypatch.setitem(sys.modules, module, None)
        with pytest.raises(ModuleNotFoundError, match=rf"pip install 'orbitdb\[{told}\]'"):
            write(path)
    assert list(tmp_path.iterdir()) == []


def test_choices_that_cannot_be_saved_last_for_the_session(tmp_path):
    (tmp_path / "link").symlink_to(tmp_path / "nowhere")
    told: list[str] = []
    kept = Kept(tmp_path / "link" / "browse.json", told.append)
    with kept.changing() as state:
        state.marked.append("13")
    assert "your choice lasts for this session only" in told[0]
    assert kept.state.marked == ["13"]


@pytest.mark.slow
async def test_screens_report_a_damaged_catalogue(filled, monkeypatch):
    monkeypatch.setattr(statistics, "FIRST_BOUNCES", 100_000)
    async with browsing(filled) as (app, pilot):

        async def told(*keys, code=None):
            app.clear_notifications()
            await (press(pilot, *keys) if code is None else ask(pilot, keys[0], code))
            await until(lambda: errors(app))  # a slow machine may seem settled before the error appears
            return errors(app)

        filled.write_bytes(b"no catalogue" * 9999)
        damaged = f"{filled} is not an orbitdb catalogue: name another file"
        for key, shows in (("d", CountsScreen), ("S", StatisticsScreen)):
            assert damaged in await told(key)
            assert isinstance(app.screen, shows)
            await press(pilot, "escape")
            assert isinstance(app.screen, MainScreen)
        assert damaged in await told("c", code="0132132")
        assert "solving" not in shown(app)


@pytest.mark.slow
async def test_choices_that_cannot_be_saved_are_reported(filled_once, tmp_path):
    state = tmp_path / "browse.json"
    state.touch()
    async with browsing(filled_once, state=state) as (app, pilot):

        async def told(*keys):
            app.clear_notifications()
            await press(pilot, *keys)
            return [note.message for note in app._notifications]

        main = app.screen
        state.unlink()
        state.mkdir()
        failed, marked = await told("asterisk")
        assert failed == f"{state} cannot be read (Is a directory)"
        assert marked.startswith("marked 13, 1 in all")
        assert main.rows.marked == {"13"}  # for this session


@pytest.mark.slow
async def test_the_mouse_works_beside_the_rows_and_in_dialogs_and_small_windows(filled):
    async with browsing(filled) as (app, pilot):
        main, table = app.screen, table_of(app)
        drawing = main.query_one(OrbitDrawing)
        # the frame around the rows is not a row
        row, ordering = table.cursor, main.rows.ordering
        around = table.outer_size
        await pilot.click(table, offset=(around.width - 1, around.height - 1))
        await settle(pilot)
        assert (table.cursor, main.rows.ordering) == (row, ordering)
        # no picture without room for it; the next one is complete again
        size = app.size
        await pilot.resize_terminal(24, 10)
        await settle(pilot)
        narrow = [drawing.render_line(y).text.strip() for y in range(drawing.size.height + 1)]
        assert set(narrow) <= {""}
        await pilot.resize_terminal(*size)
        await settle(pilot)
        assert any(drawing.render_line(y).text.strip() for y in range(drawing.size.height))
        assert drawing.render_line(drawing.size.height).text.strip() == ""
        await press(pilot, "d")
        assert isinstance(app.screen, CountsScreen)
        tallies = app.screen.query_one("#tallies", OptionList)
        first = tallies.highlighted
        await press(pilot, "j", "j", "k")
        assert there(tallies.highlighted) == there(first) + 1
        await press(pilot, "escape")
        # answer a question with the mouse
        answers: list[bool | None] = []
        for answer in ("no", "yes"):
            app.push_screen(QuestionDialog("leave?", yes="leave", no="stay"), answers.append)
            await settle(pilot)
            await pilot.click(f"#{answer}")
            await settle(pilot)
        assert answers == [False, True]
        # mark columns with the mouse
        await press(pilot, "C")
        columns = app.screen.query_one(OptionList)
        columns.highlighted = 1
        await press(pilot, "end")
        assert "[ ] solver" in shown(app)
        columns.action_select()
        await settle(pilot)
        assert "[x] solver" in shown(app)
        await press(pilot, "escape")


@pytest.mark.slow
async def test_a_new_catalogue_is_read_and_unexpected_errors_are_raised(filled_once, tmp_path):
    path = tmp_path / "new.db"

    with pytest.raises(ZeroDivisionError):  # noqa: PT012  # raised when the session ends
        async with browsing(path) as (app, pilot):
            assert app.catalogue.missing
            shutil.copy(filled_once, path)
            await press(pilot, "ctrl+r")
            assert len(table_of(app).source) == app.catalogue.count(Selection()) > 0
            app.call_later(lambda: 1 / 0)
            await pilot.pause()
