"""Patterns in packed words are those that SQLite, and a look at two rounds of a word, find."""

import sqlite3
from contextlib import closing

from hypothesis import given
from hypothesis import strategies as st

from orbitdb.symbols.patterns import Factor, Like
from orbitdb.symbols.words import from_strings, pack

words = st.integers(1, 20).flatmap(lambda p: st.lists(st.text("013", min_size=p, max_size=p), min_size=1))


@given(words, st.text("0134%_", max_size=8), st.booleans())
def test_texts_with_wildcards_are_those_of_sqlite(some, pattern, wanted):
    with closing(sqlite3.connect(":memory:")) as plain:
        likes = [plain.execute("SELECT ? LIKE ?", (word, pattern)).fetchone()[0] == wanted for word in some]
    like = Like(pattern, wanted)
    assert like.fitting(pack(from_strings(some)), len(some[0])).tolist() == likes
    assert list(map(like.fits, some)) == likes


@given(words, st.data())
def test_factors_are_found_across_the_end_and_in_two_rounds_at_most(some, data):
    least = [min(word[turn:] + word[:turn] for turn in range(len(word))) for word in some]
    longer = st.sampled_from(least).map(lambda word: 3 * word)
    start, size = data.draw(st.integers(0, 20)), data.draw(st.integers(1, 41))
    factor = Factor(data.draw(st.text("0134", min_size=1, max_size=4) | longer)[start % 4 :][:size] or "1")
    found = [factor.factor in 2 * word for word in least]
    assert list(map(factor.fits, least)) == found
    for rotation in (least, some):
        assert factor.fitting(pack(from_strings(rotation)), len(some[0])).tolist() == found
