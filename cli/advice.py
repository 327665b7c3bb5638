"""Completes the commands that messages suggest with the --db and --a that the user gave."""

import re
from collections.abc import Sequence
from itertools import pairwise

_AT_ONE_A = ("fill", "sweep", "simulate", "levels", "bounds")
_ADVISED = re.compile(r"'orbitdb ([a-z]+)( [^']*)?'")
_given: dict[str, str] = {}


def remember(arguments: Sequence[str]) -> None:
    """Remember --db and --a from a command line, unless they are repeated, a grid, or need quotes."""
    _given.clear()
    for option in ("--db", "--a"):
        values = [value for name, value in pairwise(arguments) if name == option]
        values += [text.removeprefix(f"{option}=") for text in arguments if text.startswith(f"{option}=")]
        if len(values) == 1 and values[0].isprintable() and not set(values[0]) & set("'\"\\$` :,"):
            _given[option] = values[0]


def completed(message: str) -> str:
    """Add the remembered options to the commands that a message suggests."""

    def with_given(advised: re.Match[str]) -> str:
        command, rest = advised[1], advised[2] or ""
        missing = [option for option in _given if f"{option} " not in f"{rest} "]
        if command not in _AT_ONE_A:
            missing = [option for option in missing if option == "--db"]
        return f"'orbitdb {command}{rest}{''.join(f' {option} {_given[option]}' for option in missing)}'"

    return _ADVISED.sub(with_given, message)
