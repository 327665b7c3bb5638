"""``orbitdb births`` and ``orbitdb sweep``, and other commands if nothing has been filled."""

import json
import shutil

import pytest
from contents import alter

from orbitdb import Catalogue
from orbitdb.cli.advice import completed
from orbitdb.filling.fill import fill_births

OF_BIRTHS = ["p", "classes", "births", "deaths", "always", "least", "largest"]


@pytest.fixture
def born(born_once, tmp_path):
    """A copy of `born_once`, the default of the command line."""
    return shutil.copy(born_once, tmp_path / "orbits.db")


def test_births_are_found_once_and_shown(cli):
    first = cli("births", "--p", "5")
    assert first.code == 0
    assert first.out.splitlines()[0].split() == OF_BIRTHS
    assert first.out.splitlines()[-1].split() == ["5", "17", "13", "0", "4", "0.366025", "1.674424"]
    assert first.err.startswith("births, p = 2..5: ")
    again = cli("births", "--json")
    assert again.err == ""
    assert "\nbirths     periods 2-5\n" in cli("info").out
    rows = json.loads(again.out)
    assert [list(row) for row in rows] == [OF_BIRTHS] * 4
    assert rows[0]["least"] is None
    assert json.loads(cli("births", "--p", "4-5", "--json").out) == rows[2:]


@pytest.mark.slow
def test_births_of_some_periods_are_shown_alone(awkward, cli):
    assert [row["p"] for row in json.loads(cli("births", "--p", "3", "--json").out)] == [2, 3]


def test_a_word_that_dies_for_good_has_no_further_birth(awkward, cli):
    """The word after it has one."""
    (ended,) = json.loads(cli("births", "--deaths", "--json").out)
    lives = {life.word: life for life in Catalogue(awkward).births(ended["p"])}
    assert (ended["born"], ended["dies"]) == (lives[ended["word"]].born, lives[ended["word"]].dies)
    assert max(lives) > ended["word"]
    assert ended["reborn"] is None


@pytest.mark.slow
def test_the_table_of_an_unfilled_a_comes_from_births(cli, born):
    unfilled = cli("table", "--a", "1", "--json")
    assert unfilled.code == 0
    assert unfilled.err == "periods 2-6 at a = 1: counted from births, without a fill\n"
    cli("fill", "--p", "6", "--a", "1")
    filled = cli("table", "--a", "1", "--json")
    assert filled.err == ""
    assert filled.out == unfilled.out
    assert json.loads(unfilled.out)[4]["boundary"] == 32


@pytest.mark.slow
def test_rows_can_be_chosen_by_births_and_deaths(cli, born):
    alter(born, "DELETE FROM change WHERE cycle IN (SELECT id FROM cycle WHERE p = 6)",
          "DELETE FROM birth_fill WHERE p = 6")  # fmt: skip
    cli("fill", "--p", "6")
    alive = cli("query", "--exists", "0.8", "--not-at", "0.7", "--p", "5", "-c", "code,born,dies", "--json")
    assert {round(row["born"], 6) for row in json.loads(alive.out)} == {0.770598}
    assert {row["dies"] for row in json.loads(alive.out)} == {None}
    every = ("--p", "5", "--status", "all")
    ordered = cli("query", *every, "--order", "born desc", "-c", "born", "--format", "csv")
    values = ordered.out.splitlines()[1:]
    assert float(values[0]) == pytest.approx(1.674424, abs=1e-6)
    assert values[-1] == '""'  # an orbit from a = 0 on
    lacking = cli("query", "--exists", "0.8", "--p", "6")
    assert (lacking.code, lacking.out) == (1, "")
    assert "births of period 6 are not stored" in lacking.err.splitlines()[0]
    assert "births of period 6 are not stored" in cli("query", "--p", "6", "--order", "born", "-c", "p").err
    chosen = cli("entropy", "--a", "0.8", "--exists", "0.5")
    assert (chosen.code, chosen.out) == (1, "")
    assert "at a = 0.8, all orbits of periods 2-5 were counted" in chosen.err


@pytest.mark.slow
def test_query_names_the_words_born_with_a_word(cli, born):
    (line,) = (each for each in cli("query", "--code", "01552").out.splitlines() if "born at" in each)
    a, _, words = line.removeprefix("  born at ").partition("with ")
    assert words
    for word in words.split(", "):
        assert f"for a > {a.strip()[:7]}" in cli("query", "--code", word).out


