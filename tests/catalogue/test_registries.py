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

import pytest
from hypothesis import given
from hypothesis import strategies as st

from orbitdb import Catalogue
from orbitdb.columns import IN_CATALOGUE
from orbitdb.store import views

DOCS = Path(__file__).parents[2] / "docs"
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


def test_every_column_of_an_orbit_is_an_attribute(filled):
    """Rows, `Orbit` and `Subset` give the same values, to the last bit."""
    catalogue = Catalogue(filled, a=1.6)
    names = [each.name for each in IN_CATALOGUE if each.name not in OF_FILES]
    rows = [*catalogue.rows(p="2-5", columns=names)][::3]
    subset = catalogue.select(p="2-5")[::3]
    for row, orbit in zip(rows, subset, strict=True):
        assert [getattr(orbit, name) for name in names] == list(row)
    for name in {*names} - {"code"}:
        stored = [getattr(orbit, name) for orbit in subset]
        values = getattr(subset, name).tolist()
        assert [None if value != value or value == "" else value for value in values] == stored, name


OF_FILES = ("a", "born", "cycle", "dies", "element", "iterations", "rules")
"""Columns that do not describe an orbit by itself."""


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
from orbitdb.cli.tui import statistics_screen as screen
from orbitdb.catalogue import Catalogue
found = Catalogue({small!r}).statistics()
curves = screen.curves_of(found, None)["lambda_d"]
print("lambda_c_third" in screen.columns(), [each.name for each in curves])
"""
    assert re.fullmatch(r"True .*'thirds'.*\n", ran(AVERAGE + screen))


def quotient_error(lyapunov, length, lyapunov_error, length_error):
    """Return lambda_c and its error bound, as SQLite computes them from the formulas."""
    lambda_c, error = (str(views.CLASS_COLUMNS[name].compile(compile_kwargs={"literal_binds": True}))
                       for name in ("lambda_c", "lambda_c_error"))  # fmt: skip
    values = {
        "lyapunov": lyapunov,
        "length": length,
        "lyapunov_error": lyapunov_error,
        "length_error": length_error,
    }
    source = ", ".join(f"{value!r} AS {name}" for name, value in values.items())
    with closing(sqlite3.connect(":memory:")) as plain:
        query = f"SELECT {lambda_c}, {error} FROM (SELECT {source}) AS orbit"
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
