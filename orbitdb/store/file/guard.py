"""The guard: a catalogue's file may hold data, and nothing that acts when it is read or written.

SQLite runs what a file brings along: triggers, views, virtual tables, generated columns, CHECK and
DEFAULT expressions, indexes of expressions. Before anything else is asked of a file its schema is read
as text, which runs none of it: the catalogue's own names must be what `orbitdb.store.file.layout` says, and
whatever else there is must be plain. It takes about 0.3 ms.
"""

import re
import sqlite3
from contextlib import closing
from functools import cache
from itertools import pairwise

from orbitdb.errors import StoreError
from orbitdb.store.file.layout import TABLES
from orbitdb.store.file.tokens import Token, meaningful

VIEW = """\
CREATE VIEW catalogue AS
SELECT stadium.a AS a,
       sequence.p AS p,
       sequence.word AS code,
       sequence.word AS word,
       cycle.word AS representative,
       coalesce(orbit.status, 'geometric') AS status,
       sequence.rules AS rules,
       orbit.length AS length,
       orbit.lyapunov AS lyapunov,
       orbit.lyapunov / sequence.p AS lambda_d,
       orbit.lyapunov / orbit.length AS lambda_c,
       cycle.time_reversal AS time_reversal,
       cycle.symmetry AS symmetry,
       cycle.class_size AS class_size,
       cycle.walls AS walls,
       orbit.margin AS margin,
       orbit.residual AS residual,
       orbit.error AS error,
       orbit.length_error AS length_error,
       orbit.lyapunov_error AS lyapunov_error,
       orbit.iterations AS iterations,
       orbit.solver AS solver,
       sequence.element AS element,
       sequence.cycle AS cycle,
       (SELECT nullif(change.a, 0.0) FROM change
        WHERE change.cycle = sequence.cycle AND change.number = 1) AS born,
       (SELECT change.a FROM change
        WHERE change.cycle = sequence.cycle AND change.number = 2) AS dies
FROM sequence
JOIN stadium
LEFT JOIN cycle ON cycle.id = sequence.cycle
LEFT JOIN orbit ON orbit.stadium = stadium.id AND orbit.cycle = sequence.cycle
WHERE orbit.status IS NOT NULL OR sequence.rules IS NOT NULL
"""
"""The view of the newest schema, as the last migration that touched it made it."""

LIFE = """\
CREATE VIEW life AS
SELECT change.cycle AS cycle,
       cycle.p AS p,
       cycle.class_size AS class_size,
       cycle.word AS word,
       change.a AS born,
       change.error AS born_error,
       death.a AS dies,
       death.error AS dies_error
FROM change
JOIN cycle ON cycle.id = change.cycle
LEFT JOIN change AS death ON death.cycle = change.cycle AND death.number = change.number + 1
WHERE change.kind = 'born'
"""
"""The view of the lives of classes, in the same way."""

VIEWS = {"catalogue": VIEW, "life": LIFE}

_ACTIVE = {"CHECK", "GENERATED", "AS", "VIRTUAL", "WHERE"}
_BARE = re.compile(r"[\w\s,()]*", re.ASCII)
_WORD = re.compile(r"[A-Z]+")
_Shape = tuple[set[tuple[str, str, bool, int, int]], set[str]]


class TamperedError(StoreError):
    """The schema of a file is not that of a catalogue.

    Attributes
    ----------
    parts : int
        How many tables, views, indexes and triggers there are in the file.
    faults : list of str
        Those that are not as they must be, such as ``trigger t``.
    """

    def __init__(self, message: str, parts: int, faults: list[str]) -> None:
        super().__init__(message)
        self.parts = parts
        self.faults = faults


def refuse_tampered(connection: sqlite3.Connection, path: object, newest: bool) -> None:
    """Refuse a file that holds more than data.

    Parameters
    ----------
    connection : sqlite3.Connection
        Opened a moment ago.
    path : path-like
        For the message.
    newest : bool
        Whether the file must have the newest schema; of others, that are about to be migrated, only
        what acts is refused.

    Raises
    ------
    TamperedError
        With the first thing that is wrong.
    """
    schema = connection.execute("SELECT type, name, sql FROM sqlite_master").fetchall()
    faults = [f"{kind} {name}" for kind, name, text in schema if _acts(kind, name, text or "", newest)]
    if newest and not faults:
        faults = _misshapen(connection, {(kind, name): text for kind, name, text in schema})
    if faults:
        raise TamperedError(
            f"{path} is not as orbitdb made it ({faults[0]}), and nothing of it was run: restore a copy, "
            "or fill a new one",
            len(schema),
            faults,
        )


def _acts(kind: str, name: str, text: str, newest: bool) -> bool:
    """Tell whether a part of a schema would run something of its own."""
    if kind == "view":
        ours = VIEWS.get(name.lower())
        return newest and ours is not None and text.split() != ours.split()
    if kind not in ("table", "index"):
        return True
    if _BARE.fullmatch(text) and not (_ACTIVE | {"DEFAULT"}).intersection(_WORD.findall(text.upper())):
        return kind == "index" and text.count("(") > 1
    found = meaningful(text)
    if any(token.keyword in _ACTIVE for token in found) or _computes(found):
        return True
    return kind == "index" and sum(token.text == "(" for token in found) > 1


def _computes(found: list[Token]) -> bool:
    """Tell whether a DEFAULT is an expression in brackets."""
    return any(token.keyword == "DEFAULT" and behind.text == "(" for token, behind in pairwise(found))


def _misshapen(connection: sqlite3.Connection, schema: dict[tuple[str, str], str]) -> list[str]:
    """Return what of a catalogue is missing, or has other columns or options."""
    faults = [f"view {name}" for name in VIEWS if ("view", name) not in schema]
    for name, shape in _expected().items():
        if _shape(connection, name, schema.get(("table", name), "")) != shape:
            faults.append(f"table {name}")
    return faults


@cache
def _expected() -> dict[str, _Shape]:
    """Return the shapes of the tables, from an empty catalogue."""
    with closing(sqlite3.connect(":memory:")) as empty:
        for statement in TABLES:
            empty.execute(statement)
        made = empty.execute("SELECT name, sql FROM sqlite_master WHERE type = 'table'").fetchall()
        return {name: _shape(empty, name, text) for name, text in made}


def _shape(connection: sqlite3.Connection, name: str, text: str) -> _Shape:
    """Return the columns of a table, as SQLite tells them, and the options behind them."""
    columns = {
        (column, kind, bool(required), key, hidden)
        for _, column, kind, required, _, key, hidden in connection.execute(f"PRAGMA table_xinfo({name})")
    }
    return columns, set(text.rpartition(")")[2].replace(",", " ").split())
