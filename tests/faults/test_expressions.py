"""Free expressions can only choose rows, and are stopped when they take too long."""

import contextlib
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from typing import cast

import pytest
from contents import alter
from processes import start
from quick import slow_but

from orbitdb.catalogue import Catalogue
from orbitdb.store.asking.selection import Selection, SelectionError
from orbitdb.store.file.ids import LONG
from orbitdb.store.file.tokens import tokens
from orbitdb.store.reading.moment import reading

ENDLESS = "WITH RECURSIVE n(x) AS (SELECT 1 UNION ALL SELECT x + 1 FROM n) SELECT count(*) FROM n"
GROWING = "WITH a AS (SELECT 1 x)" + "".join(
    f", {name} AS (SELECT 1 x FROM {before} u, {before} v)"
    for before, name in zip("abcdefghijklmnopqrst", "bcdefghijklmnopqrstu", strict=True)
)
ATTACKS = {
    # read something else
    "another table": "(SELECT max(parameters) FROM run) <> ''",
    "the schema": "(SELECT max(sql) FROM sqlite_master) <> ''",
    "a table called catalogue": "(WITH catalogue AS (SELECT sql FROM sqlite_master) SELECT 1 FROM catalogue)",
    "a subquery called catalogue": "(SELECT 1 FROM (SELECT sql FROM sqlite_master) AS catalogue)",
    "a pragma called catalogue": "(SELECT max(file) FROM pragma_database_list AS catalogue) <> ''",
    "json_each": "(SELECT count(*) FROM json_each('[1]')) = 1",
    "a row number": "rowid = 1",
    "a file": "readfile('/etc/passwd') <> ''",
    "an extension": "load_extension('evil') IS NULL",
    # write
    "a second statement": "1; DELETE FROM orbit",
    "closing the bracket": "1) OR (1",
    "another query behind brackets": "1) UNION SELECT sql FROM sqlite_master WHERE (1",
    "attach": "(ATTACH 'x.db' AS y)",
    "a comment without end": "1 /*",
    "a row limit": "1 LIMIT 1",
    "chance, which SQLite asks once for all rows": "random() % 2",
    # grow, or run for ever
    "an endless recursion": f"({ENDLESS}) > 0",
    "a recursion in a subquery": f"p IN (SELECT p FROM catalogue WHERE ({ENDLESS}) > 0)",
    "names of names": f"({GROWING} SELECT count(*) FROM u) > 0",
    "a subquery of a subquery": "p IN (SELECT b + b FROM (SELECT p + p AS b FROM catalogue))",
    "a join": "(SELECT count(*) FROM catalogue AS b, catalogue AS c) > 0",
    "a join in brackets": "(SELECT count(*) FROM (catalogue AS b JOIN catalogue AS c)) > 0",
    "a join in quotes": """(SELECT count(*) FROM "catalogue" AS b, 'catalogue' AS c) > 0""",
    "printf": "length(printf('%*c', 1000000000, 'x')) > 0",
    "group_concat": "length((SELECT group_concat(code) FROM catalogue)) > 0",
    "replace that grows": "length(replace(code, '1', '11')) > 0",
    "replace that grows often": "length(" + "replace(" * 30 + "code" + ", '1', '1111')" * 30 + ") > 0",
    "a long pattern": f"code LIKE '{'%1' * 2000}'",
    "a long expression": " OR ".join(["p = 1"] * 200_000),
    "a long list": f"p IN ({', '.join(['1'] * 400_000)})",
    "a long name": f"(SELECT {' + '.join(['p'] * 900)} AS x FROM catalogue WHERE {' + '.join(['x'] * 900)})",
    "many brackets": "(" * 10_000 + "1" + ")" * 10_000,
    "many brackets that fit": "(" * 4_000 + "1" + ")" * 4_000,
    "many signs": "- " * 9_000 + "1",
    "much denied": "NOT " * 4_000 + "1",
    "a value in a value's name": ":x(SELECT 1)",
    "a value by number": "p = ?1",
    "a NUL": "p = '\x00'",
}  # fmt: skip


