"""Edge words and windows: rules, symmetries, codes, and verdicts that no word contradicts."""

import math
from dataclasses import dataclass
from itertools import compress

import numpy as np
import pytest
from edges import code_of, edge_words, text_of, texts_of, windows_of
from hypothesis import example, given, settings
from hypothesis import strategies as st
from quick import slow_but
from solutions import words_of

from orbitdb.billiard.legs import cut, half_turns, slacks
from orbitdb.entropy_bounds import verdicts
from orbitdb.entropy_bounds.verdicts import Verdict, corner, decide_windows, solve_corner
from orbitdb.entropy_bounds.windows import (
    IN_RUN,
    MIRROR,
    REVERSAL,
    STARTS_LEG,
    Windows,
    geometric_entropy,
    open_chains,
    reverse,
)
from orbitdb.orbits.newton import newton
from orbitdb.symbols.edges import MAY_FOLLOW, X
from orbitdb.symbols.words import from_strings, least_rotation, primitive_root, to_strings


def left_right(code: str) -> str:
    return code.translate(str.maketrans("1345", "3154"))


@pytest.mark.parametrize("p", slow_but(range(2, 7), range(2, 8)))
def test_codes_and_edge_words_are_equivalent(p):
    words = words_of(p)
    edges = edge_words(words)
    assert MAY_FOLLOW[edges, np.roll(edges, -1, axis=1)].all()
    for code, word in zip(to_strings(words), edges, strict=True):
        back = primitive_root(code_of(text_of(word)))
        assert least_rotation(code) in {least_rotation(back), least_rotation(left_right(back))}
        assert code in (back, left_right(back))  # starting at the same bounce


def test_edge_words_have_the_expected_codes():
    assert text_of(edge_words(from_strings(["1232131"]))[0]) == "aAaAXXU"
    assert code_of("aAaAXXU") == "1232131"
    assert code_of("X") == "13"
    assert code_of("UaAXX") == "11231" + "33213"


def test_geometric_entropy_is_the_growth_rate_of_all_edge_words():
    rate = math.log(max(abs(np.linalg.eigvals(MAY_FOLLOW))))
    assert rate == pytest.approx(geometric_entropy(), abs=1e-13)
    z = math.exp(-geometric_entropy())
    assert z**3 + z**2 + 3 * z < 1  # rounded upward
    assert 1.2187557 < geometric_entropy() < 1.2187558


@pytest.mark.parametrize("turn", [MIRROR, REVERSAL], ids=["mirror", "reversal"])
def test_symmetries_preserve_the_rules(turn):
    assert (turn[turn] == np.arange(9)).all()
    follow = MAY_FOLLOW[np.ix_(turn, turn)]
    assert (follow == (MAY_FOLLOW if turn is MIRROR else MAY_FOLLOW.T)).all()


def test_reversing_edge_words_reverses_the_code():
    word = edge_words(np.array([[1, 2, 0, 3, 3, 2, 0, 2]], dtype=np.uint8))
    backwards = edge_words(np.array([[2, 0, 2, 5, 5, 0, 2, 1]], dtype=np.uint8))
    assert (reverse(word)[0] == np.roll(backwards[0], 1)).all()


LENGTHS = (0.05, 1.6)


@dataclass(frozen=True)
class Junctions:
    """Conditions at the end of each run, at the maximum of the length of cyclic words, orbit or not.

    `holds` is the smaller slack of the run's end and the leg's start. `value` is h + d o if this is
    the condition and the run has several bounces. Both have shape (N, p) and are NaN elsewhere.
    """

    holds: np.ndarray
    value: np.ndarray

    @classmethod
    def of(cls, words: np.ndarray, a: float) -> "Junctions":
        holds, value = np.full(words.shape, np.nan), np.full(words.shape, np.nan)
        for rows, legs in cut(words):
            alpha = newton(legs, a).alpha
            slack = slacks(legs, alpha)
            least = np.minimum(slack[1], slack[2])
            rising = (legs.k > 1) & (legs.s != legs.d)
            f = np.where(rising, half_turns(legs, alpha) + legs.d * alpha, np.nan)
            run, place, straight = legs.bounces
            runs = np.where(straight, 0, run)
            last = ~straight & (place == np.take_along_axis(legs.k, runs, axis=0) - 1)
            bounce, word = np.nonzero(last)
            holds[rows[word], bounce] = least[run[bounce, word], word]
            value[rows[word], bounce] = f[run[bounce, word], word]
        return cls(holds, value)


def stretches(words: np.ndarray, before: int, after: int) -> tuple[Windows, np.ndarray, np.ndarray]:
    """Cut windows around all junctions of a run and a leg; return them with their words and bounces."""
    edges = edge_words(words)
    row, bounce = np.nonzero(STARTS_LEG[edges])
    letters = edges[row[:, None], (bounce[:, None] + np.arange(-before, after)) % words.shape[1]]
    meant = IN_RUN[letters[:, before - 1]] | (letters[:, before] != X)  # one bounce before X has no condition
    marks = np.full(meant.sum(), before, dtype=np.intp)
    return Windows(letters[meant], marks), row[meant], bounce[meant]


