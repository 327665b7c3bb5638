"""The paper's artificial dynamics: an independent way to every orbit."""

import numpy as np
import pytest

from orbitdb.billiard.stability import forces
from orbitdb.billiard.stadium import HALF_PI, STRAIGHT, Stadium
from orbitdb.orbits.newton import solve
from orbitdb.orbits.orbit import Status
from orbitdb.orbits.relaxation import relax, starting_points
from orbitdb.symbols.least_words import representatives
from orbitdb.symbols.words import from_strings


@pytest.mark.parametrize(
    ("a", "p"),
    [
        (0.5, 5),
        *(
            pytest.param(*case, marks=pytest.mark.slow)
            for case in ((0.2, 6), (0.5, 6), (1.0, 6), (1.6, 5), (2.5, 4))
        ),
    ],
)
def test_the_statuses_are_those_of_the_concave_problem(a, p):
    stadium = Stadium(a)
    words, _ = representatives(p)
    relaxed, solved = relax(words, stadium, 1e-6), solve(words, stadium)
    decided = solved.status != Status.BOUNDARY
    assert (relaxed.status == solved.status)[decided].all()
    assert np.abs(relaxed.margin[~decided]).max(initial=0.0) < 1e-4


def test_orbits_through_a_joint_fall_on_either_side():
    words, _ = representatives(6)
    stadium = Stadium(1.0)
    boundary = solve(words, stadium).status == Status.BOUNDARY
    relaxed = relax(words[boundary], stadium)
    assert boundary.sum() == 7
    assert set(relaxed.status) == {Status.ORBIT, Status.DYNAMICAL}
    assert np.abs(relaxed.margin).max() < 1e-5


def test_coordinates_length_and_exponent_agree_with_newton():
    words, _ = representatives(5)
    relaxed, solved = relax(words, Stadium(0.5), 1e-10), solve(words, Stadium(0.5))
    orbits = solved.status == Status.ORBIT
    assert np.abs(relaxed.coordinates - solved.coordinates)[orbits].max() < 1e-8
    np.testing.assert_allclose(relaxed.length[orbits], solved.length[orbits], rtol=1e-14)
    np.testing.assert_allclose(relaxed.lyapunov[orbits], solved.lyapunov[orbits], rtol=1e-8)


def test_a_long_word_keeps_its_exponent_in_range():
    stadium = Stadium()
    word = from_strings(["13" * 200 + "113"])  # lambda is above 709, where e^lambda overflows
    solved = solve(word, stadium)
    relaxed = relax(word, stadium, np.inf, start=solved.coordinates)
    assert solved.lyapunov[0] > 709
    np.testing.assert_allclose(relaxed.lyapunov, solved.lyapunov, rtol=1e-13)


def test_the_dynamics_stops_when_all_forces_are_below_epsilon():
    words, _ = representatives(5)
    stadium = Stadium(0.5)
    relaxed = relax(words, stadium, 1e-5)
    force = np.abs(forces(stadium, words, relaxed.coordinates)).max(axis=1)
    assert (force < 1e-5).all()
    np.testing.assert_allclose(force, relaxed.residual, rtol=1e-6)


def test_a_word_that_is_given_up_is_unresolved():
    words, _ = representatives(4)
    relaxed = relax(words, Stadium(), max_steps=100)
    late = relaxed.status == Status.UNRESOLVED
    assert late.any()
    assert not late.all()
    assert np.isnan(relaxed.coordinates[late]).all()
    assert (relaxed.iterations[late] == 100).all()


@pytest.mark.slow
def test_it_goes_on_where_it_stopped():
    words, _ = representatives(4)
    stadium = Stadium(1.0)
    first = relax(words, stadium, 1e-4)
    second = relax(words, stadium, 1e-8, start=first.coordinates)
    whole = relax(words, stadium, 1e-8)
    np.testing.assert_array_equal(second.coordinates, whole.coordinates)
    np.testing.assert_array_equal(first.iterations + second.iterations, whole.iterations)


@pytest.mark.parametrize("a", [0.1, 1.0, 10.0])
def test_every_atom_starts_inside_its_own_section(a):
    words, _ = representatives(7)
    start = starting_points(words, Stadium(a))
    assert (np.abs(start) < np.where(STRAIGHT[words], a, HALF_PI)).all()
    again = (words == np.roll(words, -1, axis=1)) & (np.roll(words, -1, axis=1) != np.roll(words, -2, axis=1))
    rising = np.roll(start, -1, axis=1) > start
    runs = again & ~STRAIGHT[words]
    assert (rising == (words < 4))[runs].all()
