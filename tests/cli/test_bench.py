"""`bench`: every kind of it, and its figure."""

import csv
import json
from itertools import islice

import pytest

from orbitdb.benchmarks import stress, work_precision


def test_stages_of_several_periods(cli):
    done = cli("bench", "--kind", "stages", "--p", "2-4", "--json")
    rows = json.loads(done.out)
    assert [(row["p"], row["sequences"], row["classes"]) for row in rows] == [
        (2, 1, 1),
        (3, 8, 2),
        (4, 32, 8),
    ]
    assert all(value >= 0 for row in rows for name, value in row.items() if name != "p")


def test_hard_cases(cli, monkeypatch):
    """The first of one of the seven kinds; all of them take a while."""
    monkeypatch.setattr(stress, "CASES", {"joint": lambda: islice(stress.joint_words(), 2)})
    rows = list(csv.DictReader(cli("bench", "--kind", "stress", "--format", "csv").out.splitlines()))
    assert [row["case"] for row in rows] == ["joint", "joint"]


def test_statuses_all_explained(cli):
    done = cli("bench", "--kind", "statuses", "--p", "2,3", "--json")
    assert done.code == 0
    assert [(row["p"], row["unexplained"]) for row in json.loads(done.out)] == [(2, 0), (3, 0)]


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


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--p", "3-4"], "periods 3 to 4: methods are compared on one, such as --p 9"),
        (["--p", "1"], "periods '1': measure from 2 to 13"),
        (["--p", "14", "--kind", "stages"], "periods '14': measure from 2 to 13"),
        (["--p", "3", "--plot", "x.gif"], ""),
    ],
)
def test_what_it_refuses(cli, arguments, said):
    done = cli("bench", *arguments)
    assert (done.code, done.out, len(done.err.splitlines())) == (2, "", 1)
    assert said in done.err
