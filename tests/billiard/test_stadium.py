"""The stadium's shape: points, tangents, outline, area and perimeter."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from orbitdb.billiard.stadium import MAX_A, MIN_A, STRAIGHT, Stadium

half_lengths = st.floats(MIN_A, MAX_A)
SYMBOLS = np.arange(6, dtype=np.uint8)


@given(half_lengths, st.floats(-1, 1))
def test_points_are_on_the_boundary(a, u):
    points = Stadium(a).points(SYMBOLS, np.where(STRAIGHT, a * u, math.pi / 2 * u))
    for symbol, (x, y) in enumerate(points):
        if symbol in (0, 2):
            assert y == symbol - 1
            assert abs(x) <= a
        else:
            centre = -a if symbol in (1, 4) else a
            assert math.hypot(x - centre, y) == pytest.approx(1, abs=1e-15 * (2 + a))
            assert (x - centre) * centre >= -1e-15 * (a + 1) * a


def test_coordinates_follow_the_paper():
    stadium = Stadium(1.5)
    points = stadium.points(np.array([0, 1, 2, 3, 4, 5], np.uint8), np.array([0.5, 0, -0.5, 0, 1, -1]))
    c, s = math.cos(1), math.sin(1)
    expected = [[0.5, -1], [-2.5, 0], [-0.5, 1], [2.5, 0], [-1.5 - c, s], [1.5 + c, -s]]
    assert np.abs(points - expected).max() < 1e-15


@given(st.floats(0.01, 100), st.floats(-1.5, 1.5))
def test_tangents_are_unit_derivatives_of_points(a, x):
    stadium, h = Stadium(a), 1e-5
    at = np.full(6, x)
    tangents = stadium.tangents(SYMBOLS, at)
    slope = (stadium.points(SYMBOLS, at + h) - stadium.points(SYMBOLS, at - h)) / (2 * h)
    assert np.hypot(*tangents.T) == pytest.approx(np.ones(6), abs=1e-15)
    assert np.abs(tangents - slope).max() < 1e-9 * (1 + a)


def test_walls_and_semicircles_meet_at_the_joints():
    stadium = Stadium(1.6)
    for wall, x, arc, t in ((0, -1.6, 1, -1), (2, -1.6, 4, 1), (0, 1.6, 3, -1), (2, 1.6, 5, 1)):
        symbols = np.array([wall, arc], np.uint8)
        first, second = stadium.points(symbols, np.array([x, t * math.pi / 2]))
        assert np.abs(first - second).max() < 1e-15


def test_arclength_is_the_distance_along_the_boundary():
    stadium = Stadium(1.3)
    symbols = np.array([0, 0, 3, 5, 3, 2, 2, 1, 4, 1], dtype=np.uint8)
    ends = math.pi / 2
    places = np.array([-1.3, 1.3, -ends, 0.0, ends, 1.3, -1.3, ends, 0.0, -ends])
    along = stadium.arclength(symbols, places)
    steps = [2.6, 0, ends, ends, 0, 2.6, 0, ends, ends]
    np.testing.assert_allclose(along, np.concatenate([[0], np.cumsum(steps)]), atol=1e-15)
    assert along[-1] == pytest.approx(stadium.perimeter)


@pytest.mark.parametrize("a", [0.01, 1.0, 1.6, 50.0])
def test_area_and_perimeter_match_the_outline(a):
    stadium = Stadium(a)
    x, y = stadium.outline(4000).T
    assert (x[0], y[0]) == (x[-1], y[-1])
    area = 0.5 * np.sum(x[:-1] * y[1:] - x[1:] * y[:-1])
    perimeter = np.hypot(np.diff(x), np.diff(y)).sum()
    assert area == pytest.approx(stadium.area, rel=1e-6)
    assert perimeter == pytest.approx(stadium.perimeter, rel=1e-6)
    assert stadium.mean_free_path == pytest.approx(math.pi * area / perimeter, rel=1e-6)
