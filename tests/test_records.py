"""Orbits and selections are compared by value; records with arrays have short reprs."""

import pickle
import pkgutil
from dataclasses import replace

import numpy as np
import pytest
from same import same
from there import there

import orbitdb
from orbitdb import Catalogue, Selection, solve, solve_word
from orbitdb.billiard.legs import Chain, cut
from orbitdb.symbols.words import from_strings


def test_no_public_name_is_also_a_module():
    """Importing the module would replace the name."""
    assert not {found.name for found in pkgutil.iter_modules(orbitdb.__path__)} & set(orbitdb.__all__)


@pytest.mark.parametrize("word", ["13", "1232131", "1001", "1111111111111111111102020202023"])
def test_equal_orbits_are_the_same_key(word):
    one, same = solve_word(word, 1.6), solve_word(word, 1.6)
    assert one == same == pickle.loads(pickle.dumps(one)) == replace(one, stored=True)
    assert len({one, same, solve_word(word[1:] + word[0], 1.6), solve_word(word, 1.7)}) == 2
    assert one != word


def test_coordinates_of_an_orbit_are_read_only():
    one = solve_word("1232131", 1.6)
    for orbit in (one, pickle.loads(pickle.dumps(one)), replace(one, stored=True)):
        with pytest.raises(ValueError, match="read-only"):
            there(orbit.coordinates)[0] = 0.0


def test_parts_of_a_batch_join_in_order():
    ((_, legs),) = cut(from_strings(["0103", "1232", "0123"]))
    parts = [legs.chain(np.array(rows, np.intp)) for rows in ([2], [], [0, 1])]
    assert same(Chain.joined(parts), legs.chain(np.array([2, 0, 1])))


def test_selections_are_equal_by_value():
    assert Selection() == Selection() != Selection(ranges={"length": (3.0, None)})
    assert len({Selection(), Selection(), Selection(a=1.5)}) == 2


def test_records_with_large_arrays_have_a_one_line_repr(filled):
    catalogue = Catalogue(filled, a=1.6)
    found = (
        catalogue.identify(start=(0, 0.001, 0)),
        catalogue.spectrum(),
        solve(from_strings(["13", "31"]), 1.6),
    )
    for record in found:
        assert "\n" not in repr(record)
        assert repr(record).startswith((f"{type(record).__name__}(", "<"))
        assert len(repr(record)) < 1000
