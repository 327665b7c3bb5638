"""What the checks of stored orbits let pass: all that the rows' own bounds allow, and little more."""

from dataclasses import replace

import numpy as np
import pytest
from solutions import representatives

from orbitdb.billiard.stability import Links
from orbitdb.billiard.stadium import HALF_PI, STRAIGHT, Stadium
from orbitdb.orbits.newton import solve
from orbitdb.orbits.orbit import Orbits
from orbitdb.verification.invariants import check_consistency

USED = {"margins": 0.99, "reflection": 0.7, "lengths": 0.15, "lambda": 0.05, "Hessian": 0.002}
"""Shares of what is allowed that some of the moved rows come to."""


def moved_by(orbits: Orbits, stadium: Stadium, move: np.ndarray) -> Orbits:
    """Return rows whose bounces are off by what their bounds say, and whose length and lambda are exact."""
    size, nothing = np.abs(move).max(axis=1), np.zeros(len(orbits))
    places = orbits.coordinates + move
    links = Links.of(stadium, orbits.words, places)
    residual = np.abs(links.cos_in - links.cos_out).max(axis=1)
    return replace(
        orbits,
        coordinates=places,
        residual=residual,
        error=size,
        length_error=nothing,
        lyapunov_error=nothing,
    )


@pytest.mark.parametrize(("a", "p"), [(0.3, 7), (6.0, 5)])
@pytest.mark.parametrize("size", [1e-4, 1e-6])
def test_rows_that_need_their_bounds_pass_and_come_near_them(a, p, size):
    stadium = Stadium(a)
    orbits = solve(representatives(p), stadium)
    ends = np.where(STRAIGHT[orbits.words], a, HALF_PI) - np.abs(orbits.coordinates)
    orbits = orbits.rows((orbits.status == "orbit") & (ends.min(axis=1) > 2 * size))
    rng = np.random.default_rng(p)
    largest = dict.fromkeys(USED, 0.0)
    for _ in range(20):
        move = size * rng.choice([-1.0, 1.0], orbits.coordinates.shape)
        for check in check_consistency(moved_by(orbits, stadium, move), stadium):
            assert not check.failures, check
            if check.name in largest:
                largest[check.name] = max(largest[check.name], check.share)
    for name, share in USED.items():
        assert largest[name] > share, (name, largest)
