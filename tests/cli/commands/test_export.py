"""Exported files keep every bit and their provenance, or are not written at all."""

import json
import os
import subprocess
import sys
from operator import itemgetter

import numpy as np
import pytest
from processes import COMMAND
from there import there

from orbitdb import Catalogue, __version__
from orbitdb import output_files as files
from orbitdb.errors import SelectionError


@pytest.mark.slow
def test_every_format_records_its_provenance(varied, tmp_path, cli):
    from pyarrow import parquet

    paths = {form: tmp_path / f"orbits.{form}" for form in ("csv", "tsv", "json", "jsonl", "parquet")}
    chosen = ("--p", "2-5", "--status", "orbit,dynamical", "-c", "+coordinates", "--db", str(varied))
    for path in paths.values():
        done = cli("export", str(path), *chosen)
        assert done.code == 0, done.err
        assert "dynamically pruned words of period 2 to 5 at a = 1.6" in done.err
    kept = [
        json.loads(files.metadata_path(paths[form]).read_text()) for form in ("csv", "tsv", "json", "jsonl")
    ]
    of_table = parquet.read_table(paths["parquet"]).schema.metadata
    kept.append({name.decode(): json.loads(value) for name, value in of_table.items()})
    for metadata in kept:
        assert metadata["orbitdb"] == __version__
        assert metadata["selection"].endswith("of period 2 to 5 at a = 1.6")
        assert metadata["a"] == 1.6
        assert metadata["database"] == str(varied)
        assert metadata["date"].endswith("+00:00")


def test_exported_bounces_are_where_the_orbit_hits_the_boundary(varied, tmp_path, cli):
    from pyarrow import parquet

    target = tmp_path / "bounces.parquet"
    chosen = (
        "--p",
        "5",
        "--status",
        "orbit,dynamical",
        "--by-bounce",
        "-c",
        "code,error",
        "--db",
        str(varied),
    )
    assert cli("export", str(target), *chosen).code == 0
    table = parquet.read_table(target)
    found = {name: table[name].to_numpy() for name in table.column_names}
    subset = Catalogue(varied).select(p=5, status="orbit", coordinates=True)
    assert [str(code) for code in found["code"]] == np.repeat(subset.code, 5).tolist()
    assert "".join(map(str, found["symbol"])) == "".join(subset.code)
    np.testing.assert_array_equal(found["n"], np.tile(np.arange(1, 6), len(subset)))
    np.testing.assert_allclose(found["coordinate"], there(subset.coordinates), rtol=0, atol=1e-15)
    points = np.stack([found["x"], found["y"]], axis=-1).reshape(-1, 5, 2)
    ahead = np.roll(points, -1, axis=1) - points
    ahead /= np.linalg.norm(ahead, axis=-1, keepdims=True)
    outward = points - np.clip(points, [-1.6, 0], [1.6, 0])  # along a radius, or away from a wall
    sine = outward[..., 0] * ahead[..., 1] - outward[..., 1] * ahead[..., 0]
    np.testing.assert_allclose(found["sine"], sine.ravel(), rtol=0, atol=1e-14)
    angle = np.arctan2(points[..., 1], np.abs(points[..., 0]) - 1.6)
    right = 2 * 1.6 + np.pi / 2 + angle
    arclength = np.where(
        np.abs(points[..., 0]) < 1.6,
        np.where(points[..., 1] < 0, points[..., 0] + 1.6, 4.8 + np.pi - points[..., 0]),
        np.where(points[..., 0] > 0, right, 8 * 1.6 / 2 + 1.5 * np.pi - angle),
    )
    np.testing.assert_allclose(found["arclength"], arclength.ravel(), rtol=0, atol=1e-14)


def test_bounces_of_one_word_equal_those_of_the_export(varied, cli):
    asked = ("--by-bounce", "--format", "jsonl", "--db", str(varied))
    one = cli("query", "--code", "3123", *asked)
    other = cli("export", "--p", "4", "--where", "code = '1233'", *asked)
    here, there = ([json.loads(row)["x"] for row in done.out.splitlines()] for done in (one, other))
    assert here == [there[-1], *there[:-1]]


@pytest.mark.slow
def test_a_tilde_is_the_home_folder_in_every_path(filled, tmp_path, cli, monkeypatch):
    home, elsewhere = tmp_path / "home", tmp_path / "elsewhere"
    for folder in (home, elsewhere):
        folder.mkdir()
    monkeypatch.setenv("HOME", str(home))
    monkeypatch.chdir(elsewhere)
    (home / "levels.csv").write_text("k\n2\n3\n")
    asked = ("--db", str(filled))
    for command in (
        ("export", "~/bounces.csv", "--by-bounce", "--where", "code = '13'", *asked),
        ("identify", "--points", "~/bounces.csv", *asked),
        ("plot", "orbit", "13", "-o", "~/orbit.svg", *asked),
        ("export", "~/data", "--dataset", "--p", "2", *asked),
        ("verify", "~/data"),
        ("spectrum", "--levels", "~/levels.csv", *asked),
    ):
        assert "~" not in cli(*command).err, command
    assert {"bounces.csv", "orbit.svg", "data"} <= {path.name for path in home.iterdir()}
    assert not list(elsewhere.iterdir())


