"""The paper's artificial dynamics, an independent method that finds every orbit."""

import numpy as np
import pytest
from quick import slow_but
from scipy.integrate import solve_ivp

from orbitdb.billiard.stability import forces
from orbitdb.billiard.stadium import HALF_PI, STRAIGHT, Stadium
from orbitdb.orbits.relaxation import STEP, relax, starting_points
from orbitdb.orbits.solve import solve
from orbitdb.orbits.status import Status
from orbitdb.symbols.enumeration import representatives


@pytest.mark.parametrize(
    ("a", "p"), slow_but(1, [(0.5, 5), (0.2, 6), (0.5, 6), (1.0, 6), (1.6, 5), (2.5, 4)])
)
def test_relaxation_gives_the_statuses_of_the_concave_problem(a, p):
    stadium = Stadium(a)
    words, _ = representatives(p)
    relaxed, solved = relax(words, stadium, 1e-6), solve(words, stadium)
    decided = solved.status != Status.BOUNDARY
    assert (relaxed.status == solved.status)[decided].all()
    assert np.abs(relaxed.margin[~decided]).max(initial=0.0) < 1e-4


@pytest.mark.parametrize("p", slow_but(1, [6, 7]))
def test_the_margin_of_a_dynamical_word_is_that_of_its_fixed_point(p):
    """At this a, no direction of a fixed point is beyond the limits for orbits."""
    words, _ = representatives(p)
    solved = solve(words, Stadium(1.6))
    outside = solved.rows(solved.status == Status.DYNAMICAL)
    relaxed = relax(outside.words, Stadium(1.6), 1e-9)
    assert len(outside) > 7
    np.testing.assert_allclose(outside.margin, relaxed.margin, atol=1e-7)


def test_coordinates_length_and_exponent_agree_with_newton():
    words, _ = representatives(5)
    relaxed, solved = relax(words, Stadium(0.5), 1e-10), solve(words, Stadium(0.5))
    orbits = solved.status == Status.ORBIT
    assert np.abs(relaxed.coordinates - solved.coordinates)[orbits].max() < 1e-8
    np.testing.assert_allclose(relaxed.length[orbits], solved.length[orbits], rtol=1e-14)
    np.testing.assert_allclose(relaxed.lyapunov[orbits], solved.lyapunov[orbits], rtol=1e-8)


def test_the_dynamics_stops_when_all_forces_are_below_epsilon():
    words, _ = representatives(5)
    stadium = Stadium(0.5)
    relaxed = relax(words, stadium, 1e-5)
    force = np.abs(forces(stadium, words, relaxed.coordinates)).max(axis=1)
    assert (force < 1e-5).all()
    np.testing.assert_allclose(force, relaxed.residual, rtol=1e-6)


def test_the_relaxation_follows_the_differential_equation():
    """Eq. (2) is solved by another method. A scheme of lower order than 4 would be off by 1e-5 or more."""
    words, stadium = representatives(4)[0], Stadium(0.5)
    relaxed = relax(words, stadium, 0.1)

    def velocity(_, x, word):
        return np.where(STRAIGHT[word], -1, 1) * forces(stadium, word[None], x[None])[0]

    for row, (word, start) in enumerate(zip(words, starting_points(words, stadium), strict=True)):
        ends = 0, STEP * relaxed.iterations[row]
        found = solve_ivp(velocity, ends, start, "DOP853", args=(word,), rtol=1e-10, atol=1e-10).y[:, -1]
        assert relaxed.coordinates[row] == pytest.approx(found, abs=2e-6)


def test_a_word_that_does_not_converge_is_unresolved():
    words, _ = representatives(4)
    relaxed = relax(words, Stadium(), max_steps=100)
    late = relaxed.status == Status.UNRESOLVED
    assert late.any()
    assert not late.all()
    assert np.isnan(relaxed.coordinates[late]).all()
    assert (relaxed.iterations[late] == 100).all()


@pytest.mark.parametrize("a", [0.1, 1.0, 10.0])
def test_every_atom_starts_on_its_wall_or_semicircle(a):
    words, _ = representatives(7)
    start = starting_points(words, Stadium(a))
    assert (np.abs(start) < np.where(STRAIGHT[words], a, HALF_PI)).all()
    again = (words == np.roll(words, -1, axis=1)) & (np.roll(words, -1, axis=1) != np.roll(words, -2, axis=1))
    rising = np.roll(start, -1, axis=1) > start
    runs = again & ~STRAIGHT[words]
    assert (rising == (words < 4))[runs].all()
