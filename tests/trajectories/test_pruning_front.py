"""The pruning front: the order of paths in the symbol plane, and every status from the front alone."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from itineraries import random_rays
from quick import slow_but
from solutions import real, solved, words_of

from orbitdb import Catalogue, PruningFront, Stadium, solve, symbol_plane
from orbitdb.billiard.stability import birkhoff
from orbitdb.symbols.enumeration import representatives
from orbitdb.symbols.plane import ordinate
from orbitdb.symbols.words import to_strings
from orbitdb.trajectories.pruning_front import letters
from orbitdb.trajectories.rays import Rays

SOME_A = (0.5, 1.6, 5.0)
seeds = st.integers(0, 2**32 - 1)

EXTENT = {0: 2.0, 1: math.pi}
"""Extent of a piece of the boundary in the coordinate of `leaving`: a wall in units of a, a semicircle."""


def leaving(a, piece, along, angle):
    """Return paths that leave a piece of the boundary.

    `along` grows anticlockwise from 0 to `EXTENT`, and `angle` is that between the tangent and the path.
    """
    if piece % 2:
        turn = along + math.pi * (piece // 2)
        side = np.full(len(along), 1.0 if piece == 1 else -1.0)
        x, y, tangent = side * a + np.sin(turn), -np.cos(turn), turn
    else:
        up = piece - 1.0
        side = np.zeros(len(along))
        x, y, tangent = -up * a * (along - 1), np.full(len(along), up), math.pi * (piece // 2)
    return Rays(x, y, np.cos(tangent + angle), np.sin(tangent + angle), side)


def gamma_of(rays, a):
    return ordinate(rays.side != 0, letters(rays, a))


def reversed_rays(rays, a):
    """Return the paths reversed from the same bounce: what arrived there now leaves."""
    nx, ny = np.where(rays.side == 0, 0.0, rays.x - rays.side * a), rays.y
    out = 2 * (rays.vx * nx + rays.vy * ny)
    return rays._replace(vx=out * nx - rays.vx, vy=out * ny - rays.vy)


@pytest.mark.parametrize("a", SOME_A)
@pytest.mark.parametrize("piece", slow_but(1, range(4)))
def test_gamma_and_delta_follow_the_order_of_paths(a, piece):
    """In fans from a point and in beams of parallel paths; not one pair is out of order."""
    rng = np.random.default_rng(piece)
    n, m = 100, 40
    ends, turns = EXTENT[piece % 2], math.pi
    along, angle = rng.uniform(0, ends, (n, 1)), np.sort(rng.uniform(0, turns, (n, m)), axis=1)
    fan = leaving(a, piece, np.repeat(along, m), angle.ravel())
    assert (np.diff(gamma_of(fan, a).reshape(n, m)) >= 0).all()
    assert (np.diff(gamma_of(reversed_rays(fan, a), a).reshape(n, m)) <= 0).all()
    along, angle = np.sort(rng.uniform(0, ends, (n, m)), axis=1), rng.uniform(0, turns, (n, 1))
    beam = leaving(a, piece, along.ravel(), np.repeat(angle, m))
    rises = 1 if piece % 2 else -1
    for rays in (beam, reversed_rays(beam, a)):
        assert (rises * np.diff(gamma_of(rays, a).reshape(n, m)) >= 0).all()


@pytest.mark.parametrize("a", SOME_A)
def test_the_flow_from_a_bounce_has_the_letters_of_its_word(a):
    """gamma and delta of the paths that leave the bounces of orbits are those of the words.

    Errors of 1e-15 grow by about e^lambda_d a bounce; after 12 bounces they cannot yet change a letter.
    """
    words = words_of(6)[real(solved(6, a))]
    orbits = solve(words, a)
    points = Stadium(a).points(words, orbits.coordinates)
    steps = np.roll(points, -1, axis=1) - points
    steps /= np.linalg.norm(steps, axis=-1, keepdims=True)
    side = np.array([0.0, -1, 0, 1, -1, 1])[words]
    rays = Rays(*(part.ravel() for part in (*np.moveaxis(points, -1, 0), *np.moveaxis(steps, -1, 0), side)))
    sine = birkhoff(Stadium(a), words, orbits.coordinates)[1]
    assert (np.abs(sine) < 1).all()
    found = np.stack([gamma_of(rays, a), gamma_of(reversed_rays(rays, a), a)], axis=-1)
    np.testing.assert_allclose(found.reshape(*words.shape, 2), symbol_plane(words), rtol=0, atol=1e-4)


@pytest.mark.parametrize("a", slow_but([1.6], [0.1, 0.5, 0.73, 1.0, 1.57, 1.6, 2.3, 5.0]))
def test_every_status_follows_from_the_front(a):
    """The solver and the front share nothing. Orbits through joints, as at a = 0.5, are not allowed."""
    front = PruningFront(a)
    boundary = 0
    for p in range(2, 10):
        orbits = solved(p, a)
        np.testing.assert_array_equal(front.allows(words_of(p)), real(orbits))
        boundary += (orbits.status == "boundary").sum()
    assert boundary > 0 or a not in (0.5, 1.0)


@pytest.mark.slow
def test_table_1_follows_from_the_front():
    front = PruningFront(1.6)
    counts = []
    for p in range(2, 12):
        words, sizes = representatives(p)
        counts.append(int(sizes[front.allows(words)].sum()))
    assert counts == [1, 8, 32, 80, 188, 376, 1424, 4104, 11064, 29880]


widths = st.floats(-0.8, 0.7).map(lambda power: 10.0**power)


@pytest.mark.slow
@given(widths, seeds)
def test_no_path_has_a_point_beyond_the_front(a, seed):
    """Points are moved inwards by 1e-6: paths between the walls are alike for more than 27 letters."""
    rays = random_rays(Stadium(a), 500, np.random.default_rng(seed))
    points = np.stack([gamma_of(rays, a), gamma_of(reversed_rays(rays, a), a)])
    front = PruningFront(a)
    for each in (front.walls, front.semicircles):
        gamma, delta = points[:, (rays.side != 0) == each.curved]
        assert each.below(gamma - 1e-6, delta - 1e-6).all()
        assert each.below(1 - gamma - 1e-6, 1 - delta - 1e-6).all()


@pytest.mark.slow
@given(widths)
def test_every_end_of_a_wall_or_semicircle_has_the_same_front_turned_or_not(a):
    """The first end of a wall, anticlockwise, has its upper front; that of a semicircle has its lower one.

    The flow differs from end to end by rounding, which may change the last of the 27 letters.
    """
    front = PruningFront(a)
    for piece in range(4):
        each = front.semicircles if piece % 2 else front.walls
        some = slice(100, -100, 41)  # as many on either side of the right angle
        theta = each.angle[some]
        for along in (0.0, EXTENT[piece % 2]):
            rays = leaving(a, piece, np.full(len(theta), along), theta)
            found = np.stack([gamma_of(rays, a), gamma_of(reversed_rays(rays, a), a)])
            if bool(along) != bool(piece % 2):
                found = 1 - found[:, ::-1]
            np.testing.assert_allclose(found, [each.gamma[some], each.delta[some]], rtol=0, atol=1e-6)


@pytest.mark.parametrize("a", SOME_A)
def test_gamma_rises_and_delta_falls_along_a_front(a):
    for front in (PruningFront(a).walls, PruningFront(a).semicircles):
        assert (np.diff(front.gamma) >= 0).all()
        assert (np.diff(front.delta) <= 0).all()
        assert front.gamma.min() >= (0.4 if front.curved else 0)
        on = np.arange(0, len(front.angle), 50)
        assert not front.below(front.gamma[on] + 1e-6, front.delta[on] + 1e-6).any()
        assert front.below(front.gamma[on] - 1e-6, front.delta[on] - 1e-6).all()


def test_geometric_pruning_is_the_limit_of_long_stadiums():
    """Rules 4 and 6 forbid half of the plane of walls, rule 5 two squares of the plane of semicircles."""
    far = PruningFront(1e4)
    for front, free, corner in ((far.walls, 0.49, 0.51), (far.semicircles, 0.79, 0.81)):
        inside, beyond = np.array([free, 0.99]), np.array([corner, 0.99])
        assert front.below(inside, inside[::-1]).all()
        assert not front.below(beyond, beyond[::-1]).any()
    areas = [np.trapezoid(1 - f.delta, f.gamma) for a in (0.2, 1, 5) for f in [PruningFront(a).semicircles]]
    assert areas[0] > areas[1] > areas[2] > 0.04


@pytest.mark.parametrize(("a", "lost"), [(0.01, ["1133"]), (0.05, [])])
def test_a_front_of_a_short_stadium_says_that_it_forbids_orbits(a, lost):
    front, words = PruningFront(a), representatives(4)[0]
    wrong = front.allows(words) != (solve(words, a).status == "orbit")
    assert to_strings(words[wrong]) == lost
    assert any("forbids some orbits" in note for note in front.notes) == bool(lost)


def test_a_catalogue_has_the_front_of_its_stadium(filled):
    catalogue = Catalogue(filled, a=1.6)
    assert catalogue.pruning_front().stadium == Stadium(1.6)
    front = catalogue.pruning_front(a=0.5)
    assert repr(front) == "<pruning front at a = 0.5>"
    chosen = catalogue.select(p=7)
    words, _ = catalogue.select(p=7, coordinates=True).of_period(7)
    np.testing.assert_array_equal(catalogue.pruning_front().allows(words), chosen.status == "orbit")
