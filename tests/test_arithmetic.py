"""What error bounds assume about NumPy's functions is checked before the first bound is computed."""

import mpmath as mp
import numpy as np
import pytest

from orbitdb.billiard import arithmetic
from orbitdb.billiard.arithmetic import RoundingError, check_functions
from orbitdb.billiard.stadium import Stadium
from orbitdb.orbits.solve import solve
from orbitdb.symbols.words import from_strings

EXACT = {"sin": mp.sin, "cos": mp.cos, "arctan": mp.atan, "log": mp.log, "arcsinh": mp.asinh, "tanh": mp.tanh}


@pytest.fixture(autouse=True)
def unchecked():
    check_functions.cache_clear()
    yield
    check_functions.cache_clear()


def test_the_table_of_hard_arguments_is_rounded_correctly():
    for name, (arguments, results) in arithmetic.HARD.items():
        with mp.workdps(60):
            assert [float(EXACT[name](mp.mpf(x))) for x in arguments] == list(results), name


@pytest.mark.parametrize("name", arithmetic.UNITS)
def test_an_inaccurate_function_is_refused_in_one_line(name, monkeypatch):
    """A function is off by two more units than assumed, at a single argument; then no orbit is solved."""
    right = getattr(np, name)

    def careless(x, *args, **kwargs):
        y = right(x, *args, **kwargs)
        wrong = x == arithmetic.HARD[name][0][-1]
        return np.where(wrong, y + (arithmetic.UNITS[name] + 2) * np.spacing(y), y)

    monkeypatch.setattr(np, name, careless)
    with pytest.raises(RoundingError, match=f"NumPy's {name} is off by .* install another") as caught:
        solve(from_strings(["13"]), Stadium())
    assert "\n" not in str(caught.value)


def test_the_functions_of_this_numpy_are_as_accurate_as_assumed():
    """They are tried at random arguments in the ranges used, including arguments close to pi/2."""
    rng = np.random.default_rng(2)
    near = np.pi / 2 - 10.0 ** rng.uniform(-13, 0, 500)
    ranges = {
        "sin": np.concatenate([rng.uniform(-np.pi, np.pi, 500), near]),
        "cos": np.concatenate([rng.uniform(-np.pi, np.pi, 500), near]),
        "arctan": 10.0 ** rng.uniform(-7, 13, 500),
        "log": 10.0 ** rng.uniform(-3, 121, 500),
        "arcsinh": 10.0 ** rng.uniform(-6, 61, 500),
        "tanh": 10.0 ** rng.uniform(-6, 3, 500),
    }
    for name, arguments in ranges.items():
        found = getattr(np, name)(arguments)
        for x, y in zip(arguments.tolist(), found.tolist(), strict=True):
            with mp.workdps(40):
                off = abs(EXACT[name](mp.mpf(x)) - mp.mpf(y)) / mp.mpf(float(np.spacing(abs(y))))
            assert off <= arithmetic.UNITS[name], (name, x)
