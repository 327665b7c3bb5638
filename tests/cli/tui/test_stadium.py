"""The terminal UI shows one stadium at a time, and tells what is not filled there."""

import pytest
from screens import drive, press, settle, shown, table_of
from textual.widgets import Input

from orbitdb.billiard.stadium import Stadium
from orbitdb.catalogue.catalogue import Catalogue
from orbitdb.cli.tui.dialogs.fill import FillDialog
from orbitdb.cli.tui.dialogs.lines import LineDialog
from orbitdb.cli.tui.orbit.drawing import OrbitDrawing
from orbitdb.filling.periods import fill_periods
from orbitdb.orbits.single_word import solve_word
from orbitdb.store.asking.selection import Selection


def stadiums_of(app):
    """Return every a of what is on screen."""
    screen = app.screen_stack[0]
    source, drawing = table_of(app).source, screen.query_one(OrbitDrawing)
    orbits = [orbit.a for orbit in (screen.orbit, drawing.orbit, *screen.compared) if orbit is not None]
    rows = [source.chosen.selection.a] if len(source) else []
    return {screen.selection.a, drawing.a, *orbits, *rows}


@pytest.fixture(scope="module")
def at_one(tmp_path_factory):
    """A catalogue of a = 1 alone."""
    path = tmp_path_factory.mktemp("one") / "orbits.db"
    Catalogue.create(path)
    for _ in fill_periods(path, 1.0, range(2, 6)):
        pass
    return path


@pytest.mark.slow
def test_a_stadium_that_is_not_filled_shows_nothing_and_how_to_fill_it(at_one, tmp_path):
    path = tmp_path / "orbits.db"
    path.write_bytes(at_one.read_bytes())

    async def steps(app, pilot):
        assert stadiums_of(app) == {2.0}
        assert len(table_of(app).source) == 0
        assert app.screen.orbit is None
        text = shown(app)
        assert app.catalogue.unfilled(Selection(a=2.0)) in text
        assert "so does the key f" in text
        await press(pilot, "f")
        assert isinstance(app.screen, FillDialog)
        assert app.screen.query_one("#a", Input).value == "2"
        app.screen.query_one("#periods", Input).value = "2-4"
        await press(pilot, "enter", "escape")
        assert len(table_of(app).source) == 41
        assert stadiums_of(app) == {2.0}
        assert "not filled" not in shown(app)

    drive(path, steps, (220, 48), Selection(a=2.0))


@pytest.mark.slow
def test_another_stadium_takes_everything_with_it(varied):
    async def steps(app, pilot):
        await press(pilot, "j", "m", "j", "m")
        await press(pilot, "a", "up", "enter")
        assert stadiums_of(app) == {1.0}
        assert app.screen.compared == ()
        app.screen.take_found(solve_word("1232131", Stadium(1.6)))  # too late
        await settle(pilot)
        assert stadiums_of(app) == {1.0}

    drive(varied, steps)


@pytest.mark.slow
def test_any_stadium_can_be_typed(varied):
    async def steps(app, pilot):
        await press(pilot, "a", "2", "full_stop", "5")
        assert "nothing is filled there: f fills it" in " ".join(shown(app).split())
        await press(pilot, "enter")
        assert app.screen.selection.a == 2.5
        assert "and so does the key f" in " ".join(shown(app).replace("│", " ").split())
        await press(pilot, "a", "1", "enter")
        assert app.screen.selection.a == 1.0
        await press(pilot, "a", "0", "enter")
        assert isinstance(app.screen, LineDialog)
        assert app.screen.query_one("Input").has_class("-wrong")

    drive(varied, steps)
