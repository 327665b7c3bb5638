"""A dataset is readable by other tools, reproducible and checked."""

import csv
import hashlib
import json
import os
import shutil
import signal
from contextlib import closing
from pathlib import Path

import pandas
import pyarrow.parquet
import pytest
from contents import ask
from made_levels import keep_made_levels
from processes import small_blocks, start

from orbitdb import Catalogue, Selection, __version__
from orbitdb.answers.dataset import write_dataset
from orbitdb.store.file import reading
from orbitdb.store.lookup import a_values


@pytest.fixture(scope="module")
def known(tmp_path_factory):
    """A catalogue with rows in every table."""
    path = tmp_path_factory.mktemp("dataset") / "orbits.db"
    with closing(Catalogue.create(path, 1.6)) as catalogue:
        catalogue.fill("2-5")
        catalogue.fill("2-3", a=1)
        catalogue.fill_births("2-4")
        catalogue.prove_bounds(5)
        catalogue.simulate(bounces=2000, seed=7)
        catalogue.escape("top:-0.3:0.3", "33", trajectories=100, bounces=5)
    keep_made_levels(path)
    return str(path)


@pytest.fixture(scope="module")
def written(known):
    """A dataset of the entire catalogue."""
    made = Path(known).with_name("data")
    with reading(known) as connection:
        write_dataset(connection, made, [Selection(a) for a in a_values(connection)])
    return made


@pytest.fixture
def folder(written, tmp_path):
    """A copy of this dataset in a folder of its own."""
    return Path(shutil.copytree(written, tmp_path / "data"))


def package(folder):
    return json.loads((folder / "datapackage.json").read_text(encoding="utf-8"))


def files_of(folder):
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def read_csv(path):
    return list(csv.DictReader(path.read_text(encoding="utf-8").splitlines()))


@pytest.mark.slow
def test_other_tools_read_the_same_orbits_as_the_catalogue(known, folder):
    frame = pandas.read_parquet(folder / "orbits")
    rows = ask(Path(known), "SELECT a, code, status, length FROM catalogue")
    found = zip(frame["a"], frame["code"], frame["status"], frame["length"].fillna(0.0), strict=True)
    assert sorted(found) == sorted((a, code, status, length or 0.0) for a, code, status, length in rows)
    assert all(len(x) == p for x, p in zip(frame["coordinates"], frame["p"], strict=True) if x is not None)
    parts = [pandas.read_parquet(path) for path in sorted((folder / "orbits").iterdir())]
    assert all(part["representative"].tolist() == sorted(part["representative"]) for part in parts)
    kept = pyarrow.parquet.ParquetFile(folder / "orbits/a=1.6_p=05.parquet").metadata.row_group(0).column(0)
    assert kept.compression == "ZSTD"


@pytest.mark.slow
def test_other_tools_read_the_same_tables_as_the_catalogue(known, folder):
    classes = pandas.read_parquet(folder / "classes.parquet")
    assert classes["representative"].tolist() == [
        word for (word,) in ask(Path(known), "SELECT word FROM cycle ORDER BY id")
    ]
    births = pandas.read_parquet(folder / "births.parquet")
    lives = ask(Path(known), "SELECT word, coalesce(born, 0) FROM life")
    assert sorted(zip(births["representative"], births["born"].fillna(0), strict=True)) == sorted(lives)
    counts = read_csv(folder / "counts.csv")
    assert [(row["a"], row["p"], row["N_c"]) for row in counts][-1] == ("1.6", "5", "80")
    averages = pandas.read_csv(folder / "averages.csv")
    assert averages[["a", "p"]].values.tolist() == [[1, 2], [1, 3], [1.6, 2], [1.6, 3], [1.6, 4], [1.6, 5]]
    names = {"parity": str, "number": int, "k": float, "error": float}
    levels = [
        tuple(kind(row[name]) for name, kind in names.items()) for row in read_csv(folder / "levels.csv")
    ]
    assert sorted(levels) == sorted(ask(Path(known), f"SELECT {', '.join(names)} FROM level"))
    (trajectories,) = read_csv(folder / "trajectories.csv")
    assert (trajectories["a"], trajectories["seed"]) == ("1.6", "7")
    (rates,) = read_csv(folder / "escapes.csv")
    assert (rates["opening"], rates["without"], rates["trajectories"]) == ("top:-0.3:0.3", "33", "100")
    assert float(rates["measure"]) == pytest.approx(0.047307, abs=1e-6)
    survival = read_csv(folder / "survival.csv")
    assert [row["n"] for row in survival if row["n"]] == [row["t"] for row in survival if row["t"]]
    (bounds,) = read_csv(folder / "bounds.csv")
    assert (bounds["edges"], bounds["arithmetic"]) == ("5", "doubles")


