"""Pictures of an orbit made of characters, and the screen with all facts about it."""

import math
from dataclasses import replace
from io import StringIO
from typing import Any

import numpy as np
import pytest
from rich.console import Console, Group
from screens import LARGE, SMALL, browsing, press, shown
from textual.widgets import Input
from there import there

from orbitdb.billiard.stadium import Stadium
from orbitdb.cli.tui.panels.canvas import DOTS, Canvas, Curve, draw_curves, joined, round_ticks
from orbitdb.cli.tui.panels.drawing import (
    MOST_DRAWN,
    along,
    draw_orbit,
    draw_phase,
    fixed_point,
    path_of,
    phase_points,
)
from orbitdb.cli.tui.panels.facts import parts_of
from orbitdb.orbits.solve import solve_word
from orbitdb.selection import Selection
from orbitdb.symbols.symmetry import MIRROR_X, MIRROR_Y, REVERSE, images_of, members
from orbitdb.symbols.words import least_rotation
from orbitdb.text import upwards

A = 1.6
WORDS = ["13", "1232131", "0132", "113", "1554455", "1111113"]


def solved(word, a=A):
    orbit = solve_word(word, Stadium(a))
    assert orbit.coordinates is not None
    return orbit


def text_of(lines):
    """Return the characters of a picture as an array, shape (rows, columns)."""
    return np.array([[*"".join(text for text, _ in line)] for line in lines])


def dots_of(lines):
    """Return the positions of the dots, decoded from the characters."""
    codes = np.vectorize(ord)(text_of(lines))
    bits = {(0, 0): 1, (0, 1): 2, (0, 2): 4, (1, 0): 8, (1, 1): 16, (1, 2): 32, (0, 3): 64, (1, 3): 128}
    braille = np.where(codes >= 0x2800, codes - 0x2800, 0)
    found = [np.argwhere(braille & bit)[:, ::-1] * DOTS + place for place, bit in bits.items()]
    return np.concatenate(found)


@pytest.mark.parametrize(("columns", "rows"), [(40, 9), (90, 18), (30, 40), (200, 5)])
@pytest.mark.parametrize("a", [0.01, 1.0, 1.6, 4.0])
def test_the_stadium_keeps_its_aspect_ratio_at_any_size(a, columns, rows):
    picture, true = draw_orbit(a, np.zeros((0, 2)), columns, rows)
    assert text_of(picture).shape == (rows, columns)
    if not true:
        return
    dots = dots_of(picture)
    width, height = np.ptp(dots, axis=0)
    assert abs(width - height * (a + 1)) <= 2 + 2 * (a + 1)
    aside = 8 if rows >= 7 else 0  # the symbols of the bounces need a margin
    assert width >= DOTS[0] * columns - 4 - aside or height >= DOTS[1] * rows - 4 - aside


def test_a_very_long_stadium_is_stretched_and_says_so():
    picture, true = draw_orbit(1e4, np.zeros((0, 2)), 60, 10)
    assert not true
    drawn = np.argwhere(text_of(picture) != " ")
    assert [len(np.unique(places)) for places in drawn.T] == [10 - 2, 60 - 4]  # without the margin


def test_a_line_has_both_ends_and_no_gaps():
    canvas = Canvas(30, 15, (-1, -1), (1, 1))
    ends = canvas.dots(np.array([[-0.9, -0.7], [0.8, 0.95], [0.1, -0.4]]))
    dots = joined(ends)
    assert np.abs(np.diff(dots, axis=0)).max() == 1
    assert {*map(tuple, ends.tolist())} <= {*map(tuple, dots.tolist())}


def test_every_dot_has_its_bit():
    seen = set()
    for x in range(DOTS[0]):
        for y in range(DOTS[1]):
            canvas = Canvas(1, 1, (0, 0), (1, 1))
            canvas.put("path", np.array([[x, y]]))
            [[(cell, _)]] = canvas.lines()
            seen.add(ord(cell) - 0x2800)
    assert seen == {1 << n for n in range(8)}


def test_marks_cover_dots_and_points_outside_are_left_out():
    canvas = Canvas(2, 1, (0, -3), (3, 0))  # a unit is a dot
    canvas.mark("start", [[1, -1]], "S")
    canvas.mark("bounce", [[9, -9]], "B")
    canvas.put("path", np.array([[0, 0], [-1, 2], [4, 0], [3, 3]]))
    assert canvas.lines() == [[("S", "start"), (chr(0x2880), "path")]]


def length_of(path):
    return np.hypot(*np.diff(path, axis=0).T).sum()