QUICK = ["another table", "the schema", "a file", "another query behind brackets", "a row limit", "a join",
         "printf", "a long pattern", "a NUL"]  # fmt: skip
LONG_ONES = {"much denied", "many signs", "many brackets that fit", "a long name"}


@pytest.mark.parametrize(
    "name",
    [
        *slow_but(QUICK, [name for name in ATTACKS if name not in LONG_ONES]),
        *(pytest.param(name, marks=pytest.mark.fuzz) for name in sorted(LONG_ONES)),
    ],
)
def test_an_expression_can_only_choose_rows(varied, name):
    before = varied.read_bytes()
    catalogue, chosen = Catalogue(varied), Selection(where=ATTACKS[name])
    uses: list[Callable[[], object]] = [
        lambda: catalogue.count(chosen),
        lambda: catalogue.select(chosen),
        lambda: catalogue.classes(chosen),
        lambda: list(catalogue.rows(chosen, ("code",), order="length desc", limit=1)),
    ]
    for use in uses:
        with pytest.raises(SelectionError) as caught:
            use()
        assert len(str(caught.value)) < 1100
        assert "\n" not in str(caught.value)
    assert varied.read_bytes() == before


def test_bound_values_are_only_values(own):
    """Bound values are never read as SQL."""
    catalogue = Catalogue(own)
    for value in ("1 OR 1", "'; DELETE FROM orbit; --", ":x", "(SELECT 1)"):
        assert catalogue.count(Selection(where="code = :x", parameters={"x": value})) == 0
    with pytest.raises(SelectionError, match="characters"):
        catalogue.count(Selection(where="code = :x", parameters={"x": "1" * 100_000}))
    with pytest.raises(SelectionError, match="type"):
        catalogue.count(Selection(where="code = :x", parameters=cast(dict[str, str], {"x": ["1"]})))
    assert catalogue.count(Selection(where="code = ':x'")) == 0
    with pytest.raises(SelectionError, match="it has no :x"):
        catalogue.count(Selection(where="code = ':x'", parameters={"x": 1}))
    with pytest.raises(SelectionError, match="it has no :ength"):
        catalogue.count(Selection(where="length > 9", parameters={"ength": 1}))


ALLOWED = {
    "length < (SELECT avg(length) FROM catalogue WHERE p = 5)": 100,
    "length(code) - length(replace(code, '0', '')) = 1": 50,
    "EXISTS (SELECT 1 FROM catalogue AS b WHERE b.length = catalogue.length AND b.p > 5)": 100,
    "code IN (SELECT representative FROM catalogue WHERE p < 5) AND a = 1.6": 5,
    f"p IN ({', '.join(['2'] * 3000)})": 1,
    "(p, code) IN (VALUES (2, '13'), (3, '113'))": 1,
    "code GLOB '01*' OR code LIKE '%3_'": 50,
    "round(lambda_c, 2) BETWEEN 0.3 AND 0.4 -- the weak ones": 20,
    "'a:b' = 'a:b' AND code <> 'x -- y' AND \"p\" > 2 /* not the shortest */": 300,
}  # fmt: skip


@pytest.mark.parametrize("text", ALLOWED)
def test_useful_expressions_are_allowed(own, text):
    assert Catalogue(own).count(Selection(where=text)) >= ALLOWED[text]


