"""What shells are offered behind an option."""

import pytest


@pytest.fixture(scope="module")
def command():
    import typer

    from orbitdb.cli.app import program

    return typer.main.get_command(program())


@pytest.mark.parametrize(
    ("typed", "offered"),
    [
        (["query", "-c", "length_"], ["length_error"]),
        (["query", "--order", "code,length"], ["code,length", "code,length_error"]),
        (["export", "--status", "orbit,bo"], ["orbit,boundary"]),
        (["query", "--status", ""], ["orbit", "geometric", "dynamical", "boundary", "unresolved", "all"]),
        (["table", "--a", "1"], ["1", "1.6"]),
        (["query", "--a", ""], ["1", "1.6", "all"]),
        (["browse", "--a", ""], ["1", "1.6"]),
    ],
)
@pytest.mark.parametrize("named", [True, False])
def test_shells_are_offered_values(varied, tmp_path, monkeypatch, command, typed, offered, named):
    """Those of a are of the catalogue that --db names, or of the user's."""
    monkeypatch.setenv("ORBITDB_DB", str(tmp_path / "none.db" if named else varied))
    with command.make_context("orbitdb", typed[:1], resilient_parsing=True) as top:
        called = command.commands[typed[0]]
        db = ["--db", str(varied)] if named else []
        context = called.make_context(typed[0], db, parent=top, resilient_parsing=True)
    option = next(each for each in called.params if typed[1] in each.opts)
    assert [item.value for item in option.shell_complete(context, typed[2])] == offered
