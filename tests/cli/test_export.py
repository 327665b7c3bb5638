"""Exported files keep every bit and their provenance, or are not written at all."""

import io
import json
import subprocess
import sys

import numpy as np
import pytest
from processes import COMMAND
from there import there

from orbitdb import Catalogue, __version__
from orbitdb import export as files


@pytest.mark.slow
def test_every_format_records_its_provenance(varied, tmp_path, cli):
    from pyarrow import parquet

    paths = {form: tmp_path / f"orbits.{form}" for form in ("csv", "jsonl", "parquet", "npz")}
    chosen = ("--p", "2-5", "--status", "orbit,dynamical", "--coordinates", "--db", str(varied))
    for path in paths.values():
        done = cli("export", str(path), *chosen)
        assert done.code == 0, done.err
        assert "dynamically pruned words of period 2 to 5 at a = 1.6" in done.err
    kept = [json.loads(files.metadata_path(paths[form]).read_text()) for form in ("csv", "jsonl")]
    of_table = parquet.read_table(paths["parquet"]).schema.metadata
    kept.append({name.decode(): json.loads(value) for name, value in of_table.items()})
    with np.load(paths["npz"]) as archive:
        kept.append(json.loads(str(archive["metadata"])))
    for metadata in kept:
        assert metadata["orbitdb"] == __version__
        assert metadata["selection"].endswith("of period 2 to 5 at a = 1.6")
        assert metadata["a"] == 1.6
        assert metadata["database"] == str(varied)
        assert metadata["date"].endswith("+00:00")


def test_exported_bounces_are_where_the_orbit_hits_the_boundary(varied, tmp_path, cli):
    target = tmp_path / "bounces.npz"
    chosen = ("--p", "5", "--status", "orbit,dynamical", "--bounces", "-c", "code,error", "--db", str(varied))
    assert cli("export", str(target), *chosen).code == 0
    with np.load(target) as archive:
        found = dict(archive)
    subset = Catalogue(varied).select(p=5, status="orbit", coordinates=True)
    assert [str(code) for code in found["code"]] == np.repeat(subset.codes, 5).tolist()
    assert "".join(map(str, found["symbol"])) == "".join(subset.codes)
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
    asked = ("--bounces", "--format", "jsonl", "--db", str(varied))
    one = cli("query", "--code", "3123", *asked)
    other = cli("export", "--p", "4", "--where", "code = '1233'", *asked)
    here, there = ([json.loads(row)["x"] for row in done.out.splitlines()] for done in (one, other))
    assert here == [there[-1], *there[:-1]]


def test_marked_words_are_never_read_as_numbers(varied, cli):
    import pandas as pd

    chosen = ("--p", "3", "--status", "orbit,geometric", "--mark-words", "-c", "code,representative,length",
              "--order", "code", "--db", str(varied))  # fmt: skip
    exported = cli("export", "--format", "csv", *chosen)
    table = pd.read_csv(io.StringIO(exported.out))
    assert table["code"][1] == "w002"
    assert table["representative"].isna()[1]  # pruned geometrically
    assert exported.out == cli("query", "--format", "csv", *chosen).out
    (row,) = json.loads(cli("query", "--code", table["code"].iloc[-1], "--json", "--db", str(varied)).out)
    assert f"w{row['code']}" == table["code"].iloc[-1]


@pytest.mark.parametrize(
    ("command", "name", "begins"),
    [("export --p 3 -o", "x.csv", "code,"), ("plot orbit --code 13 -o", "x.svg", "<?xml")],
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
    for loaded in ("orbitdb.plots.style", "pyarrow.parquet"):
        monkeypatch.delitem(sys.modules, loaded, raising=False)
    monkeypatch.setitem(sys.modules, package, None)
    outcome = cli(*arguments.split(), "--a", "1.6", "--db", str(varied))
    assert (outcome.code, outcome.err) == (1, f"orbitdb: {said}\n")
    assert list(tmp_path.iterdir()) == []
