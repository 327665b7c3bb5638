"""Edge words: their rules, their symmetries, and the codes they stand for."""

import math

import numpy as np
import pytest
from edges import code_of, edge_words, edges_of, text_of
from quick import slow_but
from solutions import words_of

from orbitdb.entropy.windows import (
    MAY_FOLLOW,
    MIRROR,
    REVERSAL,
    geometric_entropy,
    reverse,
)
from orbitdb.symbols.words import least_rotation, primitive_root, to_strings


def left_right(code: str) -> str:
    return code.translate(str.maketrans("1345", "3154"))


@pytest.mark.parametrize("p", slow_but(range(2, 7), range(2, 8)))
def test_codes_and_edge_words_say_the_same(p):
    words = words_of(p)
    edges = edge_words(words)
    assert MAY_FOLLOW[edges, np.roll(edges, -1, axis=1)].all()
    for code, word in zip(to_strings(words), edges, strict=True):
        back = primitive_root(code_of(text_of(word)))
        assert least_rotation(code) in {least_rotation(back), least_rotation(left_right(back))}
        assert code in (back, left_right(back))  # beginning with the same bounce


def test_one_code():
    assert edges_of("1232131") == "aAaAXXU"
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
def test_symmetries_keep_the_rules(turn):
    assert (turn[turn] == np.arange(9)).all()
    follow = MAY_FOLLOW[np.ix_(turn, turn)]
    assert (follow == (MAY_FOLLOW if turn is MIRROR else MAY_FOLLOW.T)).all()


def test_reversal_is_that_of_the_code():
    word = edge_words(np.array([[1, 2, 0, 3, 3, 2, 0, 2]], dtype=np.uint8))
    backwards = edge_words(np.array([[2, 0, 2, 5, 5, 0, 2, 1]], dtype=np.uint8))
    assert (reverse(word)[0] == np.roll(backwards[0], 1)).all()
