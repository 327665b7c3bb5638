"""Security: free expressions can only choose rows, and a file from elsewhere can only be read."""

import contextlib
import csv
import io
import json
import os
import re
import signal
import sqlite3
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from processes import COMMAND
from quick import slow_but
from screens import drive, press, settle, shown, table_of

from orbitdb.catalogue.catalogue import Catalogue
from orbitdb.cli.tui.export import export as export_shown
from orbitdb.cli.tui.table.pages import Ordering
from orbitdb.errors import StoreError
from orbitdb.plaintext import cell, printable
from orbitdb.store.asking import confinement
from orbitdb.store.asking.confinement import CancelledError
from orbitdb.store.asking.selection import Selection, SelectionError
from orbitdb.store.file.guard import TamperedError
from orbitdb.store.file.migrate import migrate
from orbitdb.store.file.schema import LONG, SCHEMA_VERSION, TABLES, VIEWS
from orbitdb.store.file.tables import metadata
from orbitdb.store.file.tokens import tokens


@pytest.fixture
def own(varied, tmp_path) -> Path:
    """The varied catalogue, the test's own, and the default of the command line."""
    path = tmp_path / "orbits.db"
    path.write_bytes(varied.read_bytes())
    return path


def alter(path: Path, *statements: str) -> None:
    """Change a file by hand, as somebody who may do all that SQLite can."""
    with contextlib.closing(sqlite3.connect(path)) as plain, plain:
        plain.execute("PRAGMA writable_schema = ON")
        for statement in statements:
            plain.execute(statement)


# free expressions

