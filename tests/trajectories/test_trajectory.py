"""Rays bounce by bounce: the law of reflection, symbols, and trajectories from a start."""

import math

import matplotlib
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from itineraries import itineraries, random_rays
from matplotlib import pyplot
from solutions import words_of
from there import there

from orbitdb.billiard.stadium import Stadium
from orbitdb.errors import InputError
from orbitdb.orbits.solve import solve, solve_word
from orbitdb.symbols.words import to_strings
from orbitdb.trajectories.ensemble import Arcs, advance
from orbitdb.trajectories.rays import Rays, bounce
from orbitdb.trajectories.trajectory import random_start, trace_points, trace_start, trajectory

widths = st.floats(-3, 3).map(lambda power: 10.0**power)
seeds = st.integers(0, 2**32 - 1)


def normals(rays, a):
    return np.where(rays.side == 0, 0.0, rays.x - rays.side * a), rays.y


def reflected(rays, a):
    """Return the directions in which the rays arrived at their bounces."""
    nx, ny = normals(rays, a)
    out = 2 * (rays.vx * nx + rays.vy * ny)
    return rays.vx - out * nx, rays.vy - out * ny


@given(widths, seeds)
@settings(max_examples=settings().max_examples // 2)
def test_every_bounce_is_on_the_boundary_and_obeys_the_law_of_reflection(a, seed):
    before = random_rays(Stadium(a), 50, np.random.default_rng(seed))
    for _ in range(20):
        hit = bounce(before, a)
        after = hit.rays
        on_wall = after.side == 0
        assert np.all(np.abs(after.x[on_wall]) <= a)
        assert np.all(np.abs(after.y[on_wall]) == 1)
        beyond = (after.x - after.side * a)[~on_wall]
        assert np.all(beyond * after.side[~on_wall] > -1e-12 * (1 + a))
        np.testing.assert_allclose(beyond**2 + after.y[~on_wall] ** 2, 1, atol=1e-14 * (1 + a))
        arrived = reflected(after, a)
        np.testing.assert_allclose(arrived, (before.vx, before.vy), atol=1e-13 * (1 + a))
        x, y = before.x + hit.path * before.vx, before.y + hit.path * before.vy
        np.testing.assert_allclose(x, after.x, rtol=1e-13, atol=1e-13 * (1 + a))
        np.testing.assert_allclose(y, after.y, atol=1e-13 * (1 + a))
        assert np.all(hit.path >= 0)
        nx, ny = normals(after, a)
        sine = -(after.vx * nx + after.vy * ny)
        np.testing.assert_allclose((hit.kick * sine)[~on_wall], 2, rtol=1e-6)
        assert not hit.kick[on_wall].any()
        before = after


def test_one_bounce_returns_a_ray_to_the_circle():
    t, graze, off, a = np.linspace(-1.4, 1.4, 9), 1e-3, 1 + 1e-7, 1.6
    way = t + math.pi / 2 + graze
    rays = Rays(a + off * np.cos(t), off * np.sin(t), off * np.cos(way), off * np.sin(way), np.ones(9))
    after = bounce(rays, a).rays
    assert np.hypot(after.x - a, after.y) == pytest.approx(1, abs=1e-12)
    assert np.hypot(after.vx, after.vy) == pytest.approx(1, abs=1e-12)


def test_bouncing_balls_never_end_and_a_steep_path_is_one_step():
    upright = Rays(*(np.array([v]) for v in (0.3, -1.0, 0.0, 1.0, 0.0)))
    found = itineraries(Stadium(1.6), upright, 1001)
    assert to_strings(found.symbols)[0] == "20" * 500 + "2"
    assert np.all(found.coordinates == 0.3)
    assert np.all(found.path == 2)
    slow = 1e-9
    arcs = Arcs(*(np.array([v]) for v in (1.0, slow, 1.0, -slow, -1.0)))
    step = advance(arcs, 1.6)
    assert step.walls[0] == pytest.approx(1.6 / slow, rel=1e-6)
    assert step.path[0] == pytest.approx(2 * step.walls[0], rel=1e-6)


@pytest.mark.parametrize(("p", "a"), [(2, 1.6), (3, 0.4), (5, 1.6), (6, 4.0), (7, 1.6), (8, 0.7)])
def test_solved_orbits_can_be_followed_and_read_back(p, a):
    """Rays that start on solved orbits reproduce the words and coordinates of these orbits."""
    stadium = Stadium(a)
    orbits = solve(words_of(p), stadium)
    real = orbits.status == "orbit"
    words, coordinates = orbits.words[real], orbits.coordinates[real]
    points = stadium.points(words, coordinates)
    ahead = points[:, 1] - points[:, 0]
    ahead /= np.hypot(ahead[:, :1], ahead[:, 1:])
    side = np.array([0.0, -1, 0, 1, -1, 1])[words[:, 0]]
    rays = Rays(points[:, 0, 0], points[:, 0, 1], ahead[:, 0], ahead[:, 1], side)
    found = itineraries(stadium, rays, p)
    assert to_strings(found.symbols) == to_strings(np.roll(words, -1, axis=1))
    error = 1e-13 * np.exp(orbits.lyapunov[real])
    worst = np.abs(found.coordinates - np.roll(coordinates, -1, axis=1)).max(axis=1)
    assert np.all(worst < error)
    assert np.all(np.abs(found.path.sum(axis=1) - orbits.length[real]) < p * error)


def test_a_path_into_a_joint_can_be_followed_up_to_the_joint():
    def followed(height, **most):
        return trace_start(Stadium(1.6), (0, 0, math.atan2(height, 1.6)), 1e-3, **most)

    for number, height in enumerate((1, -3), 1):  # to the joint, and to its image in the bottom wall
        with pytest.raises(InputError, match=rf"at bounce {number}, .*: move the start$"):
            followed(height)
    with pytest.raises(InputError, match=r"at bounce 3, .*: move the start, or follow fewer than 2 bounces$"):
        followed(-5)
    with pytest.raises(InputError, match="at bounce 3"):
        followed(-5, bounces=2)
    assert to_strings(followed(-5, bounces=1).symbols[None]) == ["20"]


def test_a_polygon_that_ends_where_it_starts_is_closed():
    points = [(0, -1), (0.5, 1), (0.3, -1), (0, -1)]
    assert to_strings(trace_points(Stadium(1.6), points, 0.0).symbols[None]) == ["020"]
    joint = [(1.6, 1), (0.5, -1), (0.3, 1)]  # the end of a wall
    assert to_strings(trace_points(Stadium(1.6), joint, 0.0).symbols[None]) == ["202"]


@given(widths, seeds)
@settings(max_examples=settings().max_examples // 4)
def test_any_trajectory_obeys_the_law_of_reflection_at_every_bounce(a, seed):
    stadium, rng = Stadium(a), np.random.default_rng(seed)
    x, y, angle = rng.uniform(-a, a), rng.uniform(-1, 1), rng.uniform(-math.pi, math.pi)
    path = trajectory(a, x, y, angle, bounces=30)
    assert len(path) == 30
    points = np.stack([np.append(x, path.x), np.append(y, path.y)], axis=1)
    steps = np.diff(points, axis=0)
    before = np.stack([np.cos(np.append(angle, path.angle[:-1])), np.sin(np.append(angle, path.angle[:-1]))])
    after = np.stack([np.cos(path.angle), np.sin(path.angle)])
    np.testing.assert_allclose(steps, before.T * path.path[:, None], atol=1e-12 * (1 + a))
    curved = ~np.isin(path.symbol, (0, 2))
    normal = np.stack([np.where(curved, path.x - np.sign(path.x) * a, 0.0), path.y])
    np.testing.assert_allclose(np.hypot(*normal), 1, atol=1e-12 * (1 + a))
    mirrored = before - 2 * (before * normal).sum(axis=0) * normal
    np.testing.assert_allclose(mirrored, after, atol=1e-11 * (1 + a))
    assert np.all(np.abs(path.x[~curved]) <= stadium.a)


@pytest.mark.parametrize("word", ["01112555", "011255", "111333"])
def test_the_first_run_has_its_sense_wherever_in_it_a_trajectory_starts(word):
    """Before its last bounce, too: only the bounce before the start tells whether the run goes up or down."""
    for orbit in there(solve_word(word, 1.6)).images():
        points, code = there(orbit.points), orbit.code
        for last in range(orbit.p):
            step = points[last] - points[last - 1]
            x, y = ((points[last] + points[last - 1]) / 2).tolist()
            path = trajectory(1.6, x, y, math.atan2(step[1], step[0]), bounces=orbit.p)
            assert to_strings(path.symbol[None])[0] == code[last:] + code[:last], (code, last)


def test_a_trajectory_along_an_orbit_has_its_bounces_and_symbols():
    orbit = there(solve_word("1232131", 1.6))
    points = there(orbit.points)
    step = points[0] - points[-1]
    x, y = points[-1].tolist()
    path = trajectory(1.6, x, y, math.atan2(step[1], step[0]), bounces=14)
    assert to_strings(path.symbol[None])[0] == 2 * orbit.code
    off = np.hypot(path.x - np.tile(points[:, 0], 2), path.y - np.tile(points[:, 1], 2))
    assert (off <= 1e-13 + 10 * path.error).all()
    assert path.path[:7].sum() == pytest.approx(there(orbit.length), rel=1e-12)


@given(widths, seeds)
@settings(max_examples=settings().max_examples // 4)
def test_the_stretching_is_that_of_two_neighbours_in_the_most_stretched_direction(a, seed):
    """Neighbours offset across the path and in direction give the map by differences."""
    path = trajectory(a, seed=seed, bounces=4)
    x, y, angle = random_start(Stadium(a), seed)
    small = 1e-7
    across = np.array([-math.sin(angle), math.cos(angle)])
    columns = []
    for offset, turn in ((small, 0.0), (0.0, small)):
        ends = []
        for sign in (1, -1):
            sx, sy = np.array([x, y]) + sign * offset * across
            try:
                ends.append(trajectory(a, sx, sy, angle + sign * turn, bounces=4))
            except InputError:  # the neighbour starts outside
                return
        one, two = ends
        if (one.symbol != two.symbol).any() or (path.error > 1e-11).any() or path.path.min() < 1e-3:
            return
        turned = np.angle(np.exp(1j * (one.angle - two.angle)))
        off = -np.sin(path.angle) * (one.x - two.x) + np.cos(path.angle) * (one.y - two.y)
        columns.append(np.stack([off, turned]) / (2 * small))
    norms = np.linalg.norm(np.moveaxis(np.array(columns), -1, 0), ord=2, axis=(1, 2))
    np.testing.assert_allclose(np.exp(path.lyapunov), norms, rtol=1e-3)


@given(widths, seeds)
@settings(max_examples=settings().max_examples // 4)
def test_stretching_is_never_shrinking_and_does_not_stop(a, seed):
    path = trajectory(a, seed=seed, bounces=300)
    assert (path.lyapunov >= 0).all()  # the map preserves areas
    assert np.isfinite(path.lyapunov).all()
    assert np.isfinite(path.error).all()


def test_a_trajectory_along_an_orbit_is_stretched_by_lambda_in_every_traversal():
    orbit = there(solve_word("13", 1.6))
    path = trajectory(1.6, 0, 0, 0, bounces=60)
    each = path.lyapunov[11::2] - path.lyapunov[9:-2:2]
    np.testing.assert_allclose(each, there(orbit.lyapunov), rtol=1e-12)
    balls = trajectory(1.6, 0, 0, math.pi / 2, bounces=1000)  # only shear: the matrix is (1, length; 0, 1)
    length = balls.path.cumsum()
    np.testing.assert_allclose(balls.lyapunov, np.arcsinh(length / 2), rtol=1e-12)


@pytest.mark.slow
def test_finite_time_exponents_tend_to_the_average_over_trajectories():
    path = trajectory(1.6, seed=3, bounces=10_000)
    assert path.lyapunov[-1] / len(path) == pytest.approx(0.88679, abs=0.06)
    assert path.lyapunov[-1] / path.path.sum() == pytest.approx(0.37521, abs=0.03)


def test_random_starts_are_uniform_and_repeatable():
    again = [trajectory(1.6, seed=3) for _ in range(2)]
    assert (again[0].x == again[1].x).all()
    assert (again[0].x != trajectory(1.6, seed=4).x).any()
    stadium, rng = Stadium(0.5), np.random.default_rng(1)
    x, y, angle = np.array([random_start(stadium, rng) for _ in range(4000)]).T
    inside = 4 * 0.5 / stadium.area  # the share of the rectangle between the straight walls
    assert np.mean(np.abs(x) < 0.5) == pytest.approx(inside, abs=0.04)
    assert np.hypot(np.maximum(np.abs(x) - 0.5, 0), y).max() < 1
    assert np.abs([np.mean(np.exp(1j * angle)), np.mean(x), np.mean(y)]).max() < 0.08


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({}, "a seed for a random start"),
        ({"x": 0.0, "y": 0.0}, "a seed for a random start"),
        ({"x": 0.0, "y": 0.0, "angle": 1.0, "seed": 3}, "a seed for a random start"),
        ({"x": 0.0, "seed": 3}, "a seed for a random start"),
        ({"seed": -1}, "seed = -1"),
        ({"seed": "three"}, "seed = 'three'"),
    ],
)
def test_a_trajectory_needs_one_start(given, message):
    with pytest.raises(InputError, match=message):
        trajectory(1.6, **given)


def test_a_trajectory_is_a_table_and_a_picture():
    matplotlib.use("agg")
    path = trajectory(Stadium(1.0), 0.2, -1, 1.0, 5)
    assert str(path) == "<5 bounces at a = 1>"
    assert repr(path).splitlines()[1].split()[:4] == ["x", "y", "angle", "symbol"]
    assert path._repr_html_().count("<tr>") == 6
    long = trajectory(1.0, seed=1, bounces=30)
    assert long._repr_html_().count("<tr>") == 21
    assert "… and 10 more" in long._repr_html_()
    frame = path.to_pandas()
    assert list(frame.columns) == ["x", "y", "angle", "symbol", "path", "error", "lyapunov"]
    assert frame["x"].tolist() == path.x.tolist()
    axes = path.plot()
    assert axes.get_title() == "5 bounces at $a = 1$"
    pyplot.close("all")


@pytest.mark.parametrize(
    ("start", "bounces", "message"),
    [
        ((3, 0, 1), 5, "outside the stadium"),
        ((0, math.nan, 1), 5, "nan and inf"),
        (("left", 0, 1), 5, "three numbers|give the start"),
        ((0, 0, 1), 0, "give 1 to"),
        ((0, 0, 1), 2.5, "give 1 to"),
    ],
)
def test_an_impossible_trajectory_says_why(start, bounces, message):
    with pytest.raises(InputError, match=message):
        trajectory(1.6, start[0], start[1], start[2], bounces)
