"""Other programs read a catalogue as the cookbook says; those that are not installed are skipped."""

import json
import shutil
import subprocess

import pytest

from orbitdb import Catalogue

BY_PERIOD = (
    "SELECT p, count(*) AS words FROM catalogue WHERE a = 1.6 AND status = 'orbit' GROUP BY p ORDER BY p"
)


def numbers(path):
    catalogue = Catalogue(path, a=1.6)
    return [(p, catalogue.count(p=p, status="orbit")) for p in range(2, 9)]


def test_pandas_reads_the_file(filled):
    pandas = pytest.importorskip("pandas")
    frame = pandas.read_sql(BY_PERIOD, f"sqlite:///{filled}")
    assert [*frame.itertuples(index=False, name=None)] == numbers(filled)


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("datasette") is None, reason="Datasette is not installed")
def test_datasette_reads_the_file(filled):
    page = f"/{filled.stem}/catalogue.json?p=5&status=orbit&a=1.6&_size=max&_shape=array"
    done = subprocess.run(["datasette", "--get", page, filled], capture_output=True, text=True, check=True)
    found = {(row["code"], row["length"]) for row in json.loads(done.stdout)}
    assert found == {*Catalogue(filled, a=1.6).rows(p=5, status="orbit", columns=("code", "length"))}


@pytest.mark.slow
def test_duckdb_reads_an_exported_file(filled, tmp_path):
    duckdb = pytest.importorskip("duckdb")
    target = tmp_path / "orbits.parquet"
    Catalogue(filled, a=1.6).rows(status="orbit").write(target)
    query = f"SELECT p, count(*) FROM '{target}' GROUP BY p ORDER BY p"
    assert duckdb.sql(query).fetchall() == numbers(filled)


@pytest.mark.slow
def test_duckdb_attaches_the_file(filled):
    duckdb = pytest.importorskip("duckdb")
    connection = duckdb.connect()
    try:
        connection.execute(f"ATTACH '{filled}' AS orbits (TYPE sqlite)")
    except duckdb.IOException:
        pytest.skip("DuckDB's extension for SQLite is neither installed nor can it be downloaded")
    names = ("code", "p", "length", "area", "quarter_maslov", "quarter_length")
    query = f"SELECT {', '.join(names)} FROM orbits.catalogue WHERE a = 1.6 AND status = 'orbit'"
    found = connection.execute(query).fetchall()
    assert sorted(found) == sorted(map(tuple, Catalogue(filled, a=1.6).rows(columns=names)))