ENDLESS = "WITH RECURSIVE n(x) AS (SELECT 1 UNION ALL SELECT x + 1 FROM n) SELECT count(*) FROM n"
GROWING = "WITH a AS (SELECT 1 x)" + "".join(
    f", {name} AS (SELECT 1 x FROM {before} u, {before} v)"
    for before, name in zip("abcdefghijklmnopqrst", "bcdefghijklmnopqrstu", strict=True)
)
ATTACKS = {
    # reading something else
    "another table": "(SELECT max(parameters) FROM run) <> ''",
    "the schema": "(SELECT max(sql) FROM sqlite_master) <> ''",
    "a table called catalogue": "(WITH catalogue AS (SELECT sql FROM sqlite_master) SELECT 1 FROM catalogue)",
    "a subquery called catalogue": "(SELECT 1 FROM (SELECT sql FROM sqlite_master) AS catalogue)",
    "a table by alias": "(SELECT max(sql) FROM sqlite_master AS catalogue) <> ''",
    "main": "(SELECT max(sql) FROM main.sqlite_master) <> ''",
    "a pragma": "(SELECT count(*) FROM pragma_table_info('orbit')) > 0",
    "a pragma called catalogue": "(SELECT max(file) FROM pragma_database_list AS catalogue) <> ''",
    "json_each": "(SELECT count(*) FROM json_each('[1]')) = 1",
    "a row number": "rowid = 1",
    "a file": "readfile('/etc/passwd') <> ''",
    "an extension": "load_extension('evil') IS NULL",
    "the build": "sqlite_source_id() <> ''",
    # writing
    "a second statement": "1; DELETE FROM orbit",
    "closing the bracket": "1) OR (1",
    "another query behind brackets": "1) UNION SELECT sql FROM sqlite_master WHERE (1",
    "attach": "(ATTACH 'x.db' AS y)",
    "a comment without end": "1 /*",
    "a row limit": "1 LIMIT 1",
    "an order": "1 ORDER BY p",
    "returning": "1 RETURNING 1",
    # growing, or running for ever
    "an endless recursion": f"({ENDLESS}) > 0",
    "a recursion in a subquery": f"p IN (SELECT p FROM catalogue WHERE ({ENDLESS}) > 0)",
    "names of names": f"({GROWING} SELECT count(*) FROM u) > 0",
    "a subquery of a subquery": "p IN (SELECT b + b FROM (SELECT p + p AS b FROM catalogue))",
    "a join": "(SELECT count(*) FROM catalogue AS b, catalogue AS c) > 0",
    "a join in brackets": "(SELECT count(*) FROM (catalogue AS b JOIN catalogue AS c)) > 0",
    "a join in quotes": """(SELECT count(*) FROM "catalogue" AS b, 'catalogue' AS c) > 0""",
    "a natural join": "(SELECT count(*) FROM catalogue NATURAL JOIN catalogue AS b) > 0",
    "printf": "length(printf('%*c', 1000000000, 'x')) > 0",
    "zeroblob": "length(zeroblob(1000000000)) > 0",
    "group_concat": "length((SELECT group_concat(code) FROM catalogue)) > 0",
    "char": "char(65, 65) = 'AA'",
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


LONG_ONES = {"much denied", "many signs", "many brackets that fit", "a long name"}


@pytest.mark.parametrize(
    "name",
    [
        *slow_but([*ATTACKS][::5], [name for name in ATTACKS if name not in LONG_ONES]),
        *(pytest.param(name, marks=pytest.mark.fuzz) for name in sorted(LONG_ONES)),
    ],
)
def test_an_expression_does_nothing_but_choose(varied, name):
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


COMMANDS = ["query", "entropy", "lyapunov", "verify", "export", "plot"]
SUPPLIED = {"export": ["--format", "csv"], "plot": ["lengths", "-o", "lengths.svg"]}


@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize(
    "name",
    slow_but(
        ["a second statement"], ["a table called catalogue", "a pragma", "a second statement", "zeroblob"]
    ),
)
def test_every_command_refuses(own, cli, command, name):
    outcome = cli(command, *SUPPLIED.get(command, []), "--where", ATTACKS[name])
    assert outcome.code == 2
    assert outcome.out == ""
    assert len(outcome.err.splitlines()) == 1


@pytest.mark.parametrize("option", ["--order", "-c"])
@pytest.mark.parametrize(
    "value",
    slow_but(
        ["(SELECT 1)", "p; DROP TABLE run", "*"],
        ["(SELECT 1)", "p; DROP TABLE run", "length(code)", "rowid", "1", "p--", "*"],
    ),
)
def test_orders_and_columns_are_names(own, cli, option, value):
    assert cli("query", option, value).code == 2


def test_values_are_values(own):
    """What is bound is never read as SQL, whatever it holds."""
    catalogue = Catalogue(own)
    for value in ("1 OR 1", "'; DELETE FROM orbit; --", ":x", "(SELECT 1)"):
        assert catalogue.count(Selection(where="code = :x", parameters={"x": value})) == 0
    with pytest.raises(SelectionError, match="characters"):
        catalogue.count(Selection(where="code = :x", parameters={"x": "1" * 100_000}))
    with pytest.raises(SelectionError, match="type"):
        catalogue.count(Selection(where="code = :x", parameters={"x": ["1"]}))
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
    "(p, code) IN (VALUES (2, '13'), (3, '113'))": 1,
    "code GLOB '01*' OR code LIKE '%3_'": 50,
    "round(lambda_c, 2) BETWEEN 0.3 AND 0.4 -- the weak ones": 20,
    "random() % 2 IN (0, 1, -1)": 300,
    "'a:b' = 'a:b' AND code <> 'x -- y' AND \"p\" > 2 /* not the shortest */": 300,
}  # fmt: skip


@pytest.mark.parametrize("text", ALLOWED)
def test_what_users_want_is_allowed(own, text):
    assert Catalogue(own).count(Selection(where=text)) >= ALLOWED[text]


@pytest.mark.parametrize("use", ["count", "rows", "sorted", "classes", "select"])
def test_every_use_is_stopped_in_time(own, monkeypatch, use):
    from orbitdb.store.asking import expressions

    monkeypatch.setattr(expressions, "SECONDS", 0.02)
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
    assert catalogue.count(Selection()) > 300  # the connection is as it was


