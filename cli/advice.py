"""Completes the commands that messages suggest with the --db and --a that the user gave."""

import re
from collections.abc import Sequence
from itertools import pairwise

from orbitdb.text import quoted

_AT_ONE_A = ("fill", "sweep", "simulate", "levels", "bounds")
_SEVERAL = re.compile("[ :,]|all")
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


def completed(message: str) -> str:
    """Add the remembered options to the commands that a message suggests, each between single quotes."""
    before, *suggested = message.split("'orbitdb ")
    return "'orbitdb ".join([before, *map(_completed, suggested)])


def _completed(suggested: str) -> str:
    """Add the remembered options to a command that ends at the first quote."""
    command, quote, after = suggested.partition("'")
    name, *options = command.split()
    allowed = ("--db", "--a") if name in _AT_ONE_A else ("--db",)
    missing = [option for option in allowed if option in _given and option not in options]
    return "".join([command, *(f" {option} {_given[option]}" for option in missing), quote, after])
