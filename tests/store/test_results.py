"""Results by period: what the library gives, commands print, and rows alone would give."""

from collections import Counter
from itertools import product

import numpy as np
import pytest
from rules import broken_by_hand

from orbitdb import Catalogue, InputError
from orbitdb.symbols.words import SYMBOLS


@pytest.fixture
def catalogue(filled_once):
    return Catalogue(filled_once, a=1.6)


def test_table_1_of_the_paper(catalogue):
    found = catalogue.table()
    assert found["N_c"] == [1, 8, 32, 80, 188, 376, 1424]
    assert found["N"] == [2, 24, 130, 400, 1154, 2632, 11522]
    assert found.to_pandas()["N_t"].tolist() == [1, 8, 32, 96, 252, 712, 2096]


def test_fills_count_the_words_that_break_each_rule(catalogue):
    for fill in catalogue.fills()[:4]:
        texts = ["".join(symbols) for symbols in product(SYMBOLS, repeat=fill.p)]
        words = [w for w in texts if all(w < w[i:] + w[:i] for i in range(1, fill.p))]
        broken = Counter(rule for word in words for rule in broken_by_hand(word))
        assert (fill.primitive, fill.pruned) == (len(words), tuple(broken[rule] for rule in range(1, 7)))


def test_rows_of_a_subset_give_what_the_catalogue_gives(catalogue):
    chosen = catalogue.select(p="2-8", status="orbit")
    entropies, averages = catalogue.entropy(p="2-8"), catalogue.lyapunov(p="2-8")
    for name in ("p", "N", "K_0", "h_zeta"):
        assert chosen.entropy()[name] == entropies[name]
    found = chosen.averages()
    for name in found.columns:
        np.testing.assert_allclose(_numbers(found[name]), _numbers(averages[name]), rtol=1e-14, atol=1e-15)
    assert chosen.table()["N_c"] == catalogue.table()["N_c"]


def test_a_part_of_the_rows_is_averaged_without_sum_rules(catalogue):
    chosen = catalogue.select(p="2-8", status="orbit")
    found = chosen[chosen.length < 14].averages()
    assert set(found["lambda_d_sum_rule"]) == {None}
    assert any("part" in note for note in found.notes)
    assert found["lambda_d"][0] == catalogue.lyapunov(p=2)["lambda_d"][0]


def test_what_is_missing_is_said(catalogue):
    found = catalogue.entropy(p="7-12")
    assert any("not filled" in note for note in found.notes)
    assert found["h_zeta"] == [None, None]
    assert len(catalogue.entropy(p=12)) == 0
    with pytest.raises(InputError, match="exp or det"):
        catalogue.lyapunov(weight="none")


def test_a_result_shows_itself(catalogue):
    found = catalogue.table(p="2-4")
    assert repr(found).splitlines()[0].split() == list(found.columns)
    assert "<table>" in found._repr_html_()


def _numbers(values):
    return np.array([np.nan if value is None else value for value in values], dtype=float)
