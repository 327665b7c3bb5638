"""Periods that are not or partly filled never count as zero, and are described in the same way everywhere."""

import json
import re
from collections import Counter

import pytest
from contents import alter, answer, before_statements, counts_of, made
from quick import slow_but
from sqlalchemy import event
from there import there

from orbitdb import Catalogue
from orbitdb.answers.complete_periods import read_complete_periods
from orbitdb.answers.completeness import Coverage
from orbitdb.cli.advice import completed, remember
from orbitdb.errors import InputError
from orbitdb.filling.fill import fill_periods, fill_words
from orbitdb.filling.sweeps import sweep_periods
from orbitdb.selection import Selection
from orbitdb.store.file import reading
from orbitdb.store.periods import Fill
from orbitdb.symbols.pruning import count_admissible


@pytest.fixture(autouse=True)
def nothing_given():
    """Let advice lack the options of a command in an earlier test."""
    remember([])


def fill(p, state="done"):
    return Fill(p, state, 1, 0.0, 0.0, 0.0, 0.0, None, (), None, None, None, None, None)


def coverage(fills, periods, a=1.6, filled_at=(1.6,)):
    """Return what is stored of some periods, of a catalogue that nobody made."""
    known = Coverage(None, Selection(a, tuple(periods)))  # type: ignore[arg-type]
    known.stored.fills, known.stored.filled_at = fills, list(filled_at)
    return known


KNOWN = [fill(p) for p in (*range(2, 9), 10)]


@pytest.mark.parametrize(
    ("known", "periods", "a", "filled_at", "named"),
    [
        (KNOWN, [(12, 12)], 1.6, [1.0, 1.6], "period 12 |periods 2-8, 10|some at a = 1)|--p 12 --a 1.6"),
        ([*KNOWN, fill(9, "filling")], [(9, 9), (11, 11)], 1.6, [1.6], "period 11 |periods 2-8, 10)|--p 11 "),
        (KNOWN, [(3, 9), (8, 12)], 1.6, [1.6], "periods 9, 11-12 are|--p 12 "),
        ([], [], 0.1234567, [], "nothing is filled|--p 11 --a 0.1234567"),
        ([], [], 7.2, range(1, 11), "some at a = 5, 6, 7, 8, 9, 10 and 4 more"),
        ([], [(19, 99)], 1.0, range(1, 9), "periods 19-20 |a = 2, 3, 4, 5, 6, 7 and 1 more|--p 20 |--code"),
        (KNOWN, [(21, 10**9)], 1.6, [1.6], "go up to period 20|--code"),
    ],
)
def test_the_message_names_what_is_unfilled_what_is_filled_and_the_command(
    known, periods, a, filled_at, named
):
    said = completed(there(coverage(known, periods, a, filled_at).unfilled()))
    assert [each for each in named.split("|") if each not in said] == []


@pytest.mark.parametrize("periods", [[(2, 8)], [], [(0, 1)]])
def test_filled_periods_get_no_message(periods):
    assert coverage(KNOWN, periods).unfilled() is None
    assert coverage([fill(9, "filling")], [(9, 9)]).unfilled() is None


def test_a_subset_does_not_count_unfilled_periods_as_zero(varied):
    catalogue = Catalogue(varied)
    assert str(catalogue.select(p=9, status="orbit")) == (
        "<period 9 is not filled at a = 1.6 (filled: periods 2-6; some at a = 1): "
        "`catalogue.fill(p=9, a=1.6)` fills it>"
    )
    assert str(catalogue.select(a=2.5)).startswith("<nothing is filled at a = 2.5 (filled: some at a = 1, ")
    some = str(catalogue.select(p="6-7", status="orbit"))
    assert some.startswith("<188 orbits of period 6 to 7 at a = 1.6; period 7 is not filled at a = 1.6 (")
    assert str(catalogue.select(p=2, length=(99, None))) == (
        "<0 orbits of period 2 at a = 1.6 with length >= 99>"
    )


def test_the_only_a_of_a_catalogue_is_the_default(tmp_path):
    path = tmp_path / "orbits.db"
    assert Catalogue.create(path).a == 1.6
    fill_words(path, ["13"], 0.5)
    assert Catalogue(path).a == 0.5
    assert Catalogue(path)["13"].length == pytest.approx(6, rel=1e-15)
    made(path, fill_periods(path, 2.0, [2]))
    with pytest.raises(InputError, match=r"^orbits are stored at a = 0\.5, 2: name one, such as `a=0\.5`"):
        Catalogue(path).select(p=2)
    assert repr(Catalogue(path)) == "<Catalogue orbits.db: no complete period at a = 0.5; period 2 at a = 2>"
    assert len(Catalogue(path, a=2.0).select(p=2)) == len(Catalogue(path).select(p=2, a=2.0)) == 1
    made(path, fill_periods(path, 1.6, [2]))
    assert Catalogue(path).a == 1.6