def test_the_time_of_those_who_use_the_rows_does_not_count(own, monkeypatch):
    from orbitdb.store.asking import expressions

    monkeypatch.setattr(expressions, "SECONDS", 1.0)
    clock = iter(float(10 * n) for n in range(1000))
    monkeypatch.setattr(confinement.time, "monotonic", lambda: next(clock))
    patience = confinement.Patience(35.0)  # at 0
    with patience.working():  # from 10 to 30: 15 are left from 40 on
        pass
    assert not patience.ended  # at 50
    assert patience.ended  # at 60


def slow_filter() -> Selection:
    """Return a choice that takes a minute or more on the filled catalogue."""
    rest = " + ".join(f"b.length * catalogue.lyapunov * {n}" for n in range(60))
    return Selection(where=f"(SELECT sum({rest}) FROM catalogue AS b WHERE b.code <> catalogue.code) < 0")


@pytest.mark.slow
def test_a_filter_that_nobody_waits_for_any_more_is_stopped(filled):
    catalogue = Catalogue(filled)
    asked = iter([False] * 50)
    with pytest.raises(CancelledError):
        catalogue.choose(slow_filter(), cancelled=lambda: next(asked, True))


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="needs POSIX signals")
def test_ctrl_c_is_no_refusal(filled):
    """SQLite, asked for the time, swallows the interrupt; it must not be told as a slow expression."""
    process = subprocess.Popen(
        [*COMMAND, "query", "--where", str(slow_filter().where), "--db", str(filled)],
        stderr=subprocess.PIPE,
        text=True,
    )
    with contextlib.suppress(subprocess.TimeoutExpired):
        process.wait(3)
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=60)
    assert process.returncode == 130
    assert err.startswith("orbitdb: interrupted")


def test_words_of_a_million_bounces_can_be_asked_for(tmp_path):
    """No limit on texts stands in the way of the longest words there are, in any column or order."""
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


def test_tokens_are_all_that_was_given():
    text = "a='x''y' -- c\n/* d */ \"n\" [m] `k` :v :: x'00' 1.5e3 ½ $ \x00"
    assert "".join(token.text for token in tokens(text)) == text
    kinds = [(token.kind, token.text) for token in tokens(text) if token.kind not in ("blank", "sign")]
    assert kinds == [("word", "a"), ("string", "'x''y'"), ("name", '"n"'), ("name", "[m]"), ("name", "`k`"),
                     ("value", ":v"), ("word", "x"), ("string", "'00'"), ("number", "1.5e3"),
                     ("word", "½")]  # fmt: skip


# files that act

NAMES = re.findall(r" AS (\w+)[,\n]", VIEWS["catalogue"].partition("AS\n")[2])
LOOP = "WITH RECURSIVE n(x) AS (SELECT 1 UNION ALL SELECT x + 1 FROM n)"


def rewritten(table: str, before: str, after: str) -> str:
    """Return the statement that changes the text of a table."""
    return f"UPDATE sqlite_master SET sql = replace(sql, '{before}', '{after}') WHERE name = '{table}'"


