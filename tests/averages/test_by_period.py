"""Averages compared with sums over all symbol sequences, with independent formulas, and with the paper."""

import itertools
import math
from dataclasses import fields, replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from quick import slow_but
from same import same
from scipy.optimize import brentq
from solutions import class_rows, entropy, lyapunov, words_of

from orbitdb.averages.by_period import (
    PeriodSums,
    Weight,
    divisors,
    every_period,
    lyapunov_of_periods,
    of_divisors,
    of_pairs,
)
from orbitdb.averages.pseudocycles import lyapunov_by_stability
from orbitdb.billiard.stability import Links, bounce_matrices
from orbitdb.billiard.stadium import Stadium
from orbitdb.orbits.exponents import OrbitClasses
from orbitdb.orbits.solve import solve
from orbitdb.symbols.pruning import rules_broken
from orbitdb.symbols.words import primitive_root, to_strings

DIRECT = 6


@cache
def every_sequence(a, p):
    """Return length, lambda and |det(1 - M)| of every sequence of p symbols that is a fixed point.

    Each rotation is solved separately. Lengths and matrices, including those of repetitions, are computed
    bounce by bounce as in the paper.
    """
    sequences = np.array(list(itertools.product(range(6), repeat=p)), dtype=np.uint8)
    sequences = sequences[rules_broken(sequences) == 0]
    roots = [len(primitive_root(word)) for word in to_strings(sequences)]
    found = []
    for d in set(roots):
        repeated = sequences[np.array(roots) == d]
        orbits = solve(repeated[:, :d], Stadium(a))
        real = orbits.status == "orbit"
        words, coordinates = repeated[real], np.tile(orbits.coordinates[real], p // d)
        length = Links.of(Stadium(a), words, coordinates).before.sum(axis=1)
        M = np.broadcast_to(np.eye(2), (len(words), 2, 2))
        for factor in np.moveaxis(bounce_matrices(Stadium(a), words, coordinates), 1, 0):
            M = factor @ M
        exponent = np.log(np.abs(np.linalg.eigvals(M)).max(axis=1))
        found.append(np.stack([length, exponent, np.abs(np.linalg.det(np.eye(2) - M))]))
    return np.concatenate(found, axis=1)


def weights_of(weight, exponent, determinant):
    return np.exp(-exponent) if weight is Weight.EXPONENTIAL else 1 / determinant


@pytest.mark.parametrize("a", slow_but([1.6], [1.6, 0.7]))
@pytest.mark.parametrize("weight", Weight)
def test_averages_equal_averages_over_all_sequences(a, weight):
    rows = class_rows(a, DIRECT)
    counts, averages = entropy(rows, DIRECT), lyapunov(rows, DIRECT, weight)
    for i, p in enumerate(range(2, DIRECT + 1)):
        length, exponent, determinant = every_sequence(a, p)
        w = weights_of(weight, exponent, determinant)
        assert counts.N[i] == len(length)
        assert averages.lambda_d[i] == pytest.approx((w * exponent).sum() / w.sum() / p, rel=1e-9)
        assert averages.lambda_c[i] == pytest.approx((w * exponent / length).sum() / w.sum(), rel=1e-9)


@pytest.mark.parametrize("weight", Weight)
def test_zeta_averages_are_derivatives_of_the_growth_rate(weight):
    """The derivative is taken of the zero of exp(-sum T_n z^n / n), with all weights tilted by e^(beta A)."""

    def growth(order, tilt):
        log_zeta = np.zeros(order + 1)
        for p in range(2, order + 1):
            length, exponent, determinant = every_sequence(1.6, p)
            w = weights_of(weight, exponent, determinant)
            log_zeta[p] = -(w * np.exp(tilt[0] * exponent + tilt[1] * length)).sum() / p
        series, power = np.zeros(order + 1), np.eye(1, order + 1)[0]
        for k in range(1, order + 2):
            series += power
            power = np.convolve(power, log_zeta)[: order + 1] / k
        value = np.polynomial.Polynomial(series)
        grid = np.linspace(0, 12, 1201)
        first = np.flatnonzero(value(grid) < 0)[0]
        return -math.log(brentq(value, grid[first - 1], grid[first], xtol=1e-14))

    averages = lyapunov(class_rows(1.6, DIRECT), DIRECT, weight)
    h = 1e-4
    for order in (4, DIRECT):
        slope = [
            (growth(order, step) - growth(order, -step)) / (2 * h)
            for step in (np.array([h, 0]), np.array([0, h]))
        ]
        i = order - 2
        assert averages.z0[i] == pytest.approx(math.exp(-growth(order, np.zeros(2))), rel=1e-10)
        assert averages.lambda_d_zeta[i] == pytest.approx(slope[0], rel=1e-6)
        assert averages.mean_path_zeta[i] == pytest.approx(slope[1], rel=1e-6)
        assert averages.lambda_c_zeta[i] == pytest.approx(slope[0] / slope[1], rel=1e-6)


def test_the_topological_zeta_function_is_the_product_over_all_cyclic_words():
    product = np.eye(1, DIRECT + 1)[0]
    for p in range(2, DIRECT + 1):
        for _ in range((solve(words_of(p), Stadium(1.6)).status == "orbit").sum()):
            shifted = np.concatenate([np.zeros(p), product])[: DIRECT + 1]
            product = product - shifted
    found = entropy(class_rows(1.6, DIRECT), DIRECT)
    for i, order in enumerate(range(2, DIRECT + 1)):
        z0 = math.exp(-found.h_zeta[i])
        terms = product[: order + 1] * z0 ** np.arange(order + 1)
        assert abs(terms.sum()) < 1e-12 * np.abs(terms).sum()
        assert (np.polynomial.Polynomial(product[: order + 1])(np.linspace(0, z0 * 0.999, 500)) > 0).all()


@pytest.mark.parametrize("weight", Weight)
def test_a_stability_cut_that_keeps_everything_equals_truncation_by_period(weight):
    rows = class_rows(1.6, DIRECT)
    by_period, by_stability = lyapunov(rows, DIRECT, weight), lyapunov_by_stability(rows, 40, DIRECT, weight)
    assert by_stability.z0 == pytest.approx(by_period.z0[-1], rel=1e-11)
    assert by_stability.lambda_d == pytest.approx(by_period.lambda_d_zeta[-1], rel=1e-11)
    assert by_stability.lambda_c == pytest.approx(by_period.lambda_c_zeta[-1], rel=1e-11)
    assert by_stability.mean_path == pytest.approx(by_period.mean_path_zeta[-1], rel=1e-11)


@given(st.integers(0, 2**32 - 1), st.sampled_from(list(Weight)))
@settings(max_examples=settings().max_examples // 4)
def test_only_classes_and_their_sizes_matter(seed, weight):
    """Shuffling the rows or splitting classes into single words does not change the averages."""
    rows = class_rows(1.6, 6)
    split = np.repeat(np.arange(len(rows)), rows.words)
    np.random.default_rng(seed).shuffle(split)
    words = rows.rows(split)
    words = OrbitClasses(words.p, np.ones_like(words.words), words.length, words.lyapunov, words.walls)
    for name in ("lambda_d", "lambda_c", "lambda_d_zeta", "lambda_c_zeta", "z0"):
        np.testing.assert_allclose(
            getattr(lyapunov(words, 6, weight), name), getattr(lyapunov(rows, 6, weight), name), rtol=1e-11
        )
    assert list(entropy(words, 6).N) == list(entropy(rows, 6).N)


@pytest.mark.parametrize("weight", Weight)
def test_without_orbits_every_average_is_nan(weight):
    rows = class_rows(1.6, 4).rows(np.zeros(0, int))
    assert np.isnan(lyapunov(rows, 5, weight).lambda_d).all()
    assert np.isnan(lyapunov(rows, 5, weight).lambda_d_zeta).all()
    assert np.isnan(entropy(rows, 5).K_0).all()
    assert np.isnan(entropy(rows, 5).h_zeta).all()
    assert math.isnan(lyapunov_by_stability(rows, 9, weight=weight).lambda_c)


def test_repetitions_are_weighted_by_their_own_matrices():
    """Up to six repetitions are tried, with eigenvalues e^lambda and -e^lambda (odd powers are negative)."""
    lengths, exponents, negative = np.array([3.0, 4.0]), np.array([0.7, 1.1]), np.array([False, True])
    rows = OrbitClasses(np.array([3, 3]), np.array([2, 5]), lengths, exponents, 1 * negative)
    sums = PeriodSums.of(rows, 3).sums
    assert len(sums) >= 6
    for r, of_weights in enumerate(sums, 1):
        multipliers = (np.where(negative, -1, 1) * np.exp(exponents)) ** r
        apart = np.abs((1 - multipliers) * (1 - 1 / multipliers))
        for found, w in zip(of_weights, (rows.words / np.abs(multipliers), rows.words / apart), strict=True):
            values = w, w * r * exponents, w * r * lengths, w * exponents / lengths
            assert found == pytest.approx([each.sum() for each in values], rel=1e-13)


def test_rows_that_are_not_orbits_are_refused():
    good = class_rows(1.6, 3)
    columns: list[Any] = [good.p, good.words, good.length, good.lyapunov, good.walls]
    for place, bad in ((0, 0), (1, 0), (2, -1.0), (2, np.inf), (3, np.nan), (3, 0.0)):
        wrong: list[Any] = [column.copy() for column in columns]
        wrong[place][0] = bad
        with pytest.raises(ValueError, match="need a positive"):
            OrbitClasses(*wrong)
    columns[4] = good.walls[:-1]
    with pytest.raises(ValueError, match="same length"):
        OrbitClasses(*columns)


def test_averages_need_the_periods_of_their_orbits():
    assert of_divisors(12) == {2, 3, 4, 6, 12}
    assert of_divisors(11) == {11}
    assert of_pairs(6) == {2, 3, 5, 6}
    assert every_period(4) == {2, 3, 4}
    assert every_period(0) == of_divisors(1) == set()


@given(st.integers(1, 200))
def test_divisors_of_a_period_are_found(p):
    assert divisors(p) == [d for d in range(1, p + 1) if p / d == p // d]


def parts_of(a: float, p: int, count: int) -> list[PeriodSums]:
    rows = class_rows(a, 7)
    places = np.array_split(np.flatnonzero(rows.p == p), count)
    return [PeriodSums.of(rows.rows(part), p) for part in places]


@pytest.mark.parametrize("weight", Weight)
@pytest.mark.parametrize("a", [0.5, 1.6])
def test_averages_from_sums_equal_averages_from_orbits(a, weight):
    rows = class_rows(a, 7)
    sums = {p: PeriodSums.joined(parts_of(a, p, 3), p) for p in range(2, 8)}
    expected, found = lyapunov(rows, 7, weight), lyapunov_of_periods(sums, 7, weight)
    assert found.faults == expected.faults
    for field in fields(found):
        if field.name != "faults":
            values = getattr(found, field.name), getattr(expected, field.name)
            np.testing.assert_allclose(*values, rtol=1e-12, err_msg=field.name)


def test_impossible_averages_are_reported_even_if_longer_orbits_allow_them():
    """Zeros are spurious at this tiny a, while the orbits of period 7 are made far more unstable."""
    rows = class_rows(1e-6, 7)
    rows = replace(rows, lyapunov=np.where(rows.p == 7, 5, 1) * rows.lyapunov)
    sums = {p: PeriodSums.of(rows.rows(rows.p == p), p) for p in range(2, 8)}
    faults = lyapunov_of_periods(sums, 7, Weight.DETERMINANT).faults
    assert faults == lyapunov(rows, 7, Weight.DETERMINANT).faults
    assert "is outside 2e-06 to 0.8814" in faults[4]


def test_sums_do_not_depend_on_order_and_survive_serialisation():
    parts = parts_of(1.6, 7, 9)
    whole = PeriodSums.joined(parts, 7)
    assert same(PeriodSums.joined(parts[::-1], 7), whole)
    assert same(PeriodSums.from_numbers(7, whole.numbers()), whole)
    none = PeriodSums.joined([], 7)
    assert same(PeriodSums.from_numbers(7, none.numbers()), none)
    for wrong in (whole.numbers()[8:], whole.numbers()[:-8] + b"\xff" * 8):
        with pytest.raises(ValueError, match="sums of period 7"):
            PeriodSums.from_numbers(7, wrong)


def test_pairs_are_the_means_of_two_orders():
    found = lyapunov(class_rows(1.6, 7), 7)
    for name in ("lambda_d", "lambda_c"):
        single = getattr(found, name)
        assert getattr(found, f"{name}_pair")[1:] == pytest.approx((single[1:] + single[:-1]) / 2)
