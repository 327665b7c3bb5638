"""The geometric rules against a naive second reading of the paper's appendix."""

from itertools import product

import numpy as np
import pytest
from quick import slow_but
from rules import broken_by_hand

from orbitdb.symbols.pruning import FAMILY, rule_numbers, rules_broken, rules_of
from orbitdb.symbols.words import SYMBOLS, from_strings


@pytest.mark.parametrize("p", slow_but(range(1, 5), range(1, 7)))
def test_every_word_breaks_the_rules_it_breaks_by_hand(p):
    words = ["".join(symbols) for symbols in product(SYMBOLS, repeat=p)]
    masks = rules_broken(from_strings(words))
    assert [rule_numbers(int(mask)) for mask in masks] == [broken_by_hand(word) for word in words]


@pytest.mark.parametrize(
    ("word", "numbers"),
    [
        ("1232131", []),
        ("13", []),
        (FAMILY, [3]),
        ("1001", [1, 3, 6]),
        ("134", [2, 5]),
        ("1013", [4]),
        ("13553", [5]),
        ("1021 3", [6]),
        ("1020 4 4 3", [6]),
        ("3202023 1", [6]),
        ("111", [3]),
    ],
)
def test_known_words(word, numbers):
    assert rules_of(word.replace(" ", "")) == numbers


def test_no_words_break_no_rules():
    assert rules_broken(np.zeros((0, 6), dtype=np.uint8)).shape == (0,)
