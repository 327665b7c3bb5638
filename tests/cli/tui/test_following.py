"""The screen follows the shown orbit in a, shows the rows of one stadium, and says what is not filled."""

import asyncio
import threading

import pytest
from contents import made
from screens import LARGE, browsing, press, row_of, settle, shown, table_of, until, write
from textual.widgets import Input
from there import there

from orbitdb.answers.completeness import Coverage
from orbitdb.catalogue import Catalogue
from orbitdb.cli.advice import completed
from orbitdb.cli.tui.dialogs import LineDialog
from orbitdb.cli.tui.fill_dialog import FillDialog
from orbitdb.cli.tui.panels.drawing import OrbitDrawing
from orbitdb.cli.tui.panels.facts import FactsPanel, bar
from orbitdb.cli.tui.panels.orbit_panel import change_between, next_a, next_change
from orbitdb.cli.tui.screens import in_shell
from orbitdb.filling.fill import fill_periods
from orbitdb.orbits.solve import solve_word
from orbitdb.selection import Selection
from orbitdb.store.file import reading
from orbitdb.symbols.words import least_rotation

BORN, DIED, REBORN = 0.386252501738, 0.473270308236, 0.605684335145
LIVES = [(BORN, DIED), (REBORN, None)]


def test_a_step_stops_on_both_sides_of_a_change_and_at_the_stadium_of_the_rows():
    way, a = [], 0.46
    while a < 0.62:
        way.append(a)
        a = next_a(LIVES, a, True, 1.6)
    beside = [a for a in way if min(abs(a / end - 1) for end in (DIED, REBORN)) < 1e-8]
    assert [a < DIED or a > REBORN for a in beside] == [True, False, False, True]
    assert next_a(LIVES, beside[1], False, 1.6) == beside[0]
    assert next_a([(0.5, 0.5005)], 0.501, False, 1.6) == pytest.approx(0.5005, rel=1e-8)  # the nearer end
    assert change_between(LIVES, beside[0], beside[1]) == "gone at a = 0.473270308236"
    assert change_between(LIVES, beside[3], beside[2]) == "gone at a = 0.605684335145"
    assert change_between(LIVES, beside[2], beside[3]) == "born at a = 0.605684335145"
    assert change_between(LIVES, 1.0, 1.1) is None
    down = next_a((), 1.6, False, 1.6)
    assert down == 1.568  # steps have few digits
    assert next_a((), down, True, 1.6) == next_a((), 1.59, True, 1.6) == 1.6
    birth = [(1.6, None)]
    assert next_a(birth, 1.59, True, 1.6) < 1.6
    assert next_a(birth, next_a(birth, 1.59, True, 1.6), True, 1.6) == 1.6


def test_hops_go_to_both_sides_of_every_change():
    places = [0.1]
    while (after := next_change(LIVES, places[-1], True)) is not None:
        places.append(after)
    del places[0]
    beside = [end * (1 + side * 1e-9) for end in (BORN, DIED, REBORN) for side in (-1, 1)]
    assert places == pytest.approx(beside, rel=1e-10)
    assert next_change(LIVES, 1.6, False) == places[-1]
    assert next_change([(0.0, None)], 1.6, False) is None


def test_the_bar_shows_lives_and_position():
    assert bar(LIVES, 1.0, 24) == "········━·━━┃━━━━━━━━━━━"
    assert bar([(0.0, None)], 1e-4, 6) == "━━━━━━"


@pytest.mark.slow
async def test_the_orbit_is_followed_while_the_rows_stay(varied):
    async with browsing(varied, LARGE) as (app, pilot):
        side, facts = app.screen.side, app.screen.query_one(FactsPanel)
        await press(pilot, "j", "less_than_sign", "less_than_sign")
        assert (side.orbit.code, side.orbit.a, app.screen.query_one(OrbitDrawing).a) == ("013", 1.537, 1.537)
        assert facts.border_title == "013, p = 3, orbit, a = 1.537"
        await press(pilot, "T")
        assert (side.orbit.code, side.orbit.a) == ("310", 1.537)
        assert row_of(app)[0] == least_rotation("310")
        await press(pilot, "escape")
        assert (side.orbit.a, side.orbit.stored) == (1.6, True)
        before = row_of(app)[0]
        await press(pilot, "less_than_sign", "escape")
        assert (side.orbit.code, side.orbit.a) == (row_of(app)[0], 1.6) == (before, 1.6)
        await press(pilot, "less_than_sign", "j")  # another word is shown as it is stored
        assert (side.orbit.code, side.orbit.a) == (row_of(app)[0], 1.6)
        await press(pilot, "less_than_sign", "greater_than_sign")
        assert side.orbit.a == 1.6
        side.orbit = solve_word("01552", 1.6)
        await press(pilot, "comma")
        assert side.orbit.a == pytest.approx(2 / 3**0.5, rel=1e-8)
        assert side.orbit.length is not None
        await press(pilot, "comma")
        assert side.orbit.length is None
        await press(pilot, "comma")
        assert [note.message for note in app._notifications][-1] == "no birth or death at a smaller a"


@pytest.mark.slow
async def test_keys_work_during_a_search_of_births(varied, monkeypatch):
    """Steps taken during the search are combined; a key that leaves the orbit drops them."""
    sought, go_on = threading.Event(), threading.Event()

    def slow(catalogue, word, a, find=Catalogue.orbit):
        if threading.current_thread() is not threading.main_thread():
            sought.set()
            assert go_on.wait(60)
        return find(catalogue, word, a=a)

    monkeypatch.setattr(Catalogue, "orbit", slow)
    async with browsing(varied, LARGE) as (app, pilot):
        side = app.screen.side
        await pilot.press("greater_than_sign")
        await asyncio.to_thread(sought.wait, 60)
        await pilot.press("greater_than_sign", "greater_than_sign")
        assert side.orbit.a == 1.6
        await until(lambda: "following …" in shown(app))
        go_on.set()
        await until(lambda: side.orbit.a > 1.69)
        await settle(pilot)
        assert side.orbit.a == 1.699
        go_on.clear()
        await pilot.press("greater_than_sign", "greater_than_sign", "j")
        assert side.orbit.code == row_of(app)[0]
        go_on.set()
        await settle(pilot)
        assert (side.orbit.code, side.orbit.a) == (row_of(app)[0], 1.6)


def stadiums_of(app):
    """Return all values of a that are on the screen."""
    screen = app.screen_stack[0]
    source, drawing = table_of(app).source, screen.query_one(OrbitDrawing)
    orbits = [orbit.a for orbit in (screen.side.orbit, drawing.orbit) if orbit is not None]
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
        with reading(path) as connection:
            assert completed(there(Coverage(connection, Selection(a=2.0)).unfilled())) in text
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
        with reading(path) as connection:
            advice = there(Coverage(connection, main.choices.selection).lacking_births())
        assert in_shell(advice).partition(" --")[0] in shown(app)


@pytest.mark.slow
async def test_changing_a_updates_everything_and_any_a_can_be_typed(varied):
    async with browsing(varied) as (app, pilot):
        await press(pilot, "a", "up", "enter")
        assert stadiums_of(app) == {1.0}
        app.screen.side.take_found(solve_word("1232131", 1.6))  # it arrives too late
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
