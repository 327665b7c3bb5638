"""Zeta functions compared with known results and lists of terms, and averages that do not converge."""

import itertools
import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from quick import slow_but
from solutions import class_rows, entropy, lyapunov

from orbitdb import Catalogue, Selection
from orbitdb.answers.complete_periods import Periods
from orbitdb.averages.by_period import Weight, faults_of
from orbitdb.averages.pseudocycles import Factors, expand_by_stability, lyapunov_by_stability
from orbitdb.averages.zeta import cycle_averages, expand, leading_zero

NOTHING = np.zeros((0, 8))


@pytest.mark.parametrize("symbols", [1, 2, 6])
def test_the_zeta_function_of_a_full_shift_is_one_minus_bz(symbols):
    traces = float(symbols) ** np.arange(1.0, 9.0)
    found = expand(traces, NOTHING).coefficients
    np.testing.assert_allclose(found, [1, -symbols, *[0] * 7], atol=1e-9 * symbols**8)
    assert leading_zero(found[:2]) == pytest.approx(1 / symbols, rel=1e-15)


def test_the_leading_zero_is_nan_if_no_zero_is_positive():
    assert math.isnan(leading_zero(np.array([1.0])))
    assert math.isnan(leading_zero(np.array([1.0, 0.0, 1.0])))
    assert math.isnan(leading_zero(np.array([1.0, 2.0, 0.0, 0.0])))
    assert math.isnan(cycle_averages(expand(np.zeros(3), np.zeros((2, 3))))[2][1])


@given(st.lists(st.floats(0.2, 3), min_size=1, max_size=6))
def test_the_leading_zero_is_the_smallest_known_zero(zeros):
    zeros = sorted(set(np.round(zeros, 1)))
    polynomial = np.polynomial.Polynomial([1.0])
    for zero in zeros:
        polynomial *= np.polynomial.Polynomial([1.0, -1 / zero])
    assert leading_zero(np.array(polynomial.coef, float)) == pytest.approx(zeros[0], rel=1e-7)


def test_a_leading_zero_close_to_others_is_more_accurate_than_an_eigenvalue():
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
def test_the_stability_expansion_equals_a_list_of_pseudocycles(rows, cut, degree):
    """Costs are multiples of 1/4 and the cut is not, so that sums are exact and none equals the cut."""
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


def test_small_chunks_change_nothing():
    rng = np.random.default_rng(5)
    n = 60
    cost = rng.uniform(1, 8, n)
    factors = Factors(
        rng.integers(2, 9, n), rng.integers(1, 9, n), cost, np.exp(-cost), np.stack([cost, 2 * cost])
    )
    whole = expand_by_stability(factors, 7.0)
    done: list[float] = []
    parts = expand_by_stability(factors, 7.0, progress=done.append, chunk=40)
    assert len(done) > 5
    assert done == sorted(done)
    assert done[-1] == pytest.approx(1)
    scale = np.abs(whole.coefficients).max()
    np.testing.assert_allclose(parts.coefficients, whole.coefficients, atol=1e-12 * scale)
    np.testing.assert_allclose(parts.slopes, whole.slopes, atol=1e-10 * scale)


HIGHEST = 9
ZETA = ("lambda_d_zeta", "lambda_c_zeta", "mean_path_zeta", "z0")
GRID = [1e-6, 1e-3, 0.1, 0.3, 0.5, 1.6, 10.0, 1e3]


@pytest.mark.parametrize("weight", Weight)
@pytest.mark.parametrize("a", slow_but([0.3, 1.6], GRID))
def test_an_average_is_blank_or_between_the_extremes_of_its_orbits(a, weight):
    rows = class_rows(a, HIGHEST)
    found = lyapunov(rows, HIGHEST, weight)
    for i, p in enumerate(found.p.tolist()):
        part = rows.rows(rows.p <= p)
        known = [math.isfinite(getattr(found, name)[i]) for name in ZETA]
        assert known == [not found.faults[i]] * 4
        if known[0]:
            for name, values in (
                ("lambda_d_zeta", part.lyapunov / part.p),
                ("lambda_c_zeta", part.lyapunov / part.length),
                ("mean_path_zeta", part.length / part.p),
            ):
                assert values.min() * (1 - 1e-9) <= getattr(found, name)[i] <= values.max() * (1 + 1e-9)
    if a >= 0.5:
        assert not any(found.faults)


