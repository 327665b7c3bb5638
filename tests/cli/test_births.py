"""``orbitdb births``, and what other commands say of an a that is not filled."""

import json
import sqlite3
from contextlib import closing

import pytest

KEYS = ["p", "classes", "births", "deaths", "always", "least", "largest"]


def test_births_are_found_once_and_shown(cli):
    first = cli("births", "--p", "6")
    assert first.code == 0
    assert first.out.splitlines()[0].split() == KEYS
    assert first.out.splitlines()[-1].split() == ["6", "47", "33", "0", "14", "0.291644", "3.043599"]
    assert first.err.startswith("births, p = 2..6: ")
    again = cli("births", "--json")
    assert again.err == ""
    assert "\nbirths     periods 2-6\n" in cli("info").out
    rows = json.loads(again.out)
    assert [list(row) for row in rows] == [KEYS] * 5
    assert rows[0]["least"] is None


def test_the_table_of_an_a_that_is_not_filled(cli):
    cli("births", "--p", "6")
    born = cli("table", "--a", "1", "--json")
    assert born.code == 0
    assert born.err == "periods 2-6 at a = 1: from births, with no fill\n"
    cli("fill", "--p", "6", "--a", "1")
    filled = cli("table", "--a", "1", "--json")
    assert filled.err == ""
    assert filled.out == born.out
    assert json.loads(born.out)[4]["boundary"] == 32


def test_rows_are_chosen_by_life(cli):
    cli("births", "--p", "5")
    cli("fill", "--p", "6")
    born = cli("query", "--exists", "0.8", "--not-at", "0.7", "--p", "5", "-c", "code,born,dies", "--json")
    assert {round(row["born"], 6) for row in json.loads(born.out)} == {0.770598}
    assert {row["dies"] for row in json.loads(born.out)} == {None}
    ordered = cli("query", "--p", "5", "--order", "born desc", "-c", "born", "--format", "csv")
    values = ordered.out.splitlines()[1:]
    assert float(values[0]) == pytest.approx(1.674424, abs=1e-6)
    assert values[-1] == '""'  # an orbit from a = 0 on
    lacking = cli("query", "--exists", "0.8", "--p", "6")
    assert (lacking.code, lacking.out) == (1, "")
    assert "births of period 6 are not found" in lacking.err.splitlines()[0]
    chosen = cli("entropy", "--a", "0.8", "--exists", "0.5")
    assert (chosen.code, chosen.out) == (1, "")
    assert "births tell how many orbits of periods 2-5 there are at a = 0.8" in chosen.err


@pytest.mark.slow
def test_query_names_who_is_born_with_a_word(cli):
    assert "born at" not in cli("query", "--code", "01552").out
    cli("births", "--p", "5")
    (line,) = (each for each in cli("query", "--code", "01552").out.splitlines() if "born at" in each)
    a, _, words = line.removeprefix("  born at ").partition("with ")
    assert words
    for word in words.split(", "):
        assert f"from a = {a.strip()[:7]}" in cli("query", "--code", word).out


def test_a_life_that_ends_is_a_line(cli, tmp_path):
    """No class of few bounces ceases to be an orbit; here two do by hand, one of them to come back."""
    cli("births", "--p", "4")
    with closing(sqlite3.connect(tmp_path / "orbits.db")) as plain, plain:
        (run,) = plain.execute("SELECT max(run) FROM change").fetchone()
        classes = dict(plain.execute("SELECT word, id FROM cycle WHERE p > 2"))
        changes = [("0132", 2, 3.0, "died"), ("0132", 3, 5.0, "born"), ("0132", 4, 9.0, "died")]
        for word, number, a, kind in [*changes, ("013", 2, 2.0, "died")]:
            row = (classes[word], number, a, a / 1e15, kind, run)
            plain.execute(
                "INSERT INTO change (cycle, number, a, error, kind, run) VALUES (?, ?, ?, ?, ?, ?)", row
            )
    ended = cli("births", "--deaths", "--json")
    assert ended.err == "3 lives end, among 11 classes\n"
    assert [list(row.values()) for row in json.loads(ended.out)] == [
        [3, "013", 4, 0.0, 2.0, 2e-15, None],
        [4, "0132", 4, 0.0, 3.0, 3e-15, 5.0],
        [4, "0132", 4, 5.0, 9.0, 9e-15, None],
    ]
    assert list(json.loads(ended.out)[0]) == [
        "p",
        "word",
        "class_size",
        "born",
        "dies",
        "dies_error",
        "reborn",
    ]


def test_no_zero_has_a_sign_in_a_table(cli):
    assert "-0.000000000000" not in cli("query", "13", "--bounces").out
