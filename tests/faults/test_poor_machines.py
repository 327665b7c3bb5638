"""Old SQLite, no home folder, odd numbers and names: one line that says what to do, or the right answer."""

import csv
import os
import shutil
import sys
from decimal import ROUND_DOWN, Context, Decimal, FloatOperation, Inexact, localcontext
from fractions import Fraction

import numpy as np
import pytest
from processes import COMMAND, run

from orbitdb.billiard.stadium import Stadium, StadiumError
from orbitdb.catalogue import Catalogue
from orbitdb.store.views import view_texts

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="needs POSIX users")

NOBODY = 54321
"""A user id without an entry."""


def old_sqlite(version: tuple[int, int, int]) -> list[str]:
    """Return a command for which Python has an older SQLite."""
    written = ".".join(map(str, version))
    *python, program = COMMAND
    old = f"import sqlite3; sqlite3.sqlite_version_info = {version}; sqlite3.sqlite_version = {written!r}"
    return [*python, f"{old}\n{program}"]


@pytest.mark.slow
def test_an_old_sqlite_is_named_and_harms_nothing(filled, tmp_path):
    before = filled.read_bytes()
    for arguments in (
        ("query", "--p", "3", "--db", filled),
        ("fill", "--p", "3", "--db", tmp_path / "new.db"),
    ):
        done = run(*arguments, command=old_sqlite((3, 36, 0)))
        assert (done.returncode, done.stdout) == (3, "")
        assert done.stderr == (
            "orbitdb: this Python has SQLite 3.36.0, but orbitdb needs 3.37.0 or newer: use a newer Python\n"
        )
    assert [each.name for each in tmp_path.iterdir()] == [filled.name]
    assert filled.read_bytes() == before


AS_NOBODY = [
    *("setpriv", "--reuid", str(NOBODY), "--regid", str(NOBODY), "--clear-groups"),
    *("--inh-caps", "+dac_override", "--ambient-caps", "+dac_override"),  # to read this Python
    *COMMAND,
]


@pytest.mark.slow
def test_no_home_folder_is_no_traceback(filled):
    """As in a container that runs with a user id of its own."""
    if os.getuid() or not shutil.which("setpriv"):
        pytest.skip("needs the right to become another user")
    named = {"PATH": os.environ["PATH"]}
    done = run("fill", "--p", "3", command=AS_NOBODY, env=named)
    assert (done.returncode, done.stdout) == (3, "")
    assert done.stderr == "orbitdb: you have no home folder: name a catalogue with --db or ORBITDB_DB\n"
    for options, more in ((("--db", str(filled)), {}), ((), {"ORBITDB_DB": str(filled)})):
        done = run("query", "--p", "3", *options, command=AS_NOBODY, env=named | more)
        assert done.returncode == 0, done.stderr


@pytest.mark.parametrize(
    "a", [np.float16(1.6), np.float32(1.6), np.longdouble("1.6"), Decimal("1.6"), Fraction(8, 5)], ids=repr
)
def test_what_stands_for_a_number_is_that_number(filled, a):
    assert Stadium(a).a == 1.6
    catalogue = Catalogue(filled)
    assert catalogue.count(a=a) == catalogue.count(a=1.6) > 0
    assert catalogue.find("1232131", a=a) == catalogue.find("1232131", a=1.6)


@pytest.mark.parametrize(
    "a",
    [True, "1.6", 1.6j, None, np.array([1.6]), Decimal("sNaN"), Decimal("1e999"), Fraction(10**400), 10**400],
)
def test_what_stands_for_no_half_length_is_refused(a):
    with pytest.raises(StadiumError, match="is not a half length"):
        Stadium(a)


@pytest.mark.slow
def test_a_changed_decimal_context_changes_no_answer(filled, cli):
    """Neither the precision nor the traps of whoever calls the library."""
    commands = [
        "query --p 3", "query 0123", "table", "lyapunov", "births --p 4", "bounds --a 2 --edges 4",
        "simulate --bounces 20000 --no-store",
    ]  # fmt: skip
    usual = [cli(*command.split(), "--db", str(filled)) for command in commands]
    with localcontext(Context(prec=1, rounding=ROUND_DOWN, traps=[Inexact, FloatOperation])):
        view_texts.cache_clear()
        changed = [cli(*command.split(), "--db", str(filled)) for command in commands]
        assert Stadium(1.6) == Stadium(Decimal("1.6"))  # type: ignore[arg-type]
    assert [outcome.code for outcome in usual] == [0] * len(commands)
    assert [outcome.out for outcome in changed] == [outcome.out for outcome in usual]


def test_names_with_a_meaning_for_sqlite_are_refused(cli, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name in (":memory:", "x.db-wal", "x.db-shm", "x.db-journal"):
        for command in ("fill --p 3", "query --p 3", "info"):
            assert cli(*command.split(), "--db", name).says(2, f"{name} has a meaning for SQLite")
    for long in ("n" * 252, "ñ" * 127):
        assert cli("fill", "--p", "3", "--db", long).says(2, "the file name has", "at most 247")
    assert list(tmp_path.iterdir()) == []
    assert cli("fill", "--p", "3", "--db", "n" * 247).code == 0
    assert [len(each.name) for each in tmp_path.iterdir()] == [247]


@pytest.mark.parametrize("length", [240, 241, 255, 256])
def test_a_file_with_a_long_name_is_written_whole_or_not_at_all(cli, varied, tmp_path, length):
    for ending in (".csv", ".parquet", ".db"):
        name = "n" * (length - len(ending)) + ending
        outcome = (
            cli("export", str(tmp_path / name), "--p", "3", "--db", str(varied))
            if ending != ".db"
            else (cli("export", str(tmp_path / name), "--db", str(varied)))
        )
        if outcome.code:
            assert outcome.code in (2, 3)
            assert outcome.err.count("\n") == 1
            assert list(tmp_path.iterdir()) == []
        for each in tmp_path.iterdir():
            assert each.stat().st_size > 100
            each.unlink()


def test_a_list_of_levels_with_an_endless_field_is_one_line(cli, tmp_path):
    csv.field_size_limit(1 << 17)  # Python's own; frictionless raises it for the whole process
    levels = tmp_path / "levels.csv"
    levels.write_text('k\n"' + "1" * 200_000 + '"\n')
    assert cli("assess", str(levels)).says(2, "levels.csv", "field")
