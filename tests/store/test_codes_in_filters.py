"""Codes in expressions find words in any rotation; errors in expressions are reported."""

import itertools

import numpy as np
import pytest
from there import there

from orbitdb import Catalogue
from orbitdb.errors import SelectionError
from orbitdb.filling.fill import fill_words
from orbitdb.selection import Selection
from orbitdb.sql_text import parse_parameters
from orbitdb.symbols.pruning import rule_numbers, rules_broken, rules_of_pattern
from orbitdb.symbols.symmetry import members
from orbitdb.symbols.words import least_rotation, parse


@pytest.fixture
def catalogue(varied):
    return Catalogue(varied)


@pytest.mark.parametrize(
    ("where", "found"),
    [
        ("code = code('3123')", {"1233"}),
        ("CODE=code ( '3 1 2 3' )", {"1233"}),
        ("not code = code('31') and p < 4 and code not in (code(:w), code('(1)^2 3')) and status = 'orbit'",
         {"031", "123", "132", "133", "155", "344"}),
        ("code = iif(p = 2, code('31'), code('3123'))", {"13", "1233"}),
        ("p = 3 and length in (SELECT length FROM catalogue WHERE code = code('310'))",
         {"013", "031", "123", "132"}),
        ("code = code('001') or p = 2", {"13"}),
        ("code = code('31')", {"13"}),
        ("code('310') == code", {"031"}),
        ("code in (code('31'), code(:w))", {"13", "013"}),
        ("p < 4 and status = 'orbit' and code <> code('31') and not code IN (code('013'), code('31'))",
         {"031", "113", "123", "132", "133", "155", "344"}),
        ("representative = code('3010')", {"0103", "1232"}),
        ("code = 'code(''31'')'", set()),
        ("code = 0113 or representative = 0113", set()),  # not 113
        ("code BETWEEN code('013') AND code('031') and p = 3", {"013", "031"}),
        ("p < 4 and code = code(substr(code, 1, 2))", {"13"}),
    ],
)  # fmt: skip
def test_a_code_in_a_filter_finds_its_word_in_any_rotation(catalogue, where, found):
    chosen = Selection.from_criteria(where=where, parameters={"w": "130"} if ":w" in where else {})
    assert {word for (word,) in catalogue.rows(chosen, columns=("code",))} == found
    assert catalogue.count(chosen) == len(found)
    assert sum(catalogue.classes(chosen).words) == len(found)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("criteria", "pattern"),
    [
        ({"without": "0202"}, "0202"),
        ({"without": ["0202"]}, "0202"),
        ({"where": "not contains(code, '0202')"}, "0202"),
        ({"where": "contains(code, :w) = 0", "parameters": {"w": "0202"}}, "0202"),
        ({"without": "(02)^2 1"}, "02021"),
        ({"where": "not contains(code, '(02)^2 1')"}, "02021"),
    ],
)
def test_words_without_a_pattern_are_those_that_never_contain_it(filled, criteria, pattern):
    catalogue = Catalogue(filled)
    every = [word for (word,) in catalogue.rows(columns=("code",))]
    wanted = [word for word in every if pattern not in word * 4]
    assert [word for (word,) in catalogue.rows(columns=("code",), **criteria)] == wanted
    assert catalogue.count(**criteria) == len(wanted) < len(every)


def test_like_misses_patterns_that_wrap_around(filled):
    catalogue = Catalogue(filled)
    assert catalogue.count(where="code not like '%31%'") > catalogue.count(without="31") > 0


def test_several_patterns_are_all_left_out(filled, cli):
    catalogue = Catalogue(filled)
    subset = catalogue.select(p="2-6", without=["02", "44"], contains="13")
    every = catalogue.select(p="2-6").code.tolist()
    assert subset.code.tolist() == [
        word for word in every if "02" not in 2 * word and "44" not in 2 * word and "13" in 2 * word
    ]
    assert str(subset).endswith(" containing 13 without 02 or 44>")
    done = cli("query", "--p", "2-6", "--without", "02", "--without", "44", "--contains", "13",
               "-c", "code", "--format", "tsv", "--db", str(filled))  # fmt: skip
    assert done.out.splitlines()[1:] == subset.code.tolist()
    select = "SELECT count(*) AS n FROM catalogue WHERE contains(code, '0202')"
    counted = cli("sql", select, "--format", "tsv", "--db", str(filled))
    assert int(counted.out.splitlines()[1]) == catalogue.count(contains="0202", status=())


