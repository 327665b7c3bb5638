"""Reading beside a fill, or behind one that was stopped: whole periods, or a word that they are not."""

import json

import pytest
import sqlalchemy as sa
from quick import slow_but

from orbitdb.catalogue.catalogue import Catalogue
from orbitdb.catalogue.whole_periods import read_whole
from orbitdb.filling.periods import fill_periods
from orbitdb.store.asking.selection import Selection
from orbitdb.symbols.counting import count_admissible

SENTENCE = (
    "period 9 at a = 1.6 is partial: a fill goes on or was stopped; 'orbitdb fill --p 9 --a 1.6' completes it"
)
LEFT_OUT = SENTENCE.replace("partial", "partial and left out")
NINE = Selection(periods=((9, 9),))


@pytest.fixture
def partial(filled, begin_fill):
    """A catalogue with p = 2..8, and a part of p = 9."""
    begin_fill(filled, 9).close()
    return filled


def notes(outcome):
    assert outcome.code == 0, outcome.err
    return [line for line in outcome.err.splitlines() if "partial" in line]


@pytest.mark.parametrize("command", slow_but(["query"], ["query", "export"]))
def test_rows_of_a_part_are_shown_and_said_to_be_one(cli, partial, command):
    whole = cli(command, "--format", "csv", "--p", "2-8")
    assert notes(whole) == []
    asked = cli(command, "--format", "csv", "--p", "2-9")
    assert notes(asked) == [SENTENCE]
    rows, stored = len(asked.out.splitlines()), Catalogue(partial).count(NINE)
    assert rows == len(whole.out.splitlines()) + stored
    assert 0 < stored < count_admissible(9)


@pytest.mark.parametrize("command", slow_but(["lyapunov"], ["table", "entropy", "lyapunov"]))
def test_averages_are_over_whole_periods(cli, partial, command):
    whole, asked = cli(command, "--p", "2-8"), cli(command)
    assert notes(whole) == []
    assert notes(asked) == [LEFT_OUT]
    assert asked.out == whole.out


@pytest.mark.slow
def test_an_average_cut_by_stability_needs_all_lower_periods(cli, filled, begin_fill):
    begin_fill(filled, 9).close()
    below = cli("lyapunov", "--cut", "8", "--p", "2-8", "--json")
    above = cli("lyapunov", "--cut", "8", "--json")
    assert notes(above) == [LEFT_OUT]
    assert above.out == below.out
    for _ in fill_periods(filled, 1.6, [10]):
        pass
    holed = cli("lyapunov", "--cut", "8", "--json")
    assert "the zeta function lacks p = 9" in holed.err
    assert json.loads(holed.out)[0]["lambda_d_zeta"] is None


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["entropy", "lyapunov", "sheet", "phase-space", "lengths"])
def test_figures_say_it(cli, partial, tmp_path, kind):
    few = ["--limit", "4"] if kind == "sheet" else []
    drawn = cli("plot", kind, "--p", "7-9", *few, "-o", str(tmp_path / "figure.png"))
    assert notes(drawn) == [LEFT_OUT if kind in ("entropy", "lyapunov") else SENTENCE]


def test_a_file_keeps_what_was_partial(cli, partial, tmp_path):
    for name, periods, expected in (("part.csv", "9", [9]), ("whole.csv", "8", [])):
        cli("export", str(tmp_path / name), "--p", periods)
        kept = json.loads((tmp_path / f"{name}-metadata.json").read_text())
        assert kept["partial"] == expected


@pytest.fixture(params=["not begun", "begun"])
def busy(request, filled, begin_fill):
    """A catalogue with p = 2..8 in which a fill of p = 9 goes a batch further behind every question."""
    begun = request.param == "begun"
    going = begin_fill(filled, 9) if begun else fill_periods(filled, 1.6, [9])
    at_work = False

    def go_on(connection, cursor, statement, *_):
        nonlocal at_work
        if not at_work and statement.startswith(("SELECT", "WITH")):
            at_work = True
            next(going, None)
            at_work = False

    sa.event.listen(sa.Engine, "after_cursor_execute", go_on)
    yield [9] if begun else []
    sa.event.remove(sa.Engine, "after_cursor_execute", go_on)


@pytest.mark.parametrize("command", slow_but(["lyapunov"], ["query", "entropy", "lyapunov", "verify"]))
def test_what_a_command_says_is_of_one_moment(cli, busy, command):
    asked = cli(command, "--p", "8-9")
    said = LEFT_OUT if command in ("entropy", "lyapunov") else SENTENCE
    assert notes(asked) == [said] * len(busy)


def test_whole_periods_are_read_without_their_neighbours_parts(partial):
    found = read_whole(Catalogue(partial), Selection())
    assert found.periods == list(range(2, 9))
    assert found.classes.p.max() == found.highest == 8
    assert found.missing == []
    assert len(read_whole(Catalogue(partial), NINE).classes) == 0
