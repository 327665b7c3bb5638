"""Turns the Python that messages suggest into commands with the --db and --a that the user gave.

The library suggests calls in backticks, such as `catalogue.fill(p=11)`, or single arguments, such as `a=1`.
Arguments have the names of the options.
"""

import ast
import re
from collections.abc import Iterator, Sequence
from itertools import pairwise

from orbitdb.text import quoted

_COMMANDS = {
    "fill_births": "births", "prove_bounds": "bounds", "fill_levels": "levels", "orbit": "query",
    "EVERY": "columns",
}  # fmt: skip
"""The command for each method, and for the dictionary of columns, that has another name."""

_PLACES = {"k": "FILE"}
"""What an argument without a name stands for in a command."""

_AT_ONE_A = ("fill", "sweep", "simulate", "levels", "bounds")
_WITHOUT_DB = ("columns",)
_SEVERAL = re.compile("[ :,]|all")
_SUGGESTED = re.compile(r"`((?:[cC]atalogue\.|orbitdb\.|\w+=)[^`]+)`")
_given: dict[str, str] = {}


def remember(arguments: Sequence[str]) -> None:
    """Remember --db and --a from a command line, unless they are repeated, or several values of a."""
    _given.clear()
    for option, short in (("--db", None), ("--a", "-a")):
        values = [value for name, value in pairwise(arguments) if name in (option, short)]
        values += [text.removeprefix(f"{option}=") for text in arguments if text.startswith(f"{option}=")]
        alone = len(values) == 1 and values[0].isprintable()
        if alone and not (option == "--a" and _SEVERAL.search(values[0])):
            _given[option] = quoted(values[0])


def completed(message: str, where: str = "") -> str:
    """Turn the Python between backticks in a message into commands and options; `where` precedes commands."""
    return _SUGGESTED.sub(lambda found: _for_shell(found[1], where) or found[0], message)


def _for_shell(python: str, where: str) -> str | None:
    """Return the command for a call, or the options for arguments; None for other texts."""
    call = _parsed(python) or _parsed(f"_({python})")
    if isinstance(call, ast.Attribute):
        call = ast.Call(call, [], [])
    if not isinstance(call, ast.Call):
        return None
    if isinstance(call.func, ast.Name):
        return " ".join(_options(call)) or None
    method = getattr(call.func, "attr", "")
    command = _COMMANDS.get(method, method)
    options = [*_options(call)]
    allowed = ["--db" * (command not in _WITHOUT_DB), "--a" * (command in _AT_ONE_A)]
    named = {option.partition(" ")[0] for option in options}
    options += [f"{name} {value}" for name in allowed if name not in named and (value := _given.get(name))]
    return f"{where}'{' '.join(['orbitdb', command, *options])}'"


def _parsed(python: str) -> ast.expr | None:
    try:
        return ast.parse(python, mode="eval").body
    except SyntaxError:
        return None


def _options(call: ast.Call) -> Iterator[str]:
    """Yield the arguments of a call as arguments and options of a command, in order."""
    inner = getattr(call.func, "value", None)
    of_file = isinstance(inner, ast.Name) and inner.id == "Catalogue"
    for argument in call.args:
        if isinstance(argument, ast.Name):
            yield _PLACES.get(argument.id, argument.id)
        elif isinstance(argument, ast.Constant) and argument.value is not ...:
            yield f"--db {quoted(argument.value)}" if of_file else quoted(argument.value)
    for keyword in call.keywords:
        value = _value(str(keyword.arg), keyword.value)
        if value is not None:
            yield f"--{str(keyword.arg).replace('_', '-')} {value}".strip()
    if isinstance(inner, ast.Call):  # Catalogue.create(path).fill(p=11)
        yield from _options(inner)


def _value(name: str, value: ast.expr) -> str | None:
    """Return the value of an argument as an option takes it: '' for a flag, None if it is left out."""
    if isinstance(value, ast.Tuple):
        return ":".join(_value("", end) or "" for end in value.elts)
    if isinstance(value, ast.Name):
        return value.id
    found = ast.literal_eval(value)
    if isinstance(found, bool):
        return "" if found else None
    return quoted(found)
