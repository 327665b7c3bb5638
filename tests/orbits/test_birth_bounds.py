"""The bounds of births where these are found badly: the bracket that is proved must hold the true a."""

from dataclasses import replace

import numpy as np
import pytest
from quick import slow_but
from solutions import representatives

from orbitdb.orbits.births import brackets
from orbitdb.orbits.births import changes as births
from orbitdb.orbits.births.changes import find_changes


@pytest.mark.parametrize("shift", slow_but([5e-12], [5e-12, -3e-12]))
def test_the_bracket_of_a_birth_that_is_off_reaches_it_and_not_much_farther(shift, monkeypatch):
    words = representatives(5)
    exact = find_changes(words)
    refine = births.refine

    def badly(legs, guessed):
        found = refine(legs, guessed)
        return replace(found, x=found.x + shift)

    monkeypatch.setattr(brackets, "_POLISH", 0.0)
    monkeypatch.setattr(births, "refine", badly)
    found = find_changes(words)
    off = np.abs(found.a - exact.a)
    assert (np.abs(off - abs(shift) * exact.a) < 0.01 * off).all()
    assert (off <= found.error).all()
    assert (found.error < 1.3 * off).all()
