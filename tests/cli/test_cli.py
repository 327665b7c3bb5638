"""The command line as users see it."""

import io
import json
import math
import re
import shlex
import subprocess
import sys
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from processes import COMMAND, commands, run

from orbitdb.symbols.pruning import count_admissible, count_primitive
from orbitdb.text import with_bound

ROOT = Path(__file__).parents[2]


EXPLAINED = [
    "query --p 3",
    "query 1232131 13",
    "query 13 --by-bounce",
    "export --p 3 --format json",
    "table",
    "identify --length 20.8",
    "field 0123 --kappa 0.1",
]


def test_every_column_that_a_command_writes_is_explained(cli, own):
    explained = {row["column"]: row for row in json.loads(cli("columns", "--json").out)}
    assert (explained["length"]["unit"], explained["length"]["bound"]) == ("radius", "length_error")
    for command in EXPLAINED:
        done = cli(*command.split(), *["--json"] * ("--format" not in command), "--a", "1.6")
        (row, *_) = json.loads(done.out)
        assert set(row) <= set(explained), command
    bounds = {row["bound"] for row in explained.values() if row["bound"].endswith("error")}
    assert bounds - {"both errors"} <= set(explained)


@pytest.mark.parametrize("command", ["query", "export"])
def test_help_fits_eighty_columns(cli, command):
    shown = cli(command, "--help").out
    assert "'orbitdb columns'" in shown
    assert max(map(len, shown.splitlines())) <= 80


def test_words_can_be_given_as_arguments_options_or_on_stdin(cli, monkeypatch):
    once = cli("query", "--code", "1232131", "--code", "13", "--json")
    assert once == cli("query", "1232131", "13", "--json")
    monkeypatch.setattr("sys.stdin", io.StringIO("1232131\n13\n"))
    assert once == cli("query", "-", "--json")
    assert cli("query", "-h").out == cli("query", "--help").out != ""
    for p in (24, 25, 40, 41):  # up to 24 symbols are written out, and up to 40 bounces are shown
        told = cli("query", code := (p - 1) * "1" + "3", "--a", "12").out
        assert told.count(code if p <= 24 else f"1^{p - 1} 3") == 2
        assert (code in told) == (p <= 24)
        assert ("wall" in told) == (p <= 40)


def test_codes_are_read_from_stdin(cli, monkeypatch):
    """They may have the line ends of Windows."""
    monkeypatch.setattr("sys.stdin", io.StringIO("\ufeff13\r\n1^20 (02)^5 3\r\n\r\n1001\r\n"))
    outcome = cli("fill", "--code", "-")
    assert outcome.code == 0
    assert outcome.err.startswith("3 words: 1 orbit, 1 dynamical, 1 geometric, ")
    assert len(outcome.err.splitlines()) == 1
    (found,) = json.loads(cli("query", "--code", "1^20 (02)^5 3", "--json").out)
    assert found["stored"] is True
    assert found["p"] == 31


def test_a_table_shows_the_columns_that_sort_it(cli, filled):
    asked = ("query", "--p", "3", "--order", "length,quarter_length desc", "--db", str(filled))
    assert cli(*asked).out.split("\n")[0].split()[-2:] == ["time_reversal", "quarter_length"]


def test_an_empty_result_has_a_header_in_csv_but_not_in_a_table(cli, monkeypatch):
    cli("fill", "--p", "3")
    monkeypatch.setattr("sys.stdin", io.StringIO(""))
    for command in (["query", "--code", "-"], ["query", "--p", "12"], ["table", "--p", "12"]):
        assert cli(*command)[:2] == (1, "")
    assert cli("query", "--p", "12", "--format", "csv", "-c", "code,p")[:2] == (1, "code,p\n")


