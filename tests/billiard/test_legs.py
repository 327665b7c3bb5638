"""Runs and legs: how words are cut, and the length as a function of directions with its derivatives."""

import mpmath as mp
import numpy as np
import pytest
from solutions import words_of

from orbitdb.billiard.legs import (
    Chain,
    Legs,
    cut,
    derivatives,
    direction_limits,
    gradient_rounding,
    length,
    slack_errors,
    slacks,
    summation_rounding,
)
from orbitdb.billiard.stadium import STRAIGHT
from orbitdb.orbits.newton import newton
from orbitdb.symbols.words import from_strings

ALL = {p: words_of(p) for p in range(2, 8)}
STEP = 1e-30


def pieces(max_p: int = 7):
    """Cut all admissible words into legs."""
    return [(words[rows], legs) for p, words in ALL.items() if p <= max_p for rows, legs in cut(words)]


def directions(legs: Legs, a: float, seed: int) -> np.ndarray:
    """Return random directions between the limits."""
    low, high = direction_limits(legs, a)
    return np.random.default_rng(seed).uniform(low, high)


def hessian(legs: Legs, a: float, alpha: np.ndarray) -> np.ndarray:
    """Return the Hessian of L, built from `derivatives`, shape (N, m, m)."""
    slopes = derivatives(legs, a, alpha)
    m, count = alpha.shape
    matrix = np.zeros((count, m, m))
    for i in range(m):
        matrix[:, i, i] -= slopes.between_centres[i]
        sign = legs.parity[i - 1]  # run i sees parity * alpha of the leg before it
        matrix[:, i, i] -= slopes.stiffness[i]
        matrix[:, i - 1, i - 1] -= slopes.stiffness[i]
        matrix[:, i, i - 1] -= sign * slopes.stiffness[i]
        matrix[:, i - 1, i] -= sign * slopes.stiffness[i]
    return matrix


@pytest.mark.parametrize(
    ("word", "k", "d", "n", "s"),
    [
        ("13", [1, 1], [1, 1], [0, 0], [0, 0]),
        ("1232131", [1, 1, 2, 1], [1, 1, 1, 1], [0, 0, 1, 1], [0, 0, 1, 1]),
        ("020344", [2, 1], [-1, 1], [3, 0], [-1, 0]),
        ("4420255", [2, 2], [-1, -1], [3, 0], [1, 0]),
        ("1550", [1, 2], [1, -1], [0, 1], [0, -1]),
    ],
)
def test_runs_and_legs_of_some_words_are_known(word, k, d, n, s):
    ((_, legs),) = cut(from_strings([word]))
    assert legs.k[:, 0].tolist() == k
    assert legs.d[:, 0].tolist() == d
    assert legs.n[:, 0].tolist() == n
    assert legs.s[:, 0].tolist() == s


def test_every_word_is_cut_once():
    for p, words in ALL.items():
        groups = cut(words)
        assert sorted(np.concatenate([rows for rows, _ in groups]).tolist()) == list(range(len(words)))
        for rows, legs in groups:
            assert (legs.k.sum(axis=0) + legs.n.sum(axis=0) == p).all()
            assert (STRAIGHT[words[rows]] == legs.bounces.straight.T).all()


@pytest.mark.parametrize("a", [1e-3, 0.5, 1.6, 50.0])
def test_gradient_is_the_derivative_of_the_length(a):
    """Complex steps do not suffer from cancellation, so they are exact to rounding."""
    for _, legs in pieces():
        alpha = directions(legs, a, 1)
        found = derivatives(legs, a, alpha).gradient
        for i in range(len(alpha)):
            moved = alpha.astype(complex)
            moved[i] += 1j * STEP
            exact = length(legs, a, moved).imag / STEP
            assert (np.abs(found[i] - exact) <= gradient_rounding(legs, a, alpha)[i]).all()


@pytest.mark.parametrize("a", [1e-3, 0.5, 1.6, 50.0])
def test_curvatures_are_the_derivatives_of_the_gradient(a):
    for _, legs in pieces():
        alpha = directions(legs, a, 2)
        matrix = hessian(legs, a, alpha)
        for i in range(len(alpha)):
            moved = alpha.astype(complex)
            moved[i] += 1j * STEP
            exact = derivatives(legs, a, moved).gradient.imag / STEP
            assert np.abs(matrix[:, :, i] - exact.T).max() < 1e-13 * (10 + a)


