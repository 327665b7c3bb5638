"""Averages by sum rules: tilted weights, sums over orbits, and known values."""

import numpy as np
import pytest
from contents import answer
from quick import slow_but
from solutions import sum_rules_to, tilted
from there import there

from orbitdb.answers.complete_periods import read_complete_periods, sum_rules_of
from orbitdb.averages.exact_means import exact_means
from orbitdb.averages.tilting import TiltedOrbits, tilt
from orbitdb.billiard.stadium import Stadium
from orbitdb.selection import Selection

HIGHEST = 9
TRAJECTORIES = {0.5: 1.85931011, 1.0: 2.40989931, 1.6: 2.81181711, 3.0: 3.37908170, 6.0: 4.03309448}
"""lambda per leg from trajectories of 10^8 bounces, followed leg by leg, with errors below 5e-6."""


def terms_of(a, highest):
    """Return legs, remainder, and the sums of ln D, ln K and c2 for each orbit up to the highest period."""
    orbits = TiltedOrbits.joined(orbits for _, orbits in tilted(a, highest))
    means = np.array([[mean.value] for mean in exact_means(a).terms])
    return orbits.legs, orbits.rest, *(orbits.x + means * orbits.legs)


def test_a_tilt_makes_the_means_vanish_with_positive_weights():
    rng = np.random.default_rng(0)
    x, weights = rng.normal(0.5, 1, (3, 400)), rng.normal(0, 2, 400)
    mu, tilted = there(tilt(weights, x))
    assert tilted.min() > 0
    assert tilted.sum() == pytest.approx(1)
    np.testing.assert_allclose(x @ tilted, 0, atol=1e-8)
    factors = np.log(tilted) - weights - mu @ x
    np.testing.assert_allclose(factors, factors[0])


@pytest.mark.parametrize(
    "x",
    [[[1.0, 2.0, 0.5]], [[1.0, -1.0, 2.0, -2.0], [1.0, 3.0, 0.0, 2.0]], [[1.0, -1.0], [1.0, -1.0]]],
    ids=["on one side", "on one side of a line", "on a line"],
)
def test_there_is_no_tilt_for_points_on_one_side_or_on_a_line(x):
    assert tilt(np.zeros(len(x[0])), np.array(x)) is None


def test_the_sums_of_the_shortest_orbit_are_known():
    """The word 13 lies on the axis: K = 2, D = 2 a, and 2 cosh(lambda) = tr M = 4 (1 + 2 a)^2 - 2."""
    a = 0.8
    legs, rest, drift, kick, coupling = (term[0] for term in terms_of(a, 2))
    assert legs == 2
    assert drift == pytest.approx(2 * np.log(2 * a))
    assert kick == pytest.approx(2 * np.log(2))
    assert coupling == pytest.approx(2 * np.log1p(1 / (2 * a)))
    exponent = np.arccosh((4 * (1 + 2 * a) ** 2 - 2) / 2)
    assert rest == pytest.approx(exponent - drift - kick - coupling)


@pytest.mark.parametrize("a", [0.5, 6.0])
def test_every_orbit_is_within_the_bounds(a):
    _, rest, _, _, coupling = terms_of(a, HIGHEST)
    assert (-coupling < rest).all()
    assert (rest < 0).all()


@pytest.mark.parametrize("a", slow_but([0.5, 1.6, 6.0], TRAJECTORIES))
def test_values_agree_with_trajectories_within_their_errors(a):
    found = sum_rules_to(a, HIGHEST)
    assert found.p.tolist() == list(range(2, HIGHEST + 1))
    assert (np.abs(found.lambda_l - TRAJECTORIES[a]) < found.lambda_l_error).all()
    assert abs(found.lambda_l[-1] / TRAJECTORIES[a] - 1) < 2e-4
    assert found.level[-1] == (1 if a > 3 else 3)
    means = exact_means(a)
    rest, below = (part - means.growth.value for part in (found.lambda_l, found.lambda_l_below))
    change, width = np.abs(rest - below)[-4:].max(), np.ptp(rest[-5:])
    said = (3 * width + 3 * change if a > 3 else 2 * width) + 0.03 * np.abs(rest[-1]) + means.growth.error
    assert found.lambda_l_error[-1] == pytest.approx(min(said, np.diff(means.bounds)[0]), rel=1e-9)
    np.testing.assert_allclose(found.lambda_d_sum_rule * (a + np.pi / 2), found.lambda_l)
    for name in ("sum_rule", "sum_rule_error"):
        ratio = getattr(found, f"lambda_d_{name}") / getattr(found, f"lambda_c_{name}")
        np.testing.assert_allclose(ratio, Stadium(a).mean_free_path)


@pytest.mark.slow
def test_the_error_estimate_is_useful_at_small_a():
    found = sum_rules_to(0.1, HIGHEST)
    assert abs(found.lambda_l[-1] - 0.89199) < found.lambda_l_error[-1] < 0.03  # trajectories +- 0.00015


def test_a_catalogue_gives_the_sum_rules_of_its_orbits(filled):
    found = there(
        sum_rules_of(answer(filled, read_complete_periods, Selection.from_criteria(status="orbit")))
    )
    alone = sum_rules_to(1.6, HIGHEST - 1)
    np.testing.assert_allclose(found.lambda_d_sum_rule, alone.lambda_d_sum_rule, rtol=1e-9)


@pytest.mark.parametrize(
    "criteria", [{"p": "3-6"}, {"time_reversal": "self"}, {"p": "2-6", "status": "boundary"}]
)
def test_a_subset_of_the_orbits_has_no_sum_rules(filled, criteria):
    chosen = Selection.from_criteria(**{"status": "orbit"} | criteria)
    assert sum_rules_of(answer(filled, read_complete_periods, chosen)) is None