@pytest.mark.slow
def test_every_life_that_ends_is_listed(cli, born):
    """No class of few bounces ever dies. Here two are altered to die, and one of these to be reborn."""
    changes = [("0132", 2, 3.0, "died"), ("0132", 3, 5.0, "born"), ("0132", 4, 9.0, "died")]
    for word, number, a, kind in [*changes, ("013", 2, 2.0, "died")]:
        row = f"id, {number}, {a}, {a / 1e15}, '{kind}', 1 FROM cycle WHERE word = '{word}'"
        alter(born, f"INSERT INTO change (cycle, number, a, error, kind, run) SELECT {row}")
    ended = cli("births", "--deaths", "--json")
    assert ended.err == "3 lives end among 75 classes\n"
    assert [list(row.values()) for row in json.loads(ended.out)] == [
        [3, "013", 4, None, 2.0, 2e-15, None],
        [4, "0132", 4, None, 3.0, 3e-15, 5.0],
        [4, "0132", 4, 5.0, 9.0, 9e-15, None],
    ]
    assert ",".join(json.loads(ended.out)[0]) == "p,word,class_size,born,dies,dies_error,reborn"


KEYS = ["p", "N_t", "N_c", "classes", "boundary", "unresolved", "seconds", "processor_seconds"]


def test_other_commands_use_sweeps(cli):
    planned = cli("sweep", "--p", "6", "--dry-run")
    assert planned.err.startswith("p = 2..6 at a = 1.6: 389 words to solve, under a second, in ")
    assert planned.out == ""
    swept = cli("sweep", "--p", "6", "--json")
    rows = json.loads(swept.out)
    assert [list(row) for row in rows] == [KEYS] * 5
    assert [rows[-1][key] for key in KEYS[:6]] == [6, 252, 188, 39, 0, 0]
    assert swept.err.startswith("p = 2..6 at a = 1.6: 389 words, ")
    commands = (("table",), ("entropy",), ("lyapunov", "--weight", "det"))
    before = [cli(*command, "--json") for command in commands]
    source = "periods 2-6 at a = 1.6: counted by a sweep, without stored rows\n"
    assert all(outcome.code == 0 and source in outcome.err for outcome in before)
    assert cli("lyapunov", "--cut", "9").code == 1
    part = cli("entropy", "--time-reversal", "self").err
    assert part.startswith(
        "at a = 1.6, all orbits of periods 2-6 were counted, but no rows are stored: choose"
    )
    cli("fill", "--p", "5")
    assert "period 6 at a = 1.6: counted by a sweep" in cli("lyapunov").err
    cli("fill", "--p", "6")
    for command, old in zip(commands, before, strict=True):
        new = cli(*command, "--json")
        assert "sweep" not in new.err
        for row, stored in zip(json.loads(old.out), json.loads(new.out), strict=True):
            stored = {key: row[key] if "sum_rule" in key else x for key, x in stored.items()}
            near = {key: pytest.approx(x, rel=1e-12) for key, x in stored.items() if isinstance(x, float)}
            assert row == stored | near


@pytest.mark.slow
def test_partial_births_are_named_and_left_out(cli, tmp_path, monkeypatch):
    cli("migrate")
    monkeypatch.setattr("orbitdb.filling.fill.BIRTHS_BLOCK", 50)
    going = fill_births(tmp_path / "orbits.db", [6])
    next(going)
    going.close()
    done = cli("births")
    assert (done.code, done.out) == (1, "")
    partial, nothing = done.err.splitlines()
    assert partial == "births of period 6 are incomplete: 'orbitdb births --p 6' completes them"
    catalogue = Catalogue(tmp_path / "orbits.db")
    assert [*map(completed, catalogue.births(6).notes)] == [partial]
    assert catalogue.births(7).notes == (
        "births of period 7 are not stored: `catalogue.fill_births(p=7)` finds them",
    )
    assert nothing.startswith("no births in ")
    assert cli("births", "--p", "6").err.startswith("births, p = 2..6: ")
    whole, part = (cli("entropy", "--a", "1", "--p", p, "--json").out for p in ("2-4", "3-4"))
    assert json.loads(part) == json.loads(whole)[1:]


@pytest.mark.slow
def test_verify_says_which_sums_it_did_not_compute_again(cli, tmp_path, monkeypatch):
    for module in ("check_sweeps", "verify"):
        monkeypatch.setattr(f"orbitdb.verification.{module}.SWEPT_ANEW", 2)
    cli("sweep", "--p", "4")
    cli("births", "--p", "4")
    assert "11 of 11 classes have all births and deaths between" in cli("verify", "--births").err
    for periods, what in ((["--p", "3"], "the sums of a swept period were"),
                          ([], "the sums of 2 swept periods were")):  # fmt: skip
        done = cli("verify", *periods)
        assert done.code == 0
        assert done.err.splitlines()[0] == f"{what} not recomputed: only sums of whole periods up to 2 are"


def test_a_sweep_takes_whole_periods(cli):
    done = cli("sweep", "--p", "4", "--contains", "13")
    assert (done.code, done.out) == (2, "")
    assert "--contains" in done.err