def test_everything_in_the_folder_is_described(folder):
    described = package(folder)
    resources = {each["path"]: each for each in described["resources"]}
    written = files_of(folder)
    assert set(resources) | {"datapackage.json"} == set(written)
    for path, each in resources.items():
        assert each["hash"] == f"sha256:{hashlib.sha256(written[path]).hexdigest()}"
        fields = each["schema"]["fields"] if "rows" in each else []
        assert all(field["description"] for field in fields), path
        assert all(field["unit"] for field in fields if field["type"] == "number"), path

    def told(path, name):
        (field,) = (each for each in resources[path]["schema"]["fields"] if each["name"] == name)
        return field["description"], field.get("unit"), field.get("bound")

    orbits = "orbits/a=1.6_p=05.parquet"
    assert told(orbits, "length") == ("length of one traversal, L", "radius", "length_error")
    assert told("levels.csv", "error") == ("estimated error of k", "1/radius", None)
    assert told("averages.csv", "lambda_c_zeta")[:2] == (
        "average lambda_c; zeta function to order p",
        "1/radius",
    )
    assert resources[orbits]["title"] == "96 words of period 5 at a = 1.6"
    made = {each["command"]: each for each in described["made_by"]}
    assert made["simulate"]["seed"] == 7
    assert set(made) >= {"fill", "births", "bounds", "levels"}
    assert "Creative Commons Attribution 4.0" in (folder / "LICENSE.txt").read_text(encoding="utf-8")
    readme = (folder / "README.md").read_text(encoding="utf-8")
    assert (
        f"\n{described['description']}. Version {described['version']}, made by orbitdb {__version__}.\n"
        in readme
    )
    assert f'version: "{described["version"]}"' in (folder / "CITATION.cff").read_text(encoding="utf-8")
    assert "@" not in readme


@pytest.mark.slow
def test_the_same_catalogue_gives_the_same_bytes(known, cli, tmp_path):
    for name in ("one", "two"):
        assert cli("export", str(tmp_path / name), "--dataset", "--a", "1.6", "--db", known).code == 0
    one, two = (files_of(tmp_path / name) for name in ("one", "two"))
    assert one == two
    assert (
        cli(
            "export", str(tmp_path / "two"), "--dataset", "--force", "--p", "2-4", "--a", "1.6", "--db", known
        ).code
        == 0
    )
    assert package(tmp_path / "one")["version"] != package(tmp_path / "two")["version"]
    assert sorted(path.name for path in tmp_path.iterdir()) == ["one", "two"]
    assert not [path for path in one if "a=1_" in path]