GAP = "period 13 is not filled at a = 1.6 (filled: periods 2-6; some at a = 1): 'orbitdb fill --p 13 --a 1.6'"
NOWHERE = "nothing is filled at a = 3 (filled: some at a = 1, 1.6): 'orbitdb fill --p 11 --a 3' fills periods"
READERS = ["query --status orbit", "query --json", "table", "entropy", "lyapunov", "export --format csv",
           "plot entropy -o f.svg", "plot lengths -o f.svg", "plot phase-space -o f.svg",
           "verify"]  # fmt: skip


@pytest.mark.parametrize("command", slow_but(READERS[:4], READERS))
def test_no_command_counts_unfilled_periods_as_zero(cli, varied, tmp_path, monkeypatch, command):
    monkeypatch.chdir(tmp_path)
    for more, said in (["--p", "13", "--a", "1.6"], GAP), (["--a", "3"], NOWHERE):
        done = cli(*command.split(), *more, "--db", str(varied))
        lines = done.err.replace(f" --db {varied}", "").splitlines()
        assert done.code == 1
        assert lines[0].startswith(said)
        assert len(lines) == 1 + (command == "verify" and said == GAP)  # it also says the file is sound
        assert "no orbits" not in done.err


@pytest.mark.parametrize(
    "command", slow_but(["table"], [*READERS[:6], "query --code 13", "plot orbit --code 13 --force -o f.svg"])
)
def test_commands_default_to_the_only_a(cli, tmp_path, monkeypatch, command):
    monkeypatch.chdir(tmp_path)
    cli("fill", "--p", "4", "--a", "1")
    done = cli(*command.split())
    assert done.code == 0
    assert "a = 1, the only value in orbits.db" in done.err.splitlines()
    assert "the only value" not in cli(*command.split(), "--a", "1").err
    cli("fill", "--p", "4", "--a", "2")
    assert cli(*command.split()).says(2, "a = 1, 2", "--a")


def test_missing_births_are_reported_only_if_needed(varied):
    with reading(varied) as connection:
        some, every = (Coverage(connection, Selection.from_criteria(p=p)) for p in ("3-4", None))
        assert some.without_births(("born",)) == [3, 4]
        assert every.without_births(order="dies desc") == [2, 3, 4, 5, 6]
        assert some.without_births() == []


def test_what_is_stored_is_read_once(varied):
    statements = []
    with reading(varied) as connection:
        event.listen(connection, "before_cursor_execute", lambda *said: statements.append(said[2]))
        covered = Coverage(connection, Selection.from_criteria(a=1.6, p="3-9", born=(0.1, None)))
        for each in (covered, covered.of(Selection(1.6)), covered):
            assert each.gaps(order="born")
            assert each.unfilled() is None or each.nothing()
            assert each.complete("length")
    read = Counter(re.findall(r"FROM (\w+)", statement)[0] for statement in statements)
    assert read.keys() >= {"fill", "birth_fill"}
    assert max(read.values()) == 1, read


def test_unfinished_births_of_a_period_count_nothing(tmp_path, cli):
    assert cli("births", "--p", "5").code == 0
    assert counts_of(Catalogue(tmp_path / "orbits.db"), a=0.7).chosen == (2, 3, 4, 5)
    alter(tmp_path / "orbits.db", "UPDATE birth_fill SET state = 'filling' WHERE p = 5")
    assert counts_of(Catalogue(tmp_path / "orbits.db"), a=0.7).chosen == (2, 3, 4)


SENTENCE = (
    "period 9 at a = 1.6 is partial: a fill is running or was stopped; "
    "'orbitdb fill --p 9 --a 1.6' completes it"
)
LEFT_OUT = SENTENCE.replace("partial", "partial and left out")
NINE = Selection(periods=((9, 9),))


@pytest.fixture
def partial(filled, begin_fill):
    """A catalogue with p = 2..8, and with part of p = 9."""
    begin_fill(filled, 9).close()
    return filled


def notes(outcome):
    assert outcome.code == 0, outcome.err
    return [line for line in outcome.err.splitlines() if " partial" in line]


