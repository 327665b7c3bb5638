"""Commands in a real terminal, as people use them."""

import pytest
from terminal import run_in_terminal


@pytest.mark.parametrize("columns", [80, 200])
def test_the_first_command_of_the_readme(tmp_path, columns):
    path = tmp_path / "orbits.db"
    session = run_in_terminal("fill", "--p", "7", "--db", path, columns=columns)
    assert session.code == 0, session.text
    assert "Traceback" not in session.text
    assert "p =  7" in session.text  # the bar was there
    shown = "".join(session.lines)
    assert shown.startswith("p = 2..7 at a = 1.6: 1101 sequences, 685 orbits")
    assert shown.endswith("orbits.db")  # and is gone
    assert not session.cursor_hidden
