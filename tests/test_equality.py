"""Records with arrays are compared by value, and equal records have equal hashes."""

import dataclasses
import importlib
import pickle
import pkgutil
from dataclasses import replace

import numpy as np
import pytest
from there import there

import orbitdb
from orbitdb import Catalogue, Orbit, Selection, solve, solve_word
from orbitdb.billiard.legs import Chain, cut
from orbitdb.equality import ByValue
from orbitdb.quantum.levels import LevelWindow
from orbitdb.quantum.weyl import Parity
from orbitdb.symbols.words import from_strings


def _records():
    """Return the public dataclasses of the package that have an array field."""
    for found in pkgutil.walk_packages(orbitdb.__path__, "orbitdb."):
        if found.name.startswith(("orbitdb.migrations", "orbitdb.cli.tui", "orbitdb.plots")):
            continue
        for name, kind in vars(importlib.import_module(found.name)).items():
            public = isinstance(kind, type) and dataclasses.is_dataclass(kind) and not name.startswith("_")
            if public and kind.__module__ == found.name and any(map(_is_array, dataclasses.fields(kind))):
                yield kind


def _is_array(field):
    kind = str(field.type)
    return "Callable" not in kind and any(
        name in kind for name in ("NDArray", "ndarray", "Floats", "Integers", "Texts")
    )


def test_no_public_name_is_also_a_module():
    """Importing the module would replace the name."""
    assert not {found.name for found in pkgutil.iter_modules(orbitdb.__path__)} & set(orbitdb.__all__)


def test_every_public_record_with_arrays_is_compared_by_value():
    kinds = list(_records())
    assert {"Orbits", "Subset", "OrbitClasses"} <= {kind.__name__ for kind in kinds}
    records = [
        kind for kind in kinds if kind.__eq__ is not object.__eq__ and kind is not Orbit
    ]  # others compare by identity
    assert [kind for kind in records if not issubclass(kind, ByValue)] == []
    assert all(kind.__eq__ is ByValue.__eq__ and kind.__hash__ is ByValue.__hash__ for kind in records)


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


def test_batches_are_compared_bit_by_bit():
    one = solve(from_strings(["1232131", "0103155"]), 1.6)
    moved = one.coordinates.copy()
    moved[1, 3] = np.nextafter(moved[1, 3], 1)
    assert one == replace(one, coordinates=one.coordinates.copy())
    assert one != replace(one, coordinates=moved)
    zero, minus = (replace(one, margin=np.full(2, value)) for value in (0.0, -0.0))
    assert zero != minus


def test_parts_of_a_batch_join_in_order():
    ((_, legs),) = cut(from_strings(["0103", "1232", "0123"]))
    parts = [legs.chain(np.array(rows, np.intp)) for rows in ([2], [], [0, 1])]
    assert Chain.joined(parts) == legs.chain(np.array([2, 0, 1]))


def test_nan_equals_nan_at_the_same_position():
    one = solve(from_strings(["1232131", "0103155"]), 1.6)
    odd = np.frombuffer(np.array([0xFFF8000000000001] * 2, dtype=np.uint64).tobytes(), dtype=float)
    here, there = np.array([np.nan, 1.0]), np.array([1.0, np.nan])
    assert replace(one, margin=here) == replace(one, margin=here.copy())
    assert replace(one, margin=here) != replace(one, margin=there)
    assert len({replace(one, margin=nan) for nan in (odd, np.full(2, np.nan))}) == 1


def test_subsets_and_classes_with_the_same_contents_are_equal(varied):
    catalogue, again = Catalogue(varied), Catalogue(varied)
    for ask in (
        lambda each, **more: each.select(p="2-4", coordinates=True, **more),
        lambda each, **more: each.classes(p="2-4", **more),
        lambda each, **more: each.classes(p="2-4", **more),
    ):
        assert ask(catalogue) == ask(again)
        assert hash(ask(catalogue)) == hash(ask(again))
        assert ask(catalogue) != ask(again, length=(None, 11.0))
    assert len({Selection(), Selection(), Selection(ranges={"length": (3.0, None)})}) == 2


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


@pytest.mark.parametrize("change", [{"a": 1.5}, {"low": 0.5}, {"high": 8.0}, {"below": 1}])
def test_records_that_differ_in_one_number_are_unequal(change):
    one = LevelWindow(1.6, Parity("ee"), 0.0, 9.0, 0, np.ones(2), np.zeros(2))
    assert replace(one) == one != replace(one, **change)
