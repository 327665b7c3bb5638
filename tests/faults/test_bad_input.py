"""Bad input changes nothing; it gives a documented exit code and one line that says what is wrong."""

import io
import os
import random
import sqlite3
import sys
from pathlib import Path

import bad_values as bad
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st
from processes import run
from quick import slow_but

from orbitdb.catalogue import Catalogue
from orbitdb.errors import SelectionError
from orbitdb.selection import Selection

SELECTING = {
    "--a": bad.NUMBERS, "--p": bad.PERIODS, "--status": bad.TEXTS, "--time-reversal": bad.TEXTS,
    "--symmetry": bad.TEXTS, "--contains": bad.CODES, "--without": bad.CODES, "--range": bad.RANGES,
    "--where": bad.EXPRESSIONS, "--parameter": bad.PARAMETERS,
}  # fmt: skip
QUERY = {"--code": bad.CODES, "--order": bad.ORDERS, "--limit": bad.INTEGERS, "--offset": bad.INTEGERS,
         "-c": bad.COLUMNS, "--format": bad.FORMATS}  # fmt: skip
COMMANDS = {
    "query": SELECTING | QUERY,
    "table": {"--a": bad.NUMBERS, "--p": bad.PERIODS, "--format": bad.FORMATS},
    "entropy": SELECTING | {"--format": bad.FORMATS},
    "lyapunov": SELECTING | {"--weight": [*bad.TEXTS, "det"], "--cut": bad.NUMBERS},
    "export": SELECTING | {"--order": bad.ORDERS, "--limit": bad.INTEGERS, "-c": bad.COLUMNS},
    "verify": SELECTING | {"--sample": bad.INTEGERS, "--seed": bad.INTEGERS, "--restarts": ["-1", "1e9"]},
    "plot sheet": SELECTING | {"--limit": bad.INTEGERS},
    "plot orbit": {"--a": bad.NUMBERS, "--code": bad.CODES},
    "field": SELECTING | {"--kappa": [*bad.NUMBERS, "0:0.3", "0:0.3:x", "0.3:0:5", "0:nan:3", "0:1e400:3"]},
    "simulate": {"--a": ["0", "nan", "½"], "--bounces": ["0", "-1", "x", "9" * 30], "--seed": ["-1", "½"]},
    "bounds": {"--a": ["0", "nan", "½"], "--edges": ["0", "1", "½", "9" * 30],
               "--width": ["0", "-1", "nan", "½"], "--seconds": ["0", "-1", "inf", "½"]},
    "bench": {"--kind": bad.TEXTS, "--a": ["0", "nan"], "--p": ["", "1", "8-2", "2-3", "½"]},
    "browse": SELECTING | {"--code": bad.CODES},
    "fill": {"--p": bad.INTEGERS, "--a": ["0", "nan", "½", "1e400"],
             "--method": bad.TEXTS, "--code": ["7", "", "(", "1^", "\udcff"]},
    "info": {"--format": bad.FORMATS},
    "identify": {"--length": bad.NUMBERS, "--points": ["", ".", "missing", "/dev/null", "-", "\udcff"],
                 "--start": [*bad.TEXTS, "0,0,1,2", "0,0,½", "0,0,1e400", "0,0,nan", "1.6,1,-1"]},
    "identify --length 10": {"--tolerance": bad.NUMBERS, "--limit": bad.INTEGERS, "--a": bad.NUMBERS},
    "identify --start 0,0,1": {"--tolerance": bad.NUMBERS, "--bounces": bad.INTEGERS, "--a": bad.NUMBERS},
}  # fmt: skip
SUPPLIED = {"plot sheet": ["--p", "3"], "plot orbit": ["--code", "013"], "verify": ["--sample", "99"],
            "field": ["--kappa", "0.1"],
            "fill": ["--dry-run"], "simulate": ["--no-store"]}  # fmt: skip
"""Arguments that a command needs besides the tested option."""


def judge(outcome, arguments):
    """Check that an error is one printable line, and that its exit code is documented."""
    code, out, err = outcome
    shown = [argument[:60] for argument in arguments]
    assert code in (0, 1, 2, 3), shown
    assert all(symbol.isprintable() or symbol in "\t\n" for symbol in out + err), shown
    lines = err.splitlines()
    assert max(map(len, lines), default=0) < 1100, shown
    if code in (2, 3):
        assert out == "", shown
        assert [line for line in lines if line.startswith("orbitdb: ")] == lines[-1:], shown
        assert len(lines) <= 2, shown  # a note about a shortened code may come first
    elif code == 1:
        assert lines, shown


@pytest.fixture
def tried(cli, varied, tmp_path, monkeypatch):
    """Return a function that runs a command on a small catalogue and checks that the file is unchanged."""
    monkeypatch.setenv("ORBITDB_DB", str(varied))
    monkeypatch.setattr("sys.stdin", io.StringIO())
    before = varied.read_bytes()

    def tried(command: str, *arguments: str) -> int:
        supplied = [*SUPPLIED.get(command, [])]
        if command.startswith("plot"):
            supplied += ["-o", str(tmp_path / "figure.svg")]
        if command == "export":
            supplied += [str(tmp_path / "rows.csv"), "--force"]
        every = [*command.split(), *supplied, *arguments]
        outcome = cli(*every)
        judge(outcome, every)
        assert varied.read_bytes() == before
        return outcome.code

    return tried


