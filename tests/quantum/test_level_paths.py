"""The laws of spacings, the errors of the staircase, and the sum over all ways of numbering a list."""

import math
from itertools import product

import numpy as np
import pytest
from scipy.integrate import trapezoid

from orbitdb.billiard.stadium import Stadium
from orbitdb.quantum.comparison import CUTOFF, Comparison, Rates, places, smoothed
from orbitdb.quantum.level_paths import BACK, Beam, backward, forward
from orbitdb.quantum.spacing_laws import MIXED, SpacingLaw
from orbitdb.quantum.staircase_errors import ErrorOfOrbits, deviations, places_in_gap, whitening
from orbitdb.quantum.weyl import Parity, wavenumber, weyl

S = np.linspace(0, 10, 4001)


@pytest.mark.parametrize("parts", [1, MIXED])
def test_spacing_laws_are_densities_with_the_right_means(parts):
    law = SpacingLaw(parts)
    for m in range(4):
        density = np.exp(law.log_density(np.array(m), S))
        assert trapezoid(density, S) == pytest.approx(1, abs=5e-3)
        assert trapezoid(density * S, S) == pytest.approx(m + 1, abs=5e-3)
        variance = trapezoid(density * (S - m - 1) ** 2, S)
        assert law.variances(5)[m] == pytest.approx(variance, abs=0.03)


def test_levels_of_one_parity_repel_each_other_and_those_of_all_hardly():
    one, mixed = SpacingLaw(1), SpacingLaw(MIXED)
    near = np.array([0.05])
    assert np.exp(one.log_density(np.array(0), near)) < 0.12
    assert np.exp(mixed.log_density(np.array(0), near)) == pytest.approx(0.74, abs=0.02)


def test_the_mixed_law_is_that_of_four_lists_joined():
    """The reference draws spacings of Wigner's law and joins four lists."""
    draw = np.random.default_rng(4)
    lists = [MIXED * np.cumsum(np.sqrt(-4 / np.pi * np.log(draw.random(50_000)))) for _ in range(MIXED)]
    joined = np.sort(np.concatenate(lists))
    for m in range(3):
        distances = joined[m + 1 :] - joined[: -m - 1]
        shares, edges = np.histogram(distances, np.arange(0, 4.1, 0.5))
        density = np.exp(SpacingLaw(MIXED).log_density(np.array(m), S))
        for share, low in zip(shares / len(distances), edges[:-1], strict=True):
            inside = (low <= S) & (low + 0.5 >= S)
            assert trapezoid(density[inside], S[inside]) == pytest.approx(share, abs=0.01)


@pytest.mark.parametrize("parts", [1, MIXED])
def test_far_apart_the_number_of_levels_between_is_normal(parts):
    """Where the surmise ends, both laws agree."""
    law, m = SpacingLaw(parts), np.arange(6, 14)
    below, above = (np.exp(law.log_density(m, np.full(8, s))) for s in (9.99, 10.01))
    assert np.abs(below - above).max() < 0.1
    far = np.exp(law.log_density(np.arange(60), np.full(60, 30.0)))
    assert far.sum() == pytest.approx(1, abs=1e-6)


def test_missing_levels_are_less_certain_in_the_middle_of_a_gap():
    spread = np.diag(places_in_gap(5, SpacingLaw(1).variances(6)))
    assert spread == pytest.approx(spread[::-1])
    assert spread[2] > spread[1] > spread[0] > 0


@pytest.mark.parametrize("m", [1, 3])
def test_missing_levels_scatter_as_those_of_random_matrices(m):
    """The reference are the middle eigenvalues of random matrices, in units of the spacings of each gap."""
    draw, off = np.random.default_rng(2), []
    for matrix in draw.normal(size=(60, 120, 120)):
        x = np.linalg.eigvalsh(matrix + matrix.T)[40:80]
        unit = (x[m + 1 :] - x[: -m - 1]) / (m + 1)
        off += [(x[j : len(unit) + j] - x[: len(unit)]) / unit - j for j in range(1, m + 1)]
    expected = np.diag(places_in_gap(m, SpacingLaw(1).variances(m + 1))).mean()
    assert np.square(np.concatenate(off)).mean() == pytest.approx(expected, rel=0.07)


