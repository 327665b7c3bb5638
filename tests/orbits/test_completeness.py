"""The proof that no birth is missing: its cells agree with solutions at single a, and it finds errors."""

from itertools import pairwise, product

import numpy as np
import pytest
from solutions import representatives

from orbitdb.billiard.legs import Chain, cut, derivatives, direction_limits, following, half_turns, preceding
from orbitdb.billiard.stadium import HALF_PI
from orbitdb.orbits.along_a import motion
from orbitdb.orbits.births import find_changes
from orbitdb.orbits.cells import ROUNDING, Kind, Reach, displaced, firmness, forcing, kinds_in_cells, reach_of
from orbitdb.orbits.missing_births import Completeness, prove_all, stretches, walk
from orbitdb.orbits.newton import newton
from orbitdb.orbits.solve import solve
from orbitdb.symbols.words import from_strings

DYING = "010203113"


def known(changes) -> list[tuple[float, float, bool]]:
    low, high = np.log(changes.a - changes.error), np.log(changes.a + changes.error)
    return list(zip(low.tolist(), high.tolist(), changes.born.tolist(), strict=True))


@pytest.fixture
def judged(monkeypatch) -> list[int]:
    """A list of the numbers of cells that are judged together."""
    numbers: list[int] = []

    def count(legs, *given):
        numbers.append(len(legs))
        return kinds_in_cells(legs, *given)

    monkeypatch.setattr("orbitdb.orbits.missing_births.kinds_in_cells", count)
    return numbers


def test_a_dying_word_is_proved_only_with_all_its_changes(judged):
    words = from_strings([DYING])
    right = known(find_changes(words))
    assert [born for *_, born in right] == [True, False, True]
    assert prove_all(words, [right]).tolist() == [Completeness.PROVED]
    assert sum(judged) < 120  # as narrow as sharp bounds require
    shifted = [(low - 0.3, high - 0.3, born) for low, high, born in right[:1]]
    for wrong in (right[:1], right[2:], [], [*shifted, *right[1:]], [*right[:1], *shifted, *right[1:]]):
        assert prove_all(words, [wrong]).tolist() == [Completeness.WRONG]


@pytest.mark.slow
def test_all_births_of_a_period_are_proved(judged):
    words = representatives(5)
    changes = find_changes(words)
    mine = [[each for each, word in zip(known(changes), changes.word.tolist(), strict=True) if word == row]
            for row in range(len(words))]  # fmt: skip
    assert (prove_all(words, mine) == Completeness.PROVED).all()
    assert sum(judged) > 100 * len(words)


WAYS: dict[Kind, list[tuple[bool, bool, tuple[bool, ...]]]] = {
    Kind.ALIVE: [(True, True, ())],
    Kind.DEAD: [(False, False, ())],
    Kind.RISING: [(False, False, ()), (True, True, ()), (False, True, (True,))],
    Kind.FALLING: [(False, False, ()), (True, True, ()), (True, False, (False,))],
    Kind.OPEN: [
        (begin, begin ^ bool(count % 2), tuple(begin ^ (k % 2 == 0) for k in range(count)))
        for begin in (False, True)
        for count in range(4)
    ],
}
"""The possible histories of a segment: whether the word is an orbit at each end, and the births between."""


def lives(kinds, alive) -> set[tuple[tuple[bool, ...], ...]]:
    """Return all lives that segments of the given kinds allow, as births and deaths by segment."""
    found = set()
    for way in product(*[WAYS[kind] for kind in kinds]):
        begins = alive is None or way[0][0] == alive
        if begins and all(left[1] == right[0] for left, right in pairwise(way)):
            found.add(tuple(changes for *_, changes in way))
    return found


def holds(some, every) -> bool:
    """Tell whether the given changes occur among others in the same order."""
    rest = iter(every)
    return all(any(each == other for other in rest) for each in some)


