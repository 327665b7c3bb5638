"""Common first attempts in Python, and the errors for unsuitable names, expressions and files."""

import sqlite3
from contextlib import closing
from itertools import permutations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from orbitdb import Catalogue, Stadium, solve_word
from orbitdb.criteria import parse_range, parse_ranges
from orbitdb.display import load
from orbitdb.errors import InputError, SelectionError
from orbitdb.orbits.solve import solve
from orbitdb.selection import Selection
from orbitdb.store.sqlite import plain_errors
from orbitdb.store.where import check
from orbitdb.symbols.words import from_strings


@pytest.fixture(scope="module")
def catalogue(varied):
    return Catalogue(varied)


@pytest.mark.parametrize("a", [1.6, np.float64(1.6), Stadium(1.6), Stadium(np.float64(1.6))], ids=repr)
def test_a_stadium_may_be_given_by_its_a(a):
    assert solve_word("1232131", a) == solve_word("1232131", Stadium())
    assert solve(from_strings(["13", "31"]), a).length.tolist() == [10.4, 10.4]
    assert type(solve_word("13", a).a) is float


@pytest.mark.parametrize("a", [1, np.int64(1), np.float32(1), np.longdouble(1)], ids=repr)
def test_any_type_of_number_is_a_half_length(a):
    assert solve_word("13", a).length == 8.0
    assert Stadium(a) == Stadium(1.0)


@pytest.mark.parametrize("a", [-1, 0, 1e-7, 1e7, np.nan, np.inf, "1.6", True, 1j, [1.6], np.ones(2), 10**400])
def test_bad_half_lengths_are_refused(catalogue, a):
    for call in (Stadium, lambda a: solve_word("13", a), lambda a: solve(from_strings(["13"]), a),
                lambda a: catalogue.select(a=a), lambda a: Catalogue(catalogue.path, a)):  # fmt: skip
        told = r"^a = .* is not a half length: give a number from 1e-06 to 1e|^give one a here; rows"
        with pytest.raises(InputError, match=told):
            call(a)


@pytest.mark.parametrize("key", [5, 0, None, b"13", ["13"], slice(2, 5), np.int64(13)], ids=repr)
def test_keys_must_be_text(catalogue, key):
    assert key not in catalogue
    for call in (
        catalogue.__getitem__,
        lambda key: catalogue.find([key], a=1.6),
        lambda key: solve_word(key, 1.6),
    ):
        with pytest.raises(InputError, match=r"give a string|^a code is a string such as '1232131', not "):
            call(key)


@pytest.mark.parametrize(
    "words",
    [np.array([1, 3]), np.array([[1.0, 3.0]]), np.array([[1, 9]]), np.array([[-1, 3]]),
     from_strings(["1001"]), from_strings(["02"]), from_strings(["11"]), from_strings(["1"])],
    ids=repr,
)  # fmt: skip
def test_words_that_cannot_be_solved_are_refused(words):
    with pytest.raises(InputError, match=r"word|symbol '7'|give '13'"):
        solve(words, 1.6)


def test_a_subset_is_given_by_criteria_or_a_selection(catalogue):
    assert catalogue.count(p=3, status="orbit") == len(catalogue.select(p=3, status="orbit")) == 8
    for call in (catalogue.select, catalogue.classes, catalogue.count, catalogue.table):
        with pytest.raises(InputError, match="choose a subset by criteria such as p=3"):
            call("p = 3")
    with pytest.raises(SelectionError, match="not both"):
        catalogue.select(Selection(), p=3)


LOW, HIGH = st.floats(0, 9), st.floats(10, 20)
ENDS = st.tuples(LOW, HIGH) | st.tuples(LOW, st.none()) | st.tuples(st.none(), HIGH)


@given(st.lists(ENDS, min_size=1, max_size=3))
def test_the_tightest_of_several_bounds_apply(ends):
    low = max((low for low, _ in ends if low is not None), default=None)
    high = min((high for _, high in ends if high is not None), default=None)
    for order in permutations(ends):
        texts = [
            f"length={'' if least is None else least}:{'' if most is None else most}" for least, most in order
        ]
        assert parse_ranges(texts) == {"length": (low, high)}


def test_more_ranges_of_periods_than_sqlite_can_compare_are_refused(catalogue):
    with pytest.raises(SelectionError, match="1499 ranges, more than 100"):
        catalogue.count(p=range(2, 3000, 2))
    assert catalogue.count(p=range(2, 202, 2)) == sum(catalogue.count(p=p) for p in (2, 4, 6, 12))


@pytest.mark.parametrize("text", ["length=:", "length=3", "length=nan:", "length=:x"])
def test_a_range_needs_a_numeric_bound(text):
    with pytest.raises(SelectionError, match="write it as length=3:10, length=3: or length=:10"):
        parse_range(text)


def test_an_unterminated_string_is_quoted_as_typed():
    with pytest.raises(SelectionError) as error:
        check("code = '013", {})
    assert str(error.value) == """where "code = '013": unrecognized token: "'013\""""


def test_an_interrupted_question_raises_keyboard_interrupt(tmp_path):
    """SQLite reports the interrupt as an error of its own."""
    with closing(sqlite3.connect(":memory:")) as plain:
        plain.create_function("stop", 0, plain.interrupt)
        endless = "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n) SELECT stop() FROM n"
        with pytest.raises(KeyboardInterrupt), plain_errors(tmp_path / "orbits.db"):
            plain.execute(endless).fetchall()


def test_a_missing_module_of_this_package_is_not_taken_for_an_extra():
    with pytest.raises(ModuleNotFoundError, match=r"No module named 'orbitdb\.nothing'"):
        load("orbitdb.nothing", "nothing", "plots")
