"""What is not filled is never told as zero, in one wording everywhere."""

import pytest
from quick import slow_but
from there import there

from orbitdb import Catalogue
from orbitdb.catalogue.gaps import describe_unfilled
from orbitdb.errors import InputError
from orbitdb.filling.periods import fill_periods, fill_word
from orbitdb.store.asking.criteria import choose
from orbitdb.store.reading.fills import Fill


def fill(p, state="done"):
    return Fill(p, state, 1, 0.0, 0.0, 0.0, 0.0, None, (), None, None, None, None, None)


KNOWN = [fill(p) for p in (*range(2, 9), 10)]


@pytest.mark.parametrize(
    ("known", "periods", "a", "filled_at", "named"),
    [
        (
            KNOWN,
            [(12, 12)],
            1.6,
            [1.0, 1.6],
            "period 12 |periods 2-8, 10|some at a = 1)|--p 12 --a 1.6",
        ),
        ([*KNOWN, fill(9, "filling")], [(9, 9), (11, 11)], 1.6, [1.6], "period 11 |periods 2-8, 10)|--p 11 "),
        (KNOWN, [(3, 9), (8, 12)], 1.6, [1.6], "periods 9, 11-12 are|--p 12 "),
        ([], [], 0.1234567, [], "nothing is filled|--p 11 --a 0.1234567"),
        ([], [(19, 99)], 1.0, range(1, 9), "periods 19-99 |a = 2, 3, 4, 5, 6, 7 and 1 more|--p 20 |--code"),
        (KNOWN, [(21, 10**9)], 1.6, [1.6], "periods 21-1000000000 |end at period 20|--code"),
    ],
)
def test_what_is_not_filled_what_is_and_what_fills_it(known, periods, a, filled_at, named):
    said = there(describe_unfilled(known, periods, a, filled_at))
    assert [each for each in named.split("|") if each not in said] == []


@pytest.mark.parametrize("periods", [[(2, 8)], [], [(0, 1)]])
def test_of_what_is_filled_nothing_is_said(periods):
    assert describe_unfilled(KNOWN, periods, 1.6, [1.6]) is None
    assert describe_unfilled([fill(9, "filling")], [(9, 9)], 1.6, [1.6]) is None


def test_a_subset_does_not_claim_zero_of_what_is_not_filled(varied):
    catalogue = Catalogue(varied)
    assert repr(catalogue.select(p=9, status="orbit")) == (
        "<period 9 is not filled at a = 1.6 (filled: periods 2-6; some at a = 1): "
        "'orbitdb fill --p 9 --a 1.6' fills it>"
    )
    assert repr(catalogue.select(a=2.5)).startswith("<nothing is filled at a = 2.5 (filled: some at a = 1, ")
    some = repr(catalogue.select(p="6-7", status="orbit"))
    assert some.startswith("<188 orbits of period 6 to 7 at a = 1.6; period 7 is not filled at a = 1.6 (")
    assert repr(catalogue.select(p=2, length=(99, None))) == (
        "<0 words of period 2 at a = 1.6 with length >= 99>"
    )


def test_the_only_a_of_a_catalogue_is_meant_where_none_is_named(tmp_path):
    path = tmp_path / "orbits.db"
    assert Catalogue.create(path).a == 1.6
    fill_word(path, "13", 0.5)
    assert Catalogue(path).a == 0.5
    assert Catalogue(path)["13"].length == pytest.approx(6, rel=1e-15)
    for _ in fill_periods(path, 2.0, [2]):
        pass
    with pytest.raises(InputError, match=r"^orbits are stored at a = 0\.5, 2: name one with --a"):
        Catalogue(path).select(p=2)
    assert len(Catalogue(path, a=2.0).select(p=2)) == len(Catalogue(path).select(p=2, a=2.0)) == 1
    for _ in fill_periods(path, 1.6, [2]):
        pass
    assert Catalogue(path).a == 1.6


GAP = "period 13 is not filled at a = 1.6 (filled: periods 2-6; some at a = 1): 'orbitdb fill --p 13 --a 1.6'"
NOWHERE = "nothing is filled at a = 3 (filled: some at a = 1, 1.6): 'orbitdb fill --p 11 --a 3' fills periods"
READERS = ["query --status orbit", "query --json", "table", "entropy", "lyapunov", "export --format csv",
           "plot entropy -o f.svg", "plot lengths -o f.svg", "plot phase-space -o f.svg",
           "verify"]  # fmt: skip


@pytest.mark.parametrize("command", slow_but(READERS[:4], READERS))
def test_no_command_tells_what_is_not_filled_as_zero(cli, varied, tmp_path, monkeypatch, command):
    monkeypatch.chdir(tmp_path)
    for more, said in (["--p", "13", "--a", "1.6"], GAP), (["--a", "3"], NOWHERE):
        done = cli(*command.split(), *more, "--db", str(varied))
        lines = done.err.splitlines()
        assert done.code == 1
        assert lines[0].startswith(said)
        assert len(lines) == 1 + command.startswith("verify")  # it says that the file is sound, too
        assert "no orbits" not in done.err


@pytest.mark.parametrize(
    "command",
    slow_but(["table"], [*READERS[:6], "query --code 13", "plot orbit --code 13 --force -o f.svg"]),
)
def test_commands_ask_at_the_only_a(cli, tmp_path, monkeypatch, command):
    monkeypatch.chdir(tmp_path)
    cli("fill", "--p", "4", "--a", "1")
    done = cli(*command.split())
    assert done.code == 0
    assert done.err.splitlines()[0] == f"a = 1, the only one in {tmp_path / 'orbits.db'}"
    assert cli(*command.split(), "--a", "1").err.startswith("a = 1, the only") is False
    cli("fill", "--p", "4", "--a", "2")
    assert cli(*command.split()).says(2, "a = 1, 2", "--a")


def test_births_are_missed_where_they_are_asked_for(varied):
    catalogue = Catalogue(varied)
    assert catalogue.without_births(choose(p="3-4"), ("born",)) == [3, 4]
    assert catalogue.without_births(choose(), order="dies desc") == [2, 3, 4, 5, 6]
    assert catalogue.without_births(choose(p="3-4")) == []
