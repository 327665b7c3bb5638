"""Expressions and statements of users can only read, are stopped after a while, and never hide Ctrl-C."""

import signal
import subprocess
import sys
from collections.abc import Callable
from functools import partial
from types import SimpleNamespace
from typing import cast

import pytest
from processes import start, wait_until_ready

from orbitdb.catalogue import Catalogue
from orbitdb.errors import SelectionError
from orbitdb.selection import Selection
from orbitdb.store import select
from orbitdb.store import where as asking
from orbitdb.store.file import reading

ENDLESS = "WITH RECURSIVE n(x) AS (SELECT 1 UNION ALL SELECT x + 1 FROM n) SELECT count(*) FROM n"
REFUSED = {
    "a second statement": "1; DELETE FROM orbit",
    "closing the bracket": "1) OR (1",
    "another query behind brackets": "1) UNION SELECT sql FROM sqlite_master WHERE (1",
    "attach": "(ATTACH 'x.db' AS y)",
    "a comment without end": "1 /*",
    "a row limit": "1 LIMIT 1",
    "a row number": "rowid = 1",
    "an extension": "load_extension('evil') IS NULL",
    "a huge text": "length(zeroblob(4000000000)) > 0",
    "many brackets": "(" * 10_000 + "1" + ")" * 10_000,
    "a long expression": " OR ".join(["p = 1"] * 20_000),
    "a value by number": "p = ?1",
    "a NUL": "p = '\x00'",
    "half a character": "p = '\ud800'",
}


@pytest.mark.parametrize("name", REFUSED)
def test_an_expression_is_one_condition(varied, name):
    before = varied.read_bytes()
    catalogue, chosen = Catalogue(varied), Selection(where=REFUSED[name])
    for use in (catalogue.count, catalogue.select):
        with pytest.raises(SelectionError) as caught:
            use(chosen)
        assert len(str(caught.value)) < 1100
        assert "\n" not in str(caught.value)
    assert varied.read_bytes() == before


@pytest.mark.parametrize(
    "statement",
    ["DELETE FROM orbit", "UPDATE run SET version = ''", "DROP TABLE orbit", "ATTACH ':memory:' AS x",
     "VACUUM", "CREATE TEMP TABLE x (y)", "PRAGMA query_only = OFF", "BEGIN", "SELECT 1; SELECT 2", ""],
)  # fmt: skip
def test_a_statement_can_only_read(varied, statement):
    before = varied.read_bytes()
    with reading(varied) as connection, pytest.raises(SelectionError, match=r"^sql "):
        asking.run_statement(connection, statement, {})
    assert varied.read_bytes() == before


def test_bound_values_are_only_values(own):
    """Bound values are never read as SQL."""
    catalogue = Catalogue(own)
    for value in ("1 OR 1", "'; DELETE FROM orbit; --", ":x", "(SELECT 1)"):
        assert catalogue.count(Selection(where="code = :x", parameters={"x": value})) == 0
    with pytest.raises(SelectionError, match="give a number or a text"):
        catalogue.count(Selection(where="code = :x", parameters=cast(dict[str, str], {"x": ["1"]})))
    assert catalogue.count(Selection(where="code = ':x'")) == 0
    with pytest.raises(SelectionError, match="it has no :x"):
        catalogue.count(Selection(where="code = ':x'", parameters={"x": 1}))
    with pytest.raises(SelectionError, match="it has no :ength"):
        catalogue.count(Selection(where="length > 9", parameters={"ength": 1}))


@pytest.mark.parametrize("name", ["_a", "_0", "_1", "_2", "a", "ids"])
def test_values_may_have_any_name(varied, name):
    count = partial(Catalogue(varied, 1.6).count, p="2-5", length=(3, 20))
    for sign in ":$@":
        assert count(where="length < 12") == count(where=f"length < {sign}{name}", parameters={name: 12})


ALLOWED = {
    "length < (SELECT avg(length) FROM catalogue WHERE p = 5)": 100,
    "length(code) - length(replace(code, '0', '')) = 1": 50,
    "EXISTS (SELECT 1 FROM catalogue AS b WHERE b.length = catalogue.length AND b.p > 5)": 100,
    "code IN (SELECT representative FROM catalogue WHERE p < 5) AND a = 1.6": 5,
    "length > (WITH m AS (SELECT avg(length) AS x FROM catalogue WHERE p = 4) SELECT x FROM m)": 100,
    "p IN (SELECT b + b FROM (SELECT p AS b FROM class WHERE p = 2))": 30,
    "cycle IN (SELECT cycle FROM orbit JOIN stadium ON stadium.id = stadium WHERE a = 1.6)": 300,
    f"p IN ({', '.join(['2'] * 3000)})": 1,
    "(p, code) IN (VALUES (2, '13'), (3, '113'))": 1,
    "code GLOB '01*' OR code LIKE '%3_'": 50,
    "round(lambda_c, 2) BETWEEN 0.3 AND 0.4 -- the weak ones": 20,
    "'a:b' = 'a:b' AND code <> 'x -- y' AND \"p\" > 2 /* not the shortest */": 300,
    "printf('%.1f', length) LIKE '1%' AND json_array_length('[1, 2]') = 2": 100,
    "replace(code, NULL, '2') IS NULL": 300,
    "EXISTS (SELECT 1 FROM json_each('[3, 4]') WHERE value = p)": 10,
}  # fmt: skip


