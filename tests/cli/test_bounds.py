"""``orbitdb bounds`` as users meet it."""

import json
import re
from decimal import Decimal

import pexpect
import pytest
from terminal import ended, spawn

KEYS = ["a", "window", "lower", "upper", "windows", "undecided"]


def test_bounds_are_rounded_outward_in_print(cli):
    rows = json.loads(cli("bounds", "--window", "8", "--json").out)
    assert [list(row) for row in rows] == [KEYS] * 7
    header, *lines = cli("bounds", "--window", "8").out.splitlines()
    assert header.split() == KEYS
    for line, row in zip(lines, rows, strict=True):
        shown = dict(zip(KEYS, line.split(), strict=True))
        assert Decimal(shown["lower"]) <= Decimal(row["lower"])
        assert Decimal(shown["upper"]) >= Decimal(row["upper"])
        assert Decimal(shown["upper"]) - Decimal(row["upper"]) < Decimal("1e-8")
        assert (int(shown["window"]), int(shown["windows"])) == (row["window"], row["windows"])


def test_bounds_end_where_they_are_told(cli):
    wide = json.loads(cli("bounds", "--a", "3", "--width", "0.01", "--json").out)
    assert wide[-1]["upper"] - wide[-1]["lower"] <= 0.01 < wide[-2]["upper"] - wide[-2]["lower"]
    assert {row["a"] for row in wide} == {3.0}
    assert len(json.loads(cli("bounds", "--time", "1e-6", "--json").out)) == 1


def test_prove_tells_what_is_proved_and_bounds_are_those_of_it(cli):
    plain = cli("bounds", "--a", "0.5", "--window", "7", "--json")
    proved = cli("bounds", "--a", "0.5", "--window", "7", "--json", "--prove")
    assert proved.out == plain.out
    assert re.search(
        r"balls prove (\d+) of \1 windows that doubles decide, 0 left open; \d+\.\d s", proved.err
    )
    assert plain.err.startswith("not kept: there is no catalogue at ")


def test_a_width_that_is_not_reached_is_told(cli):
    found = cli("bounds", "--width", "1e-6", "--window", "5", "--format", "csv")
    assert found.code == 1
    assert "apart, not 1e-06" in found.err
    assert len(found.out.splitlines()) == 5


@pytest.mark.parametrize(
    "options", [("--window", "1"), ("--window", "99"), ("--width", "0"), ("--time", "-1"), ("--a", "0")]
)
def test_what_cannot_be_done_is_told_in_one_line(cli, options):
    found = cli("bounds", *options)
    assert found.code == 2
    assert found.out == ""
    assert len(found.err.splitlines()) == 1


@pytest.mark.slow
def test_ctrl_c_leaves_the_rows_so_far():
    child = spawn("bounds", "--time", "600")
    child.expect("1[0-9] letters")
    begun = child.before + child.after
    child.sendintr()
    child.expect(pexpect.EOF)
    session = ended(child, (begun + child.before, 80))
    assert session.code == 130
    header, first, *_ = session.lines
    assert (header.split(), first.split()[1]) == (KEYS, "2")
    assert "orbitdb: interrupted" in session.text