@pytest.mark.parametrize(
    ("command", "name", "begins"),
    [("export --p 3", "x.csv", "code,"), ("plot orbit --code 13 -o", "x.svg", "<?xml")],
)
def test_an_existing_file_is_kept_without_force(varied, tmp_path, cli, command, name, begins):
    target = tmp_path / name
    target.write_text("mine")
    asked = (*command.split(), str(target), "--db", str(varied))
    done = cli(*asked)
    assert (done.code, target.read_text()) == (2, "mine")
    assert "--force" in done.err
    assert cli(*asked, "--force").code == 0
    assert target.read_text().startswith(begins)


def test_the_provenance_of_another_file_is_kept_without_force(varied, tmp_path, cli):
    target, beside = tmp_path / "x.csv", tmp_path / "x.csv-metadata.json"
    beside.write_text("another's")
    asked = ("export", "--p", "3", str(target), "--db", str(varied))
    assert cli(*asked).says(2, "x.csv-metadata.json already exists", "--force")
    assert (target.exists(), beside.read_text()) == (False, "another's")
    assert cli(*asked, "--force").code == 0
    assert json.loads(beside.read_text())["selection"]


@pytest.mark.parametrize(
    "asked",
    ["--p 2-6 --order -length", "--contains 013 --order code", "--status geometric,boundary,orbit --p 3-4"],
)
def test_classes_have_one_row_each(varied, tmp_path, cli, asked):
    asked = (*asked.split(), "--a", "1.6", "-c", "representative,code,length", "--db", str(varied))
    words = json.loads(cli("query", *asked, "--json").out)
    found = cli("query", *asked, "--classes", "--json")
    classes = json.loads(found.out)
    assert {row["representative"] for row in words} == {row["representative"] for row in classes}
    assert len(classes) < len(words)
    named = [row["code"] for row in classes if row["representative"]]
    least: dict[str, str] = {}
    for row in sorted(words, key=itemgetter("code")):
        least.setdefault(row["representative"], row["code"])
    assert sorted(named) == sorted(code for word, code in least.items() if word)
    if "-length" in asked:
        order = {row["representative"]: None for row in words}
        assert [row["representative"] for row in classes] == list(order)
    elif "code" in asked:
        assert named == sorted(named)
        assert sorted(named, key=len) != named  # not the order of periods
    said = cli("export", str(tmp_path / "x.jsonl"), *asked, "--classes").err
    assert f"{len(classes)} rows written: classes of " in said
    assert [json.loads(row) for row in (tmp_path / "x.jsonl").read_text().splitlines()] == classes


def test_classes_in_python_have_no_averages(varied):
    subset = Catalogue(varied, a=1.6).select(p="2-4", status="orbit", classes=True)
    assert subset.code.tolist() == subset.representative.tolist()
    assert str(subset[:3]) == "<3 of 11 classes of orbits of period 2 to 4 at a = 1.6>"
    assert subset.words.tolist() == subset.class_size.tolist()
    cut = Catalogue(varied, a=1.6).select(p="2-4", limit=5)
    for of, remedy in ((subset, "select without classes=True"), (cut, "select without a limit")):
        for question in (of.entropy, of.averages, of.table):
            with pytest.raises(SelectionError, match=remedy):
                question()


@pytest.mark.parametrize(
    ("where", "shown"),
    [
        (("--where", "area > 0"), [("031", 1, 3.1404, 2), ("133", 1, 3.6854, 2)]),
        (("--without", "013"), [("031", 1, 3.1404, 3), ("113", 0, -3.6854, 4)]),
        (("--where", "code = '123'"), [("123", 3, -3.1404, 1)]),
        (("--order", "element,-length"), [("113", 0, -3.6854, 4), ("013", 0, -3.1404, 4)]),
    ],
)
def test_a_class_is_shown_by_the_least_word_that_fulfils_the_conditions(varied, tmp_path, cli, where, shown):
    asked = (*where, "--p", "3", "--a", "1.6", "--classes", "-c", "+element", "--db", str(varied))
    rows = json.loads(cli("query", *asked, "--json").out)
    found = [(row["code"], row["element"], round(row["area"], 4), row["words"]) for row in rows]
    assert sorted(found) == sorted(shown)
    assert found == shown or "--order" not in where
    file = tmp_path / "classes.json"
    assert cli("export", str(file), *asked).code == 0
    assert json.loads(file.read_text()) == rows


