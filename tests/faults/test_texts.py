"""Texts from a file never act as formulas, control characters or markup."""

import csv
import io
import json
from pathlib import Path

import pytest
from contents import alter
from quick import slow_but
from screens import browsing, press, settle, shown, table_of

from orbitdb.cli.tui.screens import QuestionDialog
from orbitdb.text import cell, printable, shortened

FORMULAS = ["=1+1", "+1", "-1+cmd", "@SUM(1)", "\t=1", "\r=1", '=HYPERLINK("x")', "＝1", "－1"]

ESCAPES = ["\x1b[31mred", "\x1b]0;title\x07", "\x9b2J", "a\rb", "a\nb", "\u202egnp", "\x00", "\x7f", "\u2028"]


@pytest.mark.parametrize("text", [*FORMULAS, *ESCAPES])
def test_cells_are_never_formulas(text):
    found = cell(text)
    assert isinstance(found, str)
    assert found.isprintable()
    assert found[0] not in "=+-@＝＋－＠"


def test_cells_with_numbers_are_unchanged():
    assert [cell(value) for value in (-1.5, -3, None, "orbit", [1, 3], [-0.5, 2e-9], "1^20 3")] == [
        -1.5, -3, None, "orbit", "1 3", "-0.5 2e-09", "1^20 3",
    ]  # fmt: skip
    assert printable("½ λ_d ± 1") == "½ λ_d ± 1"
    assert printable("a\x1b[31m\udcff") == "a\\x1b[31m\\udcff"
    assert [shortened("1" * n, 5) for n in (4, 5, 6)] == ["1111", "11111", "11..."]
    assert [len(shortened("1" * n)) for n in (39, 40, 41)] == [39, 40, 40]


def evil(path: Path) -> None:
    """Put texts into rows that try to have an effect where they are shown."""
    quoted = [text.replace("'", "''").replace("\x00", "' || char(0) || '") for text in FORMULAS + ESCAPES]
    case = " ".join(f"WHEN {n} THEN '{text}'" for n, text in enumerate(quoted))
    rank = "(SELECT count(*) FROM cycle AS other WHERE other.id < cycle.id)"
    chosen = f"CASE {rank} % {len(quoted)} {case} END"
    alter(
        path,
        f"UPDATE cycle SET symmetry = {chosen}, time_reversal = {chosen}",
        "UPDATE orbit SET solver = (SELECT symmetry FROM cycle WHERE id = cycle), status = solver",
    )
    alter(path, "UPDATE orbit SET solver = (SELECT symmetry FROM cycle WHERE id = orbit.cycle)")
    alter(path, "UPDATE orbit SET status = solver WHERE cycle % 2")


def texts_of(rows: list[dict[str, str]]) -> list[str]:
    names = ("status", "symmetry", "time_reversal", "solver")
    return [row[name] for row in rows for name in names]


def safe(texts: list[str]) -> None:
    assert any("1+1" in text for text in texts)
    assert any("red" in text for text in texts)
    assert all(text.isprintable() for text in texts)
    assert not [text for text in texts if text.startswith(tuple("=+-@＝＋－＠"))]


@pytest.mark.parametrize("form", slow_but(["csv"], ["csv", "tsv"]))
@pytest.mark.slow
def test_tables_for_spreadsheets_hold_no_formulas(own, cli, tmp_path, form):
    import pandas as pd

    evil(own)
    columns = "code,status,symmetry,time_reversal,solver,margin"
    outcome = cli("query", "--format", form, "-c", columns)
    assert outcome.code == 0
    delimiter = "," if form == "csv" else "\t"
    rows = list(csv.DictReader(io.StringIO(outcome.out), delimiter=delimiter))
    safe(texts_of(rows))
    frame = pd.read_csv(io.StringIO(outcome.out), sep=delimiter, dtype={"code": str}, keep_default_na=False)
    safe([str(text) for text in frame[["status", "symmetry", "time_reversal", "solver"]].to_numpy().ravel()])
    assert min(float(row["margin"] or 0) for row in rows) < 0
    if form == "csv":
        assert cli("export", str(tmp_path / "rows.csv"), "-c", columns).code == 0
        with (tmp_path / "rows.csv").open(newline="") as file:
            assert list(csv.DictReader(file)) == rows


@pytest.mark.parametrize("form", slow_but(["table"], ["table", "csv", "tsv", "json", "jsonl"]))
def test_no_control_characters_reach_a_terminal(own, cli, form):
    evil(own)
    columns = "code,status,symmetry,time_reversal,solver"
    for arguments in (
        ["query", "--format", form, "-c", columns, "--limit", "500"],
        ["verify", "--format", form],
    ):
        outcome = cli(*arguments)
        assert outcome.code in (0, 1)
        assert all(symbol.isprintable() or symbol in "\t\n" for symbol in outcome.out + outcome.err)


def test_json_gives_stored_texts_unchanged(own, cli):
    """JSON needs no changes to be safe, because it escapes texts; programs get them back exactly."""
    evil(own)
    rows = json.loads(cli("query", "--json", "-c", "symmetry").out)
    assert {row["symmetry"] for row in rows} >= {*FORMULAS, *ESCAPES} - {"\x00"}


@pytest.mark.slow
async def test_the_terminal_ui_shows_no_control_characters(own):
    evil(own)
    alter(own, "UPDATE orbit SET status = 'orbit'")  # other statuses have no index, and no row would be shown
    async with browsing(own, size=(160, 48)) as (app, pilot):
        for key in ("j", "j", "down", "pagedown", "end", "l", "l", "l", "l"):
            await press(pilot, key)
            text = shown(app)
            assert all(symbol.isprintable() or symbol == "\n" for symbol in text)
        assert table_of(app).row is not None


@pytest.mark.parametrize("name", slow_but(["a[/b]c"], ["a[b", "a[/b]c", "[red]", "a\\[b"]))
async def test_the_terminal_ui_shows_any_file_name(tmp_path, monkeypatch, name):
    monkeypatch.chdir(tmp_path)  # a long path would wrap in the middle of the name
    async with browsing(Path(f"{name}.db"), size=(160, 48)) as (app, pilot):
        assert name[:3] in shown(app)
        app.notify(f"[/b] {name}")
        app.push_screen(QuestionDialog(f"{name}?", yes="fill", no="stay"))
        await settle(pilot)
        assert f"{name}?" in shown(app)
