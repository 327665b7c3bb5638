"""Stress cases, smaller than in a full run: every error below its stored bound."""

import dataclasses

import numpy as np
import pytest

from orbitdb.benchmarks.stress import (
    closed_words,
    compare,
    extreme_stadia,
    joint_words,
    long_legs,
    long_orbits,
    long_runs,
    parsed,
    small_margins,
    weighted_sums,
)
from orbitdb.billiard.stadium import Stadium
from orbitdb.orbits.newton import solve
from orbitdb.orbits.orbit import Orbits, Status
from orbitdb.symbols.least_words import representatives
from orbitdb.symbols.pruning import rules_broken


@pytest.mark.slow
def test_stadia_from_a_circle_to_a_channel():
    outcomes = list(extreme_stadia(p=6))
    assert len(outcomes) == 13
    assert all(outcome.passed for outcome in outcomes)
    assert all(outcome.length < 1e-15 for outcome in outcomes)
    assert outcomes[-1].orbits == outcomes[-1].words


def test_words_through_a_joint_are_decided():
    assert all(outcome.passed for outcome in joint_words((6,)))


@pytest.mark.parametrize("case", [long_runs, long_legs])
def test_runs_and_legs_of_many_bounces(case):
    outcomes = list(case(10_000))
    assert len(outcomes) == 4
    for outcome in outcomes:
        assert outcome.passed
        assert outcome.orbits == 1
        assert outcome.coordinates < 1e-14
        assert outcome.length < 1e-13
        assert outcome.lyapunov < 1e-13


@pytest.mark.parametrize("k", [10, 1000, 100_000])
def test_a_long_run_is_half_a_polygon(k):
    """1^k 5^k runs along two half 2k-gons and two horizontal legs."""
    stadium = Stadium()
    found = solve(parsed(f"1^{k} 5^{k}"), stadium)
    assert found.status[0] == Status.ORBIT
    assert found.length[0] == pytest.approx(4 * stadium.a + 4 * k * np.sin(np.pi / (2 * k)), rel=1e-15)
    assert found.margin[0] == pytest.approx(np.pi / (2 * k), rel=1e-9)


@pytest.mark.slow
def test_words_of_random_trajectories_are_orbits_of_high_order():
    stadium = Stadium()
    words = closed_words(stadium, 200, 10)
    assert words.shape == (10, 200)
    assert not rules_broken(words).any()
    found = solve(words, stadium)
    assert (found.status == Status.ORBIT).all()
    assert (found.lyapunov / 200).mean() == pytest.approx(0.887, abs=0.1)


@pytest.mark.slow
def test_orbits_with_exponents_beyond_the_range_of_doubles():
    (outcome,) = long_orbits((1000,), 2)
    assert outcome.passed
    assert outcome.orbits == 2
    assert outcome.coordinates < 1e-14
    assert outcome.lyapunov < 1e-13
    assert solve(closed_words(Stadium(), 1000, 2), Stadium()).lyapunov.min() > 709


def test_orbits_that_almost_touch_a_joint():
    (outcome,) = small_margins((11,))
    assert outcome.words >= 4
    assert 0 < outcome.orbits < outcome.words
    assert outcome.passed


@pytest.mark.slow
def test_sums_of_weights_far_apart():
    (outcome,) = weighted_sums(1_000_000)
    assert outcome.passed
    assert outcome.length < 1e-15


def test_a_wrong_row_does_not_pass():
    words, _ = representatives(5)
    orbits = solve(words, Stadium())
    lengths = orbits.length.copy()
    lengths[3] *= 1 + 1e-12
    altered: Orbits = dataclasses.replace(orbits, length=lengths)
    assert compare("x", "honest", orbits, Stadium(), 0.0).passed
    assert not compare("x", "altered", altered, Stadium(), 0.0).passed
    swapped = np.where(orbits.status == Status.ORBIT, Status.DYNAMICAL.value, orbits.status)
    assert compare("x", "status", dataclasses.replace(orbits, status=swapped), Stadium(), 0.0).wrong > 0