def test_a_pattern_longer_than_a_word_is_read_round_and_round(varied):
    catalogue = Catalogue(varied)
    for pattern in ("13131", "1313131313", "01301"):
        wanted = {word for (word,) in catalogue.rows(columns=("code",)) if pattern in word * 12}
        for chosen in (
            Selection.from_criteria(contains=pattern),
            Selection.from_criteria(where=f"contains(code, '{pattern}')"),
        ):
            assert set(catalogue.select(chosen).code.tolist()) == wanted != set()


@pytest.mark.parametrize("pattern", ["0202", "131", "1", "4", "54", "0131", "1232131", "555", "31313"])
def test_classes_that_lack_a_pattern_are_passed_over_safely(varied, pattern):
    """An expression looks at every word."""

    def codes(**criteria):
        return [code for (code,) in Catalogue(varied).rows(**criteria, columns=("code",), order="code")]

    assert codes(contains=pattern) == codes(where=f"contains(code, '{pattern}')") != []


def test_averages_without_a_pattern_say_what_they_mean(filled, cli):
    for command, said in (("lyapunov", "never contain the pattern"), ("entropy", "growth rate")):
        assert said in cli(command, "--without", "0", "--db", str(filled)).err
        where = cli(command, "--where", "not contains(code, '0')", "--db", str(filled)).err
        assert "if the filter leaves out just the words that contain some pattern, th" in where
        assert said in where
    assert "pattern" not in cli("lyapunov", "--contains", "0", "--db", str(filled)).err
    z0 = Catalogue(filled).lyapunov(without="0")["z0"]
    assert z0[-1] == pytest.approx(1.2855, abs=1e-4)


def test_words_near_the_length_limit_of_keys_are_found(own):
    """They are found one by one, sorted by code, and together with long words of other periods."""
    for word in map(parse, ("1^10 3^10", "1^11 3^10", "1^12 3^10", "1^12 0 3^9")):
        fill_words(own, [word], 1.6)
        with Catalogue(own, 1.6) as catalogue:
            assert there(catalogue.find(word)).stored
            for code in [*members(least_rotation(word))][::3]:
                found = catalogue.select(code=code, order="code")
                assert [row.code for row in found] == [code]
    with Catalogue(own, 1.6) as catalogue:
        assert {row.p for row in catalogue.select(contains="1" * 10, status=())} == {20, 21, 22}


def test_a_pruned_word_is_found_if_its_status_is_named(catalogue):
    for where in ("code = code('001')", "code IN (code('010'), code('13'))"):
        assert [orbit.code for orbit in catalogue.select(where=where, status="geometric")] == ["001"]


@pytest.mark.parametrize(
    ("where", "said"),
    [
        ("code = code(13)", "write '13', in quotes"),
        ("code = code('1313')", "give '13'"),
        ("code = code('19')", "symbol '9'"),
        ("code()", "wrong number of arguments"),
        ("code('13', '31')", "wrong number of arguments"),
        ("code('13'", "incomplete input"),
        ("p IS NOT NULL AND code = code('19')", "symbol '9'"),
        ("p IS NOT NULL AND code = code(13)", "write '13', in quotes"),
        ("iif(p = 3, contains(code, '0207'), 0)", r"contains\(..., '0207'\): .*symbol '7'"),
        ("contains(code, 202)", "write '202', in quotes"),
        ("contains(code, '0207')", r"contains\(..., '0207'\): .*symbol '7'"),
        ("contains(code)", "wrong number of arguments"),
        ("contains('0202', code)", r"the word first: write contains\(code, '0202'\)"),
        ("code(:w)", "--parameter name=value"),
        ("load_extension('evil') IS NULL", "it may not load extensions"),
    ],
)
def test_a_bad_code_in_a_filter_is_refused(catalogue, where, said):
    with pytest.raises(SelectionError, match=said):
        catalogue.count(where=where, parameters={"w": "13"} if where.endswith(":w))") else {})


def test_a_bad_code_is_refused_in_a_condition_that_depends_on_the_rows(cli, varied):
    where = "length > 10 AND code = code('19')"
    statement = f"SELECT code FROM catalogue WHERE {where}"
    for command in (["sql", statement], ["query", "--where", where]):
        assert cli(*command, "--db", str(varied)).says(2, "code('19'): symbol '9'")


@pytest.mark.parametrize(
    ("where", "found"),
    [
        ("iif(code = '13', 1, 0)", {"13"}),
        ("coalesce(code = '13', 0)", {"13"}),
        ("(code = '13', 2) = (1, p)", {"13"}),
        ("code = '13' or length < 0 or code = ':w'", {"13"}),
        ("code = '13' -- where :w = 1", {"13"}),
    ],
)
def test_sqlite_reads_expressions(catalogue, where, found):
    assert {row.code for row in catalogue.select(where=where)} == found