def test_a_selection_limits_periods_and_words_but_not_counts(known, cli, tmp_path):
    part, whole = tmp_path / "part", tmp_path / "whole"
    asked = "export", "--dataset", "--p", "4-5", "--a", "1.6", "--db", known
    assert cli(*asked, str(part), "--time-reversal", "self", "--status", "orbit").says(
        0, "that retrace their path"
    )
    assert cli(*asked, str(whole)).code == 0
    frame = pandas.read_parquet(part / "orbits")
    assert set(frame["p"]) == {4}  # none of period 5 retraces its path; its file is there
    assert [path.name for path in sorted((part / "orbits").iterdir())] == [
        "a=1.6_p=04.parquet",
        "a=1.6_p=05.parquet",
    ]
    of_orbits = [
        {each["complete"] for each in package(folder)["resources"] if "orbits/" in each["path"]}
        for folder in (part, whole)
    ]
    assert of_orbits == [{False}, {True}]
    assert set(frame["status"]) == {"orbit"}
    assert set(frame["time_reversal"]) == {"self"}
    for name in ("counts.csv", "averages.csv"):
        assert (part / name).read_bytes() == (whole / name).read_bytes()
        assert {row["p"] for row in read_csv(part / name)} == {"4", "5"}
    assert set(pandas.read_parquet(part / "births.parquet")["p"]) == {4}
    assert "retrace their path" in package(part)["description"]
    assert [cli("verify", str(each)).code for each in (part, whole)] == [0, 0]
    outcome = cli("export", str(tmp_path / "x"), "--dataset", "--range", "length=:1", "--db", known)
    assert (outcome.code, outcome.err.count("with length <= 1: nothing is written")) == (1, 2)
    assert not (tmp_path / "x").exists()


ORBITS = "orbits/a=1.6_p=04.parquet"


def one_byte_changed(folder):
    data = bytearray((folder / ORBITS).read_bytes())
    data[100] ^= 1
    (folder / ORBITS).write_bytes(data)


@pytest.mark.parametrize(
    ("damage", "fault"),
    [
        (one_byte_changed, f"{ORBITS} does not match its sha256 sum"),
        (lambda folder: (folder / ORBITS).unlink(), f"{ORBITS} is missing"),
        (lambda folder: (folder / "orbits/x.parquet").touch(), "orbits/x.parquet does not belong"),
        (lambda folder: (folder / "LICENSE.txt").write_text("mine"), "LICENSE.txt does not match"),
    ],
    ids=["byte", "missing", "other", "text"],
)
def test_damage_is_found(folder, cli, damage, fault):
    assert cli("verify", str(folder)).code == 0
    damage(folder)
    outcome = cli("verify", str(folder), "--json")
    assert outcome.code == 1
    (row,) = json.loads(outcome.out)
    assert (row["check"], row["failures"]) == ("dataset", 1)
    assert row["first"].startswith(fault)


def test_a_folder_that_is_not_a_dataset_is_refused(known, cli, tmp_path):
    for path in (tmp_path, Path(known), tmp_path / "no"):
        assert cli("verify", str(path)).says(2, "is not a dataset")
    (tmp_path / "datapackage.json").write_text('{"name": "stadium-orbits", "resources": [1]}')
    assert cli("verify", str(tmp_path)).says(2, "is not a dataset")
    assert cli("verify", str(tmp_path), "--prove").says(2, "--prove")