@pytest.mark.parametrize("use", ["count", "rows", "sorted", "classes", "select"])
def test_every_use_is_stopped_in_time(own, monkeypatch, use):
    from orbitdb.store.asking import where as limits

    monkeypatch.setattr(limits, "SECONDS", 0.02)
    rest = " + ".join(f"b.length * catalogue.lyapunov * {n}" for n in range(40))
    catalogue = Catalogue(own)
    chosen = Selection(where=f"(SELECT sum({rest}) FROM catalogue AS b WHERE b.code <> catalogue.code) < 0")
    uses: dict[str, Callable[[], object]] = {
        "count": lambda: catalogue.count(chosen),
        "rows": lambda: list(catalogue.rows(chosen)),
        "sorted": lambda: list(catalogue.rows(chosen, order="length desc")),
        "classes": lambda: catalogue.classes(chosen),
        "select": lambda: catalogue.select(chosen),
    }
    with pytest.raises(SelectionError, match=r"more than 0\.02 s"):
        uses[use]()
    assert catalogue.count(Selection()) > 300  # the connection still works


@pytest.mark.slow
def test_time_spent_on_using_rows_does_not_count(filled_once, monkeypatch):
    from orbitdb.store.asking import where as limits
    from orbitdb.store.asking.sql import run_statement

    monkeypatch.setattr(limits, "SECONDS", 0.5)
    with reading(filled_once) as moment:
        _, rows = run_statement(moment.connection, "SELECT code FROM catalogue", {})
        first = next(rows)
        time.sleep(0.6)
        assert len([first, *rows]) == Catalogue(filled_once).count()


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="needs POSIX signals")
@pytest.mark.parametrize(
    ("name", "code", "told"), [("SIGINT", 130, "interrupted"), ("SIGTERM", 143, "terminated")]
)
def test_ctrl_c_is_not_mistaken_for_a_refusal(filled, name, code, told):
    """SQLite's progress callback swallows the interrupt; it must not be reported as a slow expression."""
    rest = " + ".join(f"b.length * catalogue.lyapunov * {n}" for n in range(60))  # takes over a minute
    slow = f"(SELECT sum({rest}) FROM catalogue AS b WHERE b.code <> catalogue.code) < 0"
    process = start("query", "--where", slow, "--db", filled)
    with contextlib.suppress(subprocess.TimeoutExpired):
        process.wait(3)
    process.send_signal(signal.Signals[name])
    _, err = process.communicate(timeout=60)
    assert process.returncode == code
    assert err == f"orbitdb: {told}\n"


@pytest.mark.slow
def test_words_of_a_million_bounces_can_be_queried(tmp_path):
    """The limit on texts allows the longest possible words, in any column and order."""
    path = tmp_path / "orbits.db"
    catalogue = Catalogue.create(path)
    word, reverse = "1" * 500_000 + "3" * 500_000, "1" * 500_000 + "5" * 500_000
    alter(
        path,
        "INSERT INTO run VALUES (1, '', '', '')",
        "INSERT INTO stadium VALUES (1, 1.6)",
        f"INSERT INTO cycle VALUES ({LONG}, 1000000, '{word}', 2, 0, 'pair', '1', '{word}{reverse}')",
        f"INSERT INTO orbit VALUES (1, {LONG}, 'orbit', zeroblob(8000000), 9, 9, 1, 0, 0, 0, 0, 4, "
        "'newton', 1)",
    )
    chosen = Selection(contains="13", where="length > 8 AND code <> representative || 'x'")
    columns = ("code", "word", "representative", "length")
    (row,) = catalogue.rows(chosen, columns, order="representative desc,code")
    assert row == (word, word, word, 9.0)


def test_tokens_add_up_to_the_text():
    text = "a='x''y' -- c\n/* d */ \"n\" [m] `k` :v :: x'00' 1.5e3 ½ $ \x00"
    assert "".join(token.text for token in tokens(text)) == text
    kinds = [(token.kind, token.text) for token in tokens(text) if token.kind not in ("blank", "sign")]
    assert kinds == [("word", "a"), ("string", "'x''y'"), ("name", '"n"'), ("name", "[m]"), ("name", "`k`"),
                     ("value", ":v"), ("word", "x"), ("string", "'00'"), ("number", "1.5e3"),
                     ("word", "½")]  # fmt: skip
