"""Answers for several a equal the answers for each a, with a column for a."""

import csv
import io
import json

import pytest
from quick import slow_but

from orbitdb.text import joined

COMMANDS = [
    ("table --p 2-6", "all"),
    pytest.param("entropy --p 2-5", "1.6 1", marks=pytest.mark.slow),
    pytest.param("entropy --p 3-4 --time-reversal self", "1:1.6:2", marks=pytest.mark.slow),
    ("lyapunov --p 2-4", "all"),
    pytest.param("lyapunov --p 2-4 --cut 5", "1.6 1", marks=pytest.mark.slow),
    ("query --p 3 -c length,rules --order a,p,code", "1:1.6:2"),
    pytest.param("export --p 3 --order a,p,code -c +coordinates --limit 1000", "all", marks=pytest.mark.slow),
    ("export --p 2 --order a,p,code --by-bounce -c p,rules", "1.6 1"),
]


@pytest.mark.parametrize(("command", "asked"), COMMANDS)
def test_several_a_give_the_rows_of_each_with_its_a(cli, varied, command, asked):
    words = [*command.split(), "--format", "jsonl", "--db", str(varied)]
    done = cli(*words, *(part for a in asked.split() for part in ("--a", a)))
    each_a = ("1.6", "1") if asked == "1.6 1" and "--order" not in command else ("1", "1.6")
    alone = {a: map(json.loads, cli(*words, "--a", a).out.splitlines()) for a in each_a}
    found = [json.loads(line) for line in done.out.splitlines()]
    assert (done.code, found) == (0, [row | {"a": float(a)} for a in each_a for row in alone[a]])
    assert len({row["a"] for row in found}) == 2
    assert next(iter(found[0])) == "a" or "+coordinates" in command


def test_an_order_sorts_the_rows_of_all_a_together(cli, varied):
    """One table: stored columns, descending order, empty values, and a slice of it."""
    line = (
        "query",
        "--a",
        "all",
        "--p",
        "2-5",
        "--status",
        "orbit,dynamical,boundary",
        "--json",
        "--db",
        str(varied),
    )
    names = "-c", "a,code,p,representative,element,status,length"
    rows = json.loads(cli(*line, *names, "--order", "status desc,length desc").out)
    assert len(rows) > 200
    assert {row["length"] for row in rows if row["status"] == "dynamical"} == {None}
    by_hand = sorted(rows, key=lambda row: (row["p"], row["representative"], row["element"], row["a"]))
    by_hand.sort(key=lambda row: (row["length"] is None, -(row["length"] or 0)))
    by_hand.sort(key=lambda row: row["status"], reverse=True)
    assert rows == by_hand
    part = cli(*line, *names, "--order", "status desc,length desc", "--limit", "7", "--offset", "30")
    each_a = [[row for row in rows if row["a"] == a][30:37] for a in (1.0, 1.6)]
    assert json.loads(part.out) == [row for row in rows if any(row in some for some in each_a)]
    assert [sum(row["a"] == a for row in json.loads(part.out)) for a in (1.0, 1.6)] == [7, 7]
    table = cli("query", "--a", "all", "--p", "2-5", "--db", str(varied)).out.splitlines()
    assert len(table) == 1 + 40  # in all, if you name no limit


def test_a_word_can_be_followed_over_a(cli, varied):
    """One row per a, stored or not, with the same births at each."""
    done = cli("query", "--code", "013", "--code", "55110", "--a", "0.25:4:5", "--format", "csv",
               "-c", "code,stored,length,born,dies", "--db", str(varied))  # fmt: skip
    rows = list(csv.DictReader(io.StringIO(done.out)))
    assert [row["a"] for row in rows] == ["0.25", "0.5", "1.0", "2.0", "4.0"] * 2
    assert list(rows[0]) == ["code", "a", "stored", "length", "born", "dies"]
    assert [row["stored"] for row in rows[:5]] == ["False", "False", "True", "False", "False"]
    assert len({row["born"] for row in rows[5:]}) == 1
    for row in rows:
        assert bool(row["length"]) == (float(row["a"]) > float(row["born"] or 0)), row
    shown = cli("query", "13", "--a", "all", "--db", str(varied)).out.splitlines()
    assert [line.split()[:2] for line in shown] == [["code", "a"], ["13", "1"], ["13", "1.6"]]


def test_a_missing_a_is_reported_and_the_others_are_shown(cli, varied):
    done = cli("lyapunov", "--a", "1", "--a", "3", "--p", "2-5", "--db", str(varied))
    assert done.code == 0
    assert [line.split()[0] for line in done.out.split("\n\n")[0].splitlines()[1:]] == ["1"] * 4
    assert "periods 2-5 are not filled at a = 3" in done.err
    assert cli("entropy", "--a", "2", "--a", "3", "--p", "2-5", "--db", str(varied)).code == 1


@pytest.mark.parametrize("command", slow_but(2, ["query", "lyapunov", "export", "table", "entropy"]))
def test_several_a_succeed_if_one_of_them_has_rows(cli, varied, command):
    asked = (command, "--p", "2-5", "--format", "jsonl", "--db", str(varied))
    alone = cli(*asked, "--a", "1")
    found = cli(*asked, "--a", "1", "--a", "3")
    assert (alone.code, found.code) == (0, 0)
    assert [json.loads(line) for line in found.out.splitlines()] == [
        json.loads(line) | {"a": 1.0} for line in alone.out.splitlines()
    ]
    assert "at a = 3" in found.err
    none = cli(*asked, "--a", "2", "--a", "3")
    assert (none.code, none.out) == (1, "")


@pytest.mark.slow
@pytest.mark.parametrize("command", ["table", "entropy", "query --p 3", "export --format csv"])
def test_what_is_missing_at_many_a_is_one_line(cli, varied, command):
    outcome = cli(*command.split(), "--a", "0.5:0.9:200", "--db", str(varied))
    assert outcome.says(1, "filled at a = 0.5 (", "likewise at 199 other values of a, the last 0.9")
    outcome = cli(*command.split(), "--a", "0.5:0.9:3", "--db", str(varied))
    assert (outcome.code, outcome.err.count("\n")) == (1, 3)


def test_lines_about_different_things_stay_apart():
    said = [f"at a = {a}: {what}" for a in range(5) for what in ("x", f"{a} words", "y")]
    few = [f"period {p} at a = 1" for p in range(2, 9)]
    assert list(joined([*said, *few])) == [
        "at a = 0: x; likewise at 4 other values of a, the last 4",
        "at a = 0: 0 words",
        "at a = 0: y; likewise at 4 other values of a, the last 4",
        *(f"at a = {a}: {a} words" for a in range(1, 5)),
        *few,
    ]
    assert list(joined(["same"] * 9)) == ["same"] * 9
