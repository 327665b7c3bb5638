"""Exponents alone: the orbits, their lengths and lambda are those of the full solution."""

import numpy as np
import pytest
from solutions import representatives

from orbitdb.billiard.legs import cut, direction_limits
from orbitdb.billiard.stadium import Stadium
from orbitdb.orbits.newton import solve
from orbitdb.orbits.status import decide
from orbitdb.orbits.sums import exponents
from orbitdb.symbols.words import pack

A = [1.0, 1.6, pytest.param(0.05, marks=pytest.mark.slow), pytest.param(20.0, marks=pytest.mark.slow)]


@pytest.mark.parametrize("a", A)
def test_they_are_those_of_the_full_solution(a):
    for p in (2, 6, 8):
        words = representatives(p)
        orbits, stadium = solve(words, a), Stadium(a)
        found = list(exponents(pack(words), p, stadium))
        for name, status in (("orbits", "orbit"), ("boundary", "boundary"), ("unresolved", "unresolved")):
            places = np.concatenate([getattr(part, name) for part in found])
            assert sorted(places) == np.flatnonzero(orbits.status == status).tolist()
        for part in found:
            np.testing.assert_allclose(part.length, orbits.length[part.orbits], rtol=1e-14)
            np.testing.assert_allclose(part.lyapunov, orbits.lyapunov[part.orbits], rtol=1e-13)


@pytest.mark.parametrize("a", A)
def test_no_orbit_is_outside_wherever_the_directions_are(a):
    rng, told = np.random.default_rng(7), 0
    words = representatives(7)
    status = solve(words, a).status
    for rows, legs in cut(words):
        low, high = direction_limits(legs, a)
        for share in (0.0, 0.5, 1.0, *rng.random((20, *low.shape))):
            alpha = low + share * (high - low)
            outside = decide(legs, a, alpha).status == "dynamical"
            assert (status[rows][outside] == "dynamical").all()
            told += outside.sum()
    assert told or a == 20.0
