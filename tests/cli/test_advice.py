"""Advice in messages names the same file and half length, the intended option, and where to find more."""

import math
import re
import shlex
import shutil
from functools import partial

import pytest
from contents import alter
from quick import slow_but
from there import there

from orbitdb import Catalogue
from orbitdb.answers.completeness import Coverage, complete_length, describe_complete
from orbitdb.cli.advice import completed, remember
from orbitdb.orbits.least_values import least_exponent, least_length
from orbitdb.selection import Selection
from orbitdb.store.file import reading

FILL = "run `catalogue.fill(p=9)`"
IN_SHELL = "run 'orbitdb fill --p 9'"


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        ("table --db my.db", "run 'orbitdb fill --p 9 --db my.db'"),
        ("table --db=my.db --a=0.5", "run 'orbitdb fill --p 9 --db my.db --a 0.5'"),
        ("table", IN_SHELL),
        ("query --a 1 --a 2", IN_SHELL),
        ("bounds --a 0.3:1:5", IN_SHELL),
        ("query --a all,1", IN_SHELL),
        ("table --db 'my own.db'", """run 'orbitdb fill --p 9 --db "my own.db"'"""),
        ("table --db 'a$b.db'", r"""run 'orbitdb fill --p 9 --db "a\$b.db"'"""),
        ("query --a all", IN_SHELL),
    ],
)
def test_advice_names_the_given_catalogue_and_half_length(arguments, expected):
    remember(shlex.split(arguments))
    assert completed(FILL) == expected
    remember([])


@pytest.mark.parametrize(
    ("advised", "expected"),
    [("`catalogue.fill_births(p=4)` finds them", "'orbitdb births --p 4 --db my.db' finds them"),
     ("`catalogue.fill(p=4, a=3)` fills it", "'orbitdb fill --p 4 --a 3 --db my.db' fills it"),
     ("`Catalogue.migrate('o.db')`, `catalogue.info()`",
      "'orbitdb migrate --db o.db', 'orbitdb info --db my.db'"),
     ("`Catalogue.create('a b').fill(p=11)`", "'orbitdb fill --p 11 --db \"a b\" --a 2'"),
     ("`catalogue.fill_levels(k=25, parity='oo', a=1)`",
      "'orbitdb levels --k 25 --parity oo --a 1 --db my.db'"),
     ("`catalogue.fill_levels(k=(20, 30))`", "'orbitdb levels --k 20:30 --db my.db --a 2'"),
     ("`catalogue.assess(k, window=True)`", "'orbitdb assess FILE --window --db my.db'"),
     ("`catalogue.escape(...)`", "'orbitdb escape --db my.db'"),
     ("`catalogue.fill(code=WORD)`", "'orbitdb fill --code WORD --db my.db --a 2'"),
     ("`orbitdb.columns.EVERY` lists them", "'orbitdb columns' lists them"),
     ("`a=1`, `p='2-12'` or `fit_radius=True`", "--a 1, --p 2-12 or --fit-radius"),
     ("sql 'SELECT `a` FROM `life'", "sql 'SELECT `a` FROM `life'"),
     ("no orbitdb file at 'x'", "no orbitdb file at 'x'")],
)  # fmt: skip
def test_python_becomes_a_command_with_the_options_that_it_lacks_and_takes(advised, expected):
    remember(["query", "--db", "my.db", "--a", "2"])
    assert completed(advised) == expected
    remember([])


def test_an_error_repeats_the_given_value(cli, tmp_path):
    path = str(tmp_path / "nowhere.db")
    assert cli("table", "--db", path, "-a", "2").says(3, f"'orbitdb fill --p 11 --db {path} --a 2'")


def test_help_is_also_a_command(cli):
    assert cli("help") == cli("--help")
    assert cli("help", "table") == cli("table", "--help")


def test_the_long_name_of_an_option_suggests_the_short_one(cli):
    assert cli("query", "--period", "3").says(2, "--period", "did you mean --p?")


