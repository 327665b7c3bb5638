"""`simulate`, from its options to what it stores and who shows it."""

import json
import sqlite3
from contextlib import closing
from dataclasses import asdict
from typing import Any

from orbitdb.billiard.stadium import Stadium
from orbitdb.numerals import upwards
from orbitdb.trajectories.ensemble import simulate


def stored(path) -> list[dict[str, Any]]:
    with closing(sqlite3.connect(path)) as connection:
        connection.row_factory = sqlite3.Row
        return [dict(row) for row in connection.execute("SELECT * FROM trajectory ORDER BY lambda_d_error")]


def test_what_is_simulated_is_stored_and_shown_beside_averages(filled, cli):
    """The smallest error is shown, whichever came last, with each number under its own name."""
    best = simulate(Stadium(1.6), 20_000, 7)
    for arguments in (["2e4", "--seed", "7"], ["2000"], ["2000", "--no-store"]):
        done = cli("simulate", "--bounces", *arguments, "--json", "--db", str(filled))
        assert done.code == 0
        if "--seed" in arguments:
            (row,) = json.loads(done.out)
            assert {**row, "groups": best.groups} == {"a": 1.6, **asdict(best)}
    first, _ = kept = stored(filled)
    assert len(kept) == 2
    with closing(sqlite3.connect(filled)) as connection:
        ((asked,),) = connection.execute("SELECT parameters FROM run WHERE id = ?", (first["run"],))
    told = {name: json.loads(asked)[name] for name in ("command", "a", "bounces", "seed")}
    assert told == {"command": "simulate", "a": 1.6, "bounces": best.bounces, "seed": 7}
    assert {name: first[name] for name in asdict(best)} == asdict(best) | {"seed": "7"}
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


def test_eighty_columns_hold_it(cli):
    for bounces in ("100", "20000"):
        done = cli("simulate", "--a", "0.3660254037844386", "--bounces", bounces)
        assert done.code == 0
        assert max(map(len, (done.out + done.err).splitlines())) <= 80
