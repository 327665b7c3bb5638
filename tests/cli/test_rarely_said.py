"""What commands say in cases that are rare, and every kind of `bench`."""

import errno
import io
import json
import os
import sys
from types import SimpleNamespace
from typing import Any

import pytest

from orbitdb.benchmarks import agreement, work_precision
from orbitdb.cli import app
from orbitdb.cli.options import offered_half_lengths, offered_several_half_lengths
from orbitdb.filling import births
from orbitdb.filling.births import fill_births
from orbitdb.orbits.orbit import Status
from orbitdb.orbits.relaxation import relax


@pytest.mark.slow
def test_births_that_are_partial_are_named_and_left_out(cli, tmp_path, monkeypatch):
    cli("migrate")
    monkeypatch.setattr(births, "BLOCK", 50)
    going = fill_births(tmp_path / "orbits.db", [6])
    next(going)
    going.close()
    done = cli("births")
    assert (done.code, done.out) == (1, "")
    partial, nothing = done.err.splitlines()
    assert partial == "births of period 6 are partial: 'orbitdb births --p 6' completes them"
    assert nothing.startswith("no births in ")
    assert cli("births", "--p", "6").err.startswith("births, p = 2..6: ")
    lacking = cli("entropy", "--a", "1", "--p", "3-4")
    assert "the zeta function lacks p = 2 (not chosen)\n" in lacking.err


def test_points_and_codes_that_are_no_text(cli, filled, tmp_path, monkeypatch):
    points = tmp_path / "points"
    points.write_bytes(b"\xff\xfe")
    assert cli("identify", "--points", str(points)).says(2, str(points), "not text", "x,y")
    points.write_text('{"x": 1, "y": 2}\n{x')
    done = cli("identify", "--points", str(points))
    assert (done.code, done.out) == (2, "")
    assert done.err.startswith(f"orbitdb: {points}: line 2 is no json: write x,y of one bounce a line")
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(b"13\n\xff\n"), "utf-8"))
    assert cli("query", "--code", "-").says(2, "stdin is not text")


@pytest.mark.slow
def test_verify_says_what_it_has_not_compared(cli, tmp_path, monkeypatch):
    monkeypatch.setattr("orbitdb.verification.sweeps.SWEPT_ANEW", 2)
    cli("sweep", "--p", "4")
    for periods, what in ((["--p", "3"], "the sums of a swept period were"),
                          ([], "the sums of 2 swept periods were")):  # fmt: skip
        done = cli("verify", *periods)
        assert done.code == 0
        assert done.err.splitlines()[0] == f"{what} not computed again: only whole periods up to 2 are"


def test_methods_that_differ_for_no_reason_end_with_1(cli, monkeypatch):
    """A relaxation that takes every word for a pruned one, and says that it has come to rest."""

    def wrong(*given, **options):
        found = relax(*given, **options)
        found.status[:] = Status.DYNAMICAL
        return found

    monkeypatch.setattr(agreement, "relax", wrong)
    done = cli("bench", "--kind", "statuses", "--p", "3", "--format", "csv")
    names, row = (line.split(",") for line in done.out.splitlines())
    assert done.code == 1
    assert int(dict(zip(names, row, strict=True))["unexplained"]) == 2
    assert len(done.err.splitlines()) >= 2


def test_a_folder_that_is_gone_and_files_that_cannot_be_read(cli, tmp_path, monkeypatch):
    def fail(error):
        def call(arguments):
            raise error

        monkeypatch.setattr(app, "call", call)
        return cli("table")

    gone = FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT))
    assert fail(gone).says(3, "current folder")
    broken = OSError(errno.EIO, "Input/output error")
    outcome = fail(broken)
    assert outcome.code == 3
    odd = OSError(errno.ELOOP, "Too many symbolic links", "x.csv")
    assert fail(odd).says(1, "x.csv", "Too many symbolic links")
    with pytest.raises(ZeroDivisionError):  # what nobody has foreseen is not hidden
        fail(ZeroDivisionError())


def test_shells_are_offered_nothing_from_what_is_no_catalogue(tmp_path):
    path = tmp_path / "orbits.db"
    path.write_bytes(b"no catalogue" * 99)
    context: Any = SimpleNamespace(params={"db": path})
    assert offered_half_lengths(context, "") == []
    assert offered_several_half_lengths(context, "") == ["all"]


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
