"""Keys and their effects, many of them in one session of the terminal UI."""

import os
import shutil
from typing import Any

import pytest
from screens import ask, browsing, press, row_of, screen_lines, settle, shown, table_of, until
from textual import events
from textual.actions import parse
from textual.command import CommandList
from textual.widgets import Input
from there import there

from orbitdb.catalogue import Catalogue
from orbitdb.cli.tui.app import BrowseApp
from orbitdb.cli.tui.counts_screen import CountsScreen
from orbitdb.cli.tui.dialogs import LineDialog, NameList
from orbitdb.cli.tui.fill_dialog import FillRequest, FillState, cost_of, fill_request
from orbitdb.cli.tui.main_screen import MainScreen
from orbitdb.cli.tui.panels.drawing import OrbitDrawing
from orbitdb.cli.tui.panels.facts import FactsPanel, facts_of, parts_of
from orbitdb.cli.tui.panels.filter_bar import FilterBar
from orbitdb.cli.tui.panels.orbit_panel import OrbitPanel
from orbitdb.cli.tui.panels.paged_table import PagedTable
from orbitdb.cli.tui.panels.rows_panel import RowsPanel
from orbitdb.cli.tui.screens import QuestionDialog, ScrollBox
from orbitdb.cli.tui.statistics_screen import StatisticsScreen
from orbitdb.cli.tui.stored import Ordering
from orbitdb.orbits.solve import solve_word
from orbitdb.orbits.status import Status
from orbitdb.selection import Selection
from orbitdb.symbols.symmetry import MIRROR_X, MIRROR_Y, REVERSE, images_of
from orbitdb.symbols.words import least_rotation


async def hurry(pilot, *pressed):
    """Press keys faster than the screen is drawn; drawing takes most of a test's time."""
    for key in pressed:
        pilot.app.post_message(events.Key(key, key if len(key) == 1 else None))
    await settle(pilot)


def headings(app):
    return screen_lines(app)[3].replace("│", " ").split()


async def click(pilot, x, y):
    await pilot.click(PagedTable, offset=(x, y))
    await settle(pilot)


def target(part, action) -> tuple[Any, str]:
    """Return the class that performs an action of the main screen, and the name of its method."""
    widgets: dict[Any, Any] = {
        "drawing": OrbitDrawing,
        "side": OrbitPanel,
        "chips": FilterBar,
        "rows": RowsPanel,
        "table": PagedTable,
    }
    _, name, parameters = parse(action)
    if name == "to":
        return target(widgets[parameters[0]], parameters[1])
    return part, f"action_{name}"


def test_every_key_has_a_description_and_an_action():
    parts: list[Any] = [PagedTable, MainScreen, BrowseApp, CountsScreen, StatisticsScreen, ScrollBox]
    every = [(part, each) for part in parts for each in part.BINDINGS]
    assert all(each.description for _, each in every)
    assert all(hasattr(*target(part, each.action)) for part, each in every)


def test_long_codes_and_orbits_are_abbreviated():
    orbits = [solve_word("13" * n + rest, 1.6) for n, rest in ((14, "11"), (15, "1"), (29, "11"), (30, "1"))]
    assert [orbit.p for orbit in orbits] == [30, 31, 60, 61]
    short, longer = (dict(facts_of(orbit)) for orbit in orbits[:2])
    assert (short["runs"], longer["runs"]) == ("(13)^14 11", "(13)^15 1")
    assert [len(parts_of(orbit, None)) for orbit in orbits] == [3, 3, 3, 1]  # facts, and bounces if few


@pytest.fixture
def path(varied, tmp_path):
    """A copy of the varied catalogue."""
    return shutil.copy(varied, tmp_path / "orbits.db")


