"""``orbitdb bounds`` on the command line."""

import json
import re
from dataclasses import replace
from decimal import Decimal

import numpy as np
import pexpect
import pytest
from terminal import ended, spawn

from orbitdb.catalogue import Catalogue
from orbitdb.cli.commands.bounds import balls_of
from orbitdb.cli.grids import half_lengths
from orbitdb.entropy_bounds.bounds import EntropyBounds

WHY = "the time, the window length or the memory was not enough\n"
KEYS = ["a", "edges", "lower", "upper", "estimate", "windows", "undecided"]


def test_printed_bounds_are_rounded_outward(cli):
    rows = json.loads(cli("bounds", "--edges", "8", "--json").out)
    assert [list(row) for row in rows] == [[*KEYS, "arithmetic"]] * 7
    assert json.loads(cli("bounds", "--seconds", "1e-9", "--edges", "8", "--json").out) == rows[:1]
    header, *lines = cli("bounds", "--edges", "8").out.splitlines()
    assert header.split() == KEYS
    for line, row in zip(lines, rows, strict=True):
        shown = dict(zip(KEYS, line.split(), strict=True))
        assert Decimal(shown["lower"]) <= Decimal(row["lower"])
        assert Decimal(shown["upper"]) >= Decimal(row["upper"])
        assert Decimal(shown["upper"]) - Decimal(row["upper"]) < Decimal("1e-8")
        assert row["lower"] < row["estimate"] < row["upper"]
        assert float(shown["estimate"]) == pytest.approx((row["lower"] + row["upper"]) / 2, abs=5.1e-9)
        assert (int(shown["edges"]), int(shown["windows"])) == (row["edges"], row["windows"])


def test_bounds_that_must_be_stored_but_cannot_be_are_not_computed(cli, tmp_path):
    nowhere = str(tmp_path / "none" / "orbits.db")
    assert cli("bounds", "--edges", "3", "--store", "--db", nowhere).says(3, "none")
    assert cli("bounds", "--edges", "3", "--store", "--width", "-1").code == 2
    assert [*tmp_path.iterdir()] == []  # wrong limits leave no file


@pytest.mark.slow
def test_several_a_give_the_last_row_of_each(cli):
    """In the order in which they are named, however they are named."""
    levels = (json.loads(cli("bounds", "--a", a, "--edges", "6", "--json").out) for a in ("1", "0.5", "2"))
    alone = [rows[-1] for rows in levels]
    both = cli("bounds", "--a", "1", "--a", "0.5:2:2", "--a", "1", "--edges", "6", "--json")
    assert json.loads(both.out) == alone


@pytest.mark.slow
def test_prove_gives_the_same_bounds_and_counts_the_proved_windows(cli, tmp_path):
    plain = cli("bounds", "--a", "0.5", "--edges", "7", "--json")
    proved = cli("bounds", "--a", "0.5", "--edges", "7", "--json", "--prove")
    assert proved.out == plain.out.replace("doubles", "balls")
    assert re.search(
        r"ball arithmetic proves (\d+) of \1 windows decided in double precision, 0 left open",
        proved.err,
    )
    assert (plain.err, (tmp_path / "orbits.db").exists()) == ("", True)


def test_windows_left_open_by_balls_are_added_up_over_a():
    bounds = EntropyBounds(1.6, 5, 1.0, 1.1, 1, 0)
    last = [replace(bounds, proved=proved, left_open=left_open) for proved, left_open in ((2, 1), (4, 3))]
    said = "ball arithmetic proves 6 of 10 windows decided in double precision, 4 left open"
    assert balls_of(last) == said


def test_a_grid_is_logarithmic_and_its_values_can_be_typed():
    assert half_lengths("1.6") == (1.6,)
    assert len(half_lengths("1:2:1000")) == 1000
    for wrong in ("x", "1:2", "1:2:1", "1:2:x", "2:1:5", "0:1:5", "1:1.0001:900", "1:2:3:4", "1:2:1001"):
        with pytest.raises(ValueError, match=r":|number|half length"):
            half_lengths(wrong)
    assert half_lengths("0.5:8:5") == (0.5, 1.0, 2.0, 4.0, 8.0)
    found = np.array(half_lengths("0.3:10:40"))
    assert (found[0], found[-1], len(found)) == (0.3, 10.0, 40)
    assert np.diff(np.log(found)) == pytest.approx(np.log(10 / 0.3) / 39, rel=1e-4)
    assert [float(f"{a:g}") for a in found] == found.tolist()


@pytest.mark.parametrize("jobs", [(), pytest.param(("--jobs", "2", "--prove"), marks=pytest.mark.slow)])
def test_a_grid_shows_the_last_bounds_at_every_a_and_stores_them(cli, jobs, tmp_path):
    asked = ("bounds", "--a", "1:4:3", "--edges", "5")
    found = cli(*asked, *jobs, "--store", "--json")
    rows = json.loads(found.out)
    assert [(row["a"], row["edges"]) for row in rows] == [(1.0, 5), (2.0, 5), (4.0, 5)]
    alone = json.loads(cli("bounds", "--a", "2", "--edges", "5", "--no-store", "--json").out)[-1]
    assert rows[1] == alone | {"arithmetic": "balls" if jobs else "doubles"}
    curve = Catalogue(tmp_path / "orbits.db").entropy_curve()
    assert [(each.a, each.lower, each.upper) for each in curve] == [
        (row["a"], row["lower"], row["upper"]) for row in rows
    ]
    assert {each.arithmetic for each in curve} == {"balls" if jobs else "doubles"}
    assert ("ball arithmetic proves" in found.err) == bool(jobs)
    assert cli(*asked, "--width", str(max(each.upper - each.lower for each in curve))).code == 0
    missed = cli(*asked, "--width", "0.1")
    assert missed.err.endswith("at 2 of 3 values of a: " + WHY)
    assert missed.code == 1
    assert [row["edges"] for row in json.loads(cli(*asked, "--seconds", "1e-9", "--json").out)] == [2, 2, 2]


@pytest.mark.slow
def test_weak_stored_bounds_do_not_replace_better_ones(cli, varied, own):
    before = json.loads(cli("entropy", "--p", "4", "--json", "--db", str(own)).out)
    assert cli("bounds", "--edges", "5", "--store", "--db", str(own)).code == 0
    assert json.loads(cli("entropy", "--p", "4", "--json", "--db", str(own)).out) == before
    shown = cli("entropy", "--time-reversal", "self", "--db", str(own))
    assert "h <" not in shown.err  # the bounds are those of all orbits


@pytest.mark.slow
def test_ctrl_c_still_shows_the_rows_computed_so_far():
    child = spawn("bounds", "--seconds", "600")
    child.expect("[5-9] letters")
    begun = child.before + child.after
    child.sendintr()
    child.expect(pexpect.EOF)
    session = ended(child, (begun + child.before, 80))
    assert session.code == 130
    header, first, *_ = session.lines
    assert (header.split(), first.split()[1]) == (KEYS, "2")
    assert "orbitdb: interrupted" in session.text


def test_long_windows_begin_with_the_time_that_they_take(cli):
    """The estimate precedes the search, which is cut short here by the width."""
    found = cli("bounds", "--edges", "40", "--width", "2", "--format", "csv")
    first, *_ = found.err.splitlines()
    assert first == "windows of 40 edges take about 20 days of processor time"
    assert "take about" not in cli("bounds", "--edges", "40", "--width", "2", "--seconds", "9").err
    assert "take about" not in cli("bounds", "--width", "2").err
