"""Zeta functions against systems whose zeta function is known, and against listing every pseudo-cycle."""

import itertools
import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from orbitdb.averages.pseudocycles import Factors, expand_by_stability
from orbitdb.averages.zeta import cycle_averages, expand, leading_zero

NOTHING = np.zeros((0, 8))


@pytest.mark.parametrize("symbols", [1, 2, 6])
def test_full_shift_has_one_minus_bz(symbols):
    traces = float(symbols) ** np.arange(1.0, 9.0)
    found = expand(traces, NOTHING).coefficients
    np.testing.assert_allclose(found, [1, -symbols, *[0] * 7], atol=1e-9 * symbols**8)
    assert leading_zero(found[:2]) == pytest.approx(1 / symbols, rel=1e-15)


def test_no_positive_zero_is_nan():
    assert math.isnan(leading_zero(np.array([1.0])))
    assert math.isnan(leading_zero(np.array([1.0, 0.0, 1.0])))
    assert math.isnan(leading_zero(np.array([1.0, 2.0, 0.0, 0.0])))
    assert math.isnan(cycle_averages(expand(np.zeros(3), np.zeros((2, 3))))[2][1])


@given(st.lists(st.floats(0.2, 3), min_size=1, max_size=6))
def test_leading_zero_is_the_least_of_known_zeros(zeros):
    zeros = sorted(set(np.round(zeros, 1)))
    polynomial = np.polynomial.Polynomial([1.0])
    for zero in zeros:
        polynomial *= np.polynomial.Polynomial([1.0, -1 / zero])
    assert leading_zero(np.array(polynomial.coef, float)) == pytest.approx(zeros[0], rel=1e-7)


def test_a_leading_zero_among_others_has_more_digits_than_an_eigenvalue():
    """The eigenvalue alone is off by 1e-11 here."""
    zeros = [0.5, 0.55, 0.6, 0.65, 3, 3.1, 3.2]
    exact, none = [Fraction(1)], Fraction(0)
    for zero in map(Fraction, map(str, zeros)):
        exact = [one - other / zero for one, other in zip([*exact, none], [none, *exact], strict=True)]
    assert leading_zero(np.array(exact, float)) == pytest.approx(0.5, rel=2e-12)


def listed(factors, cut, degree):
    """Multiply out 1/zeta by listing every set of single factors."""
    kinds = [i for i, count in enumerate(factors.count) for _ in range(count)]
    sums = np.zeros((1 + len(factors.observables), degree + 1))
    for size in range(len(kinds) + 1):
        for chosen in map(list, itertools.combinations(kinds, size)):
            period = factors.period[chosen].sum()
            if period <= degree and factors.cost[chosen].sum() <= cut:
                value = np.prod(-factors.weight[chosen])
                sums[0, period] += value
                sums[1:, period] += value * factors.observables[:, chosen].sum(axis=1)
    return sums


kinds = st.tuples(
    st.integers(1, 5), st.integers(1, 3), st.integers(4, 20), st.booleans(), st.floats(0, 5), st.floats(0, 5)
)


@given(st.lists(kinds, min_size=0, max_size=4), st.integers(3, 60), st.integers(1, 25))
def test_stability_expansion_is_that_of_listed_pseudocycles(rows, cut, degree):
    """Costs are odd multiples of 1/8 in the cut's unit, so that sums are exact and none is the cut."""
    period, count, cost, negative, one, two = np.array(rows, float).reshape(-1, 6).T
    factors = Factors(
        period.astype(int),
        count.astype(int),
        cost / 4,
        np.where(negative == 1, -1, 1) * np.exp(-cost / 4),
        np.stack([one, two]),
    )
    found = expand_by_stability(factors, cut / 4 + 0.125, degree)
    expected = listed(factors, cut / 4 + 0.125, degree)
    sums = np.concatenate([found.coefficients[None], found.slopes])
    size = sums.shape[1]
    np.testing.assert_allclose(sums, expected[:, :size], rtol=1e-12, atol=1e-12)
    assert not expected[:, size:].any()
    free = expand_by_stability(factors, cut / 4 + 0.125)
    np.testing.assert_allclose(free.coefficients[:size], found.coefficients, rtol=1e-12, atol=1e-12)


def test_small_chunks_change_nothing(monkeypatch):
    rng = np.random.default_rng(5)
    n = 60
    cost = rng.uniform(1, 8, n)
    factors = Factors(
        rng.integers(2, 9, n), rng.integers(1, 9, n), cost, np.exp(-cost), np.stack([cost, 2 * cost])
    )
    whole = expand_by_stability(factors, 7.0)
    monkeypatch.setattr("orbitdb.averages.pseudocycles.CHUNK", 40)
    done: list[float] = []
    parts = expand_by_stability(factors, 7.0, progress=done.append)
    assert len(done) > 5
    assert done == sorted(done)
    assert done[-1] == pytest.approx(1)
    scale = np.abs(whole.coefficients).max()
    np.testing.assert_allclose(parts.coefficients, whole.coefficients, atol=1e-12 * scale)
    np.testing.assert_allclose(parts.slopes, whole.slopes, atol=1e-10 * scale)