def test_the_nearest_length_comes_with_the_tolerance_that_finds_it(cli, filled):
    found = cli("identify", "--length", "11.14", "--db", str(filled))
    assert (found.code, found.out) == (1, "")
    nearest, *_ = found.err.splitlines()
    assert nearest.startswith("the nearest orbit is 0123 of length 11.1427106: --tolerance ")
    tolerance = nearest.split("--tolerance ")[1].split()[0]
    assert cli("identify", "--length", "11.14", "--tolerance", tolerance, "--db", str(filled)).code == 0


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        (("--order", "length", "--limit", "20"), 8),
        (("--range", "length=:11"), 8),
        (("--range", "length=:11", "--p", "2-5"), 5),
        (("--order", "-length", "--limit", "20"), 8),
        (("--where", "length < 10"), 8),
        (("--order", "length"), 8),
        (("--limit", "3"), None),
    ],
)
def test_a_list_of_the_shortest_orbits_says_up_to_which_length_it_is_complete(cli, filled, options, expected):
    told = [
        line for line in cli("query", *options, "--db", str(filled)).err.splitlines() if "complete" in line
    ]
    if expected is None:
        assert told == []
        return
    proved = least_length(expected, 1.6)
    shown = float(told[0].split("length ")[1].split(";")[0])
    assert proved - 0.01 < shown <= proved


LISTED = [
    ("query --order length", "length"),
    ("query --order length --format csv", "length"),
    ("query --order quarter_length --limit 3", "quarter_length"),
    ("query --classes --order quarter_length,p --limit 3", "quarter_length"),
    ("query --range quarter_length=:6 --limit 3", "quarter_length"),
    ("query --where quarter_length<6", "quarter_length"),
    ("query --where 12>=length", "length"),
    ("query --order=-length --limit 3", "length"),
    ("query --range length=12: --limit 3", "length"),
    ("query --order lambda_d --where length_error<1 --limit 3", None),
    ("query --order lyapunov --limit 3", "lyapunov"),
    ("query --order quarter_lyapunov --limit 3", "quarter_lyapunov"),
    ("query --range quarter_lyapunov=:2 --limit 3", "quarter_lyapunov"),
    ("query --where lyapunov<5 --limit 3", "lyapunov"),
    ("query --order length --status dynamical --limit 3", None),
    ("export --order quarter_length --limit 3 --format csv", "quarter_length"),
    ("export {folder}/shortest.csv --range length=:12", "length"),
]


@pytest.mark.parametrize(("command", "name"), slow_but(LISTED[2:3], LISTED))
def test_a_list_ordered_or_bounded_by_a_length_says_how_far_it_is_complete(
    cli, filled, tmp_path, command, name
):
    done = cli(*command.format(folder=tmp_path).split(), "--db", str(filled))
    told = [line for line in done.err.splitlines() if "complete, by proof" in line]
    if name is None:
        assert told == []
        return
    shown = float(told[0].split(f"up to {name} ")[1].split(";")[0])
    proved = least_exponent(8, 1.6) if "lyapunov" in name else least_length(8, 1.6)
    proved /= 2 if name.startswith("quarter") else 1
    assert proved - 0.01 < shown <= proved


@pytest.mark.parametrize(
    ("length", "tolerance", "said"),
    [
        ("10.4", "0.001", "complete, by proof"),
        ("11.1", "0.5", "may have this length, too"),
        ("20.8", "0.001", "may have this length, too"),
    ],
)
def test_the_orbits_of_a_short_length_are_complete(cli, filled, length, tolerance, said):
    found = cli("identify", "--length", length, "--tolerance", tolerance, "--db", str(filled))
    assert found.err.splitlines()[-1].endswith(said)


