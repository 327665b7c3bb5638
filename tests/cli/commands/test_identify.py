"""`identify` on the command line; its answers are tested in tests/store/test_identify.py."""

import io
import json
import sys

import numpy as np
import pytest
from quick import slow_but
from there import there

from orbitdb import read_points, solve_word

ORBIT = solve_word("1232131", 1.6)
POINTS = there(ORBIT.points).tolist()
LINES = "\n".join(f"{x!r},{y!r}" for x, y in POINTS)


@pytest.fixture
def stdin(monkeypatch):
    return lambda text: monkeypatch.setattr("sys.stdin", io.StringIO(text))


FILES = {
    "pairs": LINES,
    "blanks": "# bounces\n\n" + LINES.replace(",", " "),
    "complex": "\n".join(f"({x!r}+0j),({y!r}-0.0e+00j)" for x, y in POINTS),
    "names": "n,y,x\n" + "\n".join(f"{n},{y},{x}" for n, (x, y) in enumerate(POINTS)),
    "json": json.dumps(POINTS),
    "objects": json.dumps([{"x": x, "y": y} for x, y in POINTS]),
    "lines": "\n".join(json.dumps({"x": x, "y": y}) for x, y in POINTS),
    "indented objects": "\n\n".join(json.dumps({"x": x, "y": y}, indent=1) for x, y in POINTS),
}


@pytest.mark.parametrize("form", slow_but(["pairs", "complex", "names", "objects"], FILES))
def test_points_are_read_in_any_notation(cli, tmp_path, stdin, form):
    """No catalogue is needed."""
    stdin(FILES[form])
    (tmp_path / "points").write_text(FILES[form], encoding="utf-8-sig")
    for place in ("-", str(tmp_path / "points")):
        done = cli("identify", "--points", place, "--json")
        (row, *_) = json.loads(done.out)
        assert (row["code"], row["first"], row["last"], row["turns"]) == ("1232131", 1, 7, 1.0)
        assert row["stored"] is False
        assert row["sequence"] == "1232131"
    np.testing.assert_array_equal(read_points(tmp_path / "points"), POINTS)


def test_the_number_of_rows_and_bounces_can_be_chosen(cli):
    asked = ("identify", "--start", "0,0.001,0", "--a", "1.6", "--bounces", "9", "--json")
    every, some = (json.loads(cli(*asked, *limit).out) for limit in ([], ["--limit", "2"]))
    assert (some, len(some)) == (every[:2], 2)
    assert len(every) > 2
    assert (len(every[0]["sequence"]), every[0]["sequence_first"]) == (18, -8)


@pytest.mark.slow
def test_identify_reads_the_output_of_query_and_identify(cli, filled, stdin):
    for form in ("csv", "tsv", "json", "jsonl"):
        stdin(cli("query", "1232131", "--by-bounce", "--format", form, "--db", str(filled)).out)
        done = cli("identify", "--points", "-", "--limit", "1", "--format", form, "--db", str(filled))
        assert done.code == 0, done.err
        assert "1232131" in done.out
        assert done.err == "1 orbit is shadowed\n"


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ("2.6,0\n-2.6\n2.6,0", "line 2 does not have two numbers"),
        ("x,y\n2.6,0\n-2.6", "line 3 does not have two numbers"),
        ("x,y\n2.6,0\n-2.6,zero", "line 3: 'zero' is not a number"),
        ("[[2.6, 0], [", "line 1 is not json"),
        ('{"x": 1, "y": 2}\n{"x": 1}', "an object lacks x or y"),
        ("[" * 100_000, "write one bounce x,y per line"),
        ('[["x", "y"]]', "pairs x,y"),
    ],
)
def test_bad_points_are_reported_in_one_line(cli, stdin, given, told):
    stdin(given)
    assert cli("identify", "--points", "-").says(2, "orbitdb: ", told)


def test_points_and_codes_that_are_not_text_are_refused(cli, filled, tmp_path, monkeypatch):
    points = tmp_path / "points"
    points.write_bytes(b"\xff\xfe")
    assert cli("identify", "--points", str(points)).says(2, str(points), "not text", "x,y")
    points.write_text('{"x": 1, "y": 2}\n{x')
    done = cli("identify", "--points", str(points))
    assert (done.code, done.out) == (2, "")
    assert done.err.startswith(f"orbitdb: {points}: line 2 is not json: write one bounce x,y per line")
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(b"13\n\xff\n"), "utf-8"))
    assert cli("query", "--code", "-").says(2, "stdin is not text")


def test_a_table_of_orbits_of_a_length_fits_the_screen(cli, filled):
    asked = ("identify", "--length", "22", "--tolerance", "1", "--db", str(filled))
    every = cli(*asked, "--format", "csv").out.splitlines()
    assert len(every) > 60
    table = cli(*asked)
    assert len(table.out.splitlines()) == 1 + 40
    assert f"; 40 shown, --limit {len(every) - 1} shows all" in table.err
    assert len(cli(*asked, "--limit", "50").out.splitlines()) == 1 + 50


def test_an_angle_in_degrees_is_noticed(cli):
    asked = ("identify", "--a", "1.6", "--bounces", "5", "--json", "--start")
    degrees = cli(*asked, "0,0,80")
    assert "the angle 80 is beyond 2 pi: angles are in radians; 80 degrees are 1.39626" in degrees.err
    assert "radians" not in cli(*asked, "0,0,-6.2").err