def ranges(windows: Windows, a: float) -> tuple[np.ndarray, np.ndarray]:
    """Return bounds on f over all continuations; f increases with both pushes."""
    low, high = np.empty(len(windows)), np.empty(len(windows))
    for rows, chains in open_chains(windows):
        exact = np.zeros(len(chains))
        least = solve_corner(corner(chains, a, -chains.sense, -chains.lean), a, exact)
        most = solve_corner(corner(chains, a, chains.sense, chains.lean), a, exact)
        low[rows], high[rows] = least.value - least.error, most.value + most.error
    return low, high


def check(words: np.ndarray, a: float, extents: list[tuple[int, int]]) -> np.ndarray:
    """Check that no window contradicts the words; return the number of windows with each verdict."""
    junctions = Junctions.of(words, a)
    counts = np.zeros(3, dtype=int)
    for before, after in extents:
        windows, row, bounce = stretches(words, before, after)
        verdict = decide_windows(windows, a).verdict
        holds, value = junctions.holds[row, bounce], junctions.value[row, bounce]
        low, high = ranges(windows, a)
        wrong = ((verdict == Verdict.ALLOWED) & (holds <= 0)) | (
            (verdict == Verdict.FORBIDDEN) & (holds >= 0)
        )
        wrong |= (value < low - 1e-12) | (value > high + 1e-12)
        assert not wrong.any(), (a, list(compress(texts_of(windows), wrong)))
        assert ((verdict == Verdict.ALLOWED) == (low > 0)).all()
        assert ((verdict == Verdict.FORBIDDEN) == (high < 0)).all()
        counts += np.bincount(verdict, minlength=3)
    return counts


@pytest.mark.parametrize("a", slow_but([1.6], LENGTHS))
def test_no_word_contradicts_a_window(a):
    """Verdicts and the range of f are checked around every junction of all words of up to six bounces."""
    extents = [(1, 1), (2, 3), (1, 5), (5, 2), (4, 6)]
    counts = np.sum([check(words_of(p), a, extents) for p in (2, 3, 4, 5, 6)], axis=0)
    assert counts.min() > 30


@st.composite
def edge_cycles(draw: st.DrawFn) -> str:
    """Draw a cyclic edge word with runs and legs of any length, mostly short ones."""
    word = ""
    sizes = st.sampled_from([0, 0, 0, 1, 1, 2, 3, 8, 40])
    for _ in range(draw(st.integers(1, 5))):
        word += draw(st.sampled_from("UD")) * draw(sizes)
        walls = draw(sizes)
        top = draw(st.booleans())
        heights = ("wv" if top else "vw") * walls
        if walls:
            inner = heights[: walls - 1]
            ends_on_top = top == (walls % 2 == 1)
            word += ("a" if top else "b") + inner + ("A" if ends_on_top else "B")
        else:
            word += "X"
    return word


@pytest.mark.slow
@settings(max_examples=25)
@given(edge_cycles(), st.floats(0.02, 20), st.integers(1, 6), st.integers(1, 6))
@example("U" * 40 + "X", 1.6, 3, 2)
def test_no_long_word_contradicts_a_window(edges, a, before, after):
    check(from_strings([code_of(edges)]), a, [(before, after), (1, after), (before, 1), (12, 12)])


def test_verdicts_hold_for_the_flattest_legs():
    """Whispering runs press a leg of one wall flat, to the end of the range of a cut leg."""
    for edges, extent in (("U" * 200 + "aA" + "D" * 200 + "X", (195, 1)), ("U" * 40 + "aADDDDDXX", (6, 12))):
        check(from_strings([code_of(edges)]), 1.6, [extent])


def test_conditions_are_within_their_errors():
    """Rough directions change f by no more than its error bound."""
    words = words_of(7)
    windows, _, _ = stretches(words, 8, 8)
    for a in (0.1, 1.6):
        for _, chains in open_chains(windows):
            pushed = corner(chains, a, chains.sense, -chains.lean)
            exact = solve_corner(pushed, a, np.zeros(len(chains)))
            for enough in (1.0, 1e-2, 1e-4):
                rough = solve_corner(pushed, a, np.full(len(chains), enough))
                assert (np.abs(rough.value - exact.value) <= rough.error + exact.error).all()


def test_windows_too_close_to_call_are_undecided(monkeypatch):
    """If f has a rounding error of 0.2, windows whose f comes within 0.2 of 0 are undecided."""
    windows, _, _ = stretches(words_of(6), 4, 4)
    low, high = ranges(windows, 1.6)
    plain = decide_windows(windows, 1.6).verdict
    assert (decide_windows(windows, 1.6, size=100).verdict == plain).all()
    monkeypatch.setattr(verdicts, "ROUNDING", 0.2)
    rough = decide_windows(windows, 1.6).verdict
    assert (rough[(low < 0.2) & (high > -0.2)] == Verdict.UNDECIDED).all()
    assert {*plain[rough != plain]} == {Verdict.ALLOWED, Verdict.FORBIDDEN}


def test_windows_are_cut_into_legs():
    (_, chains), *_ = open_chains(windows_of("wBUUXDD|bvAU"))
    assert len(chains.k) == 4  # two entire legs, and one at each end
    assert chains.k[1:, 0].tolist() == [3, 3, 2]
    assert chains.d[1:, 0].tolist() == [1, -1, 1]
    assert chains.n[:, 0].tolist() == [2, 0, 2, 0]
    assert chains.s[:, 0].tolist() == [1, 0, -1, 0]
    assert chains.marked.tolist() == [2]
