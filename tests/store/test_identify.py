"""Orbits found from a nearby trajectory, or from a length."""

import math

import numpy as np
import pytest
from contents import alter
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st
from itineraries import itineraries, random_rays
from quick import slow_but
from there import there

from orbitdb import Catalogue, InputError, Stadium, solve_word
from orbitdb.orbits.shadowing import shadows
from orbitdb.selection import Selection
from orbitdb.symbols import symmetry
from orbitdb.symbols.words import from_strings, least_rotation, to_strings
from orbitdb.trajectories.trajectory import trace_start

STADIUM = Stadium(1.6)
WORDS = ["13", "033244", "1232131"]
MORE = ["013", "2443", "03321", "0102313", "0103155", "01033132", "010301132", "0102304423", "01020313123"]

OF_CANDIDATES = ("representative", "p", "class_size", "length", "length_error", "lyapunov", "repetitions",
                 "difference")  # fmt: skip


@pytest.fixture
def catalogue(filled_once):
    with Catalogue(filled_once, 1.6) as opened:
        yield opened


def start_of(points, turn=0.0):
    """Return a start at the first of the bounces, in the direction of the second, turned by a small angle."""
    x, y = points[1] - points[0]
    return (*points[0], math.atan2(y, x) + turn)


def name(found):
    return least_rotation(found.orbit.code)


def test_orbits_through_a_joint_have_a_length_but_are_no_candidates(varied):
    catalogue = Catalogue(varied, 1.0)
    length, code = next(iter(catalogue.rows(status="boundary", columns=("length", "representative"))))
    found = catalogue.identify(length=length)
    assert code not in [each.code for each in found]
    assert {catalogue.orbit(each.code).status for each in found} <= {"orbit"}


@pytest.mark.parametrize("word", slow_but(WORDS[1:2], WORDS + MORE))
def test_an_exact_start_is_identified_to_the_end_of_its_trace(word):
    """So the trace ends early enough: everything that it reports is within the tolerance."""
    orbit = solve_word(word, STADIUM)
    path = trace_start(STADIUM, start_of(orbit.points), 1e-2)
    best = shadows(STADIUM, path.symbols, path.points, 1e-2)[0]
    assert best.bounces == len(path)
    assert len(path) > 2 * (26 / there(orbit.lambda_d) - 2)
    assert least_rotation(best.word) == least_rotation(word)


@pytest.mark.slow
def test_random_trajectories_agree_with_the_reference(catalogue):
    """Every orbit found stays within the tolerance for the stated number of bounces, and no longer."""
    rays = random_rays(STADIUM, 2, np.random.default_rng(5))
    expected = to_strings(itineraries(STADIUM, rays, 12).symbols)
    for x, y, vx, vy, word in zip(rays.x, rays.y, rays.vx, rays.vy, expected, strict=True):
        found = catalogue.identify(start=(x, y, math.atan2(vy, vx)), tolerance=0.03, limit=12)
        assert found.sequence[1 - found.first :].startswith(word)
        assert len(found.shadowed) == min(found.total, 12) > 0
        turns = [each.turns for each in found.shadowed]
        assert turns == sorted(turns, reverse=True)
        for each in found.shadowed:
            at = each.first - found.first
            steps = np.arange(-1, each.bounces + 1)
            steps = steps[(steps >= -at) & (at + steps < len(found.points))]
            off = np.hypot(*(found.points[at + steps] - each.orbit.points[steps % each.orbit.p]).T)
            inside = (steps >= 0) & (steps < each.bounces)
            assert ((off <= 0.03) == inside).all()
            assert off.min() == pytest.approx(each.distance)
            assert each.orbit.stored == (each.orbit.p <= 8)


