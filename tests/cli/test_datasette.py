"""`orbitdb info --datasette`, and Datasette itself with what it writes."""

import json
import subprocess
import sys

import pytest

from orbitdb import Catalogue

ANSWERS = {
    "shortest?a=1.6": ("code", "13"),
    "least_unstable?a=1.6&p=4": ("p", 4),
    "word?code=0103": ("representative", "0103"),
    "orbits_by_period?a=1.6": ("N_c", 1),
    "born_between?low=0.1&high=1": ("p", 6),
    "levels?a=1.6": ("number", 1),
}
"""A column of the first row of each query."""


@pytest.fixture(scope="module")
def described(tmp_path_factory):
    path = tmp_path_factory.mktemp("datasette") / "orbits.db"
    with Catalogue.create(path) as catalogue:
        catalogue.fill("2-5")
        catalogue.fill_births("2-6")
        catalogue.fill_levels(3, parities=["ee"])
    return path


@pytest.fixture(scope="module")
def metadata(described):
    command = [sys.executable, "-P", "-m", "orbitdb", "info", "--datasette", "--db", str(described)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=True)
    (target := described.with_name("metadata.json")).write_text(done.stdout, encoding="utf-8")
    return target


def got(described, metadata, address):
    """Ask Datasette for one page."""
    command = [sys.executable, "-P", "-m", "datasette", str(described), "-m", str(metadata), "--get", address]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_every_table_and_every_column_of_a_view_is_explained(metadata):
    (database,) = json.loads(metadata.read_text(encoding="utf-8"))["databases"].values()
    assert all(table["description"] for table in database["tables"].values())
    assert database["tables"]["catalogue"]["columns"]["length"] == (
        "length of one traversal, L [radius]; error bounded by length_error"
    )
    assert "number of the bounce" not in str(database["tables"]["element"])
    assert set(database["queries"]) == {each.partition("?")[0] for each in ANSWERS}


@pytest.mark.slow
@pytest.mark.parametrize("asked", ANSWERS)
def test_datasette_answers_every_query(described, metadata, asked):
    name, _, parameters = asked.partition("?")
    column, expected = ANSWERS[asked]
    rows = json.loads(got(described, metadata, f"/orbits/{name}.json?_shape=array&{parameters}"))
    assert rows[0][column] == expected


@pytest.mark.slow
def test_datasette_shows_what_a_column_means(described, metadata):
    assert "bound on the error of lambda_c [1/radius]" in got(described, metadata, "/orbits/catalogue")
