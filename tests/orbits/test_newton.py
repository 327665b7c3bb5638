"""Solved orbits against the paper's table, known answers and the law of reflection; very long words."""

import math

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from quick import slow_but
from solutions import random_word, real, representatives, solved, words_of

from orbitdb.billiard.legs import Legs, cut, derivatives, direction_limits
from orbitdb.billiard.stability import forces
from orbitdb.billiard.stadium import STRAIGHT, Stadium
from orbitdb.orbits.admissible import solve_admissible
from orbitdb.orbits.error_bounds import direction_errors
from orbitdb.orbits.exponents import exponents
from orbitdb.orbits.newton import MAX_STEPS, newton, responses
from orbitdb.orbits.orbits import NUMBERS
from orbitdb.orbits.solve import solve
from orbitdb.orbits.status import Status, decide
from orbitdb.symbols.pruning import rules_of
from orbitdb.symbols.words import from_strings, pack, parse

TABLE_1 = """
 2     1     1      2 0.346
 3     8     8     24 1.059
 4    32    32    130 1.216
 5    96    80    400 1.198
 6   252   188   1154 1.175
 7   712   376   2632 1.125
 8  2096  1424  11522 1.169
 9  6440  4104  36960 1.168
10 19664 11064 111042 1.161
11 60488 29880 328680 1.154
"""
"""Biham and Kvale: p, N_t, N_c, N, K_0 at a = 1.6."""


@pytest.mark.parametrize("highest", slow_but([9], [9, 11]))
def test_table_1_of_the_paper(highest):
    """Every admissible word is solved on its own. The paper truncates K_0 to three decimals."""
    counts: dict[int, int] = {}
    for line in TABLE_1.split("\n")[1:highest]:
        p, total, isolated, points, entropy = line.split()
        orbits = solved(int(p), 1.6)
        counts[int(p)] = int(np.count_nonzero(real(orbits)))
        periodic = sum(d * counts[d] for d in counts if int(p) % d == 0)
        k_0 = math.floor(1000 * math.log(periodic) / int(p)) / 1000
        assert (len(orbits), counts[int(p)], periodic, f"{k_0:.3f}") == (
            int(total),
            int(isolated),
            int(points),
            entropy,
        )
        assert set(orbits.status) <= {Status.ORBIT, Status.DYNAMICAL}


@pytest.mark.parametrize(
    "a", slow_but([1e-6, 0.2, 1.0, 1.6, 1e6], [1e-6, 1e-3, 0.2, 0.5, 1.0, 1.2, 1.6, 2.5, 5.0, 10.0, 1e3, 1e6])
)
def test_every_word_is_decided_and_orbits_obey_the_law_of_reflection(a):
    """Each bounce of an orbit obeys the law of reflection on its own wall."""
    stadium = Stadium(a)
    for p in range(2, 9):
        orbits = solve(representatives(p), stadium)
        assert not (orbits.status == Status.UNRESOLVED).any()
        found = real(orbits)
        ends = np.where(STRAIGHT[orbits.words], a, np.pi / 2) - np.abs(orbits.coordinates)
        assert (ends + orbits.error[:, None] > 0)[found].all()
        assert (orbits.margin[found] > 0).all()
        assert np.abs(forces(stadium, orbits.words, orbits.coordinates))[found].max() < 1e-13 * (1 + a)
        assert orbits.residual[found].max() < 1e-13 * (1 + a)
        assert (orbits.error[found] < 1e-7).all()


