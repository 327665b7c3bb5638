"""`columns`: what every column is, at any width."""

import json
from typing import cast

import pytest

from orbitdb.columns import GROUPS, IN_CATALOGUE

EVERY = [each for _, group in GROUPS for each in group]


@pytest.mark.parametrize("width", ["40", "80", "200"])
def test_a_table_tells_of_every_column_what_json_does(cli, monkeypatch, width):
    monkeypatch.setenv("COLUMNS", width)
    catalogue, others = cli("columns").out.split("\n\n")
    head, *lines = cast(list[str], [*catalogue.splitlines(), *others.splitlines()])
    unit, bound, means = (head.index(name) for name in ("unit", "bounded by", "means"))
    found: list[list[str]] = []
    for line in lines:
        cells = [line[:unit].strip(), line[unit:bound].strip(), line[bound:means].strip(), line[means:]]
        if cells[0]:
            found.append(cells)
        else:
            found[-1][3] += f" {cells[3]}"
    assert found == [[each.name, each.unit, each.bound, each.means] for each in EVERY]
    assert len(catalogue.splitlines()) - 1 - sum(
        not line[:unit].strip() for line in catalogue.splitlines()
    ) == (len(IN_CATALOGUE))
    assert max(map(len, lines)) <= max(int(width), means + 24)


def test_what_a_column_refers_to_can_be_asked_for(cli, filled):
    """The table that holds changes cannot."""
    told = {each["column"]: each for each in json.loads(cli("columns", "--json").out)}
    assert "the view 'life'" in told["born"]["means"]
    for name in ("born", "dies"):
        column, view = told[name]["bound"].split(" in ")
        assert cli("sql", f"SELECT {column} FROM {view}", "--json").out == "[]\n"  # no births are stored


def test_json_tells_all_of_it(cli):
    rows = json.loads(cli("columns", "--json").out)
    assert [list(row.values()) for row in rows] == [
        [each.name, of, each.kind, each.unit, each.bound, each.empty, each.means]
        for of, group in GROUPS
        for each in group
    ]
    assert list(rows[0]) == ["column", "of", "type", "unit", "bound", "empty", "means"]