@pytest.mark.parametrize("a", [1e-6, 1e-3, 0.1, 0.5, 1.6, 50.0, 1e6])
def test_length_is_strictly_concave_between_the_limits(a):
    """Therefore no word has two orbits. The corners of the box are the worst points."""
    for _, legs in pieces():
        corners = np.where(directions(legs, a, 3) > directions(legs, a, 4), *direction_limits(legs, a))
        for alpha in (directions(legs, a, 5), corners):
            slopes = derivatives(legs, a, alpha)
            assert (slopes.between_centres > 0).all()
            assert (slopes.stiffness > 0).all()
            scale = np.abs(hessian(legs, a, alpha)).max(axis=(1, 2))
            assert (np.linalg.eigvalsh(hessian(legs, a, alpha)).max(axis=1) < 1e-14 * scale).all()


@pytest.mark.parametrize("a", [1e-6, 1e-3, 0.1, 1.6, 1e3, 1e6])
def test_limits_enclose_every_orbit_by_more_than_rounding(a):
    """The exact limits are (n - 1)/(a + 1) <= s tan alpha <= (n + 1)/a, the latter 1e-12 from pi/2."""
    n = np.array([0, 1, 2, 3, 1000, 45_000, 135_002, 999_997.0])
    one = np.ones_like(n)[:, None]
    for s in (-1.0, 1.0):
        legs = Chain(one, one, n[:, None], np.where(n > 0, s, 0.0)[:, None])
        low, high = (limit[:, 0] for limit in direction_limits(legs, a))
        for i, walls in enumerate(n.tolist()):
            flat, steep = (low[i], high[i]) if s > 0 else (-high[i], -low[i])
            with mp.workdps(40):
                least = mp.atan((walls - 1) / (mp.mpf(a) + 1)) if walls else -mp.atan(1 / mp.mpf(a))
                most = mp.atan((walls + 1) / mp.mpf(a))
                assert mp.mpf(float(flat)) <= (least - 5e-14 if walls != 1 else 0)
                assert most + 5e-14 < mp.mpf(float(steep)) < mp.pi / 2 - 1e-13


def test_slack_errors_bound_the_effect_of_a_change_of_direction():
    rng = np.random.default_rng(7)
    for _, legs in pieces():
        alpha = directions(legs, 1.6, 8)
        size = 10.0 ** rng.uniform(-12, -3, alpha.shape)
        moved = alpha + size * rng.choice([-1, 1], alpha.shape)
        before, bound = slacks(legs, alpha), slack_errors(legs, size)
        walled = np.isfinite(before)
        change = np.abs(slacks(legs, moved)[walled] - before[walled])
        assert (change <= bound[walled]).all()


def test_the_rounding_of_a_gradient_is_the_same_for_the_reversed_word():
    """Each leg has a run at either end. In the reversed word, the first leg is the last but one."""
    rng = np.random.default_rng(2)
    k, n, alpha = (rng.uniform(*ends, (6, 1)) for ends in ((1, 50), (0, 4), (-1, 1)))
    one = np.ones_like(k)

    def back(of_legs: np.ndarray) -> np.ndarray:
        return np.roll(of_legs[::-1], -1, axis=0)

    there = gradient_rounding(Chain(k, one, n, one), 0.8, alpha)
    again = gradient_rounding(Chain(k[::-1], one, back(n), one), 0.8, back(alpha))
    np.testing.assert_allclose(again, back(there), rtol=1e-14)


def test_sums_over_many_legs_stay_within_their_bound():
    """In a batch of long words, a plain loop over the legs would lose five digits."""
    word = "13" * 20_000 + "3"
    ((_, legs),) = cut(from_strings([word, word[1:] + word[:1]]))
    alpha = newton(legs, 0.7).alpha
    found = length(legs, 0.7, alpha)
    for i, one in enumerate((word, word[1:] + word[:1])):
        ((_, alone),) = cut(from_strings([one]))
        (single,) = length(alone, 0.7, alpha[:, i : i + 1])
        assert abs(found[i] - single) <= 2 * summation_rounding(len(alpha)) * single
