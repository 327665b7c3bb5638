"""Which words are orbits in a field: an independent map follows every arc, and searches for words."""

import numpy as np
import pytest
from field_map import next_bounce, start_at, symbols_of, trajectories
from hypothesis import assume, given
from hypothesis import strategies as st
from in_field import A, followed, measured, orbits_at, paths_at, states
from quick import fuzz_but
from solutions import random_word, solved, words_of

from orbitdb.billiard.stadium import HALF_PI, STRAIGHT, Stadium
from orbitdb.magnetic.action import derivatives_of_action, solve_hessian
from orbitdb.magnetic.along_kappa import follow_in_field
from orbitdb.magnetic.field_status import IN_FIELD, measure
from orbitdb.orbits.solve import solve
from orbitdb.symbols.symmetry import ELEMENTS, ODD, REVERSE, act_on_coordinates, act_on_words
from orbitdb.symbols.words import (
    are_primitive,
    from_strings,
    is_primitive,
    least_rotations,
    pack,
    to_strings,
    unpack,
)


def reproduced(words, places, kappa, a):
    """Tell which paths the map follows from each bounce to the next, and in the same direction."""
    begin = states(words, places, kappa, a)
    with np.errstate(invalid="ignore"):
        end = next_bounce(a, kappa, begin.mapped(np.ravel))
    aim = begin.mapped(lambda column: np.roll(column, -1, axis=1))
    off = [column.reshape(words.shape) - wanted for column, wanted in zip(end, aim, strict=True)]
    turned = np.abs(np.sin(off[2] / 2)) * 2
    return (np.abs(off[0]) + np.abs(off[1]) + turned < 1e-8).all(axis=1) & (off[3] == 0).all(axis=1)


@pytest.mark.slow
@pytest.mark.parametrize(("a", "kappa"), [(1.6, 0.05), (1.6, 0.2), (1.6, -0.35), (0.5, 0.4), (5.0, 0.15)])
@pytest.mark.parametrize("p", [2, 5, 7])
def test_orbits_are_the_words_that_the_map_follows(p, a, kappa):
    words, places = followed(p, kappa, a)
    kept = ~np.isnan(places[:, 0])
    words, places = words[kept], places[kept]
    status = measured(words, places, kappa, a).status
    inside = (np.abs(places) < np.where(STRAIGHT[words], a, HALF_PI)).all(axis=1)
    assert ((status == "joint") == ~inside).all()
    assert (np.isin(status, ["orbit", "elliptic"]) == inside & reproduced(words, places, kappa, a)).all()


def test_the_map_gives_the_words_of_the_orbits():
    """Symbols read from the bounces of an orbit are those of its word, runs up and down included."""
    for kappa in (0.05, 0.3):
        words, places = orbits_at(7, kappa)
        path = states(words, places, kappa).mapped(np.transpose)
        assert len(words) > 50
        assert (words == symbols_of(path, cyclic=True).T).all()


@pytest.mark.parametrize("p", [4, 7])
def test_the_reverse_in_a_field_is_the_orbit_in_the_opposite_field(p):
    words, orbits = words_of(p), solved(p, A)
    zero = np.zeros(len(words))
    back = act_on_words(REVERSE, words)
    turned = act_on_coordinates(REVERSE, words, orbits.coordinates)
    forward, backward = (
        measure(Stadium(A), own, follow_in_field(Stadium(A), own, places, zero, zero + kappa), zero + kappa)
        for own, places, kappa in ((words, orbits.coordinates, -0.15), (back, turned, 0.15))
    )
    assert (forward.status == backward.status).all()
    for name in ("action", "length", "lyapunov"):
        assert getattr(forward, name) == pytest.approx(getattr(backward, name), rel=1e-9, nan_ok=True)
    assert forward.area == pytest.approx(-backward.area, abs=1e-10, nan_ok=True)


@pytest.mark.slow
@given(
    seed=st.integers(0, 10**6),
    order=st.integers(3, 12),
    a=st.floats(0.3, 6),
    share=st.floats(-0.95, 0.95).filter(lambda share: abs(share) > 1e-3),
)
def test_images_of_any_word_and_the_map_agree(seed, order, a, share):
    """Even elements keep kappa, odd ones turn its sign; the map follows exactly the words that are orbits."""
    word, kappa = random_word(seed, order), share / (a + 1)
    assume(is_primitive(word))
    words = from_strings([word])
    places, zero, found = solve(words, a).coordinates, np.zeros(1), []
    for element in ELEMENTS:
        image, own = act_on_words(element, words), act_on_coordinates(element, words, places)
        sign = -1 if element in ODD else 1
        followed = follow_in_field(Stadium(a), image, own, zero, zero + sign * kappa)
        found.append((sign, measure(Stadium(a), image, followed, zero + sign * kappa)))
        if not followed.lost[0]:
            inside = np.abs(followed.coordinates) < np.where(STRAIGHT[image], a, HALF_PI) - 1e-8
            real = inside.all() and reproduced(image, followed.coordinates, sign * kappa, a)[0]
            assert (found[-1][1].status[0] in IN_FIELD) == real
    (_, first), *others = found
    for sign, other in others:
        assert other.status.tolist() == first.status.tolist()
        assert other.action == pytest.approx(first.action, rel=1e-9, nan_ok=True)
        assert sign * other.area == pytest.approx(first.area, abs=1e-7, nan_ok=True)


