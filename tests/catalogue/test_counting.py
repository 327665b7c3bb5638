"""Counts by period, whose divisors can come from any source."""

import pytest
from quick import slow_but

from orbitdb import Catalogue

SOURCES = {
    "births": lambda catalogue: catalogue.fill_births("2-6"),
    "sweep": lambda catalogue: catalogue.sweep("2-6"),
    "fill": lambda catalogue: catalogue.fill("2-6"),
    "all three": lambda catalogue: (
        catalogue.fill("2-2"),
        catalogue.sweep("3-3"),
        catalogue.fill_births("5,6"),
        catalogue.fill("4-4"),
    ),
}
"""Functions that count periods 2 to 6; each period has only one source, so that no other can replace it."""


@pytest.fixture(scope="module", params=slow_but(["all three"], SOURCES))
def known(request, tmp_path_factory):
    """A catalogue at a = 1 with the counts of periods 2 to 6."""
    catalogue = Catalogue.create(tmp_path_factory.mktemp("counting") / "orbits.db", 1)
    SOURCES[request.param](catalogue)
    yield catalogue
    catalogue.close()


@pytest.fixture(scope="module")
def filled_table(tmp_path_factory):
    with Catalogue.create(tmp_path_factory.mktemp("counting") / "orbits.db", 1) as catalogue:
        catalogue.fill("2-6")
        return dict(catalogue.table().columns)


@pytest.mark.parametrize("p", slow_but([4], [4, 6]))
def test_the_row_of_a_period_is_the_same_alone_and_among_others(known, filled_table, p):
    """N is a sum over divisors of p, which need not be chosen."""
    one = known.table(p=p)
    assert {name: values[p - 2] for name, values in filled_table.items()} == {
        name: value for name, (value,) in one.columns.items()
    }
    assert None not in (one["N"][0], one["K_0"][0])


def test_all_sources_give_the_same_counts(known, filled_table):
    assert dict(known.table(p="2-6").columns) == filled_table


def test_sums_are_empty_if_a_divisor_is_missing(tmp_path):
    own = Catalogue.create(tmp_path / "orbits.db", 1)
    own.fill("4,6")
    found = own.table()
    assert found["N"] == found["K_0"] == [None, None]
    assert None not in found["N_c"]
    assert any("p = 6: N also needs p = 2, 3" in note for note in found.notes)
