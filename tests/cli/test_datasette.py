"""`orbitdb info --datasette`, and Datasette itself with the metadata that this writes."""

import json
import re
import subprocess
import sys
from urllib.request import urlopen

import pytest
from contents import ask

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


@pytest.fixture(scope="module")
def site(described, metadata):
    """The address of a running Datasette."""
    pytest.importorskip("datasette", reason="Datasette is not installed: pip install '.[test]'")
    command = [sys.executable, "-P", "-m", "datasette", str(described), "-m", str(metadata), "-p", "0"]
    server = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    try:
        assert server.stderr is not None
        told = (re.search(r"running on (http://127\.0\.0\.1:\d+)", line) for line in server.stderr)
        yield next(found[1] for found in told if found)
    finally:
        server.terminate()
        server.communicate(timeout=60)


def got(address):
    with urlopen(address, timeout=60) as answer:
        return answer.read().decode()


@pytest.mark.slow
def test_every_view_every_table_and_every_column_is_explained(described, metadata):
    (database,) = json.loads(metadata.read_text(encoding="utf-8"))["databases"].values()
    tables = database["tables"]
    assert all(table["description"] for table in tables.values())
    shown = {name: table["columns"] for name, table in tables.items() if not table.get("hidden")}
    assert set(shown) == {"catalogue", "class", "life", "level", "entropy_bound", "trajectory"}
    for name, columns in shown.items():
        assert all(columns.values())
        assert set(columns) == {row[1] for row in ask(described, f"PRAGMA table_info({name})")}
    assert shown["catalogue"]["length"] == "length of one traversal, L [radius]; error in length_error"
    assert shown["level"]["error"] == "estimated error of k [1/radius]"
    everything = ask(described, "SELECT name FROM sqlite_master WHERE type IN ('table', 'view')")
    assert {name for (name,) in everything} - {"alembic_version"} == set(tables)
    assert set(database["queries"]) == {each.partition("?")[0] for each in ANSWERS}


@pytest.mark.slow
@pytest.mark.parametrize("asked", ANSWERS)
def test_datasette_answers_every_query(site, asked):
    name, _, parameters = asked.partition("?")
    column, expected = ANSWERS[asked]
    rows = json.loads(got(f"{site}/orbits/{name}.json?_shape=array&{parameters}"))
    assert rows[0][column] == expected


@pytest.mark.slow
def test_datasette_shows_titles_and_what_a_column_means(site):
    assert "bound on the error of lambda_c [1/radius]" in got(f"{site}/orbits/catalogue")
    level = got(f"{site}/orbits/level")
    assert "Quantum levels" in level
    assert "estimated error of k [1/radius]" in level
    tables = {each["name"]: each["hidden"] for each in json.loads(got(f"{site}/orbits.json"))["tables"]}
    assert not tables["level"]
    assert tables["sweep_block"]
