"""What somebody tries first in Python: it works, or says in one line what is wrong."""

import numpy as np
import pytest

from orbitdb import Catalogue, Stadium, solve_word
from orbitdb.errors import InputError
from orbitdb.orbits.newton import solve
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
def test_any_number_is_a_half_length(a):
    assert solve_word("13", a).length == 8.0
    assert Stadium(a) == Stadium(1.0)


@pytest.mark.parametrize("a", [-1, 0, np.nan, np.inf, "1.6", True, 1j, [1.6], np.ones(2), 10**400])
def test_what_is_no_half_length_is_refused(catalogue, a):
    for ask in (Stadium, lambda a: solve_word("13", a), lambda a: solve(from_strings(["13"]), a),
                lambda a: catalogue.select(a=a), lambda a: Catalogue(catalogue.path, a)):  # fmt: skip
        with pytest.raises(InputError, match=r"^a = .* is not a half length: give a number from 1e-06 to"):
            ask(a)


@pytest.mark.parametrize("key", [5, 0, None, b"13", ["13"], slice(2, 5), np.int64(13)], ids=repr)
def test_what_is_no_text_is_no_key(catalogue, key):
    assert key not in catalogue
    for ask in (
        catalogue.__getitem__,
        lambda key: catalogue.find(key, 1.6),
        lambda key: solve_word(key, 1.6),
    ):
        with pytest.raises(TypeError, match=r"^a code is a text such as '1232131', not "):
            ask(key)


@pytest.mark.parametrize(
    "words",
    [["13"], "13", np.array([1, 3]), np.array([[1.0, 3.0]]), np.array([[1, 9]]), np.array([[-1, 3]]),
     from_strings(["1001"]), from_strings(["02"]), from_strings(["11"]), from_strings(["1"])],
    ids=repr,
)  # fmt: skip
def test_words_that_cannot_be_solved_are_refused(words):
    with pytest.raises(InputError, match="word"):
        solve(words, 1.6)


def test_a_subset_is_named_by_criteria_or_a_selection(catalogue):
    assert catalogue.count(p=3, status="orbit") == len(catalogue.select(p=3, status="orbit")) == 8
    for ask in (catalogue.select, catalogue.classes, catalogue.count, catalogue.partial):
        with pytest.raises(TypeError, match="name a subset by criteria such as p=3"):
            ask("p = 3")