HOSTILE = {
    "a trigger": ["CREATE TRIGGER t AFTER INSERT ON run BEGIN DELETE FROM orbit; END"],
    "a trigger on the view": [
        "CREATE TRIGGER t INSTEAD OF INSERT ON catalogue BEGIN DELETE FROM orbit; END"
    ],
    "an endless view": [
        "DROP VIEW catalogue",
        f"CREATE VIEW catalogue AS {LOOP} SELECT {', '.join(f'x AS {name}' for name in NAMES)} FROM n",
    ],
    "a view with a row more": [
        "DROP VIEW catalogue",
        VIEWS["catalogue"].replace("cycle AS cycle", "cycle AS cycle, random() AS more"),
    ],
    "another view of lives": ["DROP VIEW life", VIEWS["life"].replace("'born'", "'died'")],
    "a view that asks for another text": ["DROP VIEW life", VIEWS["life"].replace("'born'", "'bo rn'")],
    "no view of lives": ["DROP VIEW life"],
    "no view of classes": ["DROP VIEW class"],
    "a table for the view": ["DROP VIEW catalogue", f"CREATE TABLE catalogue ({', '.join(NAMES)})"],
    "no view": ["DROP VIEW catalogue"],
    "a view for a table": [
        "ALTER TABLE fill RENAME TO old", f"CREATE VIEW fill AS {LOOP} SELECT old.* FROM old, n"
    ],
    "a virtual table": ["CREATE VIRTUAL TABLE mine USING fts5(x)"],
    "a virtual table for a table": [
        "DROP TABLE trajectory", "CREATE VIRTUAL TABLE trajectory USING fts5(x)"
    ],
    "a generated column": ["ALTER TABLE run ADD COLUMN more INTEGER AS (abs(id))"],
    "a check": [rewritten("run", "PRIMARY KEY", "CHECK (abs(id) > 0), PRIMARY KEY")],
    "a check in a table beside": ["CREATE TABLE mine (x CHECK (abs(x) > 0))"],
    "a default that is computed": [rewritten("run", "version TEXT", "version TEXT DEFAULT (random())")],
    "an index of an expression": ["CREATE INDEX i ON run (abs(id))"],
    "a column more": ["ALTER TABLE run ADD COLUMN more TEXT"],
    "a column less": ["ALTER TABLE run DROP COLUMN version"],
    "a column of another type": [rewritten("run", "version TEXT", "version BLOB")],
    "another key": [rewritten("fill", "KEY (stadium, p)", "KEY (p, stadium)")],
    "a table that takes anything": [rewritten("run", "STRICT", "")],
    "a table less": ["DROP TABLE certificate"],
    "a table in capitals": ["ALTER TABLE fill RENAME TO other", "ALTER TABLE other RENAME TO FILL"],
}  # fmt: skip
BROKEN = {
    "a text that is no SQL": ["UPDATE sqlite_master SET sql = 'CREATE TABLE' WHERE name = 'run'"],
    "a trigger called a table": [
        *HOSTILE["a trigger"], "UPDATE sqlite_master SET type = 'table' WHERE name = 't'"
    ],
    "a trigger called otherwise": [
        *HOSTILE["a trigger"], "UPDATE sqlite_master SET name = 'u' WHERE name = 't'"
    ],
    "a table within itself": ["UPDATE sqlite_master SET rootpage = 1 WHERE name = 'run'"],
}  # fmt: skip
USES = [
    ["query"], ["query", "--code", "13"], ["query", "--where", "p = 3"], ["table"], ["info"], ["entropy"],
    ["lyapunov"], ["export", "--format", "csv"], ["plot", "orbit", "--code", "013", "-o", "o.svg"],
    ["plot", "lengths", "-o", "o.svg"], ["fill", "--p", "3"], ["fill", "--code", "0133"],
    ["simulate", "--bounces", "1000"],
]  # fmt: skip


def hostile(path: Path, statements: list[str]) -> None:
    try:
        alter(path, *statements)
    except sqlite3.OperationalError as error:  # no fts5 in this SQLite, or none that drops columns
        pytest.skip(str(error))


@pytest.mark.parametrize(
    "name", slow_but(["a trigger", *[*HOSTILE][::4], *[*BROKEN][:1]], [*HOSTILE, *BROKEN])
)
def test_a_file_that_acts_is_refused(own, cli, monkeypatch, tmp_path, name):
    monkeypatch.chdir(tmp_path)
    hostile(own, (HOSTILE | BROKEN)[name])
    before = own.read_bytes()
    for arguments in USES if name in ("a trigger", "an endless view") else USES[:: len(USES) - 2]:
        outcome = cli(*arguments)
        assert (outcome.code, outcome.out) == (3, ""), (arguments, outcome)
        assert len(outcome.err.splitlines()) == 1
        assert "is not as orbitdb made it" in outcome.err or "is damaged" in outcome.err
    assert own.read_bytes() == before
    with pytest.raises(StoreError):
        Catalogue(own)


@pytest.mark.parametrize("name", slow_but([*HOSTILE][::4], HOSTILE))
def test_verify_names_what_acts_and_looks_no_further(own, cli, name):
    hostile(own, HOSTILE[name])
    outcome = cli("verify", "--json")
    assert outcome.code == 1
    (row,) = json.loads(outcome.out)
    assert row["check"] == "schema"
    assert row["failures"] >= 1
    assert row["first"]
    assert "nothing of it was run" in outcome.err


