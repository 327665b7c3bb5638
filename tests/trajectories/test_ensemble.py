"""Random trajectories: the laws of billiards, the invariant measure, and lambda computed in two ways."""

import math
from functools import cache, partial

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from itineraries import is_uniform, random_rays
from quick import slow_but

from orbitdb.averages.exact_means import exact_means
from orbitdb.averages.simulation import simulate
from orbitdb.billiard.stadium import Stadium
from orbitdb.errors import InputError
from orbitdb.trajectories.ensemble import (
    LEAST,
    TRAJECTORIES,
    Arcs,
    Reference,
    TangentVectors,
    advance,
    follow_arcs,
    random_arcs,
    references,
)
from orbitdb.trajectories.legwise import simulate_legs
from orbitdb.trajectories.rays import Rays, bounce

WIDTHS = [1e-6, 1e-3, 0.3, 1.6, 1e3, 1e6]
widths = st.floats(-3, 3).map(lambda power: 10.0**power)
seeds = st.integers(0, 2**32 - 1)


def as_rays(arcs, a):
    return Rays(arcs.x + arcs.side * a, arcs.y, arcs.vx, arcs.vy, arcs.side)


@pytest.mark.parametrize("a", slow_but([0.3], [1e-6, 0.3, 1e6]))
def test_the_measure_of_bounces_on_semicircles_is_invariant(a):
    arcs = random_arcs(10_000, np.random.default_rng(12))
    for _ in range(30):
        arcs = advance(arcs, a).arcs
    sine = arcs.x * arcs.vy - arcs.y * arcs.vx
    assert is_uniform(sine, -1, 1)
    assert is_uniform(np.arctan2(arcs.y, arcs.side * arcs.x), -math.pi / 2, math.pi / 2)
    assert (arcs.side > 0).mean() == pytest.approx(0.5, abs=0.02)


