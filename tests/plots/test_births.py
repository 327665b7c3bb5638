"""The figure of births: what it draws, and where there is nothing to draw."""

import pytest


@pytest.mark.slow
def test_the_command_draws_what_is_stored(cli, tmp_path):
    figure = tmp_path / "births.svg"
    cli("migrate")
    nothing = cli("plot", "births", "-o", str(figure))
    assert (nothing.code, figure.exists()) == (2, False)
    assert "'orbitdb births --p 11' finds them" in nothing.err
    cli("births", "--p", "5")
    drawn = cli("plot", "births", "-o", str(figure))
    assert (drawn.code, drawn.out) == (0, "")
    assert "topological entropy" in figure.read_text(encoding="utf-8")
    life = cli("plot", "life", "--code", "01552", "-o", str(tmp_path / "life.svg"))
    assert (life.code, life.err) == (0, f"life of 01552, in {tmp_path / 'life.svg'}\n")
    never = cli("plot", "life", "--code", "0131", "-o", str(tmp_path / "never.svg"))
    assert (never.code, (tmp_path / "never.svg").exists()) == (2, False)
    assert "0131 has no life" in never.err
    refused = cli("plot", "births", "--code", "13", "-o", str(figure))
    assert (refused.code, len(refused.err.splitlines())) == (2, 1)