@pytest.mark.parametrize("word", slow_but(["13"], ["13", "1232131", "1" * 20 + "5" * 20]))
def test_the_bounces_of_an_orbit_identify_it(catalogue, word):
    """The sequence may be closed or not, have errors, be mirrored or reversed, and have any period."""
    orbit = solve_word(word, STADIUM)
    once, points = np.random.default_rng(1), there(orbit.points)
    closed = np.concatenate([points, points[:1]])
    for shown, element in [
        (closed, 0),
        (closed + once.normal(0, 1e-3, closed.shape), 0),
        (closed * [-1, 1], 1),
        (closed[::-1], 4),
        *([(points, 0)] if orbit.p > 2 else []),
    ]:
        found = catalogue.identify(points=shown)
        best = found.shadowed[0]
        assert name(best) == least_rotation(symmetry.images_of(word)[element])
        assert (best.first, best.bounces, best.turns) == (1, orbit.p, 1.0)
        assert best.orbit.representative == orbit.representative


def test_the_longest_stretch_along_an_orbit_is_reported():
    words = ["033244"] * 2 + ["13"] + ["033244"] * 4 + ["13"] + ["033244"] * 3
    points = np.concatenate([solve_word(word, STADIUM).points for word in words])
    best = shadows(STADIUM, from_strings(["".join(words)])[0], points, 1e-6)[0]
    assert (best.word, best.first, best.bounces) == ("033244", 14, 24)


@given(
    turns=st.integers(1, 9),
    off=st.sampled_from([0.0, 1e-4, -0.03, 0.2]),
    number=st.integers(0, 10**6),
    tolerance=st.sampled_from([0, 1e-3, 0.05, 0.2, 1.0, None]),
    limit=st.none() | st.integers(0, 9) | st.just(10**30),
)
@example(3, -0.2, 0, 0.2, 1)
@example(4, 0.0, 300, 1.0, 10**30)
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_a_length_finds_stored_orbits_and_their_repetitions(catalogue, turns, off, number, tolerance, limit):
    """The result is checked against all lengths; it is sorted by difference, period and word."""
    known = sorted({*catalogue.rows(Selection.from_criteria(status="orbit"), columns=OF_CANDIDATES[:6])})
    length = turns * known[number % len(known)][3] + off
    wanted = []
    for row in known:
        one, error = row[3:5]
        r = round(length / one)
        within = (1e-3 if tolerance is None else tolerance) + r * error + 4 * math.ulp(length)
        if r and abs(r * one - length) <= within:
            wanted.append((*row, r, r * one - length))
    wanted.sort(key=lambda row: (abs(row[-1]), row[1], row[0]))
    found = catalogue.identify(length=length, tolerance=tolerance, limit=limit)
    names = ("code", *OF_CANDIDATES[1:])
    assert [tuple(getattr(each, name) for name in names) for each in found] == wanted[:limit]
    assert all(each.total == each.repetitions * each.length for each in found)


def test_a_length_without_an_error_bound_uses_only_the_tolerance(own):
    length = there(Catalogue(own)["013"].length)
    alter(own, "UPDATE orbit SET length_error = NULL")  # as relaxation leaves it
    near = [Catalogue(own).identify(length=length + off, tolerance=1e-3) for off in (9e-4, 1.1e-3)]
    assert [len(each) > 0 for each in near] == [True, False]
    alter(own, "UPDATE orbit SET length_error = 1e-4")
    near = [Catalogue(own).identify(length=length + off, tolerance=1e-3) for off in (1.09e-3, 1.11e-3)]
    assert [len(each) > 0 for each in near] == [True, False]


def test_the_rounded_length_of_a_repetition_is_found(catalogue):
    for word in ("13", "0103155", "013"):
        one = catalogue[word]
        for times in (1, 3, 7, 1001):
            rounded = math.nextafter(times * one.length, math.inf)
            found = catalogue.identify(length=rounded, tolerance=0)
            assert (one.representative, times) in [(each.code, each.repetitions) for each in found]


