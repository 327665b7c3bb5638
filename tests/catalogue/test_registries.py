"""One entry adds a column, or an average, everywhere."""

import json
import os
import re
import sqlite3
import subprocess
import sys
from contextlib import closing
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from orbitdb import Catalogue
from orbitdb.columns import IN_CATALOGUE, Column, add, sql_of

COLUMN = """
from orbitdb.columns import Column, add
add(Column("stretch", "number", "lambda squared per bounce", "1", formula="lyapunov * lambda_d"))
"""
AVERAGE = """
import numpy as np
from orbitdb.answers.methods import AVERAGES, Average
from orbitdb.averages.by_period import of_divisors

def thirds(given):
    found = given.sums
    return {"lambda_d_third": found.lambda_d / 3, "lambda_c_third": found.lambda_c / 3}

AVERAGES.append(Average("third", "thirds", "a third of the mean", of_divisors, thirds, line="v-"))
"""
COMMAND = "from orbitdb.cli.main import run; run()"


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    path = tmp_path_factory.mktemp("registries") / "c.db"
    Catalogue.create(path).fill("2-5")
    return path


def ran(entry, program, *arguments):
    """Run Python with a further entry in a registry."""
    command = [sys.executable, "-P", "-c", entry + program, *map(str, arguments)]
    done = subprocess.run(
        command, capture_output=True, text=True, timeout=60, env={**os.environ, "COLUMNS": "200"}
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_a_column_is_one_entry(small, tmp_path):
    """Views, questions, filters, orders, every format, the list of columns, objects, and the screen."""
    chosen = ("--db", small, "--p", "4", "--where", "stretch > 0", "--order", "-stretch", "--limit", 3)
    rows = json.loads(ran(COLUMN, COMMAND, "query", *chosen, "--json"))
    values = [row["stretch"] for row in rows]
    assert values == [row["lyapunov"] * row["lambda_d"] for row in rows] == sorted(values, reverse=True)
    for form in ("table", "csv", "tsv", "jsonl", "latex", "markdown"):
        assert "stretch" in ran(COLUMN, COMMAND, "query", *chosen, "-c", "code,stretch", "--format", form)
    for name in ("x.csv", "x.parquet", "x.npz"):
        ran(COLUMN, COMMAND, "export", tmp_path / name, *chosen)
    assert "stretch" in (tmp_path / "x.csv").read_text(encoding="utf-8")
    assert "lambda squared per bounce" in ran(COLUMN, COMMAND, "columns")
    assert re.search(r"(?m)^stretch +\d", ran(COLUMN, COMMAND, "query", "1232131", "--db", small))
    assert "stretch" in ran(
        COLUMN, COMMAND, "sql", "select stretch from catalogue limit 1", "--json", "--db", small
    )
    objects = f"""
from orbitdb import Catalogue, solve_word
subset = Catalogue({str(small)!r}).select(p="4", status="orbit")
assert (subset.stretch == subset.lyapunov * subset.lambda_d).all()
assert subset[0].stretch == subset.stretch[0] and "stretch" in subset.to_pandas()
orbit = solve_word("1232131", 1.6)
assert orbit.stretch == orbit.lyapunov * orbit.lambda_d and solve_word("012", 1.6).stretch is None
from orbitdb.cli.tui.columns import EVERY
print(EVERY["stretch"].brief)
"""
    assert ran(COLUMN, objects) == "lambda squared per bounce\n"


def test_an_average_is_one_entry(small, tmp_path):
    """The result, its table and JSON, the screen and the figure."""
    (*_, last) = json.loads(ran(AVERAGE, COMMAND, "lyapunov", "--db", small, "--json"))
    assert last["lambda_c_third"] == last["lambda_c"] / 3
    table = ran(AVERAGE, COMMAND, "lyapunov", "--db", small)
    assert len(re.findall(r"(?m)^ *p .*\bthird\b", table)) == 2
    ran(AVERAGE, COMMAND, "plot", "lyapunov", "--db", small, "-o", tmp_path / "x.svg")
    assert (tmp_path / "x.svg").exists()
    shown = f"""
from pathlib import Path
from orbitdb.cli.tui.statistics import statistics_screen as screen
from orbitdb.store.asking.selection import Selection
from orbitdb.store.reading.moment import Reader
found = screen.statistics(Reader(Path({str(small)!r})), Selection())
curves = screen.curves_of(found, None)["lambda_d"]
print("lambda_c_third" in screen.columns(), [each.name for each in curves])
"""
    assert re.fullmatch(r"True .*'thirds'.*\n", ran(AVERAGE, shown))


@pytest.mark.parametrize("column", [
    Column("length", "number", "there is one", formula="lyapunov / p"),
    Column("beyond", "number", "of nothing known", formula="lyapunov / colour"),
    Column("plain", "number", "of nothing at all"),
], ids=lambda column: column.name)  # fmt: skip
def test_a_column_without_a_new_name_or_a_formula_is_refused(column):
    before = list(IN_CATALOGUE)
    with pytest.raises(ValueError, match=f"^{column.name}: give a new name, and a formula"):
        add(column)
    assert before == IN_CATALOGUE


def quotient_error(lyapunov, length, lyapunov_error, length_error):
    """What SQLite makes of the formulas of lambda_c and its bound."""
    columns = {each.name: sql_of(each) for each in IN_CATALOGUE}
    values = {
        "lyapunov": lyapunov,
        "length": length,
        "lyapunov_error": lyapunov_error,
        "length_error": length_error,
    }
    source = ", ".join(f"{value!r} AS {name}" for name, value in values.items())
    with closing(sqlite3.connect(":memory:")) as plain:
        query = f"SELECT {columns['lambda_c']}, {columns['lambda_c_error']} FROM (SELECT {source}) AS orbit"
        return plain.execute(query).fetchone()


@given(
    lyapunov=st.floats(1e-9, 1e5),
    length=st.floats(1.0, 1e6),
    lyapunov_error=st.floats(1e-16, 1e-3),
    length_error=st.floats(1e-16, 1e-3),
)
def test_the_bound_on_lambda_c_holds_and_is_no_larger_than_it_must_be(
    lyapunov, length, lyapunov_error, length_error
):
    """In exact arithmetic: the worst quotient within both errors, and the rounding of the quotient."""
    stored, bound = map(Fraction, quotient_error(lyapunov, length, lyapunov_error, length_error))
    over, under = (Fraction(lyapunov) + sign * Fraction(lyapunov_error) for sign in (1, -1))
    ends = [
        part / (Fraction(length) + sign * Fraction(length_error))
        for part in (over, under)
        for sign in (1, -1)
    ]
    worst = max(abs(end - stored) for end in ends)
    assert (
        worst
        <= bound
        <= worst * Fraction("1.00001") + stored * Fraction("2.5e-16") + bound * Fraction(2, 1000)
    )