def test_a_file_that_acts_is_not_migrated(own, cli):
    alter(own, *HOSTILE["a trigger"], f"PRAGMA user_version = {SCHEMA_VERSION - 1}")
    before = own.read_bytes()
    for arguments in (["migrate"], ["fill", "--p", "3"]):
        outcome = cli(*arguments)
        assert outcome.code == 3
        assert "trigger t" in outcome.err
    assert own.read_bytes() == before


def test_brackets_in_a_comment_are_no_expression(own):
    alter(own, "CREATE INDEX quick /* (of periods) */ ON fill (p)")
    assert Catalogue(own).count() > 0


@pytest.mark.slow
def test_what_users_add_is_let_be(own, cli):
    """A view of another name is never run, however long that would take."""
    alter(
        own,
        "CREATE TABLE mine (word TEXT DEFAULT 'a', \"check (x)\" REAL, at TEXT DEFAULT CURRENT_TIMESTAMP)",
        'CREATE TABLE "my notes" (id INTEGER PRIMARY KEY, size DECIMAL(10, 2)) -- CHECK (1)',
        "CREATE INDEX fast ON orbit (length)",
        "CREATE UNIQUE INDEX mine_word ON mine (word COLLATE nocase, at DESC)",
        f"CREATE VIEW pragma_table_list AS {LOOP} SELECT x FROM n",
        "ANALYZE",
    )
    assert cli("query").code == 0
    assert cli("fill", "--p", "7").code == 0
    assert cli("verify").code == 0


def test_a_new_catalogue_passes(tmp_path):
    path = tmp_path / "new.db"
    catalogue = Catalogue.create(path)
    with catalogue.reading() as connection:
        texts = connection.exec_driver_sql("SELECT sql FROM sqlite_master WHERE type = 'view'").scalars()
        assert sorted(text.split() for text in texts) == sorted(text.split() for text in VIEWS.values())
        assert connection.exec_driver_sql("PRAGMA trusted_schema").scalar() == 0
        assert connection.exec_driver_sql("PRAGMA cell_size_check").scalar() == 1
        assert connection.exec_driver_sql("PRAGMA query_only").scalar() == 1
    assert set(NAMES) >= {"code", "a", "length"}


def test_every_table_is_guarded(tmp_path):
    migrate(new := tmp_path / "new.db")
    for name in TABLES:
        path = tmp_path / f"{name}.db"
        path.write_bytes(new.read_bytes())
        alter(path, f"ALTER TABLE {name} ADD COLUMN more TEXT")
        with pytest.raises(TamperedError, match=f"table {name}") as caught:
            Catalogue(path)
        assert caught.value.faults == [f"table {name}"]


@pytest.mark.slow
def test_the_guard_needs_no_alembic(own):
    code = "import sys, orbitdb; orbitdb.Catalogue(sys.argv[1]); print('alembic' in sys.modules)"
    done = subprocess.run(
        [sys.executable, "-P", "-c", code, str(own)], capture_output=True, text=True, check=True
    )
    assert done.stdout == "False\n"


# rows that no catalogue has

VALUES = ["''", "'x'", "NULL", "0", "-1", "9223372036854775807", "9e999", "1e308", "5e-324", "x'00'", "'1,9'",
          "printf('%.*c', 3000, '1')", "cast(x'ff80' AS TEXT)", "char(27) || '[31m'", "'=1+1'"]  # fmt: skip
DELETIONS = ["cycle WHERE id % 5 = 2", "pruned", "element WHERE n = 1", "stadium WHERE id = 1", "fill", "run",
             "orbit WHERE cycle % 5 = 1"]  # fmt: skip
READING = [
    ["births"], ["table", "--a", "0.7"], ["entropy", "--a", "0.7"],
    ["query"], ["query", "--json"], ["query", "--format", "csv"], ["query", "--code", "013"], ["table"],
    ["info"], ["entropy"], ["lyapunov"], ["export", "--format", "csv", "--coordinates"],
    ["verify", "--p", "2-4"], ["export", "--format", "jsonl"], ["plot", "sheet", "--p", "3", "-o", "o.svg"],
]  # fmt: skip