@pytest.mark.parametrize("command", slow_but(["query"], ["query", "export"]))
def test_rows_of_a_partial_period_are_shown_with_a_note(cli, partial, command):
    asked = command, "--format", "csv", "--status", "all"
    whole = cli(*asked, "--p", "2-8")
    assert notes(whole) == []
    done = cli(*asked, "--p", "2-9")
    assert notes(done) == [SENTENCE]
    rows, stored = len(done.out.splitlines()), Catalogue(partial).count(NINE)
    assert rows == len(whole.out.splitlines()) + stored
    assert 0 < stored < count_admissible(9)


@pytest.mark.parametrize("command", slow_but(["lyapunov"], ["table", "entropy", "lyapunov"]))
def test_averages_use_whole_periods_only(cli, partial, command):
    whole, asked = cli(command, "--p", "2-8"), cli(command)
    assert notes(whole) == []
    assert notes(asked) == [LEFT_OUT]
    assert asked.out == whole.out


def test_a_partial_period_that_a_sweep_counts_is_not_left_out(awkward):
    at_a = "WHERE p = 6 AND stadium = (SELECT id FROM stadium WHERE a = 0.3)"
    alter(awkward, "DELETE FROM entropy_bound")  # a table with bounds computes closer ones
    whole = Catalogue(awkward).table(a=0.3, p=6)
    alter(awkward, f"UPDATE fill SET state = 'filling', n_c = NULL {at_a}")
    found = Catalogue(awkward).table(a=0.3, p=6)
    assert (found["p"], found["N_c"]) == ([6], whole["N_c"])
    (note,) = found.notes
    assert "period 6 at a = 0.3: counted by a sweep" in note


@pytest.mark.slow
def test_a_stability_cut_needs_all_lower_periods(cli, filled, begin_fill):
    begin_fill(filled, 9).close()
    below = cli("lyapunov", "--cut", "8", "--p", "2-8", "--json")
    above = cli("lyapunov", "--cut", "8", "--json")
    assert notes(above) == [LEFT_OUT]
    assert above.out == below.out
    made(filled, fill_periods(filled, 1.6, [10]))
    holed = cli("lyapunov", "--cut", "8", "--json")
    assert "the zeta function lacks p = 9" in holed.err
    assert json.loads(holed.out)[0]["lambda_d_zeta"] is None


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["entropy", "lyapunov", "sheet", "phase-space", "lengths"])
def test_figures_report_partial_periods(cli, partial, tmp_path, kind):
    few = ["--limit", "4"] if kind == "sheet" else []
    drawn = cli("plot", kind, "--p", "7-9", *few, "-o", str(tmp_path / "figure.png"))
    assert notes(drawn) == [LEFT_OUT if kind in ("entropy", "lyapunov") else SENTENCE]


def test_an_exported_file_records_partial_periods(cli, partial, tmp_path):
    for name, periods, expected in (("part.csv", "9", [9]), ("whole.csv", "8", [])):
        cli("export", str(tmp_path / name), "--p", periods)
        kept = json.loads((tmp_path / f"{name}-metadata.json").read_text())
        assert kept["partial"] == expected


@pytest.mark.parametrize("begun", [False, True])
@pytest.mark.parametrize("command", slow_but(["lyapunov"], ["query", "entropy", "lyapunov"]))
def test_a_command_describes_one_moment(cli, filled, begin_fill, begun, command):
    """A fill of p = 9 advances by one block with every query of the command, which does not notice it."""
    going = begin_fill(filled, 9) if begun else fill_periods(filled, 1.6, [9])
    quiet = notes(cli(command, "--p", "8-9"))
    assert quiet == ([LEFT_OUT if command in ("entropy", "lyapunov") else SENTENCE] if begun else quiet)
    at_work, blocks = False, 0

    def go_on(statement: str) -> None:
        nonlocal at_work, blocks
        if not at_work and statement.startswith(("SELECT", "WITH")):
            at_work = True
            blocks += next(going, None) is not None
            at_work = False

    with before_statements(go_on):
        assert notes(cli(command, "--p", "8-9")) == quiet
    assert blocks > 0
    going.close()


def test_whole_periods_are_read_without_partial_ones(partial):
    found = answer(partial, read_complete_periods, Selection())
    assert found.periods == tuple(range(2, 9))
    assert found.classes.p.max() == found.highest == 8
    assert found.missing == []
    assert len(answer(partial, read_complete_periods, NINE).classes) == 0
    rows = Catalogue(partial).select(p="7-9")
    assert rows.table()["p"] == rows.entropy()["p"] == [7, 8]
    alter(partial, "DELETE FROM fill WHERE p = 8")
    swept = Catalogue(made(partial, sweep_periods(partial, 1.6, [8])))
    assert LEFT_OUT in map(completed, swept.entropy().notes)
