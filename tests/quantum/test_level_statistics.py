"""Statistics of levels, checked on random matrices, random numbers and equal spacings."""

import math
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.linalg import eigvalsh
from there import there

from orbitdb.billiard.stadium import Stadium
from orbitdb.quantum.bouncing_balls import family
from orbitdb.quantum.level_statistics import (
    delta3,
    expected,
    gap_ratios,
    goe_delta3,
    goe_variance,
    number_variance,
    statistics,
    unfolded,
)
from orbitdb.quantum.weyl import Parity, weyl


@pytest.fixture
def rng():
    return np.random.default_rng(7)


def test_equal_spacings_have_the_least_rigidity_and_variance():
    x = np.arange(500.0) + 0.25
    assert gap_ratios(x).tolist() == [1.0] * 498
    assert delta3(x, 20) == pytest.approx(1 / 12, rel=0.02)
    assert there(number_variance(x, 5)) < 0.26


def test_delta3_is_the_mean_square_deviation_from_the_best_line(rng):
    x = np.sort(rng.random(40) * 40)
    length = 10.0
    found = []
    room = x[-1] - x[0] - length
    count = math.floor(room * 4)
    for start in x[0] + room * (np.arange(count) + 0.5) / count:
        places = start + (np.arange(4000) + 0.5) * length / 4000
        steps = np.searchsorted(x, places).astype(float)
        line = np.polyfit(places - start, steps, 1)
        found.append(np.mean((steps - np.polyval(line, places - start)) ** 2))
    assert delta3(x, length) == pytest.approx(np.mean(found), rel=1e-3)


@pytest.mark.slow
def test_random_numbers_have_poisson_statistics(rng):
    goe, poisson = expected()
    x = np.cumsum(rng.exponential(size=20_000))
    ratios = gap_ratios(x)
    assert abs(ratios.mean() - poisson.gap_ratio) < 5 * ratios.std() / math.sqrt(len(ratios))
    assert delta3(x, 5) == pytest.approx(poisson.delta3_5, rel=0.1)
    assert number_variance(x, 5) == pytest.approx(poisson.variance_5, rel=0.1)
    assert goe.gap_ratio > ratios.mean() + 0.1


@pytest.mark.slow
def test_random_matrices_have_goe_statistics(rng):
    goe, _ = expected()
    found: list[Any] = []
    for _ in range(5):
        matrix = rng.normal(size=(800, 800))
        values = np.sort(eigvalsh(matrix + matrix.T)) / math.sqrt(8 * 800)
        inside = np.clip(values, -1, 1)
        x = 800 * (0.5 + (inside * np.sqrt(1 - inside**2) + np.arcsin(inside)) / math.pi)[150:650]
        rigid = (number_variance(x, 1), number_variance(x, 5), delta3(x, 5), delta3(x, 20))
        assert None not in rigid
        found.append((gap_ratios(x).mean(), *rigid))
    mean, error = np.mean(found, axis=0), np.std(found, axis=0, ddof=1) / math.sqrt(5)
    wanted = (goe.gap_ratio, goe.variance_1, goe.variance_5, goe.delta3_5, goe.delta3_20)
    assert (np.abs(mean - wanted) < 6 * error + 0.01).all()


def test_the_rigidity_of_random_matrices_follows_from_their_number_variance():
    """For large L, Delta_3 is (ln(2 pi L) + gamma - 5/4 - pi^2/8) / pi^2, up to terms of order 1/L."""
    for length in (50.0, 200.0):
        long = (math.log(2 * math.pi * length) + np.euler_gamma - 1.25 - math.pi**2 / 8) / math.pi**2
        assert goe_delta3(length) == pytest.approx(long, abs=0.11 / length)
    whole = quad(lambda r: (27 - 18 * r + r**3) * goe_variance(r), 0, 3, limit=200)[0] * 2 / 81
    assert goe_delta3(3.0) == pytest.approx(whole, rel=1e-6)


def test_levels_are_unfolded_with_weyls_law_and_the_bouncing_balls():
    k, stadium = np.linspace(5, 20, 40), Stadium(1.6)
    smooth = weyl(stadium, Parity.OO)(k)
    np.testing.assert_array_equal(unfolded(k, stadium, Parity.OO), smooth)
    balls = sum(wave.imag / length for length, wave in family(stadium, k, 30.0, Parity.OO))
    np.testing.assert_allclose(unfolded(k, stadium, Parity.OO, balls=True) - smooth, balls)


def test_statistics_that_need_more_levels_are_left_out():
    found = statistics(np.linspace(3, 12, 25), Stadium(1.6), Parity.OO)
    assert found.delta3_20 is found.variance_20 is None
    assert found.delta3_1 is not None
    assert found.levels == 25