@pytest.mark.parametrize("word", WORDS)
def test_the_path_is_closed_and_as_long_as_the_orbit(word):
    orbit = solved(word)
    path = path_of(orbit)
    assert (path[0] == path[-1]).all()
    assert length_of(path) == pytest.approx(orbit.length, rel=1e-12)
    assert along(path, 1.25) == pytest.approx(along(path, 0.25))
    walked = np.array([along(path, share) for share in np.linspace(0, 1, 400)])
    assert length_of(walked) == pytest.approx(orbit.length, rel=0.02)


@pytest.mark.parametrize("more", [-1, 0, 1])
def test_a_long_path_is_cut_and_a_complete_one_closed(more):
    orbit = solved("1^{0} 5^{0}".format(MOST_DRAWN // 2 + more))
    path = path_of(orbit)
    assert (path == orbit.points[np.arange(min(orbit.p + 1, len(path))) % orbit.p]).all()
    assert len(path) == (orbit.p + 1 if more <= 0 else MOST_DRAWN)


def test_the_picture_shows_start_direction_and_particle():
    orbit = solved("13")
    picture, _ = draw_orbit(A, path_of(orbit), 60, 12, particle=0.5)
    row = next("".join(row) for row in text_of(picture) if "◆" in row)
    assert row.index("◆") < row.index("→") < row.index("●")
    assert {"wall", "path", "start", "arrow", "particle", "trail"} <= {
        style for line in picture for _, style in line
    }


@pytest.mark.parametrize("word", WORDS)
def test_time_reversal_flips_the_sine_and_keeps_the_position(word):
    points = phase_points(solved(word))
    back = phase_points(solved(images_of(word)[REVERSE]))[::-1]
    assert np.abs(points[:, 1]).max() < 1
    assert back[:, 0] == pytest.approx(points[:, 0], abs=1e-9)
    assert back[:, 1] == pytest.approx(-points[:, 1], abs=1e-9)


def test_phase_space_names_walls():
    picture = draw_phase(A, phase_points(solved("113")), 60, 12)
    lines = ["".join(line) for line in text_of(picture)]
    assert text_of(picture).shape == (12, 60)
    assert lines[-1].split() == ["0", "bottom", "3", "right", "2", "top", "1", "left"]
    assert sum(line.count("●") for line in lines) == 3
    columns, heights = (
        np.unique(found, return_counts=True) for found in dots_of(draw_phase(A, phase_points(None), 60, 11)).T
    )
    joints = np.array([0.0, 2 * A, 2 * A + math.pi, 4 * A + math.pi, Stadium(A).perimeter])
    assert columns[0][columns[1] > 20] == pytest.approx(119 * joints / joints[-1], abs=0.51)
    assert heights[0][heights[1] > 25].tolist() == [20]  # sine 0, halfway down
    assert heights[1].max() < 40


@pytest.mark.parametrize(("size", "drawn"), [((16, 5), True), ((15, 5), False), ((16, 4), False)])
def test_curves_need_some_room(size, drawn):
    picture = draw_curves([Curve("one", "", np.arange(2.0, 8.0), np.arange(6.0), "×")], *size)
    assert bool(picture) == drawn == any("×" in text for line in picture for text, _ in line)


@pytest.mark.parametrize("size", [(60, 12), (20, 6), (10, 3)])
def test_curves_fill_their_frame_and_skip_unknown_values(size):
    p = np.arange(2.0, 8.0)
    values = np.array([1.0, np.nan, 2.0, 3.0, 2.5, 2.0])
    picture = draw_curves([Curve("one", "K_0", p, values), Curve("two", "zeta", p, values, "×")], *size)
    assert len(picture) == (0 if size[0] == 10 else size[1])
    assert draw_curves([], *size) == []
    if size[0] == 60:
        text = text_of(picture[:-1])
        assert text.shape == (11, 60)
        periods = [int(name) for name in "".join(text[-1]).split()[1:]]
        places = np.flatnonzero(text[-1] != " ")[1:]
        assert periods == [2, 3, 4, 5, 6, 7]
        assert places == pytest.approx(8 + 103 / 2 * (p - 2) / 5, abs=1)
        marks = {column: row for row, column in np.argwhere(text == "×").tolist()}
        assert sorted(marks) == np.delete(places, [0, 1]).tolist()
        ticks = {"".join(line[:8]).strip(): row for row, line in enumerate(text[:-1])}
        assert [marks[places[place]] for place in (3, 5)] == [ticks["3"], ticks["2"]]


def test_the_later_periods_set_the_range_and_earlier_points_are_arrows():
    p, values = np.arange(2.0, 12.0), np.array([9.0, -7.0, 1.2, 1.0, 1.0, 1.5, 1.25, 1.0, 1.125, 1.25])
    text = text_of(draw_curves([Curve("two", "zeta", p, values, "×")], 60, 14)[:-1])
    (up,), (down,) = np.argwhere(text == "↑"), np.argwhere(text == "↓")
    assert (up[0], down[0]) == (0, len(text) - 2)  # at the edges
    assert up[1] < down[1] < np.argwhere(text == "×")[:, 1].min()
    assert (text == "×").sum() == len(p) - 2


@pytest.mark.parametrize(
    ("low", "high", "most", "ticks"),
    [
        (1.123, 1.172, 6, [1.13, 1.14, 1.15, 1.16, 1.17]),
        (0.85, 1.19, 4, [0.9, 1, 1.1]),
        (-3, 4, 2, [0]),
        (0, 50, 6, [0, 10, 20, 30, 40, 50]),
    ],
)
def test_ticks_are_round_numbers(low, high, most, ticks):
    assert round_ticks(low, high, most) == ticks


def test_values_that_differ_by_rounding_are_a_flat_curve():
    """As the averages of a single orbit, which are the same at each period but for their last digit."""
    for value in (0.404846, -3e-9):
        values = value * (1 + np.array([0, 1, 0, 2, 1]) * 2**-52)
        text = text_of(draw_curves([Curve("one", "", np.arange(3.0, 8.0), values, "×")], 60, 14)[:-1])
        assert len({row for row, _ in np.argwhere(text == "×").tolist()}) <= 2


def test_a_curve_of_one_period_starts_at_the_axis():
    picture = draw_curves([Curve("one", "K_0", np.array([5.0]), np.array([1.0]), "×")], 60, 12)
    text = text_of(picture[:-1])
    assert np.argwhere(text == "×")[:, 1].tolist() == [8]
    assert "".join(text[-1]).split() == ["p", "5", "6"]


def labels_of(word, a=A, size=(60, 18)):
    """Return the symbols of a picture by row and column, the places of the bounces, and the picture."""
    orbit = solve_word(word, a)
    path = fixed_point(orbit) if orbit.points is None else path_of(orbit)
    columns, rows = size
    picture, _ = draw_orbit(a, path, columns, rows, code=word)
    text, styles = (
        text_of(picture),
        np.array([[style for part, style in line for _ in part] for line in picture]),
    )
    labels = {(row, column): text[row, column] for row, column in np.argwhere(styles == "label").tolist()}
    return labels, np.argwhere(np.isin(text, ["•", "◆", "×"])), text


@pytest.mark.parametrize("word", ["13", "1232131", "0132", "113", "1554455"])
def test_each_bounce_has_its_symbol_beside_it(word):
    labels, bounces, _ = labels_of(word)
    assert sorted(labels.values()) == sorted(word)
    for place, symbol in labels.items():
        row, column = np.subtract(place, bounces[np.abs(bounces - place).max(axis=1).argmin()])
        assert max(abs(row), abs(column)) == 1
        assert {"0": row > 0, "2": row < 0}.get(symbol, column < 0 if symbol in "14" else column > 0) or row


def test_long_words_have_no_symbols():
    assert labels_of("13" * 12 + "1")[0] == {}


def test_a_pruned_word_shows_where_its_fixed_point_leaves_the_stadium():
    orbit = solve_word("01552", 1.0)
    assert orbit.status == "dynamical"
    path = fixed_point(orbit)
    legs = np.diff(path, axis=0) / np.hypot(*np.diff(path, axis=0).T)[:, None]
    centres = [
        x if symbol in "02" else {"1": -1, "4": -1}.get(symbol, 1)
        for (x, _), symbol in zip(path, "01552", strict=False)
    ]
    normals = path[:-1] - np.stack([centres, np.zeros(5)], axis=1)
    turns = legs - np.roll(legs, 1, axis=0)
    across = turns[:, 0] * normals[:, 1] - turns[:, 1] * normals[:, 0]
    assert across == pytest.approx(0, abs=1e-9)  # the law of reflection, also beyond the joints
    beyond = [(abs(x) > 1.0) == (symbol in "02") for (x, _), symbol in zip(path, orbit.code, strict=False)]
    _, _, text = labels_of("01552", 1.0)
    assert (text == "×").sum() == sum(beyond) > 0
    assert not (labels_of("01552", 1.6)[2] == "×").any()  # there it is an orbit
    assert len(fixed_point(solve_word("00123", 1.6))) == 0  # no path at any a


def facts_of(orbit, partners=(), width=70):
    shown = StringIO()
    console = Console(file=shown, width=width)
    console.print(Group(*parts_of(orbit, (2e-30, 128), partners, whole=True)))
    return [line.rstrip() for line in shown.getvalue().splitlines()]


def test_the_lines_state_everything_known_about_an_orbit():
    orbit = solve_word("01552", 1.6, exists=True)
    [(born, _)] = there(orbit.exists)
    texts = facts_of(orbit, [(born * (1 + 1e-15), ["01234"])])
    text = " ".join(" ".join(texts).split())
    assert f", 128 bits solver {orbit.solver} symmetry class" in text
    assert "exists a > 1.15470053838" in text
    assert "1.15470054: 2 sqrt(3)/3, recognised numerically" in text
    assert "born at 1.15470054 with 01234" in text
    several = replace(orbit, exists=((0.0, 0.41), (0.61, 1.71), (1.81, None)))
    again = " ".join(" ".join(facts_of(several)).split())
    assert "a < 0.41, and for 0.61 < a < 1.71, and for a > 1.81" in again
    part = texts[texts.index("symmetry class") + 1 : texts.index("bounces") - 1]
    words = dict(line.split(maxsplit=1) for line in part)
    assert words.keys() == set(members("01552"))
    by = {MIRROR_X: "mirrored left-right", MIRROR_Y: "mirrored up-down", REVERSE: "reversed in time"}
    assert [words[least_rotation(images_of("01552")[each])] for each in by] == [*by.values()]
    for lines, xy in ((texts, there(orbit.points).T), (facts_of(orbit, width=50), ())):
        bounces = np.array([line.split() for line in lines[lines.index("bounces") + 2 :]], dtype=float).T
        known = orbit.coordinates, *xy, orbit.arclength, orbit.sine
        assert "".join(f"{symbol:g}" for symbol in bounces[1]) == "01552"
        assert bounces[2:] == pytest.approx(np.array(known), abs=1e-6)


def test_a_pruned_word_and_a_long_one_show_what_is_known():
    texts = facts_of(solve_word("00123", 1.6, exists=True))
    assert any("hits the same straight wall twice" in line for line in texts)
    assert not {"symmetry class", "bounces"} & set(texts)
    assert phase_points(solve_word("00123", 1.6)).shape == (0, 2)
    code = "1" * 40 + "3"
    assert code in "".join(facts_of(solve_word(code, 1.6)))


@pytest.mark.slow
@pytest.mark.parametrize("size", [SMALL, LARGE])
async def test_enter_shows_all_facts_about_the_orbit(filled_once, size):
    async with browsing(filled_once, size) as (app, pilot):
        await press(pilot, "j", "enter")
        assert app.screen.whole
        assert "013 at a = 1.6" in shown(app)
        await press(pilot, "G")
        assert "bounces" in shown(app)
        await press(pilot, "question_mark")
        assert "to the top" in shown(app)  # of the facts
        await press(pilot, "escape", "v")
        assert "phase space" in shown(app)
        for back in ("enter", "escape", "q"):
            await press(pilot, "o", "bracketleft", back)  # the hidden rows stay as they are
            main: Any = app.screen
            assert not main.whole
            assert (main.choices.selection, main.side.orbit.code) == (Selection(), "013")
            await press(pilot, "enter")


@pytest.mark.slow
async def test_the_facts_follow_the_main_screen(filled_once):
    async with browsing(filled_once, LARGE, notifications=True) as (app, pilot):
        await press(pilot, "enter", "n", "n")
        assert "031 at a = 1.6" in shown(app)
        await press(pilot, "p", "greater_than_sign")
        main = app.screen_stack[0]
        assert main.side.orbit.a > 1.6
        assert f"013 at a = {main.side.orbit.a:.9g}" in shown(app)
        await press(pilot, "a", *"2.5", "enter")
        assert "013 at a = 2.5" in shown(app)
        await press(pilot, "X", "y")
        assert app.clipboard == main.side.orbit.code != "013"
        await press(pilot, "c", *"1232131", "enter")
        assert "1232131 at a = 2.5" in shown(app)
        await press(pilot, "asterisk", "e")
        assert app.screen.query_one(Input).value == "1232131.svg"
        await press(pilot, "escape", "escape")
        assert not main.whole
        assert (main.side.orbit.code, main.choices.selection.a) == ("1232131", 2.5)


@pytest.mark.slow
async def test_a_stored_proof_is_shown_with_its_orbit(cli, tmp_path):
    cli("fill", "--p", "3")
    assert cli("verify", "--prove", "--p", "2").code == 0
    async with browsing(tmp_path / "orbits.db", LARGE) as (app, pilot):
        assert app.screen.side.orbit.code == "13"
        radius, bits = app.catalogue.certificate(app.screen.side.orbit)
        assert f"radius {upwards(radius)}, {bits} bits" in shown(app)
        assert app.catalogue.certificate(solve_word("13", 1.0)) is None
        await press(pilot, "j")
        assert "none stored" in shown(app)


def test_zero_has_no_sign_in_bounces():
    """In the horizontal orbit 13, y and sine are 0 up to rounding."""
    orbit = solved("13")
    orbit = replace(orbit, coordinates=np.array([-1e-17, -1e-17]))
    assert "-0.000000" not in "".join(facts_of(orbit))