def test_deviations_of_the_expected_noise_are_independent_with_variance_1():
    stadium, count = Stadium(1.6), 120
    grid = 20 + np.arange(count) / CUTOFF
    lag = np.abs(grid[:, None] - grid)
    error = ErrorOfOrbits(CUTOFF, stadium.perimeter, 14.0, False)
    covariance = error.covariance(lag) + 1e-4 * np.eye(count)
    factor = np.linalg.cholesky(covariance)
    white = whitening(grid, error, (None, None), np.full(count, 8.0), np.zeros((count, 21)), 0.0)
    drawn = np.random.default_rng(6).normal(size=(400, count)) @ factor.T
    u = np.array([deviations(white, row) for row in drawn])
    assert u.var() == pytest.approx(1, abs=0.03)
    assert np.abs((u[:, 1:] * u[:, :-1]).mean()) < 0.02


@pytest.fixture(scope="module")
def short():
    """Six levels with a gap after the third, compared with the exact staircase of all seven."""
    stadium = Stadium(1.6)
    smooth = weyl(stadium, Parity.OO)
    every = np.array([wavenumber(smooth, n + 0.2 * (-1) ** n) for n in range(60)])
    k = np.delete(every[30:37], 3)
    error = ErrorOfOrbits(CUTOFF, stadium.perimeter, 14.0, False)
    return Comparison(k, lambda at: smoothed(at, every, CUTOFF), smooth, error, True, 0.0)


def test_the_beam_gives_the_probabilities_of_an_enumeration_of_all_paths(short):
    """The reference adds up the probabilities of all paths, each with its residual on the whole grid."""
    rates = Rates()
    steps = short.steps(rates)
    data = short.data(steps, None, rates.tau2)
    firsts = short.firsts(short.difference)
    posterior = backward(
        forward(data, steps, firsts, Beam(40.0, 100_000)), steps, 10, np.random.default_rng(0)
    )
    paths = [path for path in _paths(steps, len(short.k)) if sum(steps.log_weight[path]) > -15]
    logs, total = [], np.zeros(len(steps.level))
    for first, path in product(firsts.tolist(), paths):
        drawn = np.array(path)
        u = deviations(data.white, short.residual(steps, drawn, first))
        logs.append((steps.log_weight[drawn].sum() - (u**2).sum() / (2 * rates.tau2), drawn))
    most = max(log for log, _ in logs)
    for log, drawn in logs:
        total[drawn] += math.exp(log - most)
    total /= sum(math.exp(log - most) for log, _ in logs)
    np.testing.assert_allclose(posterior.probability, total, atol=0.03)
    likely = steps.missing[total.argmax()]
    assert likely >= 0


def _paths(steps, n, level=0, back=1):
    """Yield all paths as lists of rows of the steps."""
    if level == n:
        yield []
        return
    place = BACK * level + back - 1
    for row in range(int(steps.start[place]), int(steps.start[place + 1])):
        if steps.log_weight[row] > -9:
            after = back + 1 if steps.missing[row] < 0 else 1
            for rest in _paths(steps, n, level + 1, after):
                yield [row, *rest]


def test_drawn_paths_have_the_probabilities_of_the_steps(short):
    steps = short.steps(Rates())
    data = short.data(steps, None, 1.5)
    passed = forward(data, steps, short.firsts(short.difference), Beam(18.0, 300))
    posterior = backward(passed, steps, 4000, np.random.default_rng(3))
    share = np.bincount(posterior.drawn.ravel(), minlength=len(steps.level)) / 4000
    np.testing.assert_allclose(share, posterior.probability, atol=0.04)
    missing = np.mean([len(places(short.k, steps, path)) for path in posterior.drawn.T])
    assert missing == pytest.approx(float(posterior.probability @ np.maximum(steps.missing, 0)), abs=0.05)


def test_a_large_beam_changes_nothing(short):
    steps = short.steps(Rates())
    data, firsts = short.data(steps, None, 1.5), short.firsts(short.difference)
    small, large = (
        forward(data, steps, firsts, beam).log_evidence for beam in (Beam(18, 300), Beam(40, 9999))
    )
    assert small == pytest.approx(large, abs=1e-3)
    assert small <= large + 1e-9