@pytest.mark.parametrize("alive", [None, True, False])
@pytest.mark.parametrize("length", [1, 2, 3])
def test_verdicts_agree_with_the_lives_that_segments_allow(length, alive):
    """PROVED: only one allowed life contains the known changes. WRONG: none has exactly these changes."""
    verdicts = set()
    for kinds in product(WAYS, repeat=length):
        segments = [(kind, float(place), place + 1.0) for place, kind in enumerate(kinds)]
        allowed = lives(kinds, alive)
        for births in product([(), (True,), (False,)], repeat=length):
            changes = [(k + 0.4, k + 0.6, born) for k, here in enumerate(births) for born in here]
            verdict = walk(segments, changes, alive)
            elsewhere = [(-9.0, -8.9, True), *changes, (9.0, 9.1, False)]
            assert walk(segments, elsewhere, alive) == verdict
            verdicts.add(verdict)
            if verdict == Completeness.PROVED:
                assert {life for life in allowed if all(map(holds, births, life))} == {births}
            elif verdict == Completeness.WRONG:
                assert births not in allowed
    assert verdicts == set(Completeness)


SLOW = [pytest.param(a, marks=pytest.mark.slow) for a in (0.021, 0.11, 0.9, 1.7, 40.0)]


@pytest.mark.parametrize("a", [0.37, 3.04, *SLOW])
def test_the_verdict_on_a_cell_agrees_with_solving_at_a_point(a):
    """For all words of p = 6, cells that are proved to be orbits, or not, throughout."""
    words = representatives(6)
    status = solve(words, a).status
    for rows, legs in cut(words):
        word, kind, low, high = stretches(legs, np.log(a) - 0.1, np.log(a) + 0.13)
        here = np.flatnonzero((low < np.log(a)) & (np.log(a) < high))
        for said, each in zip(kind[here].tolist(), word[here].tolist(), strict=True):
            if said in (Kind.ALIVE, Kind.DEAD):
                assert (status[rows[each]] == "orbit") == (said == Kind.ALIVE)


@pytest.mark.parametrize("a", [1e-3, 0.37, 30.0])
def test_a_cell_of_zero_width_is_always_decided(a):
    words = representatives(6)
    status = solve(words, a).status
    for rows, legs in cut(words):
        count = len(rows)
        x, nothing = np.full(count, np.log(a)), np.zeros(count)
        kind, *_ = kinds_in_cells(legs, x, nothing, np.zeros(legs.k.shape))
        assert (kind == np.where(status[rows] == "orbit", Kind.ALIVE, Kind.DEAD)).all()


@pytest.mark.parametrize(("a", "r"), [(0.1, 0.0), (0.4, 0.02), (1.2, 0.3)])
def test_bounds_leave_room_for_rounding_throughout_a_cell(a, r):
    """They leave a relative 1e-9, more than rounding needs, and no more in a cell of a single point.

    The sine of a turn may be largest inside the range rather than at an end.
    """
    rng = np.random.default_rng(2)
    for _, legs in cut(representatives(6)):
        alpha, size = newton(legs, a).alpha, np.full(len(legs), a)
        room = np.minimum(r * rng.uniform(size=alpha.shape), HALF_PI - np.abs(alpha))
        reach = reach_of(legs, size, np.full(len(legs), r), alpha, room)
        stiff, soft = reach.stiff, reach.soft
        for _ in range(20):
            x, here = rng.choice([-r, r]), alpha + room * rng.choice([-1, 0, 1], alpha.shape)
            at, turned = derivatives(legs, a * np.exp(x), here), np.abs(np.cos(half_turns(legs, here)))
            along, across = 2 * a * np.exp(x) * np.array([np.cos(here), np.abs(np.sin(here))])
            lean = np.maximum(np.abs(legs.lift) * np.cos(here), across)
            most = np.array(
                [reach.pull, reach.drag, reach.lean, reach.bend, stiff, at.stiffness, at.between_centres]
            )
            least = [across, along, lean, turned / (4 * legs.k**2), at.stiffness, soft, reach.between_centres]
            rooms = most - (1 + 5e-10) * np.array(least)
            assert (rooms > -1e-15).all()
            assert (rooms.max() < 1e-8) == (r == 0)
            v = rng.uniform(1, 2, alpha.shape)
            behind, ahead = v - preceding(v), v - following(v)
            held = reach.between_centres * v + np.minimum(soft * behind, stiff * behind)
            held += np.minimum(following(soft) * ahead, following(stiff) * ahead)
            total = (reach.between_centres + stiff + following(stiff)) * v
            assert ((held - firmness(reach, v)) / total) == pytest.approx(ROUNDING, rel=1e-3)


