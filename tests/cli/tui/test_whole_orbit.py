"""The screen that shows the whole of an orbit."""

from dataclasses import replace
from io import StringIO

import pytest
from rich.console import Console, Group
from screens import LARGE, SMALL, drive, press, shown
from there import there

from orbitdb.cli.tui.dialogs.keys import KeysDialog
from orbitdb.cli.tui.main_screen import MainScreen
from orbitdb.cli.tui.orbit.whole_orbit import WholeOrbitScreen, whole
from orbitdb.numerals import upwards
from orbitdb.orbits.single_word import solve_word
from orbitdb.symbols.symmetry import members


def text_of(orbit, partners=()):
    shown = StringIO()
    console = Console(file=shown, width=70)
    console.print(Group(*whole(orbit, (2e-30, 128), partners)))
    return [line.rstrip() for line in shown.getvalue().splitlines()]


def test_everything_known_of_an_orbit_is_in_the_lines():
    orbit = solve_word("01552", 1.6, exists=True)
    [(born, _)] = there(orbit.exists)
    texts = text_of(orbit, [(born * (1 + 1e-15), ["01234"])])
    text = " ".join(" ".join(texts).split())
    assert ", 128 bits" in text
    assert "from a = 1.15470053838 on" in text
    assert "1.15470054 2 sqrt(3)/3, recognised numerically" in text
    assert "born at 1.15470054 with 01234" in text
    several = replace(orbit, exists=((0.0, 0.41), (0.61, 1.71), (1.81, None)))
    again = " ".join(" ".join(text_of(several)).split())
    assert "to a = 0.41, and from a = 0.61 to 1.71, and from a = 1.81 on" in again
    part = texts[texts.index("symmetry class") + 1 : texts.index("bounces") - 1]
    assert {line.split()[0] for line in part if line[0] != " "} == set(members("01552"))
    bounces = [line.split() for line in texts[texts.index("bounces") + 2 :]]
    assert "".join(row[1] for row in bounces) == "01552"
    assert [float(row[2]) for row in bounces] == pytest.approx(orbit.coordinates, abs=1e-6)
    assert float(bounces[0][4]) == -1  # symbol 0 is the bottom wall


def test_a_pruned_word_and_a_long_one_have_what_there_is():
    texts = text_of(solve_word("00123", 1.6, exists=True))
    assert any("hits one straight wall twice" in line for line in texts)
    assert not {"symmetry class", "bounces"} & set(texts)
    code = "1" * 40 + "3"
    assert code in "".join(text_of(solve_word(code, 1.6)))


@pytest.mark.slow
@pytest.mark.parametrize("size", [SMALL, LARGE])
def test_enter_opens_the_whole_orbit(filled_once, size):
    async def steps(app, pilot):
        await press(pilot, "j", "enter")
        assert isinstance(app.screen, WholeOrbitScreen)
        assert "013 at a = 1.6" in shown(app)
        await press(pilot, "G")
        assert "bounces" in shown(app)
        await press(pilot, "question_mark")
        assert isinstance(app.screen, KeysDialog)
        assert "back to the orbits" in shown(app)
        await press(pilot, "escape", "v")
        assert "phase space" in shown(app)
        await press(pilot, "enter")
        assert isinstance(app.screen, MainScreen)
        assert there(app.screen.orbit).code == "013"

    drive(filled_once, steps, size)


@pytest.mark.slow
def test_a_stored_proof_is_shown_with_its_orbit(cli, tmp_path):
    cli("fill", "--p", "3")
    assert cli("verify", "--rigorous", "--p", "2").code == 0

    async def steps(app, pilot):
        assert app.screen.orbit.code == "13"
        radius, bits = app.certificate(app.screen.orbit)
        assert f"radius {upwards(radius)}, {bits} bits" in shown(app)
        await press(pilot, "j")
        assert "none stored" in shown(app)

    drive(tmp_path / "orbits.db", steps, LARGE)