@pytest.mark.parametrize(
    ("where", "word"),
    [("code = 13", "13"), ("code = 013", "013"), ("code IN ('31')", "31"), ("code = :w", "31")],
)
def test_codes_that_find_nothing_are_explained(cli, varied, where, word):
    """A number is not a code, and a rotation of a code is none; one sentence says so."""
    values = ["--parameter", "w=+13"] if ":w" in where else []
    said = (
        "codes are texts, each the least rotation of its word: write words with code(), such as "
        f"code('{word}')"
    )
    assert cli("query", "--where", where, *values, "--a", "1.6", "--db", str(varied)).says(1, said)
    for other in ("p = 2", "code = '13'", "code in (code('31'), '013')"):
        assert "codes" not in cli("query", "--where", f"{other} and length < 0", "--db", str(varied)).err
    statement = f"SELECT code FROM catalogue WHERE {where}"
    assert cli("sql", statement, *values, "--db", str(varied)).says(1, f"no rows; {said}")


@pytest.mark.parametrize(
    ("given", "sql", "value"),
    [
        ("w=0103", "code(:w)", "0103"),
        ("w=(13)^2 1", "code(:w)", "(13)^2 1"),
        ("w=" + "1" * 20 + "3" * 20, "length(code) > length(:w)", "1" * 20 + "3" * 20),
        ("w='13'", "substr(code, 1, 2) = :w", "13"),
        ("w=+13", "substr(code, 1, 2) = :w", 13),
        ("w=13", "length < :w", 13),
        ("w=13", "SELECT count(*) FROM catalogue WHERE length / 2 > p - :w", 13),
        ("w=0.50", "lambda_c < :w", 0.5),
        ("w=-1e-3", "margin > :w", -1e-3),
        ("w=3", "p = :w and code like '1%'", 3),
        ("w=0", "walls = :w", 0),
        ("w=160", "p = :w", 160),
        ("w=self", "time_reversal = :w", "self"),
    ],
)
def test_words_are_words_and_numbers_are_numbers(given, sql, value):
    assert parse_parameters([given], sql) == {"w": value}


@pytest.mark.parametrize(
    "sql", ["substr(code, 1, 2) = :w", "length < :w and code = '13'", "SELECT word FROM cycle WHERE p = :w"]
)
def test_digits_that_could_be_either_are_refused(sql):
    with pytest.raises(SelectionError, match=r"write \"w='13'\" for the word, w=\+13 for the number"):
        parse_parameters(["w=13"], sql)


def test_a_number_is_not_a_word(catalogue):
    assert catalogue.count(where="code = :w", parameters={"w": 13}) == 0
    assert catalogue.count(where="code = :w", parameters={"w": "13"}) == 1


@pytest.mark.parametrize(
    ("where", "said"),
    [
        ("contains(code, 0202)", "codes are texts, so write '0202', in quotes"),
        ("code = code(0013)", "codes are texts, so write '0013', in quotes"),
        ("code = 031", "such as code('031')"),
        ("p = 03 and code IN (031, 13)", "such as code('031')"),
        ("code = '310'", "such as code('310')"),
        ("code > ''", None),
    ],
)
def test_messages_name_the_words_as_they_were_typed(cli, own, where, said):
    found = cli("query", "--where", where)
    assert found.code == (0 if said is None else 1 if "such as" in said else 2)
    assert said is None or said in found.err


@pytest.mark.parametrize(
    ("pattern", "rules"),
    [("101", [4]), ("00", [1]), ("1020", []), ("12021", [6]), ("141", [2, 5]), ("045", [2]), ("4", []),
     ("11", []), ("133331", []), ("13", [])],
)  # fmt: skip
def test_a_pattern_that_no_word_can_have_names_its_rule(cli, own, pattern, rules):
    """The rules that every word with the pattern breaks, found by trying all words of period 7."""
    words = np.array([*itertools.product(range(6), repeat=7 - len(pattern))], np.uint8)
    words = np.hstack([np.tile(np.array([*map(int, pattern)], np.uint8), (len(words), 1)), words])
    always = np.bitwise_and.reduce(rules_broken(words))
    assert rule_numbers(int(always)) == rules == [rule.number for rule in rules_of_pattern(pattern)]
    found = cli("query", "--contains", pattern, "--p", "2-6")
    for rule in rules:
        assert found.code == 1
        assert f"{pattern} breaks rule " in found.err
        assert f"{rule} (" in found.err
    assert rules or "rule" not in found.err
