"""`columns` explains every column; `sql` accepts one SELECT over the views and nothing else."""

import json
import shlex
from types import SimpleNamespace
from typing import cast

import pytest

from orbitdb.catalogue import Catalogue
from orbitdb.cli.commands.query import EXAMPLES
from orbitdb.columns import GROUPS, IN_CATALOGUE
from orbitdb.errors import SelectionError
from orbitdb.selection import Selection

EVERY = [each for _, group in GROUPS for each in group]


@pytest.mark.parametrize("width", ["40", "80", "200"])
def test_the_table_of_columns_says_what_json_says(cli, monkeypatch, width):
    monkeypatch.setenv("COLUMNS", width)
    catalogue, others = cli("columns").out.split("\n\n")
    some = cli("columns", "margin", "quarter_length")
    assert [line.split()[0] for line in some.out.splitlines() if not line.startswith(" ")] == [
        "column", "quarter_length", "margin"
    ]  # fmt: skip
    assert [row["of"] for row in json.loads(cli("columns", "code", "--json").out)] == ["word"]
    assert len(json.loads(cli("columns", "error", "--json").out)) == 3  # of an orbit, a level and survival
    assert cli("columns", "lenght").says(2, "column 'lenght': did you mean length?")
    head, *lines = cast(list[str], [*catalogue.splitlines(), *others.splitlines()])
    unit, bound, means = (head.index(name) for name in ("unit", "bounded by", "means"))
    found: list[list[str]] = []
    for line in lines:
        cells = [line[:unit].strip(), line[unit:bound].strip(), line[bound:means].strip(), line[means:]]
        if cells[0]:
            found.append(cells)
        else:
            found[-1][3] += f" {cells[3]}"
    assert found == [[each.name, each.unit, each.bound, each.means] for each in EVERY]
    assert sum(bool(line[:unit].strip()) for line in catalogue.splitlines()) - 1 == len(IN_CATALOGUE)
    assert max(map(len, lines)) <= max(int(width), means + 24)


def test_the_view_that_a_column_refers_to_can_be_queried(cli, filled):
    """Births are in a view; the table of changes cannot be read."""
    rows = json.loads(cli("columns", "--json").out)
    told = {each["column"]: each for each in rows if each["of"] == "word"}
    assert "the view 'life'" in told["born"]["means"]
    for name in ("born", "dies"):
        column, view = told[name]["bound"].split(" in ")
        assert cli("sql", f"SELECT {column} FROM {view}", "--json").out == "[]\n"  # no births are stored


@pytest.mark.parametrize(
    ("statement", "told"),
    [(f"SELECT {'1 + ' * 5000}1", "Expression tree is too large"), (25_000 * "0123", "syntax error")],
    ids=["deep", "long"],
)
def test_a_statement_that_is_too_long_is_refused_in_one_line(cli, own, statement, told):
    assert cli("sql", statement).says(2, "orbitdb: ", told)


def test_the_rows_of_a_statement_show_themselves(varied):
    answer = Catalogue(varied).sql("SELECT code FROM catalogue WHERE p = 2")
    assert repr(answer).splitlines()[1:] == ["code", *(code for (code,) in answer)]


TYPES = {"text": str, "integer": int, "number": float, "integers": list}


def test_values_have_the_stated_types_and_are_empty_only_as_stated(varied):
    names = [each.name for each in IN_CATALOGUE]
    with Catalogue(varied) as catalogue:
        rows = list(catalogue.rows(Selection.from_criteria(p="2-4", status="all"), columns=names))
    for column, values in zip(IN_CATALOGUE, zip(*rows, strict=True), strict=True):
        assert {type(value) for value in values} - {type(None)} <= {TYPES[column.kind]}, column
        assert any(each in (None, []) for each in values) == (column.empty != "never"), column


def test_bounds_and_units_use_a_fixed_vocabulary():
    for column in EVERY:
        assert column.unit in ("", "1", "radius", "1/radius", "radius, rad", "radius^2", "radius^3")
        bounded = column.bound.removesuffix(" in life").endswith(("error", "errors"))
        assert bounded or column.bound in ("", "exact", "proved", "itself")
        assert "error" not in column.empty


def test_json_has_every_fact_about_every_column(cli):
    rows = json.loads(cli("columns", "--json").out)
    assert [list(row.values()) for row in rows] == [
        [each.name, of, each.kind, each.unit, each.bound, each.empty, each.means]
        for of, group in GROUPS
        for each in group
    ]
    assert list(rows[0]) == ["column", "of", "type", "unit", "bound", "empty", "means"]


