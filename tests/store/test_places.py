"""Where words are among the rows, which classes are born together, and that every broken rule is named."""

import json

import pytest
from contents import alter

from orbitdb import Catalogue, Selection
from orbitdb.store.file import reading
from orbitdb.store.select import Words, count, row_key_of, row_keys_of, rows_at, rows_of
from orbitdb.verification.verify import PROMISES

ORDERS = ["p", "-p", "code desc", "area", "-length,code", "-length", "symmetry,-lambda_c", "rules"]
CRITERIA = [{}, {"contains": "13"}, {"status": "all"}, {"p": "2-30", "status": "orbit,geometric"}]


@pytest.mark.parametrize("by_class", [False, True])
@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("criteria", CRITERIA)
def test_the_keys_of_rows_are_those_of_the_rows_in_order(awkward_once, order, criteria, by_class):
    chosen = Selection.from_criteria(a=1.6, **{"p": "3-6", **criteria})
    with reading(awkward_once) as connection:
        words = Words(chosen, order, by_class)
        rows = list(rows_of(connection, words, ("code", "length", "coordinates")))
        keys = row_keys_of(connection, words)
        assert len(keys) == len(rows) == count(connection, chosen, by_class)
        part = slice(len(rows) // 3, len(rows) // 3 + 40)
        assert rows_at(connection, words, ("code", "length", "coordinates"), keys[part]) == rows[part]
        for number in range(0, len(rows), 37):
            assert row_key_of(connection, words, rows[number][0]) == keys[number].item()
        assert row_key_of(connection, words, "13" if criteria.get("p") is None else "0123012301231") is None


def test_classes_born_together_have_one_period(awkward_once):
    """The events of each period have numbers of their own."""
    catalogue = Catalogue(awkward_once, 1.6)
    lives = {life.word: life for life in catalogue.births(6)}
    in_order = [life.born or 0.0 for life in lives.values()]
    assert in_order == sorted(in_order)
    partners = {
        word: catalogue.born_with(catalogue.orbit(word, exists=True)) for word in ("011032", "010255")
    }
    for word, born in partners.items():
        for a, others in born:
            assert {len(other) for other in others} == {6}
            assert [lives[other].born for other in others] == pytest.approx([a] * len(others), rel=1e-9)
        assert born[0][0] == lives[word].born
        subset = catalogue.select(p=6, status=(), where="code = representative")
        orbit = subset[subset.code.tolist().index(word)]
        assert catalogue.born_with(orbit) == born
        assert orbit.exists == catalogue.orbit(word).exists


def test_every_broken_rule_is_named(awkward, cli):
    """The made-up death breaks one rule, and these lengths another."""
    alter(awkward, "UPDATE orbit SET length = length + 0.001 WHERE stadium = 2")
    done = cli("verify", "--a", "0.3", "--p", "2-3", "--json")
    broken = [row["check"] for row in json.loads(done.out) if row["failures"]]
    assert done.code == 1
    assert len(broken) > 1
    assert [line for line in done.err.splitlines() if "some rows break" in line] == [
        f"{name}: some rows break this rule: {PROMISES[name]}" for name in broken
    ]
