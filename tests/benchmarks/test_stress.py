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
)
from orbitdb.billiard.stadium import Stadium
from orbitdb.orbits.newton import solve
from orbitdb.orbits.orbit import Orbits, Status
from orbitdb.symbols.least_words import representatives


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


@pytest.mark.slow
def test_orbits_with_exponents_beyond_the_range_of_doubles():
    (outcome,) = long_orbits((1000,), 2)
    assert outcome.passed
    assert outcome.orbits == 2
    assert outcome.coordinates < 1e-14
    assert outcome.lyapunov < 1e-13
    assert solve(closed_words(Stadium(), 1000, 2), Stadium()).lyapunov.min() > 709


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
