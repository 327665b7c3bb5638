"""The defaults that the help of every command tells are those of the library, or those written here."""

import re
from collections.abc import Callable
from inspect import signature
from typing import Any

from orbitdb import Catalogue, Stadium
from orbitdb.catalogue.identification import NEAR, SAME_LENGTH, SHOWN
from orbitdb.filling.periods import fill_periods
from orbitdb.trajectories.ensemble import simulate
from orbitdb.trajectories.traces import BOUNCES
from orbitdb.verification.verify import verify


def of(function: Callable[..., Any], name: str) -> str:
    return str(signature(function).parameters[name].default)


A = repr(Stadium().a)
ANY_STORED = f"the only one stored, else {A}"
ALWAYS = {"--db": "ORBITDB_DB, or the user's data folder", "--format": "table"}
"""Wherever there is such an option; the format of a file has no default."""
CORES = {"--jobs": "all cores if there is enough work"}
ORDER = {"--order": of(Catalogue.select, "order")}

OWN = {
    "fill": {**CORES, "--from": "2", "--a": A, "--method": of(fill_periods, "method"), "--executor": ""},
    "sweep": {**CORES, "--from": "2", "--a": A, "--executor": ""},
    "births": {**CORES, "--from": "2"},
    "query": {**ORDER, "--a": ANY_STORED, "--limit": "40 in a table, else all", "--offset": "0"},
    "identify": {
        "--a": ANY_STORED,
        "--limit": f"{SHOWN}; for a length 40 in a table, else all",
        "--bounces": str(BOUNCES),
        "--tolerance": f"{NEAR:g} for bounces, {SAME_LENGTH:g} for a length",
    },
    "browse": {"--a": ANY_STORED, "--port": "8000"},
    "tui": {"--a": ANY_STORED, "--port": "8000"},
    "table": {"--a": ANY_STORED},
    "entropy": {"--a": ANY_STORED},
    "lyapunov": {"--a": ANY_STORED, "--weight": "exp"},
    "bounds": {**CORES, "--a": A, "--window": "14, or as many as needed", "--store": "if there is one"},
    "simulate": {"--a": A, "--bounces": "20000000", "--seed": of(simulate, "seed"), "--store": "True"},
    "plot": {"--a": ANY_STORED, "--limit": "120"},
    "export": {**ORDER, "--a": ANY_STORED},
    "verify": {
        **CORES,
        "--a": "all stored",
        "--restarts": of(verify, "restarts"),
        "--seed": of(verify, "seed"),
    },
    "bench": {"--a": A, "--kind": "methods"},
    "levels": {**CORES, "--a": A, "--parity": "all four", "--store": "True"},
    "spectrum": {
        "--a": ANY_STORED,
        "--range": "1:12",
        "--points": "500",
        "--parity": "all",
        "--k-max": "where the levels end, or 30",
        "--levels": "those of the catalogue",
    },
}


def told(option: Any) -> str | None:
    """Return the default of an option as its help tells it, None for one that has none."""
    if option.default is not None and option.default is not False and not callable(option.default):
        return str(option.default)
    said = re.search(r"\[default(?:: ([^]]*))?\]", option.help or "")
    return None if said is None else said[1] or ""


def test_the_help_tells_the_defaults_that_there_are():
    import typer

    from orbitdb.cli.app import program

    commands: Any = typer.main.get_command(program())
    for name, command in commands.commands.items():
        options = [each for each in command.params if each.param_type_name == "option"]
        found = {each.opts[0]: told(each) for each in options if told(each) is not None}
        always = {each: ALWAYS[each] for each in ALWAYS if each in {option.opts[0] for option in options}}
        files = {"--format"} if name in ("plot", "export") else set()
        assert found == {each: always[each] for each in always if each not in files} | OWN.get(name, {}), name
