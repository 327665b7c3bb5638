"""`lyapunov` with sum rules and `simulate --legwise`, as a user calls them."""

import contextlib
import io
import json
import math
import re
import sqlite3

import pytest

from orbitdb.cli.render import Format, write
from orbitdb.numerals import concise, with_error

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
    told = cli("lyapunov", "--db", str(filled)).err
    assert "by exact means, without any orbit: 0.840207 < lambda_d < 0.888388, 0.355504 < lambda_c" in told


@pytest.mark.parametrize(
    ("chosen", "said"),
    [
        (["--reversal", "self"], "not for a part of them"),
        (["--contains", "13"], "not for a part of them"),
        (["--status", "orbit,boundary"], "not for a part of them"),
        (["--p", "2,4-6"], "p = 3 is missing"),
        (["--p", "4-6"], "p = 2, 3 are missing"),
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


@pytest.mark.parametrize("value", ["NULL", "1e308"])
def test_a_lambda_that_no_orbit_has_is_told(filled, cli, value):
    with sqlite3.connect(filled) as connection:
        connection.execute(
            f"UPDATE orbit SET lyapunov = {value} WHERE length = (SELECT max(length) FROM orbit)"
        )
    connection.close()
    found = cli("lyapunov", "--db", str(filled))
    assert (found.code, found.out) == (3, "")
    assert "impossible numbers" in found.err


@pytest.mark.parametrize(
    ("error", "text"),
    [
        (1.115e-3, "0.886786 +- 1.2e-03"),
        (4.41e-6, "0.8867858 +- 4.5e-06"),
        (5.31e-7, "0.88678577 +- 5.4e-07"),
        (0.0, "0.886786 +- 0.0e+00"),
        (math.inf, "0.886786 +- inf"),
    ],
)
def test_errors_are_rounded_up_beside_the_digits_that_they_are_of(error, text):
    assert with_error(0.886785768, error) == text
    told = io.StringIO()
    with contextlib.redirect_stdout(told):
        write(("lambda_d", "lambda_d_error"), [(0.886785768, error)], Format.TABLE)
    assert told.getvalue().splitlines()[1].split() == text.split(" +- ")


def test_a_table_shows_all_methods_within_80_columns(filled, cli):
    rows = json.loads(cli("lyapunov", "--json", "--db", str(filled)).out)
    for name, block in zip(
        ("lambda_d", "lambda_c"), cli("lyapunov", "--db", str(filled)).out.split("\n\n"), strict=True
    ):
        head, *lines = block.splitlines()
        assert head.split()[:5] == ["p", name, "pair", "zeta", "sum_rule"]
        assert max(map(len, (head, *lines))) < 80
        for row, line in zip(rows[1:], lines[1:], strict=True):
            p, paper, pair, zeta, rule, *_ = line.split()
            shown = [int(p), float(paper), float(pair), float(zeta)]
            keys = ("p", name, f"{name}_pair", f"{name}_zeta")
            assert shown == pytest.approx([row[key] for key in keys], abs=1e-6)
            assert rule == concise(row[f"{name}_sum_rule"], row[f"{name}_sum_rule_error"])


@pytest.mark.parametrize(
    ("value", "error", "text"),
    [(0.886767, 2.11e-4, "0.88677(22)"), (0.88382, 0.04818, "0.884(49)"), (0.5, 12.3, "0(13)"),
     (-0.1, 0.995, "-0.1(10)"), (0.25, 0.0, "0.250000"), (None, None, None)],
)  # fmt: skip
def test_errors_stand_behind_the_digits_that_they_are_of(value, error, text):
    assert concise(value, error) == text


@pytest.mark.parametrize("cut", ["0", "-1", "nan", "1000.1"])
def test_limits_of_a_cut(filled, cli, cut):
    assert cli("lyapunov", "--cut", cut, "--db", str(filled)).says(2, f"cut {float(cut):g}", "1000")


def test_the_largest_cuts(filled, cli, monkeypatch):
    """Up to 1000 as they are; with determinants, up to so many factors, and what is advised is taken."""
    monkeypatch.setattr("orbitdb.catalogue.averaged.MOST_FACTORS", 600)
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
    assert cli("lyapunov", "--weight", "x", "--db", str(filled)).says(2, "'x'", "exp", "det")


def test_a_cut_says_up_to_where_the_filled_periods_are_complete(varied, cli):
    db = ("--db", str(varied))
    beyond = cli("lyapunov", "--cut", "6", *db)
    assert "complete, by proof, up to lambda = 4.851 at a = 1.6" in beyond.err
    assert "above 6 may be missing" in beyond.err
    assert "complete" not in cli("lyapunov", "--cut", "4.8", *db).err


def test_h_zeta_outside_the_proved_bounds_is_said_of_all_orbits_alone(varied, cli):
    db = ("--a", "1", "--db", str(varied))
    said = "h_zeta lies outside the proved bounds at periods 2-"
    found = cli("entropy", "--json", *db)
    assert said in found.err
    assert {1.0 < row["h_lower"] < row["h_upper"] < 1.12 for row in json.loads(found.out)} == {True}
    assert said not in cli("entropy", "--reversal", "self", *db).err
