"""The ids of words that are too long to pack into one."""

import numpy as np
import pytest
from contents import ask

from orbitdb import InputError
from orbitdb.catalogue import Catalogue
from orbitdb.filling.fill import fill_words
from orbitdb.store.file import migrate
from orbitdb.store.tables import LONG
from orbitdb.symbols.words import MAX_KEYED, keys_of_period, parse, primitive_root


def test_long_words_get_ids_in_order_of_arrival(tmp_path):
    """Ids of classes count up, and those of pruned words count down."""
    path = tmp_path / "orbits.db"
    migrate(path)
    words = [parse(text) for text in ("1^30 5^29", "1^31 5^29", "1^30 5^31")]
    broken = ["001" * 7 + "1", "0" * 29 + "1"]
    for word in (*words, words[0], *broken, broken[1]):
        fill_words(path, [word], 1.6)
    catalogue = Catalogue(path)
    assert len({catalogue[word].length for word in words}) == len(words)
    assert ask(path, "SELECT id FROM cycle ORDER BY id") == [(LONG,), (LONG + 1,), (LONG + 2,)]
    assert ask(path, "SELECT id, p FROM pruned ORDER BY id DESC") == [(-LONG, 22), (-LONG - 1, 30)]


def test_ids_of_long_words_are_above_those_of_all_periods():
    """So counting a period by its range of ids never includes a long word."""
    assert keys_of_period(MAX_KEYED)[1] < LONG


def test_words_of_any_length_sort_as_texts(tmp_path):
    """Words that begin alike are compared beyond the symbols that fit into one number."""
    catalogue = Catalogue.create(tmp_path / "orbits.db", 1.6)
    catalogue.fill("2-3")
    catalogue.fill(code=("1^10 3^10", "1^11 3^10", "1^30 5^29", "1^31 5^29", "0^25 1", "001"))
    codes = list(catalogue.select(status="all").code)
    assert list(catalogue.select(status="all", order="code").code) == sorted(codes) != codes
    assert list(catalogue.select(status="all", order="code desc").code) == sorted(codes)[::-1]


WORDS = ["0123", "02", "13", "1^30 5^29", "3^30 1^29", "0101", "1^40(02)^9 3", "31", "(0202)^9 0", "0^25 1"]
"""Orbits, dynamical and pruned words, some too long to pack, some in the same class; and the family."""


@pytest.fixture
def words():
    return [primitive_root(parse(word)) for word in WORDS]


def test_many_words_are_stored_as_one_by_one_in_a_single_transaction(tmp_path, words):
    together, alone = (Catalogue.create(tmp_path / f"{name}.db", 1.6) for name in ("together", "alone"))
    orbits = together.fill(code=words)
    one_by_one = [alone.fill(code=word)[0] for word in words]
    for one, other in zip(orbits, one_by_one, strict=True):
        np.testing.assert_array_equal(one.coordinates, other.coordinates)
        assert vars(one) | {"_coordinates": None} == vars(other) | {"_coordinates": None}
    assert [orbit.code for orbit in orbits] == words
    assert [orbit.stored for orbit in orbits] == [orbit.status != "family" for orbit in orbits]
    assert together.count(status="all") == alone.count(status="all")
    runs = "SELECT commits FROM run"
    assert [*together.sql(runs)] == [(1,)]
    assert len([*alone.sql(runs)]) > 4
    assert together.verify().sound


def test_many_words_are_found_as_one_by_one(tmp_path, words):
    catalogue = Catalogue.create(tmp_path / "orbits.db", 1.6)
    catalogue.fill(code=words[::2])
    found, alone = catalogue.find(words), [catalogue.find(word) for word in words]
    assert [orbit is None for orbit in found] == [orbit is None for orbit in alone]
    assert [*map(repr, found)] == [*map(repr, alone)]
    assert sum(orbit is None for orbit in found) == 4
    assert catalogue.find([]) == []
    assert catalogue.find(["13", "x"], errors="skip") == [catalogue.find("13")]


def test_words_that_are_stored_are_not_solved_again(tmp_path, words, monkeypatch):
    catalogue = Catalogue.create(tmp_path / "orbits.db", 1.6)
    before = catalogue.fill(code=words)
    size = catalogue.path.read_bytes()
    monkeypatch.setattr("orbitdb.filling.fill.solve_periods", None)
    after = catalogue.fill(code=words)
    assert [*map(repr, after)] == [*map(repr, before)]
    assert catalogue.path.read_bytes() == size


def test_nothing_is_stored_if_a_code_is_wrong_unless_such_codes_are_skipped(tmp_path):
    catalogue = Catalogue.create(tmp_path / "orbits.db", 1.6)
    codes = ["13", "1", "0123", "1313", "7"]
    with pytest.raises(InputError, match=r"^3 of 5 words cannot be read: word 2: 1 has one symbol.*word 4: "):
        catalogue.fill(code=codes)
    assert len(catalogue) == 0
    assert [orbit.code for orbit in catalogue.fill(code=codes, errors="skip")] == ["13", "0123"]
    assert "0123" in catalogue