@pytest.mark.parametrize("a", [0.4, 1.2])
def test_bounds_in_a_cell_follow_from_the_equations_and_are_sharp(a):
    """Bounds on the forcing of alpha'', on the effect of errors, and on |A u| from gradient differences."""
    step, rng, nearest = 1e-4, np.random.default_rng(1), np.zeros(3)
    for _, words in cut(representatives(7)):
        alpha, (low, high) = newton(words, a).alpha, direction_limits(words, a)
        free = np.flatnonzero(((alpha > low) & (alpha < high)).all(axis=0))
        legs, alpha = words.chain(free), alpha[:, free]
        _, velocity = motion(legs, a, alpha, direction_limits(legs, a))

        def gradient(moved, x=0.0, legs=legs):
            return derivatives(legs, a * np.exp(x), moved).gradient

        def slope(here, velocity=velocity, gradient=gradient):
            return (gradient(here + velocity * step, step) - gradient(here - velocity * step, -step)) / (
                2 * step
            )

        def reach(room, legs=legs, alpha=alpha):
            here = np.full(alpha.shape[1], a)
            return reach_of(legs, here, 0 * here, alpha, room)

        ends = gradient(alpha + velocity * step, step) + gradient(alpha - velocity * step, -step)
        second = np.abs(ends - 2 * gradient(alpha)) / step**2
        off = rng.choice([-1e-5, 1e-5], alpha.shape)
        changed = np.abs(slope(alpha + off) - slope(alpha))
        driven = forcing(reach(np.zeros_like(alpha)), np.abs(velocity)) + 1e-6  # error of differences
        loose = displaced(reach(np.abs(off)), np.abs(velocity), np.abs(off)) + 1e-11
        v = rng.uniform(1, 1.3, alpha.shape)
        q, u = firmness(reach(np.zeros_like(alpha)), v), v * rng.choice([-1, 1], alpha.shape)
        sides = np.abs(gradient(alpha + u * step) - gradient(alpha - u * step)) / (2 * step)
        assert (q > 0).all()
        shares = np.stack([(second / driven).max(0), (changed / loose).max(0), 1 / (sides / q).max(0)])
        nearest = np.maximum(nearest, shares.max(axis=1))
        assert (shares < 1 + 1e-6).all()
    assert (nearest > 0.97).all()


def test_every_force_on_the_second_derivative_counts():
    """Each kind of force is tested alone, at speeds below and above 1."""
    speed, one = np.array([[0.5], [3.0], [0.25]]), np.ones((3, 1))
    turning = (preceding(speed) + speed) ** 2
    expected = {"pull": one, "drag": 2 * speed, "lean": speed**2, "bend": turning + following(turning)}
    for name, force in expected.items():
        alone = Reach(*np.zeros((7, 3, 1)))._replace(**{name: one})
        np.testing.assert_allclose(forcing(alone, speed), force, rtol=1e-15)


@pytest.mark.parametrize("radius", [1e-3, 0.03, 0.3])
def test_mirrored_words_get_the_same_verdicts(radius):
    """If walls and senses are swapped, the directions change sign and their limits change sides."""
    told = set()
    for _, legs in cut(representatives(7)):
        mirrored = Chain(legs.k, -legs.d, legs.n, -legs.s)
        for a in (0.02, 0.1, 0.4, 1.0, 3.0):
            x, size = np.full(legs.k.shape[1], np.log(a)), np.full(legs.k.shape[1], radius)
            kind, alpha, velocity = kinds_in_cells(legs, x, size, np.zeros(legs.k.shape))
            other = kinds_in_cells(mirrored, x, size, np.zeros(legs.k.shape))
            assert (other[0] == kind).all()
            np.testing.assert_allclose(other[1], -alpha, atol=1e-9)
            np.testing.assert_allclose(other[2], -velocity, atol=1e-6)
            told |= set(kind.tolist())
    assert len(told) >= 3