@given(widths, seeds)
@settings(max_examples=settings().max_examples // 2)
def test_steps_between_semicircles_agree_with_single_bounces(a, seed):
    arcs = random_arcs(30, np.random.default_rng(seed))
    step = advance(arcs, a)
    few = step.walls < 200
    rays = Rays(*(each[few] for each in as_rays(arcs, a)))
    path, walls = np.zeros(few.sum()), np.zeros(few.sum())
    going = np.ones(few.sum(), bool)
    while going.any():
        hit = bounce(rays, a)
        rays = Rays(*(np.where(going, new, old) for new, old in zip(hit.rays, rays, strict=True)))
        path += np.where(going, hit.path, 0)
        going &= rays.side == 0
        walls += going
    expected = as_rays(step.arcs, a)
    assert np.array_equal(walls, step.walls[few])
    assert np.array_equal(rays.side, expected.side[few])
    close = {"rtol": 1e-8, "atol": 1e-9 * (1 + a)}
    np.testing.assert_allclose(path, step.path[few], **close)
    np.testing.assert_allclose(rays.x, expected.x[few], **close)
    np.testing.assert_allclose(rays.y, expected.y[few], **close)


@pytest.mark.parametrize("a", slow_but([1e-6, 1e6], WIDTHS))
def test_long_trajectories_stay_finite_and_on_the_boundary(a):
    arcs, beam = random_arcs(500, np.random.default_rng(2)), TangentVectors.begin(np.zeros(500), np.ones(500))
    arcs, beam = follow_arcs(arcs, beam, a, 500)
    np.testing.assert_allclose(arcs.x**2 + arcs.y**2, 1, atol=1e-14)
    np.testing.assert_allclose(arcs.vx**2 + arcs.vy**2, 1, atol=1e-14)
    assert np.all(arcs.side * arcs.x > -1e-12)
    assert np.isfinite(beam.growth).all()
    assert (beam.growth > 0).all()
    rays = random_rays(Stadium(a), 500, np.random.default_rng(2))
    for _ in range(500):
        rays = bounce(rays, a).rays
    assert np.all(np.abs(rays.x) <= (a + 1) * (1 + 1e-14))
    np.testing.assert_allclose(rays.vx**2 + rays.vy**2, 1, atol=1e-13)


def test_a_whispering_gallery_path_keeps_its_angle():
    """A path that starts 1e-9 from the tangent follows the semicircle in equal chords."""
    graze = 1e-9
    arcs = Arcs(*(np.array([v]) for v in (1.0, 1.0, 0.0, -graze, 1.0)))
    angles = []
    for _ in range(300):
        step = advance(arcs, 1.6)
        arcs = step.arcs
        angles.append(math.atan2(arcs.y[0], arcs.x[0]))
        assert step.kick[0] == pytest.approx(2 / graze, rel=1e-6)
        assert step.path[0] == pytest.approx(2 * graze, rel=1e-6)
    np.testing.assert_allclose(np.diff(angles), 2 * graze, rtol=1e-5)


def test_growth_agrees_with_the_product_of_bounce_matrices():
    """The product uses the paper's matrices at bounces that are found independently, one after another.

    The matrices act on (d theta, d y) = (slope, y). Each has a factor -1 that the beam leaves out.
    """
    a, n, steps = 1.6, 300, 5
    start = random_arcs(n, np.random.default_rng(3))
    few = advance(start, a).walls < 50
    _, beam = follow_arcs(start, TangentVectors.begin(np.full(n, 0.6), np.full(n, 0.4)), a, steps)
    rays, vector = as_rays(start, a), np.tile([0.4, 0.6], (n, 1))
    growth, visits = np.zeros(n), np.zeros(n, int)
    for _ in range(200):
        hit = bounce(rays, a).rays
        length = np.hypot(hit.x - rays.x, hit.y - rays.y)
        wall = hit.side == 0
        sine = (hit.x - hit.side * a) * rays.vx + hit.y * rays.vy
        bend = np.where(wall, 0.0, 2 / sine)
        M = np.stack([np.stack([bend * length - 1, bend], 1), np.stack([-length, -np.ones(n)], 1)], 1)
        moved = np.einsum("nij,nj->ni", M, vector)
        size = np.abs(moved).sum(axis=1)
        going = visits < steps
        growth += np.where(going, np.log(size), 0)
        vector = np.where(going[:, None], moved / size[:, None], vector)
        visits += going & ~wall
        rays = hit
    few &= visits == steps
    assert few.mean() > 0.9
    np.testing.assert_allclose(growth[few], beam.growth[few], rtol=1e-5)
    assert np.median(np.abs(growth - beam.growth)[few]) < 1e-10
    along = vector[:, 0] * beam.slope + vector[:, 1] * beam.y
    across = vector[:, 0] * beam.y - vector[:, 1] * beam.slope
    assert np.median(np.abs(across / along)[few]) < 1e-10


@pytest.mark.parametrize("a", slow_but([1e-3], [1e-3, 0.2, 1.0, 1.6, 30.0, 1e3]))
def test_the_mean_free_path_agrees_with_the_invariant_measure(a):
    found = simulate(Stadium(a), 1_000_000, seed=7)
    assert abs(found.mean_free_path - Stadium(a).mean_free_path) < 5 * found.mean_free_path_error
    assert found.mean_free_path_error < 0.05


def test_the_seed_fixes_the_result_and_progress_gives_partial_results():
    parts = list(references(Stadium(1.6), 300_000, seed=3, trajectories=128))
    assert len(parts) > 3
    assert [done for done, _ in parts] == sorted(done for done, _ in parts)
    assert parts[-1][0] == 1
    seen = []
    last = simulate(Stadium(1.6), 300_000, 3, trajectories=128, progress=lambda *now: seen.append(now))
    assert seen == parts
    assert last == parts[-1][1]
    assert last != simulate(Stadium(1.6), 300_000, 4, trajectories=128)
    assert (last.groups, last.seed) == (128, 3)
    assert last.bounces == pytest.approx(300_000, rel=0.1)
    first = parts[0][1]
    assert first.bounces < last.bounces
    assert abs(first.lambda_d - 0.887) < 6 * first.lambda_d_error


@pytest.mark.parametrize(("a", "needed"), [(1e-6, 15_707_974), (0.001, 15_718)])
def test_too_few_bounces_for_an_error_are_refused(a, needed):
    """At a = 1e-4, 60 000 bounces gave errors that were too small by a factor of two."""
    with pytest.raises(InputError, match=f"too few for an error.*give {needed} or more"):
        simulate(a, needed // 2)
    if needed < 1_000_000:
        assert simulate(a, needed).lambda_d_error > 0


@pytest.mark.slow
def test_the_stated_error_holds_from_the_least_number_of_bounces_on():
    expected = simulate(1e-4, 40_000_000, seed=99)
    found = [simulate(1e-4, 160_000, seed=seed) for seed in range(20)]
    off = [(each.lambda_d - expected.lambda_d) / each.lambda_d_error for each in found]
    assert max(map(abs, off)) < 4.5


@pytest.mark.parametrize("wrong", [{"bounces": 0}, {"trajectories": 1}, {"trajectories": 0}])
def test_bad_numbers_of_bounces_and_trajectories_are_refused(wrong):
    with pytest.raises(ValueError, match="two trajectories"):
        simulate(Stadium(1.6), **{"bounces": 1000, **wrong})


def test_a_simulation_leg_by_leg_is_that_of_the_exact_means():
    seen = []
    found = simulate(0.7, 20_000, 3, progress=lambda *now: seen.append(now), legwise=True)
    assert found == simulate_legs(Stadium(0.7), 20_000, exact_means(0.7).growth, 3)
    assert seen[-1] == (1, found)
    with pytest.raises(InputError, match="trajectories does nothing with legwise=True"):
        simulate(0.7, 20_000, trajectories=300, legwise=True)
    with pytest.raises(InputError, match="seed = -1"):
        simulate(0.7, 20_000, -1, legwise=True)


SEEDS = 40


@cache
def found_by_seeds(a):
    return [simulate(Stadium(a), 40_000, seed, trajectories=1024) for seed in range(SEEDS)]


@pytest.mark.slow
@pytest.mark.parametrize("a", [0.3, 1.6, 5.0])
def test_the_stated_error_of_the_mean_free_path_is_realistic(a):
    """Over many seeds, a plain ratio of sums would be off by up to seven errors, mostly in one direction."""
    stadium = Stadium(a)
    found = found_by_seeds(a)
    off = np.array(
        [(one.mean_free_path - stadium.mean_free_path) / one.mean_free_path_error for one in found]
    )
    assert 0.75 < math.sqrt((off**2).mean()) < 1.35
    assert abs(off.mean()) < 0.45
    assert np.abs(off).max() < 4.5


@pytest.mark.parametrize("a", slow_but([1.6], [0.3, 1.6, 5.0]))
def test_the_stated_errors_of_exponents_match_their_scatter(a):
    found = found_by_seeds(a)
    for name in ("lambda_d", "lambda_c"):
        values = np.array([getattr(one, name) for one in found])
        off = (values - values.mean()) / [getattr(one, f"{name}_error") for one in found]
        assert 0.75 < math.sqrt((off**2).mean()) < 1.35
        assert np.abs(off).max() < 4.5


@pytest.mark.parametrize(("a", "bounces"), [(0.1, 1000), (1.6, 9000), (0.1, 50_000)])
def test_the_number_of_bounces_is_close_to_the_requested_number(a, bounces):
    made = [simulate(Stadium(a), bounces, seed).bounces for seed in range(5)]
    assert np.median(made) == pytest.approx(bounces, rel=0.2)


@pytest.mark.parametrize("legwise", [False, True])
@pytest.mark.parametrize(("a", "bounces"), slow_but([(0.3, 1)], [(0.05, 3000), (0.3, 1), (1.6, 20_000)]))
def test_errors_of_short_simulations_are_precise(a, bounces, legwise):
    """The spread of only 16 or 32 groups would determine the error to a sixth or an eighth of its value."""
    run = partial(simulate_legs, exact=(2.0, 0.0)) if legwise else simulate
    found = [run(Stadium(a), bounces, seed=seed) for seed in range(40)]
    errors = np.array([one.mean_free_path_error for one in found])
    assert errors.std() < 0.08 * errors.mean()
    assert min(one.groups for one in found) >= LEAST


def test_many_bounces_use_the_usual_number_of_trajectories():
    assert simulate(Stadium(), 8268, 3) == simulate(Stadium(), 8268, 3, TRAJECTORIES)


def test_averages_of_steps_become_averages_of_bounces_and_of_length():
    """In this example, a step has two bounces and the length 4."""
    found = Reference.of(1.6, (3.0, 0.5), (4.0, 0.25), 0.5, 0.25, 100, 7, 1)
    assert found == Reference(1.6, 1.5, 0.25, 0.75, 0.125, 2.0, 0.125, bounces=100, groups=7, seed=1)


@pytest.mark.parametrize(
    ("off", "where"), [(0.02, "2.0 standard errors above"), (-0.03, "3.0 standard errors below")]
)
@pytest.mark.parametrize(("wanted", "lines"), [(100, 1), (80, 2), (130, 2)])
def test_notes_say_on_which_side_the_mean_free_path_is_and_whether_bounces_differ(off, where, wanted, lines):
    path = Stadium(1.6).mean_free_path + off
    said = list(Reference(1.6, 1.5, 0.25, 0.75, 0.125, path, 0.01, 100, 7, 1).notes(wanted))
    assert where in said[0]
    assert len(said) == lines
    assert all(f"100 bounces were followed, not {wanted}" in line for line in said[1:])


@pytest.mark.parametrize("legwise", [False, True])
def test_errors_have_the_units_of_their_values(legwise):
    """Both exponents are the growth per step times an exact rate, by which the error is also multiplied."""
    stadium = Stadium(0.7)
    found = simulate_legs(stadium, 20_000, (2.0, 0.0)) if legwise else simulate(stadium, 20_000)
    for each in (found.lambda_d / found.lambda_c, found.lambda_d_error / found.lambda_c_error):
        assert each == pytest.approx(stadium.mean_free_path, rel=1e-12)