START, PATH = (0, 0.5, 1.2), [[2.6, 0], [-2.6, 0], [2.6, 0]]
REFUSED = [
    ({}, "give one of start, points and length"),
    ({"start": START, "points": PATH}, "give one of start, points and length"),
    ({"start": (0, 0)}, "three numbers"),
    ({"start": (0, 0, math.nan)}, "not coordinates"),
    ({"start": (0, 1.1, 0)}, "0.1 outside the stadium at a = 1.6"),
    ({"start": "0,0,1"}, "x,y,angle"),
    ({"start": (1.6, 1, -1)}, "joint of wall and semicircle at bounce 0"),
    ({"start": (0, 0, math.atan2(1, 1.6))}, "joint .* at bounce 1"),
    ({"start": START, "bounces": 0}, "give 1 to 1000"),
    ({"start": START, "tolerance": 0}, "tolerance 0"),
    ({"start": START, "tolerance": math.nan}, "tolerance nan"),
    ({"start": START, "tolerance": 1e-20}, "larger tolerance"),
    ({"start": START, "limit": -1}, "limit = -1"),
    ({"start": START, "a": -1}, "not a half length"),
    ({"points": []}, "no points"),
    ({"points": PATH[:2]}, r"too few points \(2\): give 3"),
    ({"points": [*PATH, [1]]}, "pairs x,y"),
    ({"points": [1, 2, 3]}, "pairs x,y"),
    ({"points": [[10**400, 0]] * 3}, "pairs x,y"),
    ({"points": [PATH[0], [math.inf, 0], PATH[1]]}, "not coordinates"),
    ({"points": [PATH[0], [2.7, 0], PATH[1]]}, "point 2, .* lies 0.1 outside"),
    ({"points": [PATH[0], [0, 0], PATH[1]]}, "point 2, .* lies 1 inside"),
    ({"points": [PATH[0], PATH[1], PATH[1]]}, "points 2 and 3 are the same"),
    ({"points": PATH, "bounces": 3}, "with a start, not with points"),
    ({"length": 3, "start": (0, 0, 0)}, "give one of start, points and length"),
    ({"length": 0}, "length 0"),
    ({"length": 3, "tolerance": 1.5}, "tolerance 1.5"),
]


@pytest.mark.parametrize(("asked", "told"), REFUSED)
def test_bad_questions_are_refused_in_one_line(catalogue, asked, told):
    with pytest.raises(InputError, match=told) as refused:
        catalogue.identify(**asked)
    assert "\n" not in str(refused.value)


@pytest.mark.slow
def test_no_trajectory_continues_past_a_joint():
    """It makes no difference whether rounding takes it to the wall or to the semicircle."""
    rng = np.random.default_rng(4)
    for x, y in zip(rng.uniform(-1.6, 1.6, 40), rng.uniform(-0.9, 0.9, 40), strict=True):
        for joint in ((1.6, 1), (1.6, -1), (-1.6, 1), (-1.6, -1)):
            with pytest.raises(InputError, match="through a joint of wall and semicircle at bounce 1,"):
                trace_start(STADIUM, (x, y, math.atan2(joint[1] - y, joint[0] - x)), 1e-2)


@pytest.mark.slow
def test_a_start_on_the_boundary_is_bounce_0(catalogue):
    """If it is given to six digits, it may be slightly outside."""
    orbit = catalogue["1232131"]
    x, y, angle = (round(value, 6) for value in start_of(orbit.points))
    for start in ((x * 1.0000001, y, angle), (x * 0.9999999, y, angle)):
        found = catalogue.identify(start=start, limit=1)
        assert math.dist(found.points[-found.first], orbit.points[0]) < 1e-5
        assert name(found.shadowed[0]) == least_rotation("1232131")


def test_bouncing_balls_shadow_no_orbit(catalogue):
    found = catalogue.identify(start=(0.2, 0, math.pi / 2))
    assert (found.shadowed, found.total, set(found.sequence)) == ((), 0, {"0", "2"})