@pytest.mark.slow
async def test_rows_are_chosen_and_sorted_by_keys_and_headings(path):
    async with browsing(path) as (app, pilot):
        main, table = app.screen, table_of(app)
        await hurry(pilot, "o", "r", "left_square_bracket")
        chosen = Selection(periods=((6, 6),), statuses=(Status.ORBIT,), time_reversal="self")
        assert main.choices.selection == chosen
        assert len(table.source) == app.catalogue.count(chosen)
        main.choices.selection = Selection()
        await settle(pilot)
        assert main.sub_title == Selection().describe()
        everything = app.catalogue.count(Selection())
        assert main.rows.report == f"{len(table.source):,} of {everything:,} words"
        main, table = app.screen, table_of(app)
        await press(pilot, "l", "l", "s")
        assert main.rows.ordering == table.ordering == Ordering("length")
        assert headings(app)[:3] == ["code", "p", "length▲"]
        await press(pilot, "R", "g")
        rows = app.catalogue.rows(Selection(), columns=("code",), order="length desc", limit=1)
        ((longest,),) = rows
        assert main.side.orbit.code == longest
        assert "length▼" in headings(app)
        await click(pilot, 13, 0)  # after a code of twelve symbols
        assert main.rows.ordering == Ordering("p")
        await click(pilot, 3, 6)
        assert main.side.orbit.code == table.source.row(5)[0]


@pytest.mark.slow
async def test_the_cursor_and_the_orbit_move_by_keys(path):
    async with browsing(path) as (app, pilot):
        main, table = app.screen, table_of(app)
        words = [code for (code,) in app.catalogue.rows(Selection(), columns=("code",))]
        await hurry(pilot, "g", "j", "j", "down", "k", "pagedown", "pageup", "k", "up", "up")
        assert (table.cursor, main.side.orbit.code) == (0, words[0])
        await press(pilot, "g")
        await press(pilot, "pagedown")
        assert table.cursor == table.size.height - 2
        assert main.side.orbit.code == words[table.cursor]
        await hurry(pilot, "G", "k", "pageup")
        assert row_of(app)[0] == words[len(words) - table.size.height]
        await ask(pilot, "c", "1320")
        assert row_of(app)[0] == "0132"
        assert str(main.rows.border_subtitle) == f"{words.index('0132') + 1:,} of {len(words):,}"
        seen = [main.side.orbit.code]
        for key, element in (("T", REVERSE), ("X", MIRROR_X), ("Y", MIRROR_Y)):
            await hurry(pilot, key)
            seen.append(main.side.orbit.code)
            assert seen[-1] == images_of(seen[-2])[element]
            assert row_of(app)[0] == least_rotation(seen[-1])
        assert main.query_one(FactsPanel).border_title == f"{seen[-2]}, mirrored up-down"
        await hurry(pilot, "y", "escape")
        assert app.clipboard == seen[-1]
        assert main.side.orbit.code == row_of(app)[0]
        await press(pilot, "g")
        await press(pilot, "v")
        assert main.query_one(OrbitDrawing).phase
        await press(pilot, "space")
        assert not main.query_one(OrbitDrawing).phase
        assert main.query_one(OrbitDrawing).particle is not None
        await press(pilot, "space")
        assert main.query_one(OrbitDrawing).particle is None


@pytest.mark.slow
async def test_refusals_are_reported_and_earlier_lines_come_back(path, monkeypatch):
    async with browsing(path) as (app, pilot):
        app.push_screen(LineDialog("a line", "new", others=["old", "new", "later"]))
        await pilot.pause()
        shown = app.screen.query_one(NameList).options
        assert [str(each.prompt) for each in shown] == ["old", "later"]
        line, seen = app.screen.query_one(Input), []
        for step in (1, 1, 1, -1, -1, -1):
            app.screen.action_older(step)
            listed = app.screen.query_one(NameList).highlighted
            seen.append((line.value, line.cursor_position, listed))
        lines = {"later": 1, "old": 0, "new": None}
        told = ["later", "old", "old", "later", "new", "new"]
        assert seen == [(text, len(text), lines[text]) for text in told]
        await press(pilot, "escape")
        await press(pilot, "ctrl+p")
        listed, places = app.screen.query_one(CommandList), []
        await until(lambda: listed.option_count > 2)
        for key in ("down", "down", "up"):
            await press(pilot, key)
            places.append(listed.highlighted)
        assert places == [1, 2, 1]
        await press(pilot, "escape")
        assert len(app.screen_stack) == 1
        titles = [command.title for command in app.get_system_commands(app.screen)]
        assert {"Filter the rows, as with --where", "Next row", "Quit", "Theme"} <= set(titles)
        assert "List all actions by name, and the themes" not in titles  # they are shown
        assert len(titles) == len(set(titles))
        assert all(titles)
        with monkeypatch.context() as patch:
            patch.setattr(os, "access", lambda path, mode: path != app.catalogue.path)
            await press(pilot, "f")
        assert isinstance(app.screen, MainScreen)
        assert any("read-only" in note.message for note in app._notifications)
        app.fill_state = FillState(FillRequest(1.6, (13,)))
        await press(pilot, "q")
        assert isinstance(app.screen, QuestionDialog)
        await press(pilot, "n")
        assert app.fill_state.state == "running"
        assert isinstance(app.screen, MainScreen)