@pytest.mark.slow
def test_info_and_simulate_fit_eighty_columns(cli):
    half = ("--a", "0.36602540378")
    assert cli("fill", "--p", "6", *half).code == 0
    assert cli("sweep", "--p", "12", *half).code == 0
    assert cli("bounds", *half, "--edges", "6", "--prove").code == 0
    for bounces in ("100", "20000"):
        done = cli("simulate", *half, "--bounces", bounces)
        assert max(map(len, (done.out + done.err).splitlines())) <= 80
    facts, table = cli("info").out.split("\n\n")
    assert len(table.splitlines()) == 2 + 11
    assert facts.endswith(", 6 edges, balls")


def test_info_lists_the_entropy_at_a_few_a_and_at_every_filled_a(cli):
    """Up to four a are listed one by one."""

    def told() -> list[str]:
        lines = cli("info").out.partition("\n\n")[0].splitlines()
        return [line.split(maxsplit=1)[1] for line in lines if line.startswith("entropy ")]

    cli("fill", "--p", "2")
    cli("bounds", "--a", "1:8:4", "--edges", "2")
    bounds = "0.00000000 < h < 1.21875573, 2 edges"
    assert told() == [f"a = {a}: {bounds}" for a in (1, 2, 4, 8)]
    cli("bounds", "--edges", "2")
    assert told() == [f"a = 1.6: {bounds}", "enclosed at 4 other values of a from 1 to 8"]
    names = [line.split()[0] for line in cli("info").out.splitlines()[:6]]
    assert names == ["catalogue", "schema", "size", "SQLite", "classes", "solved"]


@pytest.mark.parametrize("command", commands())
def test_every_command_has_help_with_an_example_and_is_in_the_readme(cli, command):
    outcome = cli(command, "--help")
    assert outcome.code == 0
    assert f"orbitdb {command}" in outcome.out
    assert "Example" in outcome.out
    assert not re.search(r"<\w+>|TEXT", outcome.out)  # every option value has a name
    assert f"orbitdb {command}" in (ROOT / "README.md").read_text()


@pytest.mark.parametrize("command", commands())
def test_every_example_in_the_help_has_only_options_of_its_command(cli, command):
    import shlex

    from typer.main import get_command

    from orbitdb.cli.app import program

    asked: Any = get_command(program((command,))).commands[command]  # type: ignore[attr-defined]
    examples = re.findall(r"^\s+orbitdb (.*)$", str(asked.epilog), re.M)
    assert examples
    for example in examples:
        name, *arguments = shlex.split(re.split(r" [|>] ", example)[0])
        if name == command:  # not the first command of a pipe
            assert asked.make_context(name, arguments).params


def test_panels_list_every_command(cli):
    listed = re.findall(r"\n  (\w+)  ", cli("--help").out)
    assert sorted({*listed} & {*commands()}) == sorted(commands())


@pytest.mark.parametrize("command", ["query", "entropy", "lyapunov", "export", "plot", "verify", "browse"])
def test_subsets_are_chosen_by_the_same_options_everywhere(cli, command):
    text = cli(command, "--help").out
    names = ["p", "status", "time-reversal", "symmetry", "contains", "without", "range", "where", "parameter"]
    assert [name for name in names if not re.search(rf"\n  (-p, )?--{name}[ ,]", text)] == []


@pytest.mark.slow
def test_head_ends_quietly(filled):
    command = shlex.join([*COMMAND, "query", "--format", "csv", "--db", str(filled)])
    line = f"{command} | head -n 2; echo ${{PIPESTATUS[0]}}"
    result = subprocess.run(["bash", "-c", line], capture_output=True, text=True, check=False)
    assert len(result.stdout.splitlines()) == 3
    assert (result.stdout.splitlines()[-1], result.stderr) == ("141", "")


@pytest.mark.slow
def test_a_crash_has_a_traceback_and_exit_code_1(filled):
    program = "from orbitdb.cli import app, main; app.call = lambda arguments: 1 / 0; main.run()"
    done = run("table", "--db", filled, command=[sys.executable, "-P", "-c", program])
    assert (done.returncode, done.stderr.splitlines()[-1]) == (1, "ZeroDivisionError: division by zero")


