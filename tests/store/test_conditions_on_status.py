"""A condition that names the status, rules or births means every status, however it is written."""

import sqlite3
from contextlib import closing

import numpy as np
import pytest

from orbitdb.catalogue import Catalogue
from orbitdb.errors import SelectionError
from orbitdb.orbits.status import STORED
from orbitdb.selection import Selection

FORMS = [
    ("status = 'dynamical'", {}, False),
    ("STATUS == :status", {"status": "boundary"}, False),
    ("\"status\" in ('orbit', :other) -- born", {"other": "dynamical"}, False),
    ("'orbit' is catalogue.status and p = 3", {}, False),
    ("lower([status]) like 'dyn%'", {}, False),
    ("`status` is null", {}, False),
    ("status = 'orbit' and code like '0%'", {}, False),
    ("status = :s", {"s": "geometric"}, True),
    ("not status = 'dynamical'", {}, True),
    ("status <> 'orbit' and p < 5", {}, True),
    ("status = 'dynamical' or p < 4", {}, True),
    ("coalesce(code, '013') <> '013' and status like 'g%'", {}, True),
    ("rules like '%2%'", {}, True),
    ("born is null", {}, True),
    ("born < 1", {}, False),
]
"""Conditions, values of their names, and whether they may hold for pruned words."""

NAMES = ("code", "p", "status", "rules", "born")


@pytest.mark.parametrize(("where", "parameters", "pruned"), FORMS)
def test_a_condition_that_names_the_status_or_births_means_every_status(where, parameters, pruned, varied):
    catalogue = Catalogue(varied, 1.0)
    with closing(sqlite3.connect(":memory:")) as model:
        model.execute(f"CREATE TABLE catalogue ({', '.join(NAMES)})")
        for code, p, status, rules, born in catalogue.rows(columns=NAMES, status="all"):
            row = code, p, status, ",".join(map(str, rules)) or None if rules else None, born
            model.execute("INSERT INTO catalogue VALUES (?, ?, ?, ?, ?)", row)
        asked = f"SELECT code, status FROM catalogue WHERE (\n{where}\n) ORDER BY code"
        expected = [*model.execute(asked, parameters)]
    found = catalogue.rows(columns=("code", "status"), where=where, parameters=parameters, order="code")
    assert [*found] == expected
    assert any("geometrically pruned words" in note for note in found.notes) == pruned
    assert not pruned or "geometric" in dict(map(reversed, expected))


def test_names_in_texts_comments_and_values_do_not_choose_statuses(varied):
    catalogue = Catalogue(varied, 1.0)
    for where in ("p = :status", "code <> 'status' and p = 3", "p = 3 -- born", "p = 3 /* rules */"):
        parameters = {"status": 3} if ":" in where else {}
        assert len([*catalogue.rows(where=where, parameters=parameters)]) == catalogue.count(p=3)


@pytest.mark.parametrize("criteria", [{"time_reversal": "self"}, {"symmetry": "1"}, {"length": (0, 20)}])
def test_no_pruned_words_are_missing_where_they_cannot_be_chosen(criteria, varied):
    assert not any("pruned" in note for note in Catalogue(varied, 1.0).rows(status="all", **criteria).notes)


def test_a_random_condition_is_asked_of_every_pruned_word(varied):
    catalogue = Catalogue(varied, 1.0)
    every = catalogue.count(status="geometric")
    for _ in range(10):
        found = [*catalogue.rows(columns=("status",), status="all", where="random() < 0")]
        assert 0 < found.count(("geometric",)) < every


def test_a_dataset_has_the_pruned_words_that_a_condition_names(varied, tmp_path, cli):
    catalogue, asked = Catalogue(varied, 1.0), "rules is not null"
    every = catalogue.count(status="geometric")
    assert catalogue.write_dataset(tmp_path / "one", where=asked, a=1.0).words == every
    assert catalogue.write_dataset(tmp_path / "two", p=3, a=1.0).words == catalogue.count(p=3)
    done = cli(
        "export", str(tmp_path / "three"), "--dataset", "--where", asked, "--a", "1", "--db", str(varied)
    )
    assert done.err.splitlines()[-1].startswith(f"{every} words at a = 1")


def test_a_field_refuses_a_condition_that_only_pruned_words_fulfil(varied, cli):
    catalogue, refused = Catalogue(varied, 1.0), "geometrically pruned words cannot be followed"
    with pytest.raises(SelectionError, match=refused):
        catalogue.field(0.1, where="status = 'geometric'")
    asked = ("field", "--kappa", "0.1", "--a", "1", "--db", str(varied), "--where")
    assert cli(*asked, "rules > ''").says(2, refused)
    assert len(catalogue.field(0.1, where="status = 'geometric' or p = 3")) == catalogue.count(p=3)


def test_a_may_be_a_number_of_numpy(varied):
    chosen = Selection(a=np.float64(1.0), statuses=STORED, where="p = 3")
    assert Catalogue(varied).count(chosen) == Catalogue(varied, 1.0).count(p=3, status="all")


def test_averages_suggest_only_statuses_that_have_averages(varied):
    catalogue = Catalogue(varied, 1.0)
    asked = "status = 'boundary'"
    assert any("(`status='orbit,boundary'`)" in note for note in catalogue.entropy(where=asked).notes)
    found = catalogue.entropy(where=asked, status="orbit,boundary")
    assert found["N"][-1] == 6 * catalogue.count(where=asked)
    assert not any("other statuses" in note for note in catalogue.lyapunov(where="status like 'dyn%'").notes)