def test_filling_words_and_periods_reports_counts(tmp_path):
    path = tmp_path / "orbits.db"
    reports: list[tuple[float, float, str]] = []
    for request in (FillRequest(1.6, words=("13", "013")), FillRequest(1.6, (3, 4))):
        fill_request(path, request, lambda *report: reports.append(report))
    assert [report[:2] for report in reports] == [(2, 2), (0, 40), (8, 40), (40, 40)]
    assert reports[-1][2] == "words, p =  4 of 4"
    assert cost_of(path, FillRequest(1.6, words=("13",))) == ("1 word to solve at a = 1.6", 1)
    assert cost_of(path, FillRequest(1.6, words=("13", "031"))) == ("2 words to solve at a = 1.6", 2)
    done, small = (cost_of(path, FillRequest(1.6, periods)) for periods in ((3, 4), (2,)))
    assert done == ("these periods are already filled at a = 1.6: nothing to do", 0)
    assert small[0].startswith("1 word to fill at a = 1.6: under a second, ")


@pytest.mark.slow
async def test_the_first_rows_appear_before_the_total_is_known(filled_once, monkeypatch):
    """The first row shown is the first of all rows; keys and codes entered meanwhile still take effect."""
    began = []

    def show(table, rows, cursor=0, show=PagedTable.show):
        show(table, rows, cursor)
        panel = table.screen.rows
        if panel.reads and len(rows):
            panel.wanted = "0132"
            began.append((len(rows), panel.reads, table.row, panel.total))

    monkeypatch.setattr(PagedTable, "show", show)
    async with browsing(filled_once) as (app, pilot):
        await settle(pilot)
        table, total = table_of(app), Catalogue(filled_once).count(Selection())
        ((count, reads, row, total_then),) = began
        assert count < total == len(table.source)
        assert (reads, there(row)[0], total_then) == (True, "13", None)
        assert there(table.row)[0] == "0132"
        assert table.source.row(0)[0] == "13"


@pytest.mark.slow
async def test_the_screen_says_that_the_shown_word_is_not_stored(varied):
    async with browsing(varied) as (app, pilot):
        await ask(pilot, "c", "1^20 3")
        assert "1^20 3 is not stored" in shown(app)
        await press(pilot, "j")
        assert "is not stored" not in shown(app)
        assert "2 of 397" in shown(app)


@pytest.mark.slow
async def test_keys_that_arrive_at_once_scroll_as_far_as_single_ones(filled_once):
    async with browsing(filled_once) as (app, pilot):
        await press(pilot, "enter")
        await hurry(pilot, *"jjjjjk")
        assert app.screen.query_one(FactsPanel).scroll_y == 4
        await press(pilot, "escape", "S")
        await hurry(pilot, "pagedown", *"jjj", *"lllh")
        box = app.screen.query_one(ScrollBox)
        assert (box.scroll_x, box.scroll_y) == (2, box.container_size.height + 3)


@pytest.mark.slow
async def test_a_wider_window_has_no_columns_hidden_from_a_narrower_one(filled_once):
    async with browsing(filled_once) as (app, pilot):
        await press(pilot, *"lllllll")
        assert "length" not in headings(app)
        await pilot.resize_terminal(220, 24)
        await settle(pilot)
        assert headings(app)[:4] == ["code", "p▲", "length", "status"]