@pytest.mark.parametrize("text", ALLOWED)
def test_useful_expressions_are_allowed(own, text):
    assert Catalogue(own).count(Selection(where=text)) >= ALLOWED[text]


@pytest.mark.parametrize("use", ["count", "rows", "sorted", "classes", "endless"])
def test_every_use_is_stopped_in_time(own, monkeypatch, use):
    monkeypatch.setattr(asking, "SECONDS", 0.02)
    rest = " + ".join(f"b.length * catalogue.lyapunov * {n}" for n in range(40))
    catalogue = Catalogue(own)
    chosen = Selection(where=f"(SELECT sum({rest}) FROM catalogue AS b WHERE b.code <> catalogue.code) < 0")
    uses: dict[str, Callable[[], object]] = {
        "count": lambda: catalogue.count(chosen),
        "rows": lambda: list(catalogue.rows(chosen)),
        "sorted": lambda: list(catalogue.rows(chosen, order="length desc")),
        "classes": lambda: catalogue.classes(chosen),
        "endless": lambda: catalogue.count(where=f"({ENDLESS}) > 0"),
    }
    with pytest.raises(SelectionError, match=r"more than 0\.02 s"):
        uses[use]()
    assert catalogue.count(Selection()) > 300  # the connection still works


def test_time_between_blocks_of_rows_does_not_count(own, monkeypatch):
    """SQLite looks at the clock, which is the test's, while it finds each block."""
    clock = [0.0]
    for module in (asking, select):
        monkeypatch.setattr(module, "time", SimpleNamespace(monotonic=lambda: clock[0]))
    monkeypatch.setattr(asking, "STEPS_BETWEEN_LOOKS", 100)
    monkeypatch.setattr(select, "ROWS", 50)
    found = []
    for row in Catalogue(own).rows(where="length > 0"):
        clock[0] += 3600
        found.append(row)
    assert len(found) > 150


@pytest.mark.parametrize("name", ["interrupted", "prohibited", "'not authorized'.x"])
def test_a_refusal_is_never_ctrl_c(own, name):
    with pytest.raises(SelectionError, match="no such column: "):
        Catalogue(own).count(where=f"{name} = 1")


INTERRUPTED = """
import signal, sys
from orbitdb import Catalogue
catalogue = Catalogue(sys.argv[1])
where = "code = code('13') OR (SELECT sum(b.length) FROM catalogue AS b WHERE b.p < catalogue.p) < 0"
catalogue.count(where=where)
waiting, raised, lost = False, [], []

def interrupt(*_):
    global waiting
    waiting = False
    raise KeyboardInterrupt

signal.signal(signal.SIGALRM, interrupt)
sys.unraisablehook = lost.append  # Python itself loses what arrives in the callback of a weak reference
for n in range(1, 41):
    waiting = True
    signal.setitimer(signal.ITIMER_REAL, n * 5e-4)
    try:
        while waiting:
            catalogue.count(where=where)
    except KeyboardInterrupt:
        raised.append(n)
print(len(raised) + len(lost), all(each.exc_type is KeyboardInterrupt for each in lost))
"""


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="needs POSIX signals")
def test_ctrl_c_is_never_a_refusal(own):
    """It may arrive in any function of Python that SQLite calls, which hides every exception."""
    done = subprocess.run(
        [sys.executable, "-c", INTERRUPTED, own], capture_output=True, text=True, timeout=300
    )
    assert done.stdout == "40 True\n", done.stderr


def test_the_time_limit_of_a_query_ends_with_it(own, monkeypatch):
    """A later question at the same moment of the file may take its time."""
    clock = [0.0]
    monkeypatch.setattr(asking, "time", SimpleNamespace(monotonic=lambda: clock[0]))
    monkeypatch.setattr(asking, "STEPS_BETWEEN_LOOKS", 100)
    catalogue = Catalogue(own, 1.6)
    with catalogue.snapshot() as then:
        assert then.count(where="p = 3") == 8
        clock[0] += 3600
        assert then.count() > 300


LOOKING = """
from orbitdb.cli.main import run
from orbitdb.store.where import Patience
plain = Patience.look
def look(patience):
    print("ready", flush=True)
    Patience.look = plain
    return plain(patience)
Patience.look = look
run()
"""
"""Prints ``ready`` when SQLite first asks, in a long query, whether to go on."""


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="needs POSIX signals")
@pytest.mark.parametrize(
    ("name", "code", "told"), [("SIGINT", 130, "interrupted"), ("SIGTERM", 143, "terminated")]
)
def test_ctrl_c_is_not_mistaken_for_a_refusal(filled, name, code, told):
    """SQLite's progress callback swallows the interrupt; it must not be reported as a slow expression."""
    rest = " + ".join(f"b.length * catalogue.lyapunov * {n}" for n in range(60))  # takes over a minute
    slow = f"(SELECT sum({rest}) FROM catalogue AS b WHERE b.code <> catalogue.code) < 0"
    command = [sys.executable, "-P", "-c", LOOKING]
    process = start("query", "--where", slow, "--db", filled, command=command)
    wait_until_ready(process)
    process.send_signal(signal.Signals[name])
    _, err = process.communicate(timeout=60)
    assert process.returncode == code
    assert err == f"orbitdb: {told}\n"
