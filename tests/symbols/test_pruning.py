"""The geometric rules against a naive second reading of the paper's appendix."""

from itertools import product

import numpy as np
import pytest
from quick import slow_but
from rules import broken_by_hand

from orbitdb.symbols.pruning import rule_numbers, rules_broken
from orbitdb.symbols.words import SYMBOLS, from_strings


@pytest.mark.parametrize("p", slow_but(range(1, 5), range(1, 7)))
def test_every_word_breaks_the_rules_it_breaks_by_hand(p):
    words = ["".join(symbols) for symbols in product(SYMBOLS, repeat=p)]
    masks = rules_broken(from_strings(words))
    assert [rule_numbers(int(mask)) for mask in masks] == [broken_by_hand(word) for word in words]


def test_no_words_break_no_rules():
    assert rules_broken(np.zeros((0, 6), dtype=np.uint8)).shape == (0,)