@pytest.mark.parametrize("a", slow_but([1e-6, 0.3, 1.6], GRID))
def test_a_topological_zeta_function_that_does_not_converge_gives_no_entropy(a):
    found = entropy(class_rows(a, HIGHEST), HIGHEST)
    blank = np.isnan(found.h_zeta)
    assert [bool(fault) for fault in found.faults] == blank.tolist()
    assert (found.h_zeta[~blank] >= -1e-12).all()
    assert not blank[:5].any()


def test_every_kind_of_fault_is_reported():
    small = class_rows(1e-6, HIGHEST)
    said = faults_of(lyapunov(small, HIGHEST, Weight.DETERMINANT), range(2, HIGHEST + 1))
    assert "at p = 6 (its zero 0.002432 is spurious: lambda_d = -0.0002322 is outside 2e-06 to" in said
    assert "at p = 8 (it has no positive zero)" in said
    assert "at p = 9 (its zero 1.342 is spurious: the first term there is 1, but the last is 4.51e+21" in said
    of_entropy = faults_of(entropy(small, HIGHEST), range(2, HIGHEST + 1))
    assert of_entropy.startswith("there is no h_zeta at p = ")
    assert "8, 9 (it has no positive zero)" in of_entropy
    assert faults_of(lyapunov(small, HIGHEST), [2, 3, 9]) == ""


def test_a_stability_cut_without_an_average_says_why():
    rows = class_rows(1e-6, 8)
    for found, reason in (
        (lyapunov_by_stability(rows, 2.0, 8), "(its zero"),
        (lyapunov_by_stability(rows, 1e-7, 8), "(no orbit has a lambda of at most 1e-07)"),
        (lyapunov_by_stability(rows, 2.0, 1), "(no orbit has a lambda of at most 2)"),
    ):
        assert found.fault.startswith(reason)
        assert np.isnan([found.lambda_d, found.lambda_c, found.mean_path, found.z0]).all()
    for weight in Weight:
        assert lyapunov_by_stability(class_rows(1.6, HIGHEST), 9.0, HIGHEST, weight).fault == ""


def test_each_average_needs_its_own_periods(tmp_path):
    catalogue = Catalogue.create(tmp_path / "c.db")
    catalogue.fill("2-6")

    def there(p):
        chosen = catalogue.select(p=p, status="orbit")
        found = [chosen.averages(), chosen.entropy()]
        columns = {name: values for each in found for name, values in each.columns.items()}
        return {name: [p for p, value in zip(columns["p"], values, strict=True) if value is not None]
                for name, values in columns.items()}  # fmt: skip

    shown = there("3,5,6")
    assert shown["lambda_d"] == shown["N"] == shown["K_0"] == [3, 5]
    assert shown["lambda_d_pair"] == shown["lambda_d_zeta"] == shown["z0"] == shown["h_zeta"] == []
    shown = there("2,3,4,6")
    assert shown["lambda_c_pair"] == [3, 4]
    assert shown["lambda_c_zeta"] == [2, 3, 4]
    assert shown["lambda_c"] == [2, 3, 4, 6]


def test_the_reason_for_a_missing_period_is_given():
    chosen = Selection(periods=((5, 9),))
    subset = Periods(chosen, chosen, (5, 8, 9), (7,))
    said = subset.why_missing([2, 3, 6, 7])
    assert said == "2, 3 (not chosen); 6 (not filled); 7 (births not stored, left out)"
    assert subset.why_missing([]) == ""


@pytest.mark.slow
def test_choosing_one_period_does_not_hide_what_the_file_proves(varied):
    found = Catalogue(varied).statistics(p=6)
    assert found["N"] == Catalogue(varied).statistics()["N"][-1:]
    assert found.facts[0].startswith("entropy of all orbits: 1.15549571 < h < 1.16257011")
