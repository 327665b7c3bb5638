"""Texts never act as formulas, control characters or markup."""

from pathlib import Path

import pytest
from quick import slow_but
from screens import browsing, settle, shown

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


@pytest.mark.parametrize("name", slow_but(["a[/b]c"], ["a[b", "a[/b]c", "[red]", "a\\[b"]))
async def test_the_terminal_ui_shows_any_file_name(tmp_path, monkeypatch, name):
    monkeypatch.chdir(tmp_path)  # a long path would wrap in the middle of the name
    async with browsing(Path(f"{name}.db"), size=(160, 48)) as (app, pilot):
        assert f"{Path(name).name}.db" in shown(app)
        app.notify(f"[/b] {name}")
        app.push_screen(QuestionDialog(f"{name}?", yes="fill", no="stay"))
        await settle(pilot)
        assert f"{name}?" in shown(app)
