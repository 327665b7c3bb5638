"""A dataset is readable by other tools, reproducible and checked."""

import csv
import json
from contextlib import closing
from pathlib import Path

import pandas
import pytest
from contents import ask

from orbitdb import Catalogue


@pytest.fixture(scope="module")
def known(tmp_path_factory):
    """A catalogue with rows in every table."""
    path = tmp_path_factory.mktemp("dataset") / "orbits.db"
    with closing(Catalogue.create(path, 1.6)) as catalogue:
        catalogue.fill("2-5")
        catalogue.fill("2-3", a=1)
        catalogue.fill_births("2-4")
        catalogue.prove_bounds(5)
        catalogue.fill_levels(3, parities=["ee"])
    return str(path)


def test_other_tools_read_the_same_data_as_the_catalogue(known, cli, tmp_path):
    folder = tmp_path / "data"
    outcome = cli("export", str(folder), "--dataset", "--db", known)
    assert (outcome.code, outcome.out) == (0, "")
    frame = pandas.concat(map(pandas.read_parquet, sorted((folder / "orbits").glob("a=1.6*.parquet"))))
    rows = ask(Path(known), "SELECT code, status, length FROM catalogue WHERE a = 1.6")
    found = zip(frame["code"], frame["status"], frame["length"].fillna(0.0), strict=True)
    assert sorted(found) == sorted((code, status, length or 0.0) for code, status, length in rows)
    assert all(len(x) == p for x, p in zip(frame["coordinates"], frame["p"], strict=True) if x is not None)
    counts = list(csv.DictReader((folder / "counts.csv").read_text().splitlines()))
    assert [(row["a"], row["p"], row["N_c"]) for row in counts][-1] == ("1.6", "5", "80")
    levels = pandas.read_csv(folder / "levels.csv")
    assert levels["k"].tolist() == [k for (k,) in ask(Path(known), "SELECT k FROM level ORDER BY k")]
    described = json.loads((folder / "datapackage.json").read_text())
    files = {each["path"] for each in described["resources"]} | {"README.md", "datapackage.json"}
    assert files == {str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file()}
    (length,) = (each for each in described["resources"][0]["schema"]["fields"] if each["name"] == "length")
    assert (length["type"], length["unit"], length["bound"]) == ("number", "radius", "length_error")
    assert {each["command"] for each in described["made_by"]} >= {"fill", "births", "bounds", "levels"}
    assert [path.name for path in tmp_path.iterdir()] == ["data"]


def test_the_same_catalogue_gives_the_same_bytes(known, cli, tmp_path):
    for name in ("one", "two"):
        assert cli("export", str(tmp_path / name), "--dataset", "--a", "1.6", "--db", known).code == 0
    one, two = (
        {p.relative_to(tmp_path / n): p.read_bytes() for p in (tmp_path / n).rglob("*.*")}
        for n in ("one", "two")
    )
    assert one == two
    assert not [path for path in one if "a=1_" in path.name]


def test_a_dataset_is_checked(known, cli, tmp_path):
    folder = tmp_path / "data"
    assert cli("export", str(folder), "--dataset", "--db", known).code == 0
    assert cli("verify", str(folder)).code == 0
    (folder / "counts.csv").write_text("a,p\n")
    next((folder / "orbits").iterdir()).unlink()
    outcome = cli("verify", str(folder), "--json")
    assert outcome.code == 1
    (row,) = json.loads(outcome.out)
    assert (row["check"], row["failures"]) == ("dataset", 2)
    assert cli("verify", str(tmp_path)).says(2, "holds no dataset")
    assert cli("verify", str(folder), "--rigorous").says(2, "--rigorous")


def test_a_failed_export_leaves_no_files(known, cli, tmp_path, monkeypatch):
    (tmp_path / "there").mkdir()
    assert cli("export", str(tmp_path / "there"), "--dataset", "--db", known).says(2, "already exists")
    assert cli("export", str(tmp_path / "no" / "x"), "--dataset", "--db", known).says(3, "there is no folder")
    assert cli("export", "--dataset", "--db", known).says(2, "name the folder")
    assert cli("export", str(tmp_path / "x"), "--dataset", "--p", "3", "--db", known).says(2, "--p")
    assert cli("export", str(tmp_path / "x"), "--dataset", "--a", "3", "--db", known).says(
        2, "no whole period"
    )

    def stop(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("orbitdb.answers.dataset.table", stop)
    assert cli("export", str(tmp_path / "x"), "--dataset", "--db", known).code == 130
    assert [path.name for path in tmp_path.iterdir()] == ["there"]
