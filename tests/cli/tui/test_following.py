"""The screen shows one stadium at a time, follows an orbit and its rows in a, and says what is not filled."""

import asyncio
import threading

import numpy as np
import pytest
from contents import answer, made
from screens import LARGE, browsing, press, row_of, settle, shown, table_of, until, write
from textual.widgets import Input
from there import there

from orbitdb.answers.completeness import lacking_births, unfilled
from orbitdb.billiard.stadium import Stadium
from orbitdb.cli.tui.catalogue_file import CatalogueFile
from orbitdb.cli.tui.dialogs.fill import FillDialog
from orbitdb.cli.tui.dialogs.lines import LineDialog
from orbitdb.cli.tui.orbit.drawing import OrbitDrawing
from orbitdb.cli.tui.orbit.facts import bar
from orbitdb.cli.tui.table.following import next_a, told
from orbitdb.filling.births import fill_births
from orbitdb.filling.fill import fill_geometric, fill_periods
from orbitdb.orbits.orbit import solve_word
from orbitdb.store.asking.selection import Selection
from orbitdb.store.reading.lives import counts_at
from orbitdb.symbols.words import least_rotation

BORN, DIED, REBORN = 0.386252501738, 0.473270308236, 0.605684335145
LIVES = [(BORN, DIED), (REBORN, None)]


@pytest.fixture(scope="module")
def born(tmp_path_factory):
    """A catalogue with p = 2..5 at a = 1.6, births of p = 5, and some pruned words."""
    path = tmp_path_factory.mktemp("born") / "orbits.db"
    return made(path, fill_periods(path, 1.6, range(2, 6)), fill_births(path, [5]), fill_geometric(path, [3]))


def test_a_step_stops_on_both_sides_of_a_change():
    way, a = [], 0.46
    while a < 0.62:
        way.append(a)
        a = next_a(LIVES, a, True)
    beside = [a for a in way if min(abs(a / end - 1) for end in (DIED, REBORN)) < 1e-8]
    assert [a < DIED or a > REBORN for a in beside] == [True, False, False, True]
    assert next_a(LIVES, beside[1], False) == pytest.approx(beside[0])
    assert next_a((), 1.0, True) == pytest.approx(1.02, abs=1e-3)
    assert next_a([(0.5, 0.5005)], 0.501, False) == pytest.approx(0.5005, rel=1e-8)  # the nearer end
    assert told(LIVES, beside[0], beside[1]) == "gone at a = 0.473270308236"
    assert told(LIVES, beside[3], beside[2]) == "gone at a = 0.605684335145"
    assert told(LIVES, beside[2], beside[3]) == "born at a = 0.605684335145"
    assert told(LIVES, 1.0, 1.1) is None
    for end in (BORN, DIED):  # starting at an end does not cross it
        assert told(LIVES, end, end * 1.001) is told(LIVES, end * 0.999, end) is None


def test_a_step_stops_at_the_stadium_of_the_rows():
    down = next_a((), 1.6, False, 1.6)
    assert down < 1.59
    assert next_a((), down, True) != 1.6  # off by rounding
    assert next_a((), down, True, 1.6) == 1.6
    assert next_a((), 1.59, True, 1.6) == 1.6
    birth = [(1.6, None)]
    assert next_a(birth, 1.59, True, 1.6) < 1.6
    assert next_a(birth, next_a(birth, 1.59, True, 1.6), True, 1.6) == 1.6


def test_the_bar_shows_lives_and_position():
    assert bar(LIVES, 1.0, 24) == "········━·━━┃━━━━━━━━━━━"
    assert bar([(0.0, None)], 1e-4, 6) == "━━━━━━"


@pytest.mark.slow
async def test_the_table_follows_the_orbit_over_a_and_back(born):
    async with browsing(born) as (app, pilot):
        screen, table, catalogue = app.screen, table_of(app), app.file.reader
        stored = [table.source.row(place) for place in range(len(table.source))]
        await press(pilot, "less_than_sign", "less_than_sign")
        assert table.source.a == screen.side.orbit.a == screen.side.following.here < 1.54
        await press(pilot, "G", "T")
        assert screen.side.orbit.a == screen.side.following.here < 1.54
        assert least_rotation(screen.side.orbit.code) == row_of(app)[0]
        await press(pilot, "R")
        assert table.source.a is not None
        await press(pilot, "R", "g", "greater_than_sign", "greater_than_sign")
        assert table.source.a is None
        assert screen.side.orbit.a == 1.6
        assert screen.side.orbit.stored
        assert [table.source.row(place) for place in range(len(table.source))] == stored
        assert "orbits at a" not in shown(app)
        screen.side.orbit = app.file.find("13", 0.7)
        await press(pilot, "less_than_sign")
        rows = [table.source.row(place) for place in range(len(table.source))]
        alive = [row[0] for row in rows if row[3] == "orbit"]
        with catalogue.moment() as moment:
            assert len(alive) == counts_at(moment.connection, screen.side.following.here, 5).n_c
        assert all(row[2] is row[4] is row[10] is None for row in rows)
        assert f"{len(alive)} orbits at a = {screen.side.following.here:.9g}" in shown(app)
        assert f"facts at a = {screen.side.following.here:.9g}" in shown(app)
        assert f"{sum(row[3] == 'not yet' for row in rows)} not yet, " in shown(app)
        assert "'orbitdb births --p 4' finds them" in str(app.screen.query_one("#standing").render())
        await press(pilot, "escape")
        assert table.source.a is None
        assert screen.side.orbit.a == screen.side.following.here == 1.6
        screen.choices.selection = Selection(where="p = 3")
        await settle(pilot)
        for _ in range(2):
            await press(pilot, "greater_than_sign")
            assert table.source.a is None
            assert "the rows stay at a = 1.6" in shown(app)
        await press(pilot, "j")
        assert screen.side.orbit.a == 1.6
        assert "the rows stay" not in shown(app)