@given(a=st.floats(1e-6, 1e6), n=st.integers(0, 40))
@example(a=1.6, n=0)
def test_orbits_at_right_angles_to_both_semicircles_are_known_exactly(a, n):
    """They go back and forth over n walls along the line of the unfolded centres: L = 4 (1 + hypot(a, n))."""
    there = "20" * (n // 2) + "2" * (n % 2)
    orbit = solve(from_strings([f"1{there}3{there[::-1]}"]), Stadium(a))
    drift = 2 * math.hypot(a, n)
    assert orbit.status[0] == Status.ORBIT
    assert orbit.length[0] == pytest.approx(2 * drift + 4, rel=1e-14)
    assert orbit.lyapunov[0] == pytest.approx(2 * math.asinh(math.sqrt(drift * (drift + 2))), rel=1e-13)
    assert orbit.coordinates[0, 0] == pytest.approx(-math.atan2(n, a), abs=orbit.error[0] + 1e-15)


@pytest.mark.parametrize("a", slow_but([1.0], [0.5, 1.0, 1.6]))
def test_orbits_are_the_same_if_other_words_are_not_measured(a):
    """At a = 1 some words run through joints and are decided in ball arithmetic."""
    for p in range(2, 8):
        every = solve(representatives(p), Stadium(a))
        orbits = solve_admissible(every.words, Stadium(a), every=False)
        kept = every.status != Status.DYNAMICAL
        for name in ("status", "margin", "iterations"):
            assert (getattr(orbits, name) == getattr(every, name)).all(), name
        for name in ("coordinates", *NUMBERS):
            one, other = getattr(orbits, name), getattr(every, name)
            assert np.array_equal(one[kept], other[kept], equal_nan=True), name
            assert name == "margin" or np.isnan(one[~kept]).all(), name


@pytest.mark.parametrize("a", slow_but([0.2], [1e-4, 0.2, 0.5, 1.6, 5.0]))
def test_newton_reaches_the_same_orbit_from_any_start(a):
    """The starts are random in the allowed ranges, as in the paper's test of uniqueness."""
    rng = np.random.default_rng(11)
    for p in range(2, 9):
        for _, legs in cut(representatives(p)):
            found = newton(legs, a).alpha
            error = own_errors(legs, a, found)
            low, high = direction_limits(legs, a)
            for _ in range(5):
                again = newton(legs, a, start=rng.uniform(low, high))
                assert ((again.iterations > 0) & (again.iterations < MAX_STEPS)).all()
                allowed = error + own_errors(legs, a, again.alpha)
                assert (np.abs(again.alpha - found) <= allowed).all()


def own_errors(legs: Legs, a: float, alpha: np.ndarray) -> np.ndarray:
    """Return bounds on the distance of directions from the maximum."""
    slopes = derivatives(legs, a, alpha)
    return direction_errors(legs, a, alpha, slopes)


@pytest.mark.parametrize("word", ["13", "0103", "0103155", "12" + "02" * 3 + "31" * 40 + "3"])
def test_responses_solve_the_equations_and_do_not_move_pressed_directions(word):
    ((_, legs),) = cut(from_strings([word]))
    alpha, m = newton(legs, 1.6).alpha, len(legs.k)
    slopes, rng = derivatives(legs, 1.6, alpha), np.random.default_rng(2)
    forces, pressed = rng.normal(size=(2, m, 1)), rng.random((m, 1)) < 0.3
    minus_h = np.diag(slopes.between_centres[:, 0])
    for run in range(m):  # each run couples the leg before it to the leg after it
        tie = np.zeros(m)
        tie[run - 1], tie[run] = legs.parity[run - 1, 0], 1
        minus_h += slopes.stiffness[run, 0] * np.outer(tie, tie)
    moved = responses(legs, slopes, pressed, *forces)[:, :, 0]
    assert (moved[:, pressed[:, 0]] == 0).all()
    free = np.flatnonzero(~pressed[:, 0])
    expected = np.linalg.solve(minus_h[np.ix_(free, free)], forces[:, free, 0].T).T
    np.testing.assert_allclose(moved[:, free], expected, rtol=1e-12, atol=1e-13)


def test_an_empty_batch_can_be_solved():
    orbits = solve(np.zeros((0, 5), dtype=np.uint8), Stadium())
    assert len(orbits) == 0
    assert orbits.coordinates.shape == (0, 5)


@pytest.mark.parametrize("a", slow_but([1e-6, 1e6], [1e-6, 0.1, 1.6, 1e6]))
def test_random_words_of_two_thousand_bounces_are_solved(a):
    """An overflow would cause a warning, and every warning is an error."""
    for seed in range(4):
        word = random_word(seed, 2000)
        assert rules_of(word) == []
        orbits = solve(from_strings([word]), Stadium(a))
        assert orbits.status[0] in (Status.ORBIT, Status.DYNAMICAL)
        assert np.isfinite(orbits.coordinates).all()


def test_a_hundred_thousand_bounces_on_each_semicircle_are_solved():
    """The orbit creeps along the boundary and is almost as long as the perimeter."""
    word = parse("1^100000 2 5^100000 0")
    orbits = solve(from_strings([word]), Stadium(1.6))
    assert orbits.status[0] == Status.ORBIT
    assert orbits.residual[0] < 1e-13
    assert orbits.length[0] == pytest.approx(Stadium(1.6).perimeter, rel=1e-8)
    assert orbits.length[0] < Stadium(1.6).perimeter
    assert orbits.error[0] < 1e-8
    first, last = orbits.coordinates[0, 0], orbits.coordinates[0, 99_999]
    assert first == pytest.approx(-last, abs=1e-12)
    assert np.abs(np.diff(orbits.coordinates[0, :100_000]) - (last - first) / 99_999).max() < 1e-13


def test_words_can_be_in_different_stadiums():
    """The maximum of each word is the same, bit for bit, as in a batch with only its own stadium."""
    _, legs = cut(words_of(6))[1]
    a = np.geomspace(0.1, 9.0, len(legs))
    together = newton(legs, a)
    for i in range(0, len(legs), 20):
        alone = newton(legs.chain(np.array([i])), float(a[i]))
        assert np.array_equal(together.alpha[:, i], alone.alpha[:, 0])
        assert together.iterations[i] == alone.iterations[0]


def test_every_status_has_a_sentence():
    """Each sentence contains a key phrase."""
    said = {"orbit": "unstable", "geometric": "at any a", "dynamical": "at this a", "boundary": "joint",
            "family": "bouncing-ball", "unresolved": "not decided"}  # fmt: skip
    assert {*said} == {*Status}
    assert all(said[status] in status.sentence for status in Status)


A = [1.0, 1.6, pytest.param(0.05, marks=pytest.mark.slow), pytest.param(20.0, marks=pytest.mark.slow)]


@pytest.mark.parametrize("a", A)
def test_exponents_equal_those_of_the_full_solution(a):
    for p in (2, 6, 8):
        words = representatives(p)
        orbits, stadium = solve(words, a), Stadium(a)
        found = list(exponents(pack(words), p, stadium))
        for name, status in (("orbits", "orbit"), ("boundary", "boundary"), ("unresolved", "unresolved")):
            places = np.concatenate([getattr(part, name) for part in found])
            assert sorted(places) == np.flatnonzero(orbits.status == status).tolist()
        for part in found:
            np.testing.assert_allclose(part.length, orbits.length[part.orbits], rtol=1e-14)
            np.testing.assert_allclose(part.lyapunov, orbits.lyapunov[part.orbits], rtol=1e-13)


@pytest.mark.parametrize("a", A)
def test_rough_directions_never_prune_an_orbit(a):
    rng, told = np.random.default_rng(7), 0
    words = representatives(7)
    status = solve(words, a).status
    for rows, legs in cut(words):
        low, high = direction_limits(legs, a)
        for share in (0.0, 0.5, 1.0, *rng.random((20, *low.shape))):
            alpha = low + share * (high - low)
            outside = decide(legs, a, alpha).status == "dynamical"
            assert (status[rows][outside] == "dynamical").all()
            told += outside.sum()
    assert told or a == 20.0
