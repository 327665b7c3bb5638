"""Questions that nobody waits for any more end, whenever that is, and so do those overtaken by a fill."""

import itertools
from contextlib import closing

import pytest

from orbitdb.filling.periods import fill_geometric
from orbitdb.store.asking.selection import Selection
from orbitdb.store.reading.catalogue import Catalogue
from orbitdb.store.reading.index_reading import load_index
from orbitdb.store.reading.pages import CancelledError, chosen_keys
from orbitdb.store.reading.standings import Standing, load_standings


@pytest.mark.parametrize(
    ("criteria", "column"),
    [
        pytest.param({}, "length", marks=pytest.mark.slow),
        pytest.param({"where": "length > 9"}, "p", marks=pytest.mark.slow),
        pytest.param({"where": "code like '%13%'"}, "p", marks=pytest.mark.slow),
        ({"contains": "13"}, "code"),
        ({"where": "code like '%13%' or p = 4"}, "p"),
        ({}, "element"),
    ],
)
def test_a_question_ends_wherever_it_is_cancelled(varied, criteria, column):
    with closing(Catalogue(varied)) as catalogue:
        index, selection = load_index(catalogue, 1.6), Selection(1.6, **criteria)
        looks = itertools.count()
        whole = chosen_keys(catalogue, index, selection, column, cancelled=lambda: next(looks) < 0)
        asked = next(looks)
        assert asked > 0
        assert len(whole) == catalogue.count(selection)
        for n in range(asked):
            index.last_values.clear()
            looks = itertools.count()
            with pytest.raises(CancelledError):
                chosen_keys(catalogue, index, selection, column, cancelled=lambda c=looks, n=n: next(c) >= n)


def test_rows_stored_behind_an_index_are_not_half_listed(varied, tmp_path):
    path = tmp_path / "orbits.db"
    path.write_bytes(varied.read_bytes())
    with closing(Catalogue(path)) as catalogue:
        index = load_index(catalogue, 1.6)
        for _ in fill_geometric(path, [4]):
            pass
        with pytest.raises(CancelledError):
            chosen_keys(catalogue, index, Selection(1.6), "element")


def test_without_births_nothing_is_said_of_lives(varied):
    with closing(Catalogue(varied)) as catalogue:
        standings = load_standings(catalogue, load_index(catalogue, 1.6))
    assert {Standing(each) for each in standings.at(1.6)} == {Standing.UNKNOWN, Standing.GEOMETRIC}
    assert not standings.known.any()


def test_signs_that_are_no_symbols_choose_nothing_and_words_behind_the_last_are_nowhere(filled_once):
    with closing(Catalogue(filled_once)) as catalogue:
        index = load_index(catalogue, 1.6)
        assert not len(chosen_keys(catalogue, index, Selection(1.6, where="code LIKE '%7%'")))
        everything = chosen_keys(catalogue, index, Selection(1.6), "code")
        last = index.word(int(everything[len(everything) - 1 :][0]))
        few = chosen_keys(catalogue, index, Selection(1.6, periods=((2, 2),)), "code")
        assert everything.position(last) == len(everything) - 1
        assert few.position(last) is None
