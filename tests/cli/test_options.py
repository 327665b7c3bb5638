"""Options that have no effect, numbers as people write them, `-` for a stream, and closed streams."""

import errno
import json
import os
import shlex

import pytest
from processes import COMMAND, run
from quick import slow_but

from orbitdb.cli import app
from orbitdb.text import parse_int, real


def test_numbers_are_read_as_people_write_them():
    assert [parse_int(text) for text in ("20", "1e6", "2.5e7", "1E+3", " 7 ", "-1", "2.0")] == [
        20, 1_000_000, 25_000_000, 1000, 7, -1, 2
    ]  # fmt: skip
    assert parse_int("12345678901234567891") == 12345678901234567891
    assert [real(text) for text in ("1.6", ".5", "1.", "1e-6", "-inf", " 2 ")] == [
        1.6, 0.5, 1.0, 1e-6, float("-inf"), 2.0
    ]  # fmt: skip
    for text in ("", "1_6", "½", "1e", "0x1", "e5", "1 2", "9" * 5000):
        with pytest.raises(ValueError, match="is not a whole number"):
            parse_int(text)


def test_a_value_is_a_number_only_in_the_usual_notation(cli, filled):
    for value, code in ("7", 0), ("7.0", 0), ("0_7", 1):  # +p has no affinity: texts stay texts
        assert cli("query", "--where", "+p = :x", "--parameter", f"x={value}", "--limit", "1").code == code


def test_quiet_leaves_out_notes_but_no_error(cli, filled):
    asked = ("query", "-p", "8-9", "--status", "orbit", "-n", "2", "-c", "code")
    loud, quiet = cli(*asked), cli(*asked, "-q")
    assert "period 9" in loud.err
    assert quiet == loud._replace(err="")
    assert cli(*asked).err == loud.err  # in the same process
    assert cli("query", "-q", "--where", "lenght < 3").says(2, "lenght")


def test_columns_with_a_plus_are_added_to_the_usual_ones(cli, filled):
    usual = cli("query", "-p", "3", "--json")
    more = cli("query", "-p", "3", "--json", "-c", "+coordinates,margin,+born")
    for before, after in zip(json.loads(usual.out), json.loads(more.out), strict=True):
        assert list(after) == [*before, "coordinates", "born"]
        assert {name: after[name] for name in before} == before
    assert cli("query", "-p", "3", "-c", "code,+born").says(2, "'+born'")


def test_a_minus_means_stdout(cli, filled, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    named, silent = (cli("export", *target, "--format", "csv", "--p", "3") for target in (["-"], []))
    assert named == silent
    assert len(named.out.splitlines()) == 9
    assert len(cli("export", "-", "--format", "jsonl", "--p", "3").out.splitlines()) == 8
    for form in ["--format", "parquet"], ["--format", "npz"], []:
        done = cli("export", "-", *form)
        assert (done.code, len(done.err.splitlines())) == (2, 1)
        assert "name a file" in done.err
    assert not (tmp_path / "-").exists()


NOWHERE = "orbitdb: the output cannot be written (it is closed)\n"
NO_ROOM = "orbitdb: the output cannot be written (No space left on device)\n"


STREAMS = [
    ("columns", ">&-", 3, NOWHERE),
    ("table", ">/dev/full", 3, f"words at a = 1.6\n{NO_ROOM}"),
    ("query --format csv", ">/dev/full", 3, NO_ROOM),
    ("--help", ">/dev/full", 3, NO_ROOM),
    ("table", ">&-", 3, f"words at a = 1.6\n{NOWHERE}"),
    ("table", ">&- 2>&-", 3, ""),
    ("table", ">/dev/null 2>&-", 0, ""),
    ("export rows.csv --p 2", ">&- 2>&- <&-", 0, ""),
    ("fill --code -", "<&-", 0, "stdin contains no code\n"),
    ("browse", "<&-", 2, "orbitdb: browse needs a terminal: use 'orbitdb query' without one\n"),
]


@pytest.mark.parametrize(("command", "streams", "code", "err"), slow_but(1, STREAMS))
def test_closed_streams_give_the_documented_exit_code(filled, tmp_path, command, streams, code, err):
    line = f"{shlex.join(COMMAND)} {command} {streams}"
    done = run(line, command=["/bin/sh", "-c"], cwd=tmp_path, env={"ORBITDB_DB": str(filled)})
    assert (done.returncode, done.stderr) == (code, err)


@pytest.mark.slow
def test_a_path_that_stdout_cannot_encode_is_escaped(filled, tmp_path):
    path = filled.rename(tmp_path / "øb.db")
    done = run("info", "--db", path, env={"PYTHONIOENCODING": "ascii"})
    assert (done.returncode, done.stderr) == (0, "")
    assert r"/\xf8b.db" in done.stdout.splitlines()[0]


@pytest.mark.slow
def test_a_deleted_current_folder_is_reported(tmp_path):
    line = f"rmdir ../gone; exec {shlex.join([*COMMAND, 'fill', '--p', '3', '--db', 'x.db'])}"
    (tmp_path / "gone").mkdir()
    done = run(line, command=["/bin/sh", "-c"], cwd=tmp_path / "gone")
    told = "orbitdb: the current folder no longer exists: change to another\n"
    assert (done.returncode, done.stderr) == (3, told)


def test_browse_needs_a_terminal_to_draw_on(cli, monkeypatch):
    for name in ("stdin", "stdout"):
        monkeypatch.setattr(f"sys.{name}.isatty", lambda: True, raising=False)
    outcome = cli("browse")
    assert outcome.says(2, "stderr must be a terminal, too")
    monkeypatch.setattr("sys.stdout.isatty", lambda: False)
    assert cli("browse").says(2, "browse needs a terminal")


def test_system_errors_are_reported_and_program_errors_raised(cli, tmp_path, monkeypatch):
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
    for odd in (errno.ELOOP, errno.ENOENT):
        assert fail(OSError(odd, os.strerror(odd), "x.csv")).says(1, "x.csv", os.strerror(odd))
    with pytest.raises(ZeroDivisionError):  # unforeseen errors are not hidden
        fail(ZeroDivisionError())


@pytest.mark.parametrize(
    ("command", "said"),
    [
        ("fill p=9", "write --p 9"),
        ("table --a 1,1.6", "repeat --a for several values, or give a grid such as 0.3:10:40"),
    ],
)
def test_a_value_in_another_form_is_told_how_to_be_written(cli, command, said):
    assert cli(*command.split()).says(2, said)


def test_a_coordinate_that_is_zero_within_its_bound_is_shown_as_zero(cli):
    assert "e-" not in cli("query", "13", "--by-bounce", "--a", "1", "--digits", "3").out
    assert "e-" not in cli("query", "13", "--a", "1").out.partition("symbol")[2]
