"""Averages that do not stand are blank: missing periods, no zero, a spurious one."""

import math

import numpy as np
import pytest
from quick import slow_but
from solutions import class_rows, entropy, lyapunov

from orbitdb import Catalogue, Selection
from orbitdb.averages.by_period import faults_of, standing
from orbitdb.averages.fixed_points import Weight
from orbitdb.averages.pseudocycles import lyapunov_by_stability
from orbitdb.catalogue.whole_periods import why_missing
from orbitdb.cli.tui.statistics.averages import statistics

HIGHEST = 9
ZETA = ("lambda_d_zeta", "lambda_c_zeta", "mean_path_zeta", "z0")
GRID = [1e-6, 1e-3, 0.1, 0.3, 0.5, 1.6, 10.0, 1e3]


@pytest.mark.parametrize("weight", Weight)
@pytest.mark.parametrize("a", slow_but([0.3, 1.6], GRID))
def test_an_average_is_between_the_least_and_the_greatest_of_its_orbits_or_blank(a, weight):
    rows = class_rows(a, HIGHEST)
    found = lyapunov(rows, HIGHEST, weight)
    for i, p in enumerate(found.p.tolist()):
        part = rows.rows(rows.period <= p)
        known = [math.isfinite(getattr(found, name)[i]) for name in ZETA]
        assert known == [not found.faults[i]] * 4
        if known[0]:
            for name, values in (
                ("lambda_d_zeta", part.lyapunov / part.period),
                ("lambda_c_zeta", part.lyapunov / part.length),
                ("mean_path_zeta", part.length / part.period),
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


def test_every_kind_of_fault_is_told():
    small = class_rows(1e-6, HIGHEST)
    said = faults_of(lyapunov(small, HIGHEST, Weight.DETERMINANT), range(2, HIGHEST + 1))
    assert "at p = 6 (its zero 0.002432 is spurious: lambda_d = -0.0002322, of orbits 2e-06 to" in said
    assert "at p = 8 (it has no real zero)" in said
    assert "at p = 9 (its zero 1.342 is spurious: the series ends there in 4.51e+21" in said
    assert "8, 9 (it has no real zero)" in faults_of(entropy(small, HIGHEST), range(2, HIGHEST + 1))
    assert faults_of(lyapunov(small, HIGHEST), [2, 3, 9]) == ""


def test_a_cut_by_stability_that_gives_no_average_says_why():
    rows = class_rows(1e-6, 8)
    for found, reason in (
        (lyapunov_by_stability(rows, 2.0, 8), "(its zero"),
        (lyapunov_by_stability(rows, 1e-7, 8), "(no orbit has a lambda up to 1e-07)"),
    ):
        assert found.fault.startswith(reason)
        assert np.isnan([found.lambda_d, found.lambda_c, found.mean_path, found.z0]).all()
    for weight in Weight:
        assert lyapunov_by_stability(class_rows(1.6, HIGHEST), 9.0, HIGHEST, weight).fault == ""


def test_each_average_needs_its_own_periods():
    rows = class_rows(1.6, 6)
    shown = standing(lyapunov(rows, 6), [3, 5, 6]) | standing(entropy(rows, 6), [3, 5, 6])
    there = {name: [p for p, value in zip(shown["p"], values, strict=True) if value is not None]
             for name, values in shown.items()}  # fmt: skip
    assert there["lambda_d"] == there["N"] == there["K_0"] == [3, 5]
    assert there["lambda_d_pair"] == there["lambda_d_zeta"] == there["z0"] == there["h_zeta"] == []
    shown = standing(lyapunov(rows, 6), [2, 3, 4, 6])
    assert [value is not None for value in shown["lambda_c_pair"]] == [False, True, True, False, False]
    assert [value is not None for value in shown["lambda_c_zeta"]] == [True, True, True, False, False]


def test_a_period_is_missing_as_it_is_not_chosen_or_not_filled_or_unborn():
    chosen = Selection(periods=((5, 9),))
    said = why_missing([2, 3, 6, 7], chosen, [7])
    assert said == "2, 3 (not chosen); 6 (not filled); 7 (births not found, left out)"
    assert why_missing([], chosen) == ""


@pytest.mark.slow
def test_a_chosen_period_says_nothing_of_the_file(varied):
    found = statistics(Catalogue(varied), Selection(periods=((6, 6),)))
    assert "the zeta function lacks p = 2, 3, 4, 5 (not chosen)" in found.notes
    assert found.facts[0].startswith("entropy of all orbits: 1.15549571 < h < 1.16257011")
