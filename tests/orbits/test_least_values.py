"""Bounds on what orbits of many bounces have at least, against orbits: all of some periods, and long ones."""

import numpy as np
import pytest
from quick import slow_but
from solutions import words_of

from orbitdb import Stadium
from orbitdb.orbits.least_values import least_exponent, least_length
from orbitdb.orbits.newton import solve


@pytest.mark.parametrize("a", slow_but([0.05, 1.6], [1e-3, 0.05, 0.3, 1.0, 1.6, 3.0, 12.0, 1e4]))
def test_no_orbit_of_more_bounces_is_below(a):
    least = []
    for p in range(3, 9):
        orbits = solve(words_of(p), Stadium(a))
        real = orbits.status == "orbit"
        least.append((orbits.lyapunov[real].min(), orbits.length[real].min()))
    for p, (exponent, length) in enumerate(np.minimum.accumulate(least[::-1])[::-1], 2):
        assert 0 < least_exponent(p, a) < exponent
        assert 0 < least_length(p, a) < length


def test_they_are_of_use():
    """Within a twelfth of what there is at a = 1.6: 6.075 at p = 12, and 12.35 at p = 9."""
    assert least_exponent(11, 1.6) > 5.57
    assert least_length(8, 1.6) > 11.25
