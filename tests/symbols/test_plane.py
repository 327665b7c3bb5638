"""The symbol plane: gamma and delta by hand, under the symmetries, and blocks of symbols as intervals."""

import itertools
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from solutions import words_of
from there import there

from orbitdb import solve_word, symbol_plane
from orbitdb.symbols.symmetry import ELEMENTS, MIRROR_X, MIRROR_Y, REVERSE, act_on_words
from orbitdb.symbols.words import WordError, from_strings, to_strings

ALL = {p: words_of(p) for p in range(2, 9)}
admissible = st.sampled_from([word for p in range(2, 9) for word in to_strings(ALL[p])])

PIECE = {"0": "bottom", "1": "left", "2": "top", "3": "right", "4": "left", "5": "right"}


def test_gamma_and_delta_by_hand():
    """0123 goes round clockwise: from 0 to the left, where the digits 3/5, 0/2, 1/5 and 1/2 recur.

    Its reverse 0321 begins with a 0 that goes to the right, and mirrors it.
    """
    recurring = Fraction(63, 99)
    gamma = Fraction(2, 3) + recurring / 3
    ((first, *_),) = symbol_plane(from_strings(["0123"]))
    assert first.tolist() == pytest.approx([float(gamma), float(1 - gamma)], abs=1e-14)  # 27 letters
    assert symbol_plane(from_strings(["13"])).tolist() == [[[pytest.approx(0.5)] * 2] * 2]


@given(admissible, st.sampled_from(ELEMENTS))
def test_symmetries_act_on_the_plane(word, g):
    """One mirror turns it by half a turn, two leave it as it is, and time reversal swaps gamma and delta."""
    words = from_strings([word])
    (points,), (image,) = symbol_plane(words), symbol_plane(act_on_words(g, words))
    if bool(g & MIRROR_X) != bool(g & MIRROR_Y):
        points = 1 - points
    if g & REVERSE:
        points = points[::-1, ::-1]
    np.testing.assert_allclose(image, points, rtol=0, atol=1e-14)


@given(admissible, st.integers(1, 7))
def test_points_belong_to_bounces_in_any_rotation_and_repetition(word, shift):
    words = from_strings([word])
    points = symbol_plane(words)
    np.testing.assert_array_equal(symbol_plane(np.roll(words, shift, axis=1)), np.roll(points, shift, axis=1))
    np.testing.assert_array_equal(symbol_plane(np.tile(words, 2)), np.tile(points, (1, 2, 1)))


@pytest.mark.slow
@pytest.mark.parametrize("steps", [1, 2, 3, 4])
@pytest.mark.parametrize("past", [False, True])
def test_a_block_of_symbols_is_an_interval(steps, past):
    """Sorted by gamma, bounces with the same next bounces follow one another; so do runs up and down."""
    words = ALL[8]
    number = symbol_plane(words)[..., int(past)]
    ways: dict[str, list[tuple[float, tuple[str, ...]]]] = {}
    for word, values in zip(to_strings(words), number.tolist(), strict=True):
        for n, value in enumerate(values):
            path = [word[(n - k if past else n + k) % 8] for k in range(steps + 1)]
            block = tuple(
                f"{PIECE[after]} {after if PIECE[now] == PIECE[after] else ''}"
                for now, after in itertools.pairwise(path)
            )
            ways.setdefault(PIECE[path[0]], []).append((value, block))
    for points in ways.values():
        blocks = [block for _, block in sorted(points)]
        changes = sum(one != two for one, two in itertools.pairwise(blocks))
        assert changes == len(set(blocks)) - 1 > 1


def test_pruned_words_have_no_points():
    with pytest.raises(WordError, match="pruned by rule 4"):
        symbol_plane(from_strings(["1013"]))
    assert solve_word("1013", 1.6).symbol_plane is None
    dynamical = solve_word("01132", 1.6)
    assert dynamical.status == "dynamical"
    assert there(dynamical.symbol_plane).shape == (5, 2)


def test_points_follow_the_given_rotation():
    one, other = solve_word("1232131", 1.6), solve_word("3112321", 1.6)
    np.testing.assert_array_equal(np.roll(there(one.symbol_plane), 2, axis=0), there(other.symbol_plane))