@pytest.mark.slow
def test_a_list_by_quarter_length_misses_nothing_below_the_length_it_names(tmp_path, cli):
    """A further fill adds no row there; it did, where nothing was said."""
    few, many = (Catalogue.create(tmp_path / f"{p}.db", 1.0) for p in (8, 11))
    few.fill("2-8")
    many.fill("2-11")
    ask = partial(Catalogue.select, status="orbit", order="quarter_length", limit=30, classes=True)
    with reading(few.path) as connection:
        told = Coverage(connection, Selection(1.0)).complete("quarter_length")
    end = float(there(told).split("quarter_length ")[1].split(";")[0])
    short = [ask(each) for each in (few, many)]
    lists = [each.code[each.quarter_length <= end].tolist() for each in short]
    assert lists[0] == lists[1] == ["13", "0123"]
    assert short[0].code.tolist() != short[1].code.tolist()


@pytest.mark.parametrize(
    "change", ["DELETE FROM fill WHERE p = 2", "UPDATE fill SET unresolved = 1 WHERE p = 2"]
)
def test_a_list_with_a_gap_does_not_claim_to_be_complete(cli, filled, change):
    alter(filled, change)
    told = cli("query", "--order", "length", "--limit", "3", "--db", str(filled)).err
    assert "orbits of any length may be missing" in told


def test_periods_beyond_a_gap_prove_nothing(filled, tmp_path):
    path = shutil.copy(filled, tmp_path / "gap.db")
    alter(path, "UPDATE fill SET unresolved = 2 WHERE p = 5")
    fills = Catalogue(path).fills()
    assert complete_length(fills, Selection(1.6)) == least_length(4, 1.6)


@pytest.mark.parametrize("length", [11.2599999, 11.0, 10.999999])
def test_the_length_of_a_complete_list_is_never_rounded_up(length):
    shown = float(describe_complete(length, Selection()).split("length ")[1].split(";")[0])
    assert shown <= length < shown + 0.0100001
    assert math.isclose(shown * 100, round(shown * 100))


def test_a_list_of_all_orbits_says_where_no_list_is_complete(cli, filled):
    asked = ("query", "--order", "length", "--limit", "2", "--db", str(filled))
    said = cli(*asked).err.splitlines()[0]
    assert said.endswith(
        "(further periods prove 11.54 at most; infinitely many are shorter than 4a + 2 pi < 12.69)"
    )
    assert "infinitely" in cli("query", "--where", "length < 12", "--limit", "2", "--db", str(filled)).err
    assert "infinitely" not in cli(*asked, "--time-reversal", "pair").err


def test_a_list_without_period_2_is_told_to_choose_it(cli, filled):
    said = cli("query", "--p", "3-4", "--order", "length", "--db", str(filled)).err
    assert "choose all periods from 2 on, such as --p 2-4" in said


def test_latex_can_be_pasted(cli, filled):
    columns = "code,length,lambda_d,residual,margin,status"
    asked = ("query", "--p", "2-3", "--format", "latex", "-c", columns, "--status", "all")
    table = cli(*asked, "--db", str(filled)).out.splitlines()
    assert table[:3] == [r"% \usepackage{booktabs}", r"\begin{tabular}{lrrrrl}", r"\toprule"]
    assert table[3] == r"code & $L$ & $\lambda_d$ & residual & margin & status \\"
    assert table[5].startswith(r"\texttt{13} & 10.4000000 & 2.113748 & ")
    assert any(r" \times 10^{-" in line for line in table)
    assert table[-2:] == [r"\bottomrule", r"\end{tabular}"]
    assert all(line.count("&") == 5 for line in table if "&" in line)
    averages = cli("lyapunov", "--p", "2-5", "--format", "latex", "--db", str(filled)).out.splitlines()
    formulas = r"$p$ & $\lambda_d$ & $\lambda_c$ & $\lambda_d$ pair & ", r"& $\Delta \lambda_d$ sum rule &"
    assert all(each in averages[3] for each in formulas)
    assert not re.search(r"lambda [dc]", averages[3])


def test_the_lambda_of_a_complete_sum_is_never_rounded_up(cli, filled):
    said = cli("lyapunov", "--p", "2-5", "--cut", "5", "--db", str(filled)).err
    shown, proved = float(said.split("up to lambda = ")[1].split()[0]), least_exponent(5, 1.6)
    assert round(proved, 3) > proved
    assert proved - 0.001 < shown <= proved