@pytest.mark.fuzz
@pytest.mark.parametrize("command", COMMANDS)
def test_no_odd_value_of_an_option_does_harm(tried, command):
    for option, values in COMMANDS[command].items():
        for value in values:
            tried(command, option, value)


@pytest.mark.slow
def test_combinations_of_odd_values_do_no_harm(tried):
    rng = random.Random("options 0")
    for _ in range(120):
        command = rng.choice(list(COMMANDS))
        options = COMMANDS[command]
        arguments: list[str] = []
        for option in rng.sample(list(options), min(rng.randrange(1, 4), len(options))):
            arguments += [option, rng.choice(options[option])]
        tried(command, *arguments)


TEXT_OPTIONS = ["--code", "--p", "--status", "--time-reversal", "--symmetry", "--contains", "--without",
                "--range", "--where", "--parameter",
                "--order", "--limit", "-c", "--format", "--a"]  # fmt: skip


@pytest.mark.slow
@settings(max_examples=100, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(option=st.sampled_from(TEXT_OPTIONS), value=st.text(st.characters(), max_size=30))
@example(option="--where", value="a=:\x85")
def test_no_text_given_to_an_option_does_harm(tried, option, value):
    tried("query", f"{option}={value}" if option.startswith("--") else option, value)


@pytest.mark.parametrize(
    "command", slow_but(["query", "fill"], ["query", "table", "entropy", "info", "verify", "fill", "migrate"])
)
def test_names_that_are_not_catalogues_are_refused(cli, tmp_path, command):
    folder = tmp_path / "odd"
    folder.mkdir()
    names = bad.databases(folder)
    supplied = {"fill": ["--p", "2"]}.get(command, [])
    for name in names:
        if command in ("fill", "migrate") and Path(name).name == "missing.db":
            continue
        outcome = cli(command, *supplied, "--db", name)
        judge(outcome, [command, name])
        unusable = not name or "\x00" in name or len(Path(name).name) > 247
        assert outcome.code == (2 if unusable else 3), name
    assert not list(Path("/dev").glob("*-journal"))


@pytest.mark.parametrize(
    ("command", "ending"), slow_but(1, [("export", ".csv"), ("export", ".parquet"), ("plot", ".svg")])
)
def test_files_are_written_or_refused_but_never_left_in_part(tried, cli, tmp_path, command, ending):
    folder = tmp_path / "files"
    folder.mkdir()
    bad.make_paths(folder, ending)
    codes = {}
    for name in bad.paths(folder, ending):
        target = ["orbit", "--code", "013", "-o", name] if command == "plot" else [name]
        outcome = cli(command, *target)
        judge(outcome, [command, name])
        codes[name] = outcome.code
    kept = {name for name, code in codes.items() if code == 0}
    assert kept == {str(folder / name) for name in (f"ok{ending}", f"\udcff{ending}", f"new\nline{ending}",
                                                    f"\x1b[31m{ending}")}  # fmt: skip
    assert all(Path(name).stat().st_size > 100 for name in kept)
    refused = {str(folder / name) for name in (f"missing/x{ending}", f"file/x{ending}")}
    assert {name for name, code in codes.items() if code == 3} == refused
    assert codes[str(folder / f"{'n' * 300}{ending}")] == 2
    assert set(codes.values()) == {0, 2, 3}
    assert not [name for name in os.listdir(folder) if name.endswith(".part")]
    assert Path("/dev/null").is_char_device()


@pytest.mark.parametrize("tries", slow_but([40], [40, 300]))
def test_expressions_choose_the_rows_of_plain_sqlite_or_are_refused(varied, tries):
    before, catalogue = varied.read_bytes(), Catalogue(varied)
    plain = sqlite3.connect(f"file:{varied}?mode=ro", uri=True)
    allowed, refusals = 0, []
    for number in range(tries):
        text = bad.damaged(random.Random(f"where {number}"))
        chosen = Selection(where=text)
        try:
            count = catalogue.count(chosen)
            shown = list(catalogue.rows(chosen, columns=("code",), limit=3))
        except SelectionError as error:
            refusals.append(str(error))
            continue
        allowed += 1
        if "random" not in text:
            query = f"SELECT count(*) FROM catalogue WHERE a = 1.6 AND (\n{text}\n)"
            assert plain.execute(query).fetchone() == (count,), (number, text)
            assert len(shown) == min(count, 3), (number, text)
    assert all("\n" not in refusal and len(refusal) < 1100 for refusal in refusals)
    plain.close()
    assert allowed > tries / 5
    assert varied.read_bytes() == before


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="needs POSIX names and devices")
def test_file_names_need_not_be_utf_8(varied, tmp_path):
    name = os.fsdecode(os.fsencode(tmp_path) + b"/\xff.db")
    Path(name).write_bytes(varied.read_bytes())
    for arguments, code in (
        (("query", "--p", "3", "--db", name), 0),
        (("fill", "--p", "3", "--db", name), 0),
        (("query", "--code", "13\udcff", "--where", "\udcff"), 2),
    ):
        done = run(*arguments)
        judge((done.returncode, done.stdout, done.stderr), arguments)
        assert done.returncode == code
