"""The enclosure of the topological entropy: forbidden windows, growth rates, and the bounds."""

import math
from decimal import Decimal, localcontext
from itertools import pairwise, product

import numpy as np
import pytest
from edges import edge_words, texts_of
from hypothesis import given, settings
from hypothesis import strategies as st
from quick import fuzz_but, slow_but
from solutions import words_of

from orbitdb.averages.by_period import entropy_of_counts
from orbitdb.billiard.stadium import Stadium
from orbitdb.entropy_bounds.bounds import FORBIDDEN, UNDECIDED, search
from orbitdb.entropy_bounds.growth import TOLERANCE, automaton, growth
from orbitdb.entropy_bounds.verdicts import Verdict, decide_windows
from orbitdb.entropy_bounds.windows import (
    MIRROR,
    Windows,
    extended,
    first_windows,
    geometric_entropy,
    letters_of,
    reverse,
)
from orbitdb.orbits.solve import solve
from orbitdb.orbits.status import Status
from orbitdb.symbols.edges import MAY_FOLLOW

EDGE_WORDS = np.array(
    [word for word in product(range(9), repeat=5) if all(MAY_FOLLOW[x, y] for x, y in pairwise(word))],
    dtype=np.uint8,
)


def holds(word: tuple[int, ...], pattern: tuple[int, ...]) -> bool:
    size = len(pattern)
    return any(word[i : i + size] == pattern for i in range(len(word) - size + 1))