def test_a_failed_export_leaves_no_files(known, cli, tmp_path, monkeypatch):
    (tmp_path / "there").mkdir()
    (tmp_path / "there" / "notes.txt").write_text("mine")
    asked = "export", "--dataset", "--db", known
    assert cli(*asked, str(tmp_path / "there")).says(2, "already exists")
    assert cli(*asked, str(tmp_path / "there"), "--force").says(2, "is not a dataset")
    assert cli(*asked, str(tmp_path / "no" / "x")).says(3, "there is no folder")
    assert cli(*asked).says(2, "name the folder")
    assert cli(*asked, "-").says(2, "name the folder")
    assert cli(*asked, str(tmp_path / "x"), "--limit", "3").says(2, "--limit")
    assert cli(*asked, str(tmp_path / "x"), "--a", "3").says(1, "nothing is filled at a = 3")

    def stop(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("orbitdb.answers.dataset._others", stop)
    assert cli(*asked, str(tmp_path / "x")).code == 130
    assert [path.name for path in tmp_path.iterdir()] == ["there"]


NOBODY = 2**31 - 2
"""The number of no process."""


def test_force_replaces_a_dataset_or_leaves_it_intact(known, folder, cli, monkeypatch):
    asked = "export", str(folder), "--dataset", "--p", "2", "--force", "--db", known
    before = files_of(folder)
    folder.rename(folder.with_name(f".data.{NOBODY}.old"))  # as if killed between its two renames
    with monkeypatch.context() as patched:
        patched.setattr("orbitdb.answers.dataset._others", lambda *_: 1 / 0)
        with pytest.raises(ZeroDivisionError):
            cli(*asked)
    assert files_of(folder) == before
    assert cli(*asked).code == 0
    assert len(list((folder / "orbits").iterdir())) == 2
    assert cli("verify", str(folder)).code == 0
    assert [path.name for path in folder.parent.iterdir()] == ["data"]


def test_a_dataset_that_cannot_be_deleted_is_replaced_or_stays_whole(known, folder, cli, monkeypatch):
    unlink = os.unlink
    deleted: list[str] = []

    def refused(path, *, dir_fd=None):
        if dir_fd is not None and deleted:
            raise PermissionError(13, "Permission denied", path)
        deleted.extend([path] * (dir_fd is not None))
        unlink(path, dir_fd=dir_fd)

    with monkeypatch.context() as patched:
        patched.setattr(os, "unlink", refused)
        cli("export", str(folder), "--dataset", "--p", "2", "--force", "--db", known)
    assert deleted
    assert cli("verify", str(folder)).code == 0


@pytest.mark.parametrize("failing", [1, 2])
def test_a_dataset_is_put_back_if_it_cannot_be_renamed(known, folder, cli, monkeypatch, failing):
    """The first rename moves the old folder away, the second one moves the new folder to its place."""
    asked = "export", str(folder), "--dataset", "--p", "2", "--force", "--db", known
    before = files_of(folder)
    rename, calls = os.rename, list[object]()

    def refused(old, new):
        calls.append(new)
        if len(calls) == failing:
            raise PermissionError(13, "Permission denied", old)
        rename(old, new)

    with monkeypatch.context() as patched:
        patched.setattr(os, "rename", refused)
        assert cli(*asked).says(3, "cannot be written (Permission denied); nothing was saved")
    assert files_of(folder) == before
    assert [path.name for path in folder.parent.iterdir()] == ["data"]


@pytest.mark.parametrize("other", ["mine.txt", "orbits/orbits.db", ".git/config"])
def test_force_keeps_a_folder_that_holds_something_else(known, folder, cli, other):
    (folder / other).parent.mkdir(exist_ok=True)
    (folder / other).write_text("mine")
    before = files_of(folder)
    assert cli("export", str(folder), "--dataset", "--force", "--db", known).says(2, f"also holds {other}")
    assert files_of(folder) == before


def test_a_dataset_can_be_in_a_folder_named_tilde(known, cli, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert cli("export", "./~", "--dataset", "--p", "2", "--db", known).code == 0
    assert cli("verify", "./~").code == 0
    assert [path.name for path in tmp_path.iterdir()] == ["~"]


@pytest.mark.slow  # frictionless takes a second
def test_a_dataset_is_a_valid_data_package(folder):
    import frictionless

    assert package(folder)["$schema"] == "https://datapackage.org/profiles/2.0/datapackage.json"
    report = frictionless.validate(folder / "datapackage.json")
    assert report.flatten(["name", "type", "message"]) == []
    assert {task.name for task in report.tasks} >= {"counts", "classes", "births", "citation", "readme"}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("sent", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143), (signal.SIGKILL, -9)]
)
def test_an_export_that_is_ended_leaves_no_folder(known, tmp_path, sent, code):
    slow = small_blocks()
    slow[-1] = slow[-1].replace("run()\n", _WAITING)
    process = start("export", tmp_path / "x", "--dataset", "--db", known, command=slow)
    assert process.stdout is not None
    assert [process.stdout.readline() for _ in range(2)] == ["ready\n", "writing\n"]
    process.send_signal(sent)
    process.communicate(timeout=60)
    assert process.returncode == code
    left = [path.name for path in tmp_path.iterdir()]
    assert left == ([] if code > 0 else [f".x.{process.pid}.part"])


_WAITING = """
import time
from orbitdb.answers import dataset
def wait(*_):
    print("writing", flush=True)
    time.sleep(60)
dataset._others = wait
run()
"""