@pytest.mark.parametrize(
    ("command", "more"),
    [
        ("query --code 13", ""),
        ("verify", ""),
        ("export x.csv", ""),
        ("births --p 9", "; nothing that was stored is lost, and the same command continues from there"),
        ("simulate", ""),
        ("verify --prove", "; nothing that was stored is lost, and the same command continues from there"),
    ],
)
def test_ctrl_c_says_what_the_command_keeps(cli, monkeypatch, command, more):
    def press(arguments):
        raise KeyboardInterrupt

    monkeypatch.setattr("orbitdb.cli.app.call", press)
    assert cli(*command.split()) == (130, "", f"orbitdb: interrupted{more}\n")


@pytest.mark.parametrize("end", [KeyboardInterrupt, EOFError])
def test_ctrl_c_and_ctrl_d_end_a_working_command(cli, monkeypatch, end):
    def press(*_):
        raise end

    monkeypatch.setattr("orbitdb.symbols.words.parse", press)
    code, out, err = cli("query", "13")
    assert (code, out, err.strip()) == (130, "", "orbitdb: interrupted")


@given(value=st.floats(1e-300, 1e300), bound=st.floats(0, 1e300))
def test_a_displayed_bound_holds_for_the_displayed_digits(value, bound):
    number, _, shown = with_bound(value, bound).partition(" +- ")
    assert abs(Fraction(number) - Fraction(value)) + Fraction(bound) <= Fraction(shown)
    assert Fraction(shown) <= Fraction(11, 10) * (Fraction(bound) + Fraction(math.ulp(value)))


def test_many_pruned_words_are_stored_only_with_yes(cli, monkeypatch, tmp_path):
    path = str(tmp_path / "new.db")
    monkeypatch.setattr("orbitdb.filling.estimate.MANY_PRUNED", 300)
    chosen = ("fill", "--geometric", "--db", path, "--p")
    announced = "358 geometrically pruned words to store, under a second and up to "
    dry, refused = cli(*chosen, "4", "--dry-run"), cli(*chosen, "4")
    assert dry.code == 0
    assert announced in dry.err
    assert "41 words to solve" in dry.err
    assert refused.code == 2
    assert announced in refused.err
    assert "this would store 358 geometrically pruned words, up to " in refused.err
    assert not (tmp_path / "new.db").exists()
    assert "75 geometrically pruned words to store" in cli(*chosen, "3").err
    assert "283 geometrically pruned words to store" in cli(*chosen, "4", "--yes").err
    assert cli("fill", "--p", "4", "--yes", "--db", path).says(2, "--geometric")


def test_a_geometric_fill_stores_the_pruned_words(cli):
    """Each word is stored with the rules it breaks. An ordinary fill stores none."""
    chosen = ("query", "--status", "geometric", "--p", "2-4", "--limit", "1000", "--json")
    cli("fill", "--p", "4")
    assert json.loads(cli(*chosen).out) == []
    assert "p = 2..3 at a = 1.6: 9 words, 9 orbits, " in cli("fill", "--p", "3").err
    done = cli("fill", "--p", "4", "--geometric")
    assert done.code == 0
    rows = json.loads(cli(*chosen).out)
    assert f"41 orbits, {len(rows)} geometrically pruned words, " in done.err
    of_two = sum(row["p"] == 2 for row in rows)
    assert f"1 orbit, {of_two} geometrically pruned word" in cli("fill", "--p", "2", "--geometric").err
    for p in (2, 3, 4):
        family = p == 2  # 02 breaks no rule and has no isolated orbit
        assert sum(row["p"] == p for row in rows) == count_primitive(p) - count_admissible(p) - family
    assert {row["code"]: row["rules"] for row in rows}["0011"] == [1, 3, 6]
