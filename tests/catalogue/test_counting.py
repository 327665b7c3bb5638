"""Counts by period, whose divisors can come from any source."""

import json

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


def test_counts_by_columns_are_those_of_the_command_and_the_table(varied, cli):
    catalogue = Catalogue(varied, 1.6)
    asked = ("--p", "2-6", "--status", "all", "--by", "p,status", "--a", "1.6", "--db", str(varied), "--json")
    rows = [tuple(row.values()) for row in json.loads(cli("count", *asked).out)]
    found = catalogue.count(p="2-6", status="all", by="p,status")
    assert [*found.rows()] == rows
    of_orbits = [words for _, status, words, _ in rows if status == "orbit"]
    assert of_orbits == catalogue.table(p="2-6")["N_c"]
    assert sum(row[2] for row in rows) == catalogue.count(p="2-6", status="all")
    assert [*catalogue.count(p="2-6", by="p,status").rows()] == rows
    unnamed = [text for text in asked if text not in ("--status", "all")]
    geometric = cli("count", *unnamed, "--where", "status = 'geometric'")
    assert [*json.loads(geometric.out)[0].values()] == [3, "geometric", 62, 62]
    assert (catalogue.count(code="001"), catalogue.count(code=["001", "013"])) == (1, 2)
    every = catalogue.count(p=3, by=["status"], status="orbit", a=[1.6, 1.0])
    assert [*every.rows()] == [(1.6, "orbit", 8, 2), (1.0, "orbit", 8, 2)]
    listed = json.loads(
        cli("count", "--p", "3", "--status", "orbit", "--a", "all", "--db", str(varied), "--json").out
    )
    assert listed == [{"a": 1.0, "words": 8, "classes": 2}, {"a": 1.6, "words": 8, "classes": 2}]


def test_a_period_that_is_not_filled_has_no_count_but_a_note(varied, cli):
    none = cli("count", "--p", "9", "--a", "1.6", "--db", str(varied))
    assert none.says(1, "period 9 is not filled at a = 1.6")
    assert len(Catalogue(varied, 1.6).count(p=9, by="p")) == 0
    assert cli("count", "--by", "p,p", "--db", str(varied)).says(2, "column 'p' is named twice")
