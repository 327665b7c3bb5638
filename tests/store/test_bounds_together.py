"""Several bounds on the same measure all apply, in any order."""

import json
from itertools import permutations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from orbitdb.store.selection import parse_bounds

LOW, HIGH = st.floats(0, 9), st.floats(10, 20)
ENDS = st.tuples(LOW, HIGH) | st.tuples(LOW, st.none()) | st.tuples(st.none(), HIGH)


def written(end: float | None) -> str:
    return "" if end is None else repr(end)


@given(st.lists(ENDS, min_size=1, max_size=3))
def test_the_tightest_bounds_apply(ends):
    low = max((low for low, _ in ends if low is not None), default=None)
    high = min((high for _, high in ends if high is not None), default=None)
    for order in permutations(ends):
        texts = [f"length={written(least)}:{written(most)}" for least, most in order]
        assert parse_bounds(texts) == {"length": (low, high)}


@pytest.mark.parametrize("order", list(permutations(["length=11:", "length=12:", "length=:15"])))
def test_a_query_applies_all_bounds(cli, filled, order):
    ranges = [each for text in order for each in ("--range", text)]
    asked = ("query", "--status", "orbit", "--db", str(filled), "--json")
    rows = json.loads(cli(*asked, *ranges).out)
    assert rows == json.loads(cli(*asked, "--range", "length=12:15").out)
    assert all(12 <= row["length"] <= 15 for row in rows)