def alterations() -> list[str]:
    columns = [(table.name, column.name) for table in metadata.sorted_tables for column in table.columns]
    updates = [
        f"UPDATE OR IGNORE {table} SET {name} = {value}" for table, name in columns for value in VALUES
    ]
    return updates + [f"DELETE FROM {which}" for which in DELETIONS]


def try_altered(own: Path, cli, statements: list[str], sound: bytes) -> None:
    for number, statement in enumerate(statements):
        path = own.with_name(f"{number}.db")  # its own, for connections to others may still be open
        path.write_bytes(sound)
        with contextlib.suppress(sqlite3.IntegrityError):
            alter(path, statement)
        for arguments in READING[number % len(READING) :: 6]:
            code, out, err = cli(*arguments, "--db", str(path))
            assert code in (0, 1, 2, 3), (statement, arguments)
            assert code == 0 or err, (statement, arguments)
            assert all(symbol.isprintable() or symbol in "\t\n" for symbol in out + err), (
                statement,
                arguments,
            )


@pytest.mark.parametrize("share", [300, pytest.param(60, marks=pytest.mark.fuzz)])
@pytest.mark.slow
def test_altered_rows_are_shown_or_refused(own, cli, monkeypatch, tmp_path, share):
    monkeypatch.chdir(tmp_path)
    try_altered(own, cli, alterations()[::share], own.read_bytes())


# text that is more than text

FORMULAS = ["=1+1", "+1", "-1+cmd", "@SUM(1)", "\t=1", "\r=1", '=HYPERLINK("x")', "＝1", "－1"]
ESCAPES = ["\x1b[31mred", "\x1b]0;title\x07", "\x9b2J", "a\rb", "a\nb", "\u202egnp", "\x00", "\x7f", "\u2028"]


@pytest.mark.parametrize("text", [*FORMULAS, *ESCAPES])
def test_cells_are_no_formulas(text):
    found = cell(text)
    assert isinstance(found, str)
    assert found.isprintable()
    assert found[0] not in "=+-@＝＋－＠"


def test_cells_that_are_numbers_stay():
    assert [cell(value) for value in (-1.5, -3, None, "orbit", [1, 3], [-0.5, 2e-9], "1^20 3")] == [
        -1.5, -3, None, "orbit", "1 3", "-0.5 2e-09", "1^20 3",
    ]  # fmt: skip
    assert printable("½ λ_d ± 1") == "½ λ_d ± 1"
    assert printable("a\x1b[31m\udcff") == "a\\x1b[31m\\udcff"


def evil(path: Path) -> None:
    """Give rows the texts of a maker who wants them run by what shows them."""
    quoted = [text.replace("'", "''").replace("\x00", "' || char(0) || '") for text in FORMULAS + ESCAPES]
    case = " ".join(f"WHEN {n} THEN '{text}'" for n, text in enumerate(quoted))
    rank = "(SELECT count(*) FROM cycle AS other WHERE other.id < cycle.id)"
    chosen = f"CASE {rank} % {len(quoted)} {case} END"
    alter(
        path,
        f"UPDATE cycle SET symmetry = {chosen}, time_reversal = {chosen}",
        "UPDATE orbit SET solver = (SELECT symmetry FROM cycle WHERE id = cycle), status = solver",
    )
    alter(path, "UPDATE orbit SET solver = (SELECT symmetry FROM cycle WHERE id = orbit.cycle)")
    alter(path, "UPDATE orbit SET status = solver WHERE cycle % 2")


def texts_of(rows: list[dict[str, str]]) -> list[str]:
    names = ("status", "symmetry", "time_reversal", "solver")
    return [row[name] for row in rows for name in names]


def safe(texts: list[str]) -> None:
    assert any("1+1" in text for text in texts)
    assert any("red" in text for text in texts)
    assert all(text.isprintable() for text in texts)
    assert not [text for text in texts if text.startswith(tuple("=+-@＝＋－＠"))]