def test_a_select_can_join_and_read_other_views(varied, cli):
    across = "catalogue x, catalogue y WHERE x.code = y.code AND x.a < y.a AND y.p = 2"
    for rows, count in ((across, 1), ("life ORDER BY random()", 0)):
        asked = ("sql", f"SELECT count(*) AS n FROM {rows}", "--format", "csv", "--db", str(varied))
        assert cli(*asked).out == f"n\n{count}\n"
    texts = cli("sql", "SELECT status AS s, p AS n, symmetry AS y FROM catalogue WHERE p = 3 AND a = 1",
                "--format", "latex", "--db", str(varied)).out  # fmt: skip
    assert r"\begin{tabular}{lrl}" in texts  # whatever a column is called


def test_a_select_that_takes_too_long_is_stopped(varied, cli, monkeypatch):
    from orbitdb.store import where as limits

    monkeypatch.setattr(limits, "SECONDS", 0.1)
    endless = "SELECT sum(x.p * y.p * z.p) FROM catalogue x, catalogue y, catalogue z"
    done = cli("sql", endless, "--db", str(varied))
    assert done.code == 2
    assert "it took more than 0.1 s" in done.err


def test_time_between_blocks_of_rows_does_not_count_but_time_in_sqlite_does(varied, monkeypatch):
    """The clock is the test's: callers may take an hour, and a long statement ends unless the clock moves."""
    from orbitdb.store import where as limits

    clock = [0.0]
    monkeypatch.setattr(limits, "time", SimpleNamespace(monotonic=lambda: clock[0]))
    numbers = "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n WHERE i < 200000)"
    with Catalogue(varied) as catalogue:
        assert [*catalogue.sql(f"{numbers} SELECT max(i) FROM n")] == [(200_000,)]  # looks at the clock often
        count = 0
        for count, _ in enumerate(catalogue.sql(f"{numbers} SELECT i FROM n WHERE i % 50 = 0"), 1):
            clock[0] += 3600 if count < 4 else 0
        assert count == 4000  # in two blocks

        def tick() -> float:
            clock[0] += limits.SECONDS * 0.6
            return clock[0]

        monkeypatch.setattr(limits, "time", SimpleNamespace(monotonic=tick))
        endless = "SELECT sum(x.p * y.p * z.p) FROM catalogue x, catalogue y, catalogue z"
        with pytest.raises(SelectionError, match="it took more than 60 s"):
            list(catalogue.sql(endless))


def test_a_word_is_found_in_any_rotation_or_refused(varied, cli):
    counted = "SELECT count(*) AS n FROM catalogue WHERE a = 1.6 AND"
    word = ("--parameter", "w='310'", "--format", "csv", "--db", str(varied))
    assert cli("sql", f"{counted} code = code(:w)", *word) == (0, "n\n1\n", "")
    assert cli("sql", f"{counted} code = :w", *word) == (0, "n\n0\n", "")
    missed = cli("sql", "SELECT p FROM catalogue WHERE code = :w", *word)
    hint = "codes are texts, each the least rotation of its word: write words with code(), such as code('31')"
    assert missed == (1, "p\n", f"no rows; {hint}\n")
    assert cli("sql", "SELECT p FROM catalogue WHERE code = code('19')", *word[2:]).says(2, "symbol '9'")


def test_a_blob_is_shown_in_hexadecimal_and_no_infinity_in_json(varied, cli):
    found = cli("sql", "SELECT x'00ff' AS b, -9e999 AS low", "--json", "--db", str(varied))
    assert (found.code, json.loads(found.out)) == (0, [{"b": "00ff", "low": None}])


def test_rows_without_numbers_are_shown(varied, cli):
    rows = cli("sql", "SELECT * FROM catalogue WHERE lambda_c_error IS NULL", "--db", str(varied))
    assert (rows.code, len(rows.out.splitlines()) > 1) == (0, True)
    assert cli("sql", "SELECT 'x' lambda_d, 'y' lambda_d_error", "--db", str(varied)).out.split()[-2:] == [
        "x",
        "y",
    ]
    sampled = "0.12345678912 lambda_d, 1e-9 lambda_d_error, 0.98765432198 lambda_c, 1e-9 lambda_c_error"
    cells = cli("sql", f"SELECT {sampled}", "--db", str(varied)).out.split()[-4:]
    assert cells[::2] == ["0.1234567891", "0.9876543220"]  # as many decimals as their errors allow


@pytest.mark.usefixtures("filled")
@pytest.mark.parametrize("example", [*EXAMPLES["query"], *EXAMPLES["sql"]])
def test_the_examples_in_the_help_give_rows(cli, example):
    """The catalogue here ends before the period of one of them, which a note then says."""
    done = cli(*shlex.split(example.partition(" > ")[0]))
    assert (done.code == 0 and done.out) or "period 11 is not filled" in done.err, done.err
