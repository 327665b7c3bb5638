"""Enumeration, counts and pruning, compared with brute force and with the transfer matrix."""

from functools import cache
from itertools import pairwise, product

import numpy as np
import pytest
from quick import slow_but
from rules import broken_by_hand
from solutions import words_of

from orbitdb.symbols.edges import count_by_edges
from orbitdb.symbols.enumeration import Span, class_spans, least_words, primitive_spans, primitive_words
from orbitdb.symbols.pruning import count_admissible, rule_numbers, rules_broken
from orbitdb.symbols.symmetry import class_of, class_size
from orbitdb.symbols.words import SYMBOLS, from_strings, to_strings, unpack


@cache
def lyndon_by_hand(p: int) -> list[str]:
    """Return all primitive words that are their own least rotation, in order."""
    words = ("".join(symbols) for symbols in product(SYMBOLS, repeat=p))
    return [w for w in words if all(w < w[i:] + w[:i] for i in range(1, p))]


def strings(chunks) -> list[str]:
    return [word for chunk in chunks for word in to_strings(chunk)]


@pytest.mark.parametrize("p", slow_but(range(1, 7), range(1, 8)))
def test_enumeration_agrees_with_brute_force(p):
    every = lyndon_by_hand(p)
    assert strings(primitive_words(Span.of_period(p))) == every
    assert [word for span in primitive_spans(p, 1) for word in strings(primitive_words(span))] == every
    assert to_strings(words_of(p)) == [word for word in every if not broken_by_hand(word)]


@pytest.mark.parametrize("p", slow_but(range(1, 6), range(1, 7)))
def test_counts_agree_with_brute_force_under_every_set_of_rules(p):
    broken = [set(broken_by_hand(word)) for word in lyndon_by_hand(p)]
    for bits in range(64):
        rules = frozenset(number for number in range(1, 7) if bits >> (number - 1) & 1)
        assert count_admissible(p, rules) == sum(not (numbers & rules) for numbers in broken), rules


def test_two_counts_that_share_nothing_agree():
    assert [count_by_edges(p) for p in range(1, 61)] == [count_admissible(p) for p in range(1, 61)]


def classes_in(span: Span) -> list[tuple[str, int]]:
    found = [(to_strings(unpack(part.codes, span.p)), part.stabiliser.tolist()) for part in least_words(span)]
    return [pair for words, stabilisers in found for pair in zip(words, stabilisers, strict=True)]


@pytest.mark.parametrize("p", slow_but(range(2, 7), range(2, 9)))
def test_least_words_are_the_representatives_of_all_words(p):
    named = ((word, class_of(word)) for word in to_strings(words_of(p)))
    expected = [(word, found.stabiliser) for word, found in named if found.representative == word]
    assert classes_in(Span.of_period(p)) == expected


@pytest.mark.parametrize("p", slow_but((11,), range(2, 15)))
def test_class_sizes_add_up_to_the_count_of_the_transfer_matrix(p):
    found = np.concatenate([part.stabiliser for part in least_words(Span.of_period(p))])
    count = np.bincount(found, minlength=256)
    assert sum(n * class_size(mask) for mask, n in enumerate(count.tolist()) if n) == count_admissible(p)


@pytest.mark.parametrize(("p", "size"), [(4, 1), (9, 100), pytest.param(11, 500, marks=pytest.mark.slow)])
def test_spans_contain_every_class_once(p, size):
    cut = list(class_spans(p, size))
    assert (cut[0].after, cut[-1].upto) == (-1, 8**p - 1)
    assert all(one.upto == other.after for one, other in pairwise(cut))
    parts, whole = [classes_in(span) for span in cut], classes_in(Span.of_period(p))
    assert [each for part in parts for each in part] == whole
    assert max(map(len, parts)) <= 1.5 * size + 100  # a prefix can have about a hundred
    half = len(whole) // 2
    after = class_spans(p, size, int(whole[half - 1][0], 8))  # the word itself is excluded
    assert [each for span in after for each in classes_in(span)] == whole[half:]


@pytest.mark.parametrize("p", slow_but(range(1, 5), range(1, 7)))
def test_broken_rules_agree_with_a_naive_search(p):
    words = ["".join(symbols) for symbols in product(SYMBOLS, repeat=p)]
    masks = rules_broken(from_strings(words))
    assert [rule_numbers(int(mask)) for mask in masks] == [broken_by_hand(word) for word in words]


def test_an_empty_batch_breaks_no_rules():
    assert rules_broken(np.zeros((0, 6), dtype=np.uint8)).shape == (0,)
