"""Completes the commands that messages suggest with the --db and --a that the user gave."""

from collections.abc import Sequence
from itertools import pairwise

_AT_ONE_A = ("fill", "sweep", "simulate", "levels", "bounds")
_given: dict[str, str] = {}


def remember(arguments: Sequence[str]) -> None:
    """Remember --db and --a from a command line, unless they are repeated, a grid, or need quotes."""
    _given.clear()
    for option in ("--db", "--a"):
        values = [value for name, value in pairwise(arguments) if name == option]
        values += [text.removeprefix(f"{option}=") for text in arguments if text.startswith(f"{option}=")]
        values = [] if option == "--a" and "all" in values else values
        if len(values) == 1 and values[0].isprintable() and not set(values[0]) & set("'\"\\$` :,"):
            _given[option] = values[0]


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
