"""Defaults in help texts, their effect, and the values that shell completion offers."""

import re
from collections.abc import Callable
from inspect import signature
from types import SimpleNamespace
from typing import Any

import pytest

from orbitdb import Catalogue, Stadium
from orbitdb.answers.identification import NEAR, SAME_LENGTH, SHOWN
from orbitdb.averages.simulation import simulate
from orbitdb.cli.completions import offered_half_lengths, offered_several_half_lengths
from orbitdb.filling.fill import fill_periods
from orbitdb.trajectories.trajectory import BOUNCES
from orbitdb.verification.verify import verify


def of(function: Callable[..., Any], name: str) -> str:
    return str(signature(function).parameters[name].default)


ONLY = f"the only one stored, else {Stadium().a!r}"
ORDER = of(Catalogue.select, "order")
DEFAULTS: dict[str, dict[str, str | None]] = {
    "fill": {"--a": ONLY, "--method": of(fill_periods, "method")},
    "query": {"--a": ONLY, "--order": ORDER},
    "identify": {
        "--limit": f"{SHOWN}; with --length, 40 in a table, otherwise all",
        "--bounces": str(BOUNCES),
        "--tolerance": f"{NEAR:g} for bounces, {SAME_LENGTH:g} for a length",
    },
    "lyapunov": {"--weight": of(Catalogue.lyapunov, "weight")},
    "spectrum": {"--resolution": of(Catalogue.spectrum, "resolution")},
    "simulate": {
        "--a": ONLY,
        "--seed": of(simulate, "seed"),
        "--store": "if there is one, or one can be made",
    },
    "export": {"--order": ORDER, "--format": None},
    "verify": {"--restarts": of(verify, "restarts"), "--seed": of(verify, "seed")},
}


def told(option: Any) -> str | None:
    """Return the default of an option according to its help, or None."""
    if option.default is not None and option.default is not False and not callable(option.default):
        return str(option.default)
    said = re.search(r"\[default(?:: ([^]]*))?\]", option.help or "")
    return None if said is None else said[1] or ""


@pytest.fixture(scope="module")
def command():
    import typer

    from orbitdb.cli.app import program

    return typer.main.get_command(program())


def test_help_states_the_actual_defaults(command):
    for name, expected in DEFAULTS.items():
        found = {each.opts[0]: told(each) for each in command.commands[name].params}
        assert {each: found[each] for each in expected} == expected, name


@pytest.mark.parametrize(
    ("typed", "offered"),
    [
        (["query", "-c", "length_"], ["length_error"]),
        (["query", "--order", "code,length"], ["code,length", "code,length_error"]),
        (["export", "--status", "orbit,bo"], ["orbit,boundary"]),
        (["query", "--status", ""], ["orbit", "geometric", "dynamical", "boundary", "unresolved", "all"]),
        (["table", "--a", "1."], ["1.6"]),
        (["query", "--a", ""], ["1", "1.6", "all"]),
        (["browse", "--a", ""], ["1", "1.6"]),
    ],
)
@pytest.mark.parametrize("named", [True, False])
def test_completion_offers_values(varied, tmp_path, monkeypatch, command, typed, offered, named):
    """Values of a come from the catalogue of --db, or else from the default catalogue."""
    monkeypatch.setenv("ORBITDB_DB", str(tmp_path / "none.db" if named else varied))
    with command.make_context("orbitdb", typed[:1], resilient_parsing=True) as top:
        called = command.commands[typed[0]]
        db = ["--db", str(varied)] if named else []
        context = called.make_context(typed[0], db, parent=top, resilient_parsing=True)
    option = next(each for each in called.params if typed[1] in each.opts)
    assert [item.value for item in option.shell_complete(context, typed[2])] == offered


def test_completion_offers_nothing_from_a_file_that_is_not_a_catalogue(tmp_path):
    path = tmp_path / "orbits.db"
    path.write_bytes(b"no catalogue" * 99)
    context: Any = SimpleNamespace(params={"db": path})
    assert offered_half_lengths(context) == []
    assert offered_several_half_lengths(context) == ["all"]


def test_the_completion_of_another_shell_is_that_shells(cli):
    assert "compdef _orbitdb_completion orbitdb" in cli("--show-completion", "zsh").out
    assert "complete -o default -F _orbitdb_completion orbitdb" in cli("--show-completion", "bash").out
    other = cli("--show-completion", "tcsh")
    assert (other.code, other.out) == (1, "")
    assert "tcsh" in other.err
