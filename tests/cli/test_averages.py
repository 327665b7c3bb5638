"""`lyapunov` with sum rules and `simulate --legwise`, as a user calls them."""

import json
import re
import sqlite3
from contextlib import closing

import pytest

from orbitdb.cli.render import with_error

KEYS = [f"lambda_{kind}_sum_rule{end}" for end in ("", "_error") for kind in ("d", "c")]
LAMBDA_D, LAMBDA_C = 0.8867858, 0.3752123


def test_sum_rules_stand_beside_the_other_averages(filled, cli):
    found = cli("lyapunov", "--json", "--db", str(filled))
    rows = json.loads(found.out)
    assert [row["p"] for row in rows] == list(range(2, 9))
    for row in rows:
        assert list(row)[-4:] == KEYS
        assert abs(row["lambda_d_sum_rule"] - LAMBDA_D) < row["lambda_d_sum_rule_error"]
        assert abs(row["lambda_c_sum_rule"] - LAMBDA_C) < row["lambda_c_sum_rule_error"]
    assert (
        "by exact means, without any orbit: 0.840207 < lambda_d < 0.888388, 0.355504 < lambda_c" in found.err
    )


def test_periods_from_the_first_have_sum_rules(filled, cli):
    rows, all_rows = (
        json.loads(cli("lyapunov", *chosen, "--json", "--db", str(filled)).out)
        for chosen in (("--p", "2-6"), ())
    )
    assert rows == all_rows[:5]


@pytest.mark.parametrize(
    ("chosen", "said"),
    [
        (["--reversal", "self"], "not for a part of them"),
        (["--contains", "13"], "not for a part of them"),
        (["--status", "orbit,boundary"], "not for a part of them"),
        (["--p", "2,4-6"], "p = 3 is missing"),
    ],
)
def test_they_are_blank_for_a_part_of_the_orbits(filled, cli, chosen, said):
    found = cli("lyapunov", *chosen, "--json", "--db", str(filled))
    assert all(row[key] is None for row in json.loads(found.out) for key in KEYS)
    assert said in found.err


def test_a_class_number_that_is_no_words_is_told(filled, cli):
    with sqlite3.connect(filled) as connection:
        connection.execute("PRAGMA foreign_keys = OFF")
        (cycle,) = connection.execute("SELECT max(cycle) FROM orbit WHERE status = 'orbit'").fetchone()
        for table, column in (("cycle", "id"), ("orbit", "cycle")):
            connection.execute(f"UPDATE {table} SET {column} = {cycle | 7} WHERE {column} = {cycle}")
    connection.close()
    found = cli("lyapunov", "--db", str(filled))
    assert (found.code, found.out) == (3, "")
    assert "a class number that is no admissible word's" in found.err


@pytest.mark.parametrize("number", [1e-200, 1e200])
def test_an_impossible_number_is_told(filled, cli, number):
    with closing(sqlite3.connect(filled)) as connection, connection:
        connection.execute(
            "UPDATE orbit SET length = ? WHERE cycle = (SELECT max(cycle) FROM orbit WHERE status = 'orbit')",
            (number,),
        )
    found = cli("lyapunov", "--db", str(filled))
    assert (found.code, found.out) == (3, "")
    assert "impossible numbers among" in found.err


def test_legwise_trajectories_are_stored_and_shown(filled, cli):
    made = cli("simulate", "--legwise", "--bounces", "200000", "--json", "--db", str(filled))
    (row,) = json.loads(made.out)
    assert abs(row["lambda_d"] - LAMBDA_D) < 4 * row["lambda_d_error"] < 1e-4
    shown = json.loads(cli("lyapunov", "--json", "--db", str(filled)).out)[0]
    assert shown["lambda_d_trajectory"] == row["lambda_d"]


@pytest.mark.parametrize(
    ("error", "text"),
    [(3e-4, "0.886786 +- 0.000300"), (5.3e-7, "0.8867858 +- 0.0000005"), (0.0, "0.886786 +- 0.000000")],
)
def test_small_errors_are_shown_with_the_digits_they_need(error, text):
    assert with_error(0.8867858, error) == text


def test_legwise_trajectories_need_a_stadium_that_is_not_a_circle(cli):
    found = cli("simulate", "--legwise", "--a", "0.001", "--no-store")
    assert (found.code, found.out) == (2, "")
    assert "no known error" in found.err


@pytest.mark.parametrize("cut", ["0", "-1", "nan", "1000.1"])
def test_limits_of_a_cut(filled, cli, cut):
    done = cli("lyapunov", "--cut", cut, "--db", str(filled))
    assert (done.code, done.out) == (2, "")
    assert done.err == f"orbitdb: cut {float(cut):g}: give a lambda above 0 and up to 1000, such as 9\n"


def test_the_largest_cuts(filled, cli, monkeypatch):
    """Up to 1000 as they are; with determinants, up to so many factors, and what is advised is taken."""
    monkeypatch.setattr("orbitdb.cli.commands.averages._MOST_FACTORS", 600)
    chosen = ("lyapunov", "--p", "2-4", "--json", "--db", str(filled), "--cut")
    found, none = cli(*chosen, "1000"), cli(*chosen, "1e-7")
    assert json.loads(found.out)[0]["cut"] == 1000
    assert "no average" not in found.err
    assert json.loads(none.out)[0]["lambda_d_zeta"] is None
    assert "the zeta function gives no average (no orbit has a lambda up to 1e-07)" in none.err
    refused = cli(*chosen, "1000", "--weight", "det")
    assert (refused.code, refused.out) == (2, "")
    said = r"orbitdb: cut 1000 has too many terms with --weight det: give (\d+) or less\n"
    most = float(re.fullmatch(said, refused.err)[1])
    assert cli(*chosen, str(most), "--weight", "det").code == 0
    assert "too many terms" in cli(*chosen, str(1.2 * most), "--weight", "det").err


def test_weights_have_names(filled, cli):
    done = cli("lyapunov", "--weight", "x", "--db", str(filled))
    assert done == (2, "", "orbitdb: weight 'x': use exp or det\n")
