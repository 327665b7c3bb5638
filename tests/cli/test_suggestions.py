"""The library suggests Python, which the shell and the screen show as commands."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import typer

import orbitdb
from orbitdb import Catalogue
from orbitdb.cli.advice import completed
from orbitdb.cli.app import program

LIBRARY = Path(orbitdb.__file__).parent


def texts(path: Path) -> Iterator[str]:
    """Yield the texts in a module, except docstrings, with a 1 for each inserted value."""
    parents = (each for each in ast.walk(ast.parse(path.read_text())) if not isinstance(each, ast.Expr))
    for node in (child for each in parents for child in ast.iter_child_nodes(each)):
        if isinstance(node, ast.JoinedStr):
            parts = [part.value if isinstance(part, ast.Constant) else 1 for part in node.values]
            yield "".join(map(str, parts))
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            yield node.value


@pytest.mark.slow
def test_every_suggestion_of_the_library_is_a_method_and_a_command_with_its_options():
    top: Any = typer.main.get_command(program())
    options = {
        name: {each for option in command.params for each in option.opts}
        for name, command in top.commands.items()
    }
    suggested = {
        python
        for path in LIBRARY.rglob("*.py")
        for text in texts(path)
        for python in re.findall(r"`((?:[cC]atalogue\.[^`\n]*[(]|\w+=)[^`\n]+)`", text)
        if not path.is_relative_to(LIBRARY / "cli")
    }
    assert len(suggested) > 20
    for python in suggested:
        shown = completed(f"`{python}`")
        assert "`" not in shown
        of = set().union(*options.values())
        if command := re.match(r"'orbitdb (\w+)", shown):
            (*_, method) = re.findall(r"(\w+)\(", python)
            assert hasattr(Catalogue, method)
            of = options[command[1]]
        assert {*re.findall(r"--[\w-]+", shown)} <= of, shown


@pytest.mark.slow
def test_no_module_of_the_library_names_a_command():
    for path in LIBRARY.rglob("*.py"):
        if not path.is_relative_to(LIBRARY / "cli"):
            assert not [text for text in texts(path) if "'orbitdb " in text], path


SAID = [
    ("assess --a 2", lambda c: c.assess(a=2),
     "catalogue.fill_levels(k=(0, 30), a=2)", "levels --k 0:30 --a 2"),
    ("levels --method orbits --a 2", lambda c: c.levels(5, method="orbits", a=2),
     "catalogue.fill(p=11, a=2)", "fill --p 11 --a 2"),
    ("query --status family", lambda c: c.select(status="family"), "catalogue.orbit('02')", "query 02"),
]  # fmt: skip


@pytest.mark.parametrize(("command", "ask", "python", "shell"), SAID)
def test_a_message_names_a_method_in_python_and_a_command_in_the_shell(
    cli, filled_once, command, ask, python, shell
):
    with pytest.raises(ValueError, match=re.escape(f"`{python}`")):
        ask(Catalogue(filled_once))
    assert f"'orbitdb {shell} --db {filled_once}'" in cli(*command.split(), "--db", str(filled_once)).err


def test_a_note_names_a_method_in_python_and_a_command_in_the_shell(cli, filled_once):
    assert "`catalogue.fill(p=9, a=1.6)` fills it" in str(Catalogue(filled_once).table(p=9))
    said = cli("table", "--p", "9", "--db", str(filled_once)).err
    assert f"'orbitdb fill --p 9 --a 1.6 --db {filled_once}' fills it" in said
