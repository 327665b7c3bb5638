"""`lyapunov` with sum rules, and `simulate`: options, stored rows, and where they are shown."""

import contextlib
import io
import json
import math
import re
import sqlite3
from contextlib import closing
from typing import Any

import pytest
from contents import ask
from quick import slow_but
from there import there

from orbitdb import Catalogue
from orbitdb.averages.simulation import simulate
from orbitdb.billiard.stadium import Stadium
from orbitdb.cli.output import Format, write
from orbitdb.errors import StoreError
from orbitdb.text import concise, upwards, with_error


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
def test_errors_are_rounded_up_and_set_the_digits_of_their_values(error, text):
    assert with_error(0.886785768, error) == text
    told = io.StringIO()
    with contextlib.redirect_stdout(told):
        write(("lambda_d", "lambda_d_error"), [(0.886785768, error)], Format.TABLE)
    assert told.getvalue().splitlines()[1].split() == text.split(" +- ")


@pytest.mark.parametrize(
    ("value", "error", "text"),
    [(0.886767, 2.11e-4, "0.88677(22)"), (0.88382, 0.04818, "0.884(49)"), (0.5, 12.3, "0(13)"),
     (-0.1, 0.995, "-0.1(10)"), (0.25, 0.0, "0.250000"), (0.25, math.inf, "0.250000"), (None, None, None)],
)  # fmt: skip
def test_concise_errors_follow_the_digits_they_belong_to(value, error, text):
    assert concise(value, error) == text


@pytest.mark.parametrize("command", slow_but(2, ["entropy", "lyapunov --weight det", "lyapunov", "table"]))
@pytest.mark.parametrize("periods", ["5-6", "4", "2,6"])
def test_p_chooses_rows_and_leaves_their_numbers_alone(varied, cli, command, periods):
    asked = (*command.split(), "--a", "1.6", "--json", "--db", str(varied))
    every, some = (json.loads(cli(*asked, *which).out) for which in ((), ("--p", periods)))
    first, _, last = periods.replace(",", "-").partition("-")
    chosen = {2, 6} if "," in periods else set(range(int(first), int(last or first) + 1))
    assert some == [row for row in every if row["p"] in chosen]


@pytest.mark.parametrize("command", ["entropy", "lyapunov"])
def test_a_lower_period_that_is_missing_is_named(tmp_path, cli, command):
    for p in ("2", "4"):
        assert cli("fill", "--p", f"{p}-{p}").code == 0
    shown = cli(command, "--p", "4")
    assert "the zeta function lacks p = 3 (not filled)" in shown.err


def test_the_zero_of_a_zeta_function_is_no_escape_rate(filled, cli):
    """Without runs and bouncing balls it settles; otherwise it may even be below 1. A note says so."""
    chosen = ("lyapunov", "--weight", "det", "--p", "8", "--json", "--db", str(filled))
    some = (
        argument for pattern in ("11", "33", "44", "55", "02", "20") for argument in ("--without", pattern)
    )
    settled, other = cli(*chosen, *some), cli(*chosen, "--without", "313")
    assert math.log(json.loads(settled.out)[0]["z0"]) == pytest.approx(0.65719682, abs=1e-5)
    assert math.log(json.loads(other.out)[0]["z0"]) < 0
    assert "the zeta function does not converge, and ln z0 is no escape rate" in settled.err
    assert "ln z0 is no escape rate" in other.err


def test_the_largest_cuts_work_or_name_a_smaller_one(filled, cli, monkeypatch):
    """A cut of 1000 works. With determinants the number of terms is limited, and the advised cut works."""
    monkeypatch.setattr("orbitdb.answers.lyapunov.MOST_FACTORS", 600)
    chosen = ("lyapunov", "--p", "2-4", "--json", "--db", str(filled), "--cut")
    found, none = cli(*chosen, "1000"), cli(*chosen, "1e-7")
    assert json.loads(found.out)[0]["cut"] == 1000
    assert "no average" not in found.err
    assert json.loads(none.out)[0]["lambda_d_zeta"] is None
    assert "the zeta function gives no average (no orbit has a lambda of at most 1e-07)" in none.err
    refused = cli(*chosen, "1000", "--weight", "det")
    assert (refused.code, refused.out) == (2, "")
    said = r"orbitdb: cut 1000 has too many terms with weight det: give (\d+) or less\n"
    most = float(there(re.fullmatch(said, refused.err))[1])
    assert cli(*chosen, str(most), "--weight", "det").code == 0
    assert "too many terms" in cli(*chosen, str(1.2 * most), "--weight", "det").err


def stored(path) -> list[dict[str, Any]]:
    with closing(sqlite3.connect(path)) as connection:
        connection.row_factory = sqlite3.Row
        return [dict(row) for row in connection.execute("SELECT * FROM trajectory ORDER BY lambda_d_error")]


def test_a_simulation_that_cannot_be_stored_is_shown(cli, filled, monkeypatch):
    """It may have taken hours."""

    def fail(*_):
        raise StoreError("the disk is full")

    monkeypatch.setattr(Catalogue, "keep", fail)
    done = cli("simulate", "--bounces", "2000", "--seed", "7", "--json", "--db", str(filled))
    assert (done.code, json.loads(done.out)) == (3, [simulate(Stadium(1.6), 2000, 7).row()])


def test_simulated_exponents_are_stored_and_shown_beside_averages(filled, cli):
    """The trajectory with the smallest error is shown, whichever came last."""
    best = simulate(Stadium(1.6), 20_000, 7)
    for arguments in (["2e4", "--seed", "7"], ["2000"], ["2000", "--no-store"]):
        done = cli("simulate", "--bounces", *arguments, "--json", "--db", str(filled))
        assert done.code == 0
        if "--seed" in arguments:
            (row,) = json.loads(done.out)
            assert row == best.row()
    first, _ = kept = stored(filled)
    assert len(kept) == 2
    ((asked,),) = ask(filled, f"SELECT parameters FROM run WHERE id = {first['run']}")
    told = {name: json.loads(asked)[name] for name in ("command", "a", "bounces", "seed")}
    assert told == {"command": "simulate", "a": 1.6, "bounces": best.bounces, "seed": 7}
    kept_numbers = {**first, "a": 1.6, "seed": int(first["seed"])}
    assert {name: kept_numbers[name] for name in best.row()} == best.row()
    told = cli("lyapunov", "--p", "2-3", "--json", "--db", str(filled))
    for row in json.loads(told.out):
        for name in ("lambda_d", "lambda_d_error", "lambda_c", "lambda_c_error"):
            assert row[f"{name}_trajectory"] == getattr(best, name)
    assert "trajector" not in told.err
    table = cli("lyapunov", "--p", "2-3", "--db", str(filled))
    assert (
        f"trajectories: lambda_d = {best.lambda_d:.6f} +- {upwards(best.lambda_d_error)}, "
        f"lambda_c = {best.lambda_c:.6f} +- {upwards(best.lambda_c_error)}\n"
    ) in table.err
    elsewhere = cli("simulate", "--a", "1", "--bounces", "2000", "--db", str(filled))
    assert elsewhere.code == 0
    assert json.loads(cli("lyapunov", "--json", "--db", str(filled)).out)[0]["lambda_d_trajectory"] == (
        best.lambda_d
    )
