"""A single entry adds a column or an average everywhere."""

import json
import os
import re
import sqlite3
import subprocess
import sys
from contextlib import closing
from fractions import Fraction
from pathlib import Path

import pandas
import pytest
from hypothesis import given
from hypothesis import strategies as st

from orbitdb import Catalogue
from orbitdb.column import Column
from orbitdb.columns import IN_CATALOGUE, add
from orbitdb.formulas import sql_of

DOCS = Path(__file__).parents[2] / "docs"
COLUMN = """
from orbitdb.column import Column
from orbitdb.columns import add
add(Column("stretch", "number", "lambda squared per bounce", "1", formula="lyapunov * lambda_d"))
"""
AVERAGE = """
import numpy as np
from orbitdb.answers.lyapunov import AVERAGES, Average
from orbitdb.averages.by_period import of_divisors

def thirds(given):
    found = given.sums
    return {"lambda_d_third": found.lambda_d / 3, "lambda_c_third": found.lambda_c / 3}

AVERAGES.append(Average("third", "thirds", "a third of the mean", of_divisors, thirds, line="v-"))
"""
COMMANDS = """
import json, sys
from orbitdb.cli.main import execute
for command in json.loads(sys.argv[1]):
    assert execute(command) == 0, command
    print(end="\\0")
"""


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    path = tmp_path_factory.mktemp("registries") / "c.db"
    Catalogue.create(path).fill("2-5")
    return str(path)


def ran(program, *arguments):
    """Run Python in a separate process, after adding an entry to a registry."""
    command = [sys.executable, "-P", "-c", program, *arguments]
    done = subprocess.run(
        command, capture_output=True, text=True, timeout=300, env={**os.environ, "COLUMNS": "200"}
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def shown(entry, *commands):
    """Return the output of each command after adding an entry to a registry."""
    return ran(entry + COMMANDS, json.dumps(commands)).split("\0")[:-1]


def test_a_column_is_one_entry_for_the_commands(small, tmp_path):
    """It is in views, queries, filters, sort keys, every format, and the list of columns."""
    chosen = ("--db", small, "--p", "4", "--where", "stretch > 0", "--order", "-stretch", "--limit", "3")
    forms = ("table", "csv", "tsv", "jsonl", "latex", "markdown")
    *found, _, _, _ = shown(
        COLUMN,
        ("query", *chosen, "--json"),
        ("columns",),
        ("query", "1232131", "--db", small),
        ("sql", "select stretch from catalogue limit 1", "--json", "--db", small),
        *(("query", *chosen, "-c", "code,stretch", "--format", form) for form in forms),
        *(("export", str(tmp_path / name), *chosen) for name in ("x.csv", "x.parquet", "x.json")),
    )
    rows = json.loads(found[0])
    values = [row["stretch"] for row in rows]
    assert values == [row["lyapunov"] * row["lambda_d"] for row in rows] == sorted(values, reverse=True)
    assert "lambda squared per bounce" in found[1]
    assert re.search(r"(?m)^stretch +\d", found[2])
    assert all("stretch" in each for each in found[3:])
    assert "stretch" in (tmp_path / "x.csv").read_text(encoding="utf-8")
    assert "stretch" in pandas.read_parquet(tmp_path / "x.parquet")
    assert "stretch" in (tmp_path / "x.json").read_text(encoding="utf-8")


@pytest.mark.slow
def test_a_column_is_one_entry_in_python_and_on_the_screen(small):
    objects = f"""
from orbitdb import Catalogue, solve_word
subset = Catalogue({small!r}).select(p="4", status="orbit")
assert (subset.stretch == subset.lyapunov * subset.lambda_d).all()
assert subset[0].stretch == subset.stretch[0] and "stretch" in subset.to_pandas()
orbit = solve_word("1232131", 1.6)
assert orbit.stretch == orbit.lyapunov * orbit.lambda_d and solve_word("012", 1.6).stretch is None
from orbitdb.cli.tui.view import EVERY, columns_named
from program import renewed
print(EVERY["stretch"].brief, [each.name for each in columns_named(["stretch"])])
print(renewed("<!-- here: columns_of_orbit -->\\n<!-- end -->"))
"""
    on_screen, *page = ran(f"{COLUMN}\nimport sys; sys.path.insert(0, {str(DOCS)!r})\n{objects}").splitlines()
    assert on_screen == "lambda squared per bounce ['code', 'stretch']"
    assert "| `stretch` | number | 1 |  | lambda squared per bounce | never |" in page


@pytest.mark.slow
def test_an_average_is_one_entry(small, tmp_path):
    """It is in the result, its table and JSON, the figure, and the screen."""
    found, table, _ = shown(
        AVERAGE,
        ("lyapunov", "--db", small, "--json"),
        ("lyapunov", "--db", small),
        ("plot", "lyapunov", "--db", small, "-o", str(tmp_path / "x.svg")),
    )
    *_, last = json.loads(found)
    assert last["lambda_c_third"] == last["lambda_c"] / 3
    assert len(re.findall(r"(?m)^ *p .*\bthird\b", table)) == 2
    assert (tmp_path / "x.svg").exists()
    screen = f"""
from pathlib import Path
from orbitdb.cli.tui import statistics_screen as screen
from orbitdb.store.asking.selection import Selection
from orbitdb.store.reading.moment import Reader
found = screen.statistics(Reader(Path({small!r})), Selection())
curves = screen.curves_of(found, None)["lambda_d"]
print("lambda_c_third" in screen.columns(), [each.name for each in curves])
"""
    assert re.fullmatch(r"True .*'thirds'.*\n", ran(AVERAGE + screen))


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
    """Return lambda_c and its error bound, as SQLite computes them from the formulas."""
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
def test_the_bound_on_lambda_c_holds_and_is_no_larger_than_necessary(
    lyapunov, length, lyapunov_error, length_error
):
    """The exact error is that of the worst quotient within both errors, plus the rounding of the quotient."""
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
