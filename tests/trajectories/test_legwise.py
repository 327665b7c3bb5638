"""Trajectories leg by leg: the map compared with single bounces, the averages with tangent vectors."""

import numpy as np
import pytest
from quick import slow_but

from orbitdb.averages.exact_means import exact_means
from orbitdb.averages.simulation import simulate
from orbitdb.billiard.stadium import Stadium
from orbitdb.trajectories.ensemble import Arcs, advance, random_arcs
from orbitdb.trajectories.legwise import Beams, Runs, follow_runs, next_leg, random_runs, simulate_legs


def run_of(arcs):
    """Return the runs that start with the given bounces, reconstructed from their incoming paths."""
    out = arcs.vx * arcs.x + arcs.vy * arcs.y
    vx, vy = arcs.vx - 2 * out * arcs.x, arcs.vy - 2 * out * arcs.y
    impact = arcs.x * vy - arcs.y * vx
    up = arcs.side * np.sign(impact)
    return Runs(np.arccos(np.abs(impact)), np.arctan2(up * vy, arcs.side * vx))


@pytest.mark.parametrize("a", slow_but([0.1], [0.1, 1.6, 7.0]))
def test_the_leg_map_agrees_with_single_bounces(a):
    arcs = random_arcs(500, np.random.default_rng(2))
    for one in range(500):
        here = Arcs(*(each[[one]] for each in arcs))
        hit = advance(here, a)
        if hit.arcs.side == here.side:
            continue
        leg = next_leg(run_of(hit.arcs), a)
        bounces, here = 1, hit.arcs
        while (hit := advance(here, a)).arcs.side == here.side:
            bounces, here = bounces + 1, hit.arcs
        after = run_of(hit.arcs)
        assert (bounces, hit.walls[0]) == (leg.bounces[0], leg.walls[0])
        assert after.t[0] == pytest.approx(leg.runs.t[0], abs=1e-9)
        assert after.beta[0] == pytest.approx(leg.runs.beta[0], abs=1e-9)


def test_the_terms_of_a_leg_are_the_growth_of_its_matrices():
    """The beam is followed with a known convergence b, and with the range of all possible b."""
    a, rng = 0.9, np.random.default_rng(6)
    first = next_leg(random_runs(300, rng), a)
    y, slope = np.ones(300), rng.random(300) / first.drift
    runs, beams = first.runs, Beams(first.drift, slope, slope)
    wide = Beams(first.drift, np.zeros(300), 1 / first.drift)
    for _ in range(3):
        leg = next_leg(runs, a)
        coupling = np.log1p((1 / leg.drift + 1 / beams.drift) / leg.kick)
        _, wide, between = follow_runs(runs, wide, a)
        runs, beams, terms = follow_runs(runs, beams, a)
        slope = slope + leg.kick * y
        after = y + leg.drift * slope
        rest = np.log(after / y) - np.log(leg.drift) - np.log(leg.kick) - coupling
        y = after
        assert terms[0] == pytest.approx(rest, abs=1e-12)
        assert not terms[1].any()
        assert (np.abs(between[0] - rest) <= between[1] / 2 + 1e-12).all()
        assert (terms[2:] == [leg.path - 2 * leg.walls, leg.bounces + leg.walls]).all()
        assert (beams.drift == leg.drift).all()
        assert beams.low == pytest.approx(slope / y, rel=1e-12)
        assert ((wide.low <= beams.low) & (beams.high <= wide.high)).all()


def test_the_errors_of_exact_means_and_sample_are_combined():
    plain, wrong = (simulate_legs(Stadium(1.6), 100, (2.8, error)) for error in (0.0, 0.01))
    known = 0.01 / (1.6 + np.pi / 2)
    assert wrong.lambda_d_error == pytest.approx(np.hypot(plain.lambda_d_error, known), rel=1e-6)


@pytest.mark.parametrize(
    ("a", "lambda_l"), slow_but(1, [(1.6, 2.81181711), (0.5, 1.85931011), (6.0, 4.03309448)])
)
def test_averages_agree_with_a_hundred_times_as_many_bounces(a, lambda_l):
    found = simulate_legs(Stadium(a), 1_000_000, exact_means(a).growth, seed=8)
    assert abs(found.lambda_d * (a + np.pi / 2) - lambda_l) < 4 * found.lambda_d_error * (a + np.pi / 2)
    assert found.lambda_d_error < 3e-5
    assert found.lambda_c == pytest.approx(found.lambda_d / Stadium(a).mean_free_path)
    assert abs(found.mean_free_path - Stadium(a).mean_free_path) < 4 * found.mean_free_path_error
    assert found.bounces == pytest.approx(1_000_000, rel=0.1)


@pytest.mark.parametrize("a", [1.0, pytest.param(0.005, marks=pytest.mark.slow)])
def test_legwise_averages_agree_with_tangent_vectors(a):
    legwise = simulate_legs(Stadium(a), 300_000, exact_means(a).growth)
    plain = simulate(Stadium(a), 1_000_000)
    assert abs(legwise.lambda_d - plain.lambda_d) < 4 * np.hypot(plain.lambda_d_error, legwise.lambda_d_error)
    assert legwise.lambda_d_error < plain.lambda_d * 0.01


def test_the_seed_fixes_the_result_and_bad_numbers_are_refused():
    seen = []
    one = simulate_legs(Stadium(1.6), 1000, (2.8, 0.0), 3, progress=lambda done, found: seen.append(done))
    assert one == simulate_legs(Stadium(1.6), 1000, (2.8, 0.0), 3)
    assert seen[-1] == 1
    assert one != simulate_legs(Stadium(1.6), 1000, (2.8, 0.0), 4)
    assert simulate_legs(Stadium(1.6), 1, (2.8, 0.0)).bounces > 0
    with pytest.raises(ValueError, match="0 bounces: give 1 or more"):
        simulate_legs(Stadium(1.6), 0, (2.8, 0.0))
