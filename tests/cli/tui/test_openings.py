"""The screen shows the openings in which the chosen words have no bounce, as gaps in the wall."""

import pytest
from screens import browsing, settle

from orbitdb import Selection
from orbitdb.cli.tui.panels.drawing import OrbitDrawing, draw_orbit, path_of
from orbitdb.open_stadium.openings import parse_openings

OPENED = Selection(opening=parse_openings("top:-1.2:1"), periods=((2, 5),))


def dots(lines):
    return sum(text.count(sign) for line in lines for text, _ in line for sign in text if sign.strip())


def test_an_opening_is_a_gap_in_the_drawing():
    closed, _ = draw_orbit(1.6, path_of(None), 60, 20)
    opened, _ = draw_orbit(1.6, path_of(None), 60, 20, opening=OPENED.opening)
    assert dots(opened) < dots(closed)


@pytest.mark.slow
async def test_the_screen_has_the_gap_and_says_where_it_does_not_fit(varied):
    async with browsing(varied, (120, 40), OPENED) as (app, pilot):
        drawing = app.screen.query_one(OrbitDrawing)
        assert drawing.opening == OPENED.opening
        assert "without a bounce in top:-1.2:1" in app.screen.sub_title
        app.screen.choices.selection = Selection(1.0, opening=OPENED.opening)
        await settle(pilot)
        assert drawing.opening == ()
        assert any("goes beyond its wall" in note.message for note in app._notifications)
