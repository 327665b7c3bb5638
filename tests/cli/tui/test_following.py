"""An orbit followed in a by keys, past its death and its rebirth."""

import pytest
from screens import drive, press, settle, shown

from orbitdb.cli.tui.following import bar, next_a, told

LIVES = [(0.386252501738, 0.473270308236), (0.605684335145, None)]


def test_a_step_stops_on_both_sides_of_a_change():
    way, a = [], 0.46
    while a < 0.62:
        way.append(a)
        a = next_a(LIVES, a, True)
    beside = [a for a in way if min(abs(a / end - 1) for end in (LIVES[0][1], LIVES[1][0])) < 1e-8]
    assert [a < LIVES[0][1] or a > LIVES[1][0] for a in beside] == [True, False, False, True]
    assert next_a(LIVES, beside[1], False) == pytest.approx(beside[0])
    assert next_a((), 1.0, True) == pytest.approx(1.02, abs=1e-3)
    assert told(LIVES, beside[0], beside[1]) == "gone at a = 0.473270308236"
    assert told(LIVES, beside[3], beside[2]) == "gone at a = 0.605684335145"
    assert told(LIVES, beside[2], beside[3]) == "born at a = 0.605684335145"
    assert told(LIVES, 1.0, 1.1) is None


def test_the_bar_shows_lives_and_place():
    assert bar(LIVES, 1.0, 24) == "········━·━━┃━━━━━━━━━━━"
    assert bar([(0.0, None)], 1e-4, 6) == "━━━━━━"


@pytest.mark.slow
def test_the_orbit_is_followed_until_it_dies(filled):
    async def steps(app, pilot):
        screen = app.screen
        await press(pilot, "less_than_sign")
        assert screen.orbit.a == pytest.approx(1.6 / 1.0202, rel=1e-4)
        assert "exists" in shown(app)
        assert "stadium, a = 1.56832" in shown(app)
        screen.orbit = app.find("01552", 1.16)
        await press(pilot, "less_than_sign")
        assert screen.orbit.status == "orbit"
        assert 0 < screen.orbit.margin < 1e-6
        await press(pilot, "less_than_sign")
        await settle(pilot)
        assert screen.orbit.status == "dynamical"
        assert screen.selection.a == 1.6
        await press(pilot, "escape")
        assert screen.orbit.a == 1.6

    drive(filled, steps, (160, 48))
