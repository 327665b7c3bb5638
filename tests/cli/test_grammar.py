"""One grammar: an option has the same meaning in every command, and Python's argument has its name.

What differs stands in the tables below, each with the reason.
"""

import inspect
from collections import defaultdict
from collections.abc import Callable
from typing import Any

import pytest
import typer

import orbitdb
from orbitdb import Catalogue
from orbitdb.cli.app import program

COMMANDS: dict[str, Any] = typer.main.get_command(program()).commands  # type: ignore[attr-defined]

SHORT = {"--a": "-a", "--p": "-p", "--columns": "-c", "--output": "-o", "--limit": "-n", "--yes": "-y",
         "--force": "-f", "--quiet": "-q"}  # fmt: skip
"""The options with a letter; -h is --help."""

READ_DIFFERENTLY = {
    "--a": "a command about one stadium takes one value, one that lists values takes several, a grid, or all",
    "--p": "bench measures the words of a single period",
    "--code": "browse starts at a single word",
    "--by": "count groups by columns; escape counts by one of three measures",
    "--k": "a range; scars and plot also take one k for the nearest level, and plot says for which figure",
    "--format": "a table on stdout, or a file",
    "--method": "fill and levels have different algorithms",
}
"""Options whose values are not read alike in all commands, and why."""

METHODS: dict[str, list[Callable[..., Any]]] = {
    "fill": [Catalogue.fill],
    "births": [Catalogue.fill_births, Catalogue.births],
    "sweep": [Catalogue.sweep],
    "simulate": [Catalogue.simulate],
    "escape": [Catalogue.escape, orbitdb.Escape.plot],
    "bounds": [Catalogue.search_bounds, Catalogue.prove_bounds],
    "levels": [Catalogue.fill_levels, Catalogue.levels],
    "query": [Catalogue.rows, Catalogue.orbit],
    "count": [Catalogue.count],
    "identify": [Catalogue.identify],
    "sql": [Catalogue.sql],
    "table": [Catalogue.table],
    "entropy": [Catalogue.entropy],
    "lyapunov": [Catalogue.lyapunov],
    "spectrum": [Catalogue.spectrum],
    "assess": [Catalogue.assess, Catalogue.level_statistics, orbitdb.read_levels],
    "scars": [Catalogue.scars],
    "field": [Catalogue.field],
    "plot": [Catalogue.plot],
    "export": [Catalogue.rows, Catalogue.write_dataset, Catalogue.copy],
    "verify": [Catalogue.verify],
    "delete": [Catalogue.delete],
    "merge": [Catalogue.merge],
}
"""The methods that do what a command does; the others (browse, columns, info, migrate, bench) have none with
such options."""

IN_PYTHON = {
    "--parameter": "parameters",  # a mapping
    "--scheduler": "workers",  # an open cluster
}
"""Options whose argument has another name."""

SHELL_ONLY = {
    "--db": "the catalogue itself",
    "--format": "the method of a result: to_pandas, write",
    "--json": "the same",
    "--digits": "texts for people",
    "--uncertainty": "texts for people",
    "--quiet": "results carry their notes",
    "--yes": "nothing asks in Python",
    "--dry-run": "`Catalogue.estimate`",
    "--range": "an argument per column, such as length=(3, 10)",
    "--by-bounce": "`Orbit.points`, `.arclength`, `.sine`",
    "--dataset": "`Catalogue.write_dataset`",
    "--peaks": "`Spectrum.peaks`",
    "--terms": "`Spectrum.terms`",
    "--numbers": "`Assessment.numbers`",
    "--statistics": "`Catalogue.level_statistics`",
    "--deaths": "`Births.ended`",
    "--counts": "`FieldOrbits.counts`",
    "--rates": "`Escape.rates`",
    "--frequency": "`read_levels`",
    "--energies": "`read_levels`",
    "--radius": "`read_levels`",
    "--dpi": "`Figure.savefig`",
    "--output": "`Figure.savefig`",
}
"""Options without an argument, and what does their work in Python."""

OTHERWISE = {
    ("escape", "--by"): "`Escape.columns(by)` takes it afterwards",
    ("field", "--limit"): "a slice of the result",
    ("plot", "--force"): "`Figure.savefig`",
}


def options_of(command: Any) -> list[Any]:
    return [each for each in command.params if each.param_type_name == "option"]


def test_an_option_has_the_same_letter_everywhere():
    for name, command in COMMANDS.items():
        for option in options_of(command):
            assert option.opts[0][:2] == "--", (name, option.opts)
            letters = [each for each in option.opts if each[:2] != "--"]
            assert letters == ([SHORT[option.opts[0]]] if option.opts[0] in SHORT else []), (
                name,
                option.opts,
            )


def test_an_option_is_read_alike_everywhere():
    readings: Any = defaultdict(lambda: defaultdict(list))
    for name, command in COMMANDS.items():
        for option in options_of(command):
            how = option.metavar, option.is_flag, option.multiple, type(option.type).__name__
            readings[option.opts[0]][how].append(name)
    differing = {option: dict(found) for option, found in readings.items() if len(found) > 1}
    assert differing.keys() <= READ_DIFFERENTLY.keys(), differing


def test_options_that_no_command_has_are_not_excused():
    known = {option.opts[0] for command in COMMANDS.values() for option in options_of(command)}
    assert known >= {*READ_DIFFERENTLY, *SHELL_ONLY, *IN_PYTHON, *SHORT}


@pytest.mark.parametrize("command", METHODS)
def test_an_argument_of_python_has_the_name_of_the_option(command):
    arguments = {name for method in METHODS[command] for name in inspect.signature(method).parameters}
    for option in options_of(COMMANDS[command]):
        name = option.opts[0]
        if name in SHELL_ONLY or (command, name) in OTHERWISE:
            continue
        argument = IN_PYTHON.get(name, name[2:].replace("-", "_"))
        assert argument in arguments, f"{command} {name}: Python has {sorted(arguments)}"


@pytest.mark.parametrize("of", [Catalogue, orbitdb])
def test_python_has_one_name_for_one_thing(of):
    """Not ``periods`` beside ``p``, ``low`` and ``high`` beside ``k``, or ``word`` beside ``code``."""
    called = dict(inspect.getmembers(of, inspect.isfunction))
    taken = {name: {*inspect.signature(call).parameters} for name, call in called.items() if name[0] != "_"}
    gone = {"periods", "low", "high", "k_max", "parities", "word", "proof", "rigorous", "reversal"}
    assert {name: names & gone for name, names in taken.items() if names & gone} == {}
    assert len(taken) > 5


def test_the_program_has_at_most_28_commands():
    assert len(COMMANDS) <= 28
