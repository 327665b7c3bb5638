"""`bench`: every kind of it, and its figure."""

import json

import pytest

from orbitdb.benchmarks import work_precision


@pytest.mark.slow
def test_methods_and_their_figure(cli, tmp_path, monkeypatch):
    monkeypatch.setattr(work_precision, "REPEATS", 1)
    figure = tmp_path / "methods.svg"
    drawn = cli("bench", "--p", "3", "--json", "--plot", str(figure))
    rows = json.loads(drawn.out)
    assert {row["method"] for row in rows} == {"newton", "relaxation", "root", "balls"}
    assert {row["words"] for row in rows} == {2}
    assert "run time against error, p = 3 at a = 1.6" in figure.read_text()
    assert f"p = 3 at a = 1.6, in {figure}" in drawn.err