@settings(max_examples=settings().max_examples // 2)
@given(st.data())
def test_the_automaton_finds_patterns_their_mirror_images_and_reversals(data):
    size = st.integers(1, 4)
    start = st.integers(0, len(EDGE_WORDS) - 1)
    drawn = [
        (EDGE_WORDS[data.draw(start)][None, : data.draw(size)], data.draw(st.sampled_from([1, 2])))
        for _ in range(data.draw(st.integers(0, 5)))
    ]
    found = automaton(drawn)
    sought: dict[tuple[int, ...], int] = {}
    for words, kind in drawn:
        for one in (words, MIRROR[words], reverse(words), reverse(MIRROR[words])):
            sought[tuple(one[0])] = sought.get(tuple(one[0]), 0) | kind
    expected = []
    for word in map(tuple, EDGE_WORDS):
        kinds = 0
        for pattern, kind in sought.items():
            kinds |= kind * holds(word, pattern)
        expected.append(kinds)
    assert (found.patterns_in(EDGE_WORDS) == expected).all()
    avoiding = sum(1 for kinds in expected if not kinds)
    assert paths(*found.edges(3), len(found), found.first >> 1, (found.matches & 3) == 0) == avoiding


def paths(origin, target, states, first, free) -> int:
    """Count the words of five letters that an automaton accepts, from its steps."""
    reach = np.zeros(states, dtype=np.int64)
    np.add.at(reach, first[free[first]], 1)
    for _ in range(4):
        there = np.zeros_like(reach)
        np.add.at(there, target, reach[origin])
        reach = there
    return int(reach.sum())


@settings(max_examples=30)
@given(st.integers(1, 8), st.lists(st.tuples(st.integers(0, 7), st.integers(0, 7)), max_size=20, unique=True))
def test_the_growth_bounds_enclose_the_spectral_radius(states, steps):
    steps = [(i % states, j % states) for i, j in steps]
    matrix = np.zeros((states, states))
    for i, j in steps:
        matrix[i, j] += 1
    origin, target = (np.array([step[k] for step in steps], dtype=np.int32) for k in (0, 1))
    found = growth(origin, target, states)
    reached = np.linalg.matrix_power(np.eye(states) + matrix, states) > 0
    radius = max(abs(np.linalg.eigvals(matrix * (reached & reached.T))))  # simple in each component
    if radius < 0.5:  # nilpotent: no cycle
        assert found.lower == found.upper == -math.inf
    else:
        assert found.lower <= math.log(radius) + 1e-9
        assert found.upper >= math.log(radius) - 1e-9
        assert found.upper - found.lower < 1e-8


def test_the_growth_rate_is_enclosed_at_every_step(monkeypatch):
    """After the first step, the bounds are the numbers of steps from a state, not to a state."""
    steps = [(0, 1), (0, 3), (1, 2), (1, 0), (2, 0), (3, 0)]
    origin, target = (np.array([step[k] for step in steps], dtype=np.int32) for k in (0, 1))
    exact = growth(origin, target, 4)
    monkeypatch.setattr("orbitdb.entropy_bounds.growth.MAX_STEPS", 1)
    first = growth(origin, target, 4)
    assert (first.lower, first.upper) == pytest.approx((0, math.log(2)))
    assert first.lower < exact.lower <= exact.upper < first.upper


def test_growth_bounds_are_rounded_outward():
    """The golden mean, ln 2 and ln 3 are known to forty digits, with doubles on either side."""
    with localcontext() as context:
        context.prec = 40
        golden, two, three = ((1 + Decimal(5).sqrt()) / 2).ln(), Decimal(2).ln(), Decimal(3).ln()
    loop = [(0, 0)]
    for steps, states, exact in (
        ([*loop, (0, 1), (1, 0)], 2, golden),
        (loop * 2, 1, two),
        (loop * 3, 1, three),
    ):
        origin, target = (np.array([step[k] for step in steps], dtype=np.int32) for k in (0, 1))
        found = growth(origin, target, states)
        assert Decimal(repr(found.lower)) < exact < Decimal(repr(found.upper))
        assert found.upper - found.lower < 2 * TOLERANCE


def patterns(a: float, edges: int) -> list[tuple[np.ndarray, int]]:
    """Return the forbidden windows up to a given length, and the undecided windows of that length."""
    windows, found = first_windows(), []
    while True:
        decision = decide_windows(windows, a)
        found.append((windows.letters[decision.verdict == Verdict.FORBIDDEN], FORBIDDEN))
        undecided = decision.verdict == Verdict.UNDECIDED
        windows, at_left = windows.rows(undecided), decision.extend_left[undecided]
        if windows.edges == edges:
            return [*found, (windows.letters, UNDECIDED)]
        windows = extended(windows, at_left)


LONGEST = pytest.mark.parametrize("longest", [8, pytest.param(11, marks=pytest.mark.slow)])
"""Highest period of the words and number of edges in the windows."""


@LONGEST
@pytest.mark.parametrize("a", fuzz_but([0.2, 1.6], [0.2, 0.5, 1.0, 1.6, 3.0, 10.0]))
@pytest.mark.slow
def test_orbits_avoid_forbidden_windows_and_allowed_windows_make_orbits(a, longest):
    seeking = automaton(patterns(a, longest))
    orbits, counted = np.zeros((2, longest + 1), dtype=np.int64)
    for p in range(2, longest + 1):
        words = words_of(p)
        seen = seeking.patterns_in(np.tile(edge_words(words), (1, longest // p + 2)))
        status = solve(words, Stadium(a)).status
        real = (status == Status.ORBIT) | (status == Status.BOUNDARY)
        assert not (real & (seen & FORBIDDEN > 0)).any()
        assert (status[seen == 0] == Status.ORBIT).all()
        orbits[p], counted[p] = (status == Status.ORBIT).sum(), (seen == 0).sum()
    assert 0 < counted[-1] <= orbits[-1]
    if longest > 8 and a >= 1:  # below a = 1 the zeta function has no usable zero
        within = list(search(Stadium(a), edges=12))[-1]
        off = np.abs(entropy_of_counts(orbits).h_zeta - (within.lower + within.upper) / 2)
        assert off[-1] < off[-4] / 2


@pytest.mark.parametrize(("edges", "width", "most"), slow_but(1, [(11, 4e-3, 7000), (14, 6.2e-4, 34_000)]))
def test_bounds_at_the_usual_a_agree_with_longer_windows(edges, width, most):
    """Windows have 14 letters; 1.1588534 < h < 1.1588558 is from a compiled program with 23 letters."""
    found = list(search(Stadium(1.6), edges=edges))
    assert [level.edges for level in found] == list(range(2, edges + 1))
    lower, upper = [level.lower for level in found], [level.upper for level in found]
    assert (np.diff(lower) >= -1e-9).all()
    assert (np.diff(upper) <= 1e-9).all()
    assert upper[0] == pytest.approx(geometric_entropy(), abs=1e-9)
    assert lower[-1] < 1.1588534
    assert upper[-1] > 1.1588558
    assert upper[-1] - lower[-1] < width
    assert found[-1].windows < most


def test_the_search_ends_at_the_given_width_or_time():
    wide = list(search(Stadium(1.6), width=0.05))
    assert wide[-1].upper - wide[-1].lower <= 0.05 < wide[-2].upper - wide[-2].lower
    assert len(list(search(Stadium(1.6), seconds=1e-9))) == 1


@pytest.mark.parametrize(
    ("levels_take", "seconds", "done"),
    [
        ([1, 1], 2.79, 1),  # the second is expected to take 1.8 s
        ([1, 1], 2.81, 2),
        ([1, 2, 9], 6.9, 2),  # growing like the last two
        ([1, 1, 1], 3.29, 2),  # growing by at least 1.3
        ([1, 1, 1], 3.31, 3),
        ([0.04, 1, 1], 2.83, 2),  # short times say nothing about growth
        ([0.04, 1, 1], 2.85, 3),
        ([0.06, 0.18, 1], 0.77, 2),
        ([0.06, 0.18, 1], 0.79, 3),
    ],
)
def test_a_level_is_not_started_if_it_would_exceed_the_time(monkeypatch, levels_take, seconds, done):
    clock, left = [0.0], iter([*levels_take, 100.0])

    def decider(*work):
        clock[0] += next(left)
        return decide_windows(*work)

    monkeypatch.setattr("orbitdb.entropy_bounds.bounds.time.monotonic", lambda: clock[0])
    assert len(list(search(Stadium(1.6), seconds=seconds, decider=decider))) == done


def test_there_are_bounds_at_extreme_a():
    for a in (1e-6, 1e6):
        found = list(search(Stadium(a), edges=5))[-1]
        assert 0 <= found.lower <= found.upper <= geometric_entropy() + 1e-9


def test_extended_windows_keep_their_mark():
    windows = Windows(letters_of("UX")[None], np.array([1]))
    assert texts_of(extended(windows, np.array([True]))) == ["UU|X", "XU|X", "AU|X", "BU|X"]
    assert texts_of(extended(windows, np.array([False]))) == ["U|XU", "U|XD", "U|XX", "U|Xa", "U|Xb"]


@pytest.mark.parametrize(("name", "value"), [("MAX_WINDOW", 6), ("MOST_UNDECIDED", 100)])
def test_the_search_ends_at_its_size_limits(monkeypatch, name, value):
    monkeypatch.setattr(f"orbitdb.entropy_bounds.bounds.{name}", value)
    *before, last = search(Stadium())
    size = {"MAX_WINDOW": "edges", "MOST_UNDECIDED": "undecided"}[name]
    assert getattr(before[-1], size) <= value <= getattr(last, size)
    assert (last.edges == value) == (name == "MAX_WINDOW")


def test_progress_counts_the_windows_of_each_length():
    told: dict[str, tuple[float, float]] = {}
    found = list(search(Stadium(1.6), 6, tell=lambda done, total, text: told.setdefault(text, (done, total))))
    for bounds, count in zip(found, np.diff([0, *(each.windows for each in found)]), strict=True):
        assert told[f"{bounds.edges} letters"] == (0, count)
        assert told[f"{bounds.edges} letters: growth rates"] == (0, 0)
