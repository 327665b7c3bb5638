"""Exact means compared with explicit sums, known values, and random trajectories leg by leg."""

import numpy as np
import pytest
from quick import slow_but

from orbitdb.averages.exact_means import LOG_KICK, exact_means, log_drift, mean_coupling
from orbitdb.billiard.stadium import Stadium
from orbitdb.trajectories.legwise import next_leg, random_runs

SAMPLE = 1 << 17
HALF_LENGTHS = (0.05, 0.7, 1.6, 8.0)


def leg_probabilities(a, most):
    """Return the probabilities of 0, 1, ..., `most` straight bounces in a leg, shape (most + 1,).

    They are second differences of G(h) = sqrt(4 a^2 + h^2): P_n = [G(2n + 2) - 2 G(2n) + G(2n - 2)] / 4, and
    twice as much for n > 0, because either wall can come first.
    """
    h = 2.0 * np.arange(-1, most + 2)
    g = np.sqrt(4 * a * a + h * h)
    rises = 4 * (h[1:] + h[:-1]) / 2 / (g[1:] + g[:-1])  # differences of G, without cancellation
    probabilities = np.diff(rises) / 4
    probabilities[1:] *= 2
    return probabilities


def run_probabilities(most):
    """Return the probabilities of 1, 2, ..., `most` bounces in a run, shape (most,), at any a."""
    k = np.arange(1, most + 2)
    s = np.concatenate([[0.0], 2 * k * np.sin(np.pi / (2 * k))])
    return -np.diff(s, 2) / 2


@pytest.mark.parametrize("a", HALF_LENGTHS)
def test_leg_probabilities_add_up_to_one_and_average_a_walls(a):
    p, n = leg_probabilities(a, 100_000), np.arange(100_001)
    tail = a**2 / 100_000**2  # integral of P_n = 2 a^2 / n^3, to leading order
    assert p.min() > -1e-15
    assert p.sum() + tail / 2 == pytest.approx(1, abs=1e-3 * tail + 1e-12)
    assert p @ n == pytest.approx(a, rel=3 * a / 100_000)


def test_run_probabilities_add_up_to_one_and_average_half_pi_bounces():
    p, k = run_probabilities(3000), np.arange(1, 3001)
    assert p.sum() == pytest.approx(1, abs=1e-9)
    assert p @ k == pytest.approx(np.pi / 2, abs=1e-6)
    assert p[0] == pytest.approx(2 - np.sqrt(2))


def test_means_equal_known_values():
    """The values were computed to 30 digits with mpmath, with the tail from the Euler-Maclaurin formula."""
    k, p = np.arange(1, 2001), run_probabilities(2000)
    tail = np.pi**3 / 8 * (np.log(2000.5) / 3 + 1 / 9) / 2000.5**3
    catalan = 0.915965594177219015
    value = np.log(2) + 2 - 2 * catalan + p @ np.log(k) + tail
    assert LOG_KICK.value == pytest.approx(value, abs=1e-13)
    assert 2 * tail / 2000.5**2 < LOG_KICK.error
    assert LOG_KICK.value == pytest.approx(1.198559186, abs=1e-9)
    for a, exact in ((0.1, -1.6361690782821534), (1.6, 1.4655673872673423)):
        found = log_drift(a)
        assert abs(found.value - exact) <= found.error < 1e-11


@pytest.mark.parametrize("a", slow_but([300.0], [300.0, 3000.0]))
def test_the_tail_of_the_leg_sum_equals_a_longer_sum(a):
    """The longer sum is over all copies of the circle up to 400 000, each integrated over u."""
    x, weight = np.polynomial.legendre.leggauss(20)
    total = 1 + np.log(a)
    for n in np.array_split(np.arange(400_001.0), 50):
        for u, w in zip(np.concatenate([x - 1, x + 1]), np.tile(weight, 2) / 2, strict=True):
            h, both = 2 * n + u, np.where(n, 1.0, 0.5)  # copy 0 has rises of both signs once
            square = 4 * a * a + h * h
            total += w * both @ ((2 - abs(u)) * 4 * a * a / square**1.5 * np.log1p(-h * u / square))
    found = log_drift(a)
    assert abs(found.value - total) < 1e-14 < found.error < 1e-12


MEANS_OF_C2 = {
    1e-4: 8.333998299, 1e-3: 6.033147408, 0.00636: 4.192291004, 0.02: 3.066897346, 0.0362: 2.495462128,
    0.1: 1.559301490, 1.6: 0.152769820, 6.0: 0.043553803,
}  # fmt: skip
"""Values accurate to 4e-9, computed with three times as many nodes in phi and initial panels a/10 wide."""


@pytest.mark.parametrize(
    "a",
    [
        pytest.param(a, marks=[pytest.mark.fuzz] if a < 0.005 else [pytest.mark.slow] if a < 1 else [])
        for a in MEANS_OF_C2
    ],
)
def test_the_mean_of_c2_is_within_its_stated_error(a):
    """This includes half lengths at which wide panels would miss the peak at t = pi/2k or D is short."""
    rough, fine = mean_coupling(a, 1e-4), mean_coupling(a, 1e-7)
    for found in (rough, fine):
        assert abs(found.value - MEANS_OF_C2[a]) <= found.error + 4e-9
    assert fine.error < 1e-6


def test_bounds_on_lambda_include_the_errors_of_their_means():
    means = exact_means(0.5)
    low, high = means.bounds
    known = means.log_drift.value + means.log_kick.value
    error = means.log_drift.error + means.log_kick.error
    assert low == pytest.approx(known - error, abs=1e-15, rel=0)
    assert high == pytest.approx(
        known + means.coupling.value + error + means.coupling.error, abs=1e-15, rel=0
    )


@pytest.mark.parametrize("a", slow_but([0.05, 1.6], HALF_LENGTHS))
def test_means_agree_with_random_trajectories(a):
    first = next_leg(random_runs(SAMPLE, np.random.default_rng(5)), a)
    second = next_leg(first.runs, a)
    means = exact_means(a)
    coupling = np.log1p((1 / first.drift + 1 / second.drift) / second.kick)
    for sample, exact in (
        (np.log(second.drift), means.log_drift.value),
        (np.log(second.kick), means.log_kick.value),
        (coupling, means.coupling.value),
        (second.path - 2 * second.walls, 1 / Stadium(a).legs_per_length - 2 * a),
        (second.bounces, 1 / Stadium(a).legs_per_bounce - a),
    ):
        assert abs(sample.mean() - exact) < 4 * sample.std() / np.sqrt(SAMPLE)
    for sample, p in ((second.walls, leg_probabilities(a, 4)), (second.bounces - 1, run_probabilities(4))):
        share = np.bincount(sample.astype(int), minlength=len(p))[: len(p)] / SAMPLE
        assert (np.abs(share - p) < 4 * np.sqrt(p / SAMPLE)).all()


def test_lambda_is_within_its_bounds():
    low, high = exact_means(1.6).bounds
    assert low == pytest.approx(2.664126573, abs=1e-8)
    assert high == pytest.approx(2.816896395, abs=1e-6)
    assert low < 2.811817 < high
