"""Counts by period, which need their divisors from whatever source."""

import pytest

from orbitdb import Catalogue


@pytest.fixture(scope="module")
def known(tmp_path_factory):
    """Births of p = 2..6, sweeps of 2..6 at a = 1, fills of 2..6 at a = 2."""
    path = tmp_path_factory.mktemp("counting") / "orbits.db"
    with Catalogue.create(path) as catalogue:
        catalogue.fill_births("2-6")
        catalogue.sweep("2-6", a=1)
        catalogue.fill("2-6", a=2)
    return path


@pytest.mark.parametrize("a", [0.5, 1, 2], ids=["births", "sweep", "fill"])
@pytest.mark.parametrize("p", [4, 6])
def test_the_row_of_a_period_is_the_same_alone_and_among_others(known, a, p):
    """N sums over divisors, which need not be chosen."""
    catalogue = Catalogue(known, a)
    every, one = catalogue.table(p="2-6"), catalogue.table(p=p)
    row = dict(zip(every.columns, list(every.rows())[p - 2], strict=True))
    assert one["p"] == [p]
    assert {name: values[0] for name, values in one.columns.items()} == row
    assert None not in (row["N"], row["K_0"])


def test_all_sources_give_the_same_counts(known, tmp_path):
    own = Catalogue.create(tmp_path / "orbits.db", 1)
    own.fill("2-6")
    columns = dict(own.table().columns)
    assert dict(Catalogue(known, 1).table().columns) == columns
    assert dict(Catalogue(known).table(p="2-6", a=0.5).columns)["N_t"] == columns["N_t"]


def test_sums_are_empty_if_a_divisor_is_missing(tmp_path):
    own = Catalogue.create(tmp_path / "orbits.db", 1)
    own.fill("4,6")
    found = own.table()
    assert found["N"] == found["K_0"] == [None, None]
    assert None not in found["N_c"]
    assert any("p = 6: N needs p = 2, 3" in note for note in found.notes)