def test_the_way_to_a_curvature_does_not_matter():
    """One step or many, and back again to no field."""
    words, orbits = words_of(6), solved(6, A)
    zero = np.zeros(len(words))
    at_once = follow_in_field(Stadium(A), words, orbits.coordinates, zero, zero + 0.3).coordinates
    places = orbits.coordinates
    for k in range(30):
        places = follow_in_field(Stadium(A), words, places, zero + k / 100, zero + (k + 1) / 100).coordinates
    assert places == pytest.approx(at_once, abs=1e-9)
    home = follow_in_field(Stadium(A), words, places, zero + 0.3, zero).coordinates
    assert home == pytest.approx(orbits.coordinates, abs=1e-9)


@pytest.mark.parametrize(("a", "kappa"), [(20.0, 1e-4), (1000.0, 5e-8)])
def test_no_word_is_lost_in_a_long_stadium(a, kappa):
    """All 712 words are orbits, and coordinates on the walls are large."""
    assert len(orbits_at(7, kappa, a)[0]) == 712


def test_words_without_a_fixed_point_to_start_from_are_lost():
    """At a = 0.5, the path of 01033113 has a direction at its limit, and no stationary length."""
    words = words_of(8)
    row = to_strings(words).index("01033113")
    orbits = solved(8, 0.5)
    found = follow_in_field(
        Stadium(0.5), words[[row]], orbits.coordinates[[row]], np.zeros(1), np.full(1, 0.05)
    )
    assert np.isnan(found.residual).all()
    assert found.lost.all()


# searches from random starts


def random_paths(kappa, particles, bounces, seed):
    rng = np.random.default_rng(seed)
    starts = start_at(A, rng.uniform(0, Stadium(A).perimeter, particles), rng.uniform(-1, 1, particles))
    return trajectories(A, kappa, starts, bounces)


def triples(symbols):
    """Return all sequences of three sides, 0 to 3, from symbols of shape (T, N)."""
    sides = np.array([0, 1, 2, 3, 1, 3])[symbols]
    rows = np.stack([sides[:-2], sides[1:-1], sides[2:]], axis=-1).reshape(-1, 3)
    return {"".join(map(str, row)) for row in np.unique(rows, axis=0).tolist()}


@pytest.mark.slow
def test_six_triples_of_sides_are_new_in_a_field():
    """Up to kappa = 0.3, some arcs go from a wall to the same wall."""
    words = words_of(8)
    allowed = triples(np.concatenate([words, words[:, :2]], axis=1).T)
    paths = (random_paths(kappa, 1000, 60, seed=5) for kappa in (0.1, 0.3))
    found = set().union(*(triples(symbols_of(path)) for path in paths))
    assert found - allowed == {"300", "000", "001", "122", "222", "223"}


def converged(words, places, kappa, steps, most):
    """Return which words Newton's method leads to orbits, in steps of limited size, and their bounces."""
    now = places.T
    with np.errstate(invalid="ignore", over="ignore", divide="ignore"):
        for _ in range(steps):
            slopes = derivatives_of_action(paths_at(words, now.T, kappa))
            move = -solve_hessian(slopes, slopes.gradient)[0]
            now = now + move / np.maximum(1, np.abs(move).max(axis=0) / most)
        numbers = measured(words, now.T, kappa)
    rows = np.flatnonzero((numbers.residual < 1e-11) & np.isin(numbers.status, IN_FIELD))
    return rows[reproduced(words[rows], now.T[rows], kappa, A)], now.T


def words_found(p, kappa):
    """Return the words of period p of the orbits to which pieces of random paths lead."""
    path = random_paths(kappa, 60 * p**2, 60, seed=p)
    right, left = np.arctan2(path.y, path.x - A), np.arctan2(path.y, -(path.x + A))
    places = np.select([path.side == 3, path.side == 1], [right, left], path.x)[1:-1]
    words, starts = (
        np.lib.stride_tricks.sliding_window_view(each, p, axis=0).reshape(-1, p)
        for each in (symbols_of(path), places)
    )
    rows, places = converged(words, starts, kappa, steps=25, most=0.5)
    around = states(words[rows], places[rows], kappa).mapped(np.transpose)
    own = np.ascontiguousarray(symbols_of(around, cyclic=True).T)
    own = own[are_primitive(own)]
    return set(to_strings(unpack(least_rotations(pack(own), p), p)))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("p", "kappa"),
    fuzz_but(
        [(2, 0.05), (3, 0.2), (4, 0.05), (5, 0.2)],
        [(p, kappa) for p in range(2, 7) for kappa in (0.05, 0.2)],
    ),
)
def test_a_search_from_random_starts_finds_the_same_words(p, kappa):
    assert words_found(p, kappa) == set(to_strings(orbits_at(p, kappa)[0]))


def test_a_word_can_have_three_orbits():
    """A pitchfork makes 01112555 stable and adds two unstable orbits."""
    every, places = followed(8, 0.1)
    row = to_strings(every).index("01112555")
    words = np.repeat(every[[row]], 300, axis=0)
    starts = places[row] + np.random.default_rng(3).uniform(-0.4, 0.4, words.shape)
    rows, found = converged(words, starts, 0.1, steps=60, most=0.1)
    different, first = np.unique(found[rows].round(6), axis=0, return_index=True)
    statuses = measured(words[rows[first]], found[rows[first]], 0.1).status
    assert len(different) == 3
    assert sorted(statuses) == ["elliptic", "orbit", "orbit"]