def test_files_say_in_which_order_their_rows_are_and_how_many_at_most(varied, tmp_path, cli):
    file = tmp_path / "shortest.csv"
    asked = ("--p", "2-7", "--order", "length", "--limit", "2", "--db", str(varied), "--a", "1.6")
    assert cli("export", str(file), *asked).code == 0
    said = json.loads(files.metadata_path(file).read_text())
    assert (said["order"], said["limit"], said["offset"]) == ("length", 2, 0)


def through_links(target):
    """A path, an absolute link, and a relative link to that link."""
    target.with_name("link").symlink_to(target)
    target.with_name("links").symlink_to("link")
    return target, target.with_name("link"), target.with_name("links")


@pytest.mark.parametrize("command", ["export --format csv", "plot orbit 13 --format png -o"])
def test_no_output_replaces_a_catalogue(own, tmp_path, cli, command):
    others = [tmp_path / name for name in ("other.db", "wal.csv", "journal.csv")]
    for path, start in zip(
        others, ("53514c69746520666f726d6174203300", "377f0682", "d9d505f920a163d7"), strict=True
    ):
        path.write_bytes(bytes.fromhex(start) + bytes(4096))
    before = {path: path.read_bytes() for path in (own, *others)}
    other, *journals = others
    linked = [tmp_path / f"{path.name}.link" for path in journals]
    for link, path in zip(linked, journals, strict=True):
        link.symlink_to(path)
    for path in (*through_links(own), other, *journals, *linked):
        for force in ((), ("--force",)):
            done = cli(*command.split(), str(path), *force, "--db", str(other if path == own else own))
            assert done.says(2, "is an SQLite file, such as a catalogue"), (path, force, done)
    assert {path: path.read_bytes() for path in before} == before


@pytest.mark.parametrize("command", ["export --format csv", "plot orbit 13 --format svg -o"])
def test_an_output_through_a_link_replaces_its_target_and_keeps_the_mode(varied, tmp_path, cli, command):
    target = tmp_path / "x"
    target.write_text("old")
    target.chmod(0o640)
    *_, link = through_links(target)
    assert cli(*command.split(), str(link), "--force", "--db", str(varied)).code == 0
    assert (link.is_symlink(), target.stat().st_mode & 0o777) == (True, 0o640)
    assert target.read_text() != "old"


@pytest.mark.slow
def test_settings_of_a_notebook_or_of_latex_do_not_stop_a_figure(varied, tmp_path):
    (tmp_path / "matplotlibrc").write_text("text.usetex: True\n")
    settings = os.environ | {"MPLBACKEND": "module://missing", "PATH": str(tmp_path)}
    drawn = [*COMMAND, "plot", "orbit", "13", "-o", "x.png", "--db", str(varied)]
    done = subprocess.run(drawn, cwd=tmp_path, env=settings, capture_output=True, text=True)
    assert (done.returncode, done.stderr.splitlines()[0]) == (0, "orbit 13 at a = 1.6, in x.png")


@pytest.mark.slow
def test_a_figure_on_stdout_equals_the_file(varied, tmp_path, cli):
    drawn = ("plot", "orbit", "--code", "13", "--db", str(varied))
    target = tmp_path / "x.svg"
    target.write_text("old")
    assert cli(*drawn, "-o", str(target), "--force").code == 0
    shown = subprocess.run([*COMMAND, *drawn, "-o", "-", "--format", "svg"], capture_output=True, check=True)
    assert shown.stdout == target.read_bytes()


@pytest.mark.parametrize(
    ("arguments", "package", "said"),
    [
        ("plot orbit 13 -o x.svg", "matplotlib", "plot needs matplotlib: pip install 'orbitdb[plot]'"),
        ("export x.parquet", "pyarrow", "a parquet file needs pyarrow: pip install 'orbitdb[parquet]'"),
    ],
)
def test_a_missing_extra_is_named_with_its_install_command(
    varied, tmp_path, cli, monkeypatch, arguments, package, said
):
    monkeypatch.chdir(tmp_path)
    for loaded in ("orbitdb.plots.by_name", "orbitdb.plots.style", "pyarrow.parquet"):
        monkeypatch.delitem(sys.modules, loaded, raising=False)
    monkeypatch.setitem(sys.modules, package, None)
    outcome = cli(*arguments.split(), "--a", "1.6", "--db", str(varied))
    assert (outcome.code, outcome.err) == (1, f"orbitdb: {said}\n")
    assert list(tmp_path.iterdir()) == []