@pytest.mark.slow
async def test_keys_work_during_a_birth_search_and_all_panels_show_the_same_a(born, monkeypatch):
    """Steps taken during the search are combined; a key that leaves the orbit drops them."""
    sought, go_on = threading.Event(), threading.Event()

    def slow(file, word, a, find=CatalogueFile.find):
        if threading.current_thread() is not threading.main_thread():
            sought.set()
            assert go_on.wait(60)
        return find(file, word, a)

    monkeypatch.setattr(CatalogueFile, "find", slow)

    def of_one_a(app):
        main, table = app.screen, table_of(app)
        rows = table.source.a if table.source.a is not None else main.choices.selection.a
        return main.side.orbit.a == rows == app.screen.query_one(OrbitDrawing).a

    async with browsing(born, LARGE) as (app, pilot):
        main, table = app.screen, table_of(app)
        await pilot.press("greater_than_sign")
        await asyncio.to_thread(sought.wait, 60)
        await pilot.press("greater_than_sign", "greater_than_sign")
        assert main.side.orbit.a == 1.6
        assert of_one_a(app)
        await until(lambda: "reading births …" in shown(app))
        go_on.set()
        await until(lambda: main.side.orbit.a > 1.69)
        await settle(pilot)
        assert main.side.orbit.a == pytest.approx(1.6 * np.exp(0.06))
        assert of_one_a(app)
        go_on.clear()
        await pilot.press("greater_than_sign")
        await until(lambda: "following …" in shown(app))  # the births are known by now
        await pilot.press("greater_than_sign", "j")
        assert table.cursor == 1
        assert main.side.orbit.code == row_of(app)[0]
        go_on.set()
        await settle(pilot)
        assert main.side.orbit.code == row_of(app)[0]
        assert main.side.orbit.a == pytest.approx(1.6 * np.exp(0.06))
        assert of_one_a(app)


def stadiums_of(app):
    """Return all values of a that are on the screen."""
    screen = app.screen_stack[0]
    source, drawing = table_of(app).source, screen.query_one(OrbitDrawing)
    orbits = [
        orbit.a for orbit in (screen.side.orbit, drawing.orbit, *screen.side.compared) if orbit is not None
    ]
    rows = [source.chosen.selection.a] if len(source) else []
    return {screen.choices.selection.a, drawing.a, *orbits, *rows}


@pytest.mark.slow
async def test_an_unfilled_stadium_is_empty_and_says_how_to_fill_it(tmp_path):
    path = tmp_path / "orbits.db"
    made(path, fill_periods(path, 1.0, range(2, 6)))
    async with browsing(path, (220, 48), Selection(a=2.0)) as (app, pilot):
        main = app.screen
        assert stadiums_of(app) == {2.0}
        assert len(table_of(app).source) == 0
        assert app.screen.side.orbit is None
        text = shown(app)
        assert there(answer(app.file.path, unfilled, Selection(a=2.0))) in text
        assert "or press f" in text
        await press(pilot, "f")
        assert isinstance(app.screen, FillDialog)
        assert [field.value for field in app.screen.query(Input)] == ["2", "2-11", ""]
        app.screen.query_one("#a", Input).value = "3"  # nothing is shown, so the screen moves to this a
        await write(pilot, "2-4", "enter", "escape", field="#periods")
        assert len(table_of(app).source) == 41
        assert stadiums_of(app) == {3.0}
        assert "not filled" not in shown(app)
        main.choices.selection = Selection(a=3.0, periods=((2, 4),), where="born > 1")
        await settle(pilot)
        assert there(answer(app.file.path, lacking_births, main.choices.selection)) in shown(app)


async def test_another_stadium_drops_the_comparison(varied):
    async with browsing(varied) as (app, pilot):
        await press(pilot, "j", "m", "j", "m")
        assert len(app.screen.side.compared) == 2
        await press(pilot, "a", "up", "enter")
        assert stadiums_of(app) == {1.0}
        assert app.screen.side.compared == ()


@pytest.mark.slow
async def test_changing_a_updates_everything_and_any_a_can_be_typed(varied):
    async with browsing(varied) as (app, pilot):
        await press(pilot, "j", "m", "j", "m")
        await press(pilot, "a", "up", "enter")
        assert stadiums_of(app) == {1.0}
        assert app.screen.side.compared == ()
        app.screen.side.take_found(solve_word("1232131", Stadium(1.6)))  # it arrives too late
        await settle(pilot)
        assert stadiums_of(app) == {1.0}
        await press(pilot, "a", "2", "full_stop", "5")
        assert "nothing is filled there: press f to fill it" in " ".join(shown(app).split())
        await press(pilot, "enter")
        assert app.screen.choices.selection.a == 2.5
        assert "or press f" in " ".join(shown(app).replace("│", " ").split())
        await press(pilot, "a", "1", "enter")
        assert app.screen.choices.selection.a == 1.0
        await press(pilot, "a", "0", "enter")
        assert isinstance(app.screen, LineDialog)
        assert app.screen.query_one("Input").has_class("-wrong")
