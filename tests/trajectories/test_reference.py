"""The trajectory reference: errors that hold, and as many bounces as are asked for."""

import math
from functools import cache, partial

import numpy as np
import pytest
from quick import slow_but

from orbitdb import Stadium
from orbitdb.trajectories.ensemble import LEAST, TRAJECTORIES, simulate
from orbitdb.trajectories.legwise import simulate_legs

SEEDS = 60


@cache
def found_by_seeds(a):
    return [simulate(Stadium(a), 40_000, seed, trajectories=1024) for seed in range(SEEDS)]


@pytest.mark.slow
@pytest.mark.parametrize("a", [0.3, 1.6, 5.0])
def test_the_mean_free_path_is_off_by_as_much_as_its_error_says(a):
    """Over many seeds; a plain ratio of sums is off by up to seven errors, mostly to one side."""
    stadium = Stadium(a)
    found = found_by_seeds(a)
    off = np.array(
        [(one.mean_free_path - stadium.mean_free_path) / one.mean_free_path_error for one in found]
    )
    assert 0.75 < math.sqrt((off**2).mean()) < 1.35
    assert abs(off.mean()) < 0.45
    assert np.abs(off).max() < 4.5


@pytest.mark.parametrize("a", slow_but([1.6], [0.3, 1.6, 5.0]))
def test_exponents_scatter_by_as_much_as_their_errors_say(a):
    found = found_by_seeds(a)
    for name in ("lambda_d", "lambda_c"):
        values = np.array([getattr(one, name) for one in found])
        off = (values - values.mean()) / [getattr(one, f"{name}_error") for one in found]
        assert 0.75 < math.sqrt((off**2).mean()) < 1.35
        assert np.abs(off).max() < 4.5


@pytest.mark.parametrize(
    ("a", "bounces", "seed", "trajectories"),
    [
        (30.0, 400_000, 55, 1024),
        (1.6, 60_000, 158, 1024),
        pytest.param(1.6, 20_000_000, 20, TRAJECTORIES, marks=pytest.mark.slow),
    ],
)
def test_seeds_that_lack_long_legs(a, bounces, seed, trajectories):
    """The plain ratio of their sums is 4.1, 4.1 and 5.8 of its own errors too high."""
    found = simulate(Stadium(a), bounces, seed, trajectories)
    assert abs(found.mean_free_path - Stadium(a).mean_free_path) < 3 * found.mean_free_path_error


@pytest.mark.parametrize("a", [0.1, 1.6])
@pytest.mark.parametrize("bounces", [1000, 9000, 50_000])
def test_as_many_bounces_are_made_as_are_asked_for(a, bounces):
    made = [simulate(Stadium(a), bounces, seed).bounces for seed in range(5)]
    assert np.median(made) == pytest.approx(bounces, rel=0.2)


@pytest.mark.parametrize("legwise", [False, True])
@pytest.mark.parametrize(("a", "bounces"), [(0.05, 3000), (0.3, 1), (1.6, 20_000)])
def test_errors_of_short_runs_are_known_well_themselves(a, bounces, legwise):
    """From the spread of 16 or 32 groups an error is known to a sixth or an eighth of itself, no better."""
    run = partial(simulate_legs, known=(2.0, 0.0)) if legwise else simulate
    found = [run(Stadium(a), bounces, seed=seed) for seed in range(40)]
    errors = np.array([one.mean_free_path_error for one in found])
    assert errors.std() < 0.08 * errors.mean()
    assert min(one.groups for one in found) >= LEAST


def test_many_bounces_are_made_by_the_usual_number_of_trajectories():
    assert simulate(Stadium(), 8268, 3) == simulate(Stadium(), 8268, 3, TRAJECTORIES)


@pytest.mark.parametrize("legwise", [False, True])
def test_errors_are_in_the_units_of_their_values(legwise):
    """Exact means turn a growth per step into both exponents: value and error by the same factor."""
    stadium = Stadium(0.7)
    found = simulate_legs(stadium, 20_000, (2.0, 0.0)) if legwise else simulate(stadium, 20_000)
    for each in (found.lambda_d / found.lambda_c, found.lambda_d_error / found.lambda_c_error):
        assert each == pytest.approx(stadium.mean_free_path, rel=1e-12)