@pytest.mark.parametrize("form", slow_but(["csv"], ["csv", "tsv"]))
@pytest.mark.slow
def test_tables_for_spreadsheets_hold_no_formulas(own, cli, tmp_path, form):
    import pandas as pd

    evil(own)
    columns = "code,status,symmetry,time_reversal,solver,margin"
    outcome = cli("query", "--format", form, "-c", columns)
    assert outcome.code == 0
    delimiter = "," if form == "csv" else "\t"
    rows = list(csv.DictReader(io.StringIO(outcome.out), delimiter=delimiter))
    safe(texts_of(rows))
    frame = pd.read_csv(io.StringIO(outcome.out), sep=delimiter, dtype={"code": str}, keep_default_na=False)
    safe([str(text) for text in frame[["status", "symmetry", "time_reversal", "solver"]].to_numpy().ravel()])
    assert min(float(row["margin"] or 0) for row in rows) < 0
    if form == "csv":
        assert cli("export", str(tmp_path / "rows.csv"), "-c", columns).code == 0
        with (tmp_path / "rows.csv").open(newline="") as file:
            assert list(csv.DictReader(file)) == rows


@pytest.mark.parametrize("suffix", [".csv", ".tsv", ".json", ".jsonl"])
@pytest.mark.slow
def test_what_the_terminal_ui_writes_is_as_safe(own, tmp_path, suffix):
    evil(own)
    path = tmp_path / f"shown{suffix}"
    export_shown(path, Catalogue(own), Selection(), Ordering(), None)
    text = path.read_text()
    assert all(symbol.isprintable() or symbol in "\t\n" for symbol in text)
    if suffix in (".csv", ".tsv"):
        rows = list(csv.DictReader(io.StringIO(text), delimiter="," if suffix == ".csv" else "\t"))
        texts = [row[name] for row in rows for name in ("status", "time_reversal")]
        assert not [text for text in texts if text.startswith(tuple("=+-@＝＋－＠"))]
    assert not [name for name in os.listdir(tmp_path) if name.endswith(".part")]


@pytest.mark.parametrize("form", slow_but(["table"], ["table", "csv", "tsv", "json", "jsonl"]))
def test_no_control_characters_reach_a_terminal(own, cli, form):
    evil(own)
    columns = "code,status,symmetry,time_reversal,solver"
    for arguments in (
        ["query", "--format", form, "-c", columns, "--limit", "500"],
        ["verify", "--format", form],
    ):
        outcome = cli(*arguments)
        assert outcome.code in (0, 1)
        assert all(symbol.isprintable() or symbol in "\t\n" for symbol in outcome.out + outcome.err)


def test_json_gives_back_what_is_stored(own, cli):
    """JSON needs no changes to be safe: it escapes, and a program gets the very text."""
    evil(own)
    rows = json.loads(cli("query", "--json", "-c", "symmetry").out)
    assert {row["symmetry"] for row in rows} >= {*FORMULAS, *ESCAPES} - {"\x00"}


@pytest.mark.slow
def test_the_terminal_ui_shows_no_control_characters(own):
    evil(own)
    alter(own, "UPDATE orbit SET status = 'orbit'")  # with others there is no index, and no row is shown

    async def steps(app, pilot):
        for key in ("j", "j", "down", "pagedown", "end", "l", "l", "l", "l"):
            await press(pilot, key)
            text = shown(app)
            assert all(symbol.isprintable() or symbol == "\n" for symbol in text)
        assert table_of(app).row is not None

    drive(own, steps, size=(160, 48))


@pytest.mark.parametrize("name", slow_but(["a[/b]c"], ["a[b", "a[/b]c", "[red]", "a\\[b"]))
def test_the_terminal_ui_takes_any_name_of_a_file(tmp_path, monkeypatch, name):
    monkeypatch.chdir(tmp_path)  # a long path would be wrapped, anywhere in the name

    async def steps(app, pilot):
        assert name[:3] in shown(app)
        app.notify(f"[/b] {name}")
        await settle(pilot)

    drive(Path(f"{name}.db"), steps, size=(160, 48))
