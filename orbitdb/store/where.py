"""Run SQL that users write: expressions for ``where``, and the statements of ``orbitdb sql``.

SQLite itself reads the SQL. It runs on a connection that cannot write, may only read and call functions, and
is stopped after `SECONDS` or if it is no longer wanted.
"""

import re
import sqlite3
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from orbitdb.store.connection import Connection, add_code
from orbitdb.store.schema import OF_WORD, SHARED, TABLES, VIEWS
from orbitdb.store.selection import SelectionError
from orbitdb.symbols.words import SYMBOLS, WordError, least_rotation, parse, parse_primitive, primitive_root
from orbitdb.text import guess, line, real, shortened

Value = str | int | float
Parameters = Mapping[str, Value]

SECONDS = 60.0
"""Time limit in seconds for a statement, or for a query with a free expression."""

STEPS_BETWEEN_LOOKS = 200_000
"""SQLite steps between checks, a few milliseconds; a check has to wait while Python is busy."""
_STEPS_BETWEEN_SIGNALS = 1_000_000

READABLE = (*VIEWS, *TABLES)
"""The views and tables, with the views first, which people use most."""

_ONLY_READ = "it may only read, with a single SELECT"
_COLUMNS = (*SHARED, *OF_WORD)
_BLOCK = 2000
_ALLOWED = {
    sqlite3.SQLITE_SELECT,
    sqlite3.SQLITE_READ,
    sqlite3.SQLITE_FUNCTION,
    sqlite3.SQLITE_RECURSIVE,
}
_OF_CLASSES = SHARED.keys() - {"cycle"}  # an index on ids would change the order of the rows
_STOPPED = ("interrupted", "not authorized", "prohibited", "user-defined function")
"""Parts of the messages of SQLite if a function of Python fails or refuses to go on."""


def never() -> bool:
    """Return False: the query is never cancelled."""
    return False


class CancelledError(Exception):
    """The answer is no longer wanted."""


class Patience:
    """How long a query may still run: for a number of seconds from now, unless it is cancelled.

    The `deadline` is a time on the clock of `time.monotonic`. A caller that fetches rows in blocks adds the
    time that passes between the blocks. SQLite calls `look` and `authorize`; if one of them stops the query,
    it leaves the `reason`. Without a reason, it was Ctrl-C that made the call fail.
    """

    def __init__(self, seconds: float | None = None, cancelled: Callable[[], bool] = never) -> None:
        self.deadline = time.monotonic() + (SECONDS if seconds is None else seconds)
        self.cancelled = cancelled
        self.was_cancelled = False
        self.reason = ""

    def look(self) -> bool:
        """Tell SQLite whether to stop, because the time is up or the query has been cancelled."""
        self.was_cancelled = self.cancelled()
        if self.was_cancelled:
            self.reason = "cancelled"
        elif time.monotonic() > self.deadline:
            self.reason = f"it took more than {SECONDS:g} s"
        return bool(self.reason)

    def authorize(self, action: int, _: str | None, name: str | None, *_others: str | None) -> int:
        """Tell SQLite whether the user's SQL may do this."""
        if action in _ALLOWED and name != "load_extension":
            return sqlite3.SQLITE_OK
        self.reason = _ONLY_READ if name != "load_extension" else "it may not load extensions"
        return sqlite3.SQLITE_DENY


@contextmanager
def watched(
    connection: Connection, patience: Patience, sql: str | None = None, what: str = "where"
) -> Iterator[None]:
    """Run a query under a time limit; with `sql`, written by a user, let it only read.

    To fetch more rows later, open another such context with the same `patience`. Raises `CancelledError` if
    the query is cancelled, `KeyboardInterrupt` on Ctrl-C, and a `SelectionError` about the `sql` for any
    other error.
    """
    connection.set_progress_handler(patience.look, STEPS_BETWEEN_LOOKS)
    if sql is not None:
        connection.set_authorizer(patience.authorize)
    try:
        yield
    except (sqlite3.Error, sqlite3.Warning, ValueError, OverflowError) as error:
        if patience.was_cancelled:
            raise CancelledError from error
        if not patience.reason and any(part in str(error) for part in _STOPPED):
            raise KeyboardInterrupt from error
        if sql is None or isinstance(error, SelectionError):
            raise
        raise SelectionError(_refusal(sql, patience.reason or str(error), what)) from error
    finally:
        connection.set_authorizer(None)
        connection.set_progress_handler(never, _STEPS_BETWEEN_SIGNALS)


# expressions


def check(where: str, parameters: Parameters) -> None:
    """Raise `SelectionError` if an expression is invalid."""
    of_classes(where, parameters)


def of_classes(where: str, parameters: Parameters) -> bool:
    """Check an expression; tell whether it has the same value for all words of a class.

    It does if it contains no subquery and reads only columns that the words of a class share.

    Raises
    ------
    SelectionError
        If SQLite cannot compile it, a name has no value, or a code is compared with a number.
    """
    patience, stage = Patience(), _stage()
    columns: set[str | None] = set()
    queries = 0

    def note(action: int, table: str | None, column: str | None, *names: str | None) -> int:
        nonlocal queries
        queries += action == sqlite3.SQLITE_SELECT
        if action == sqlite3.SQLITE_READ and table == "catalogue":
            columns.add(column)
        return patience.authorize(action, table, column, *names)

    with watched(stage, patience, where):
        stage.set_authorizer(note)
        for text in (where, f"(\n{where}\n)"):  # the first refuses a bracket too many
            queries = 0
            stage.execute(f"EXPLAIN SELECT 1 FROM catalogue WHERE {text}", dict(parameters))
        _check_names(where, parameters)
    _check_words(where, parameters)
    return columns <= _OF_CLASSES and queries == 1


_kept = threading.local()


def _stage() -> Connection:
    """Return an empty database, in which a table stands in for the view ``catalogue``."""
    stage: Connection | None = getattr(_kept, "stage", None)
    if stage is None:
        stage = sqlite3.connect(":memory:", factory=Connection)
        for text in (*TABLES.values(), *(text for name, text in VIEWS.items() if name != "catalogue")):
            stage.execute(text)
        columns = ", ".join(_COLUMNS)
        stage.execute(f"CREATE TABLE catalogue ({columns}, PRIMARY KEY (a, p, code)) WITHOUT ROWID")
        add_code(stage)
        _kept.stage = stage
    return stage


# statements


def run_statement(
    connection: Connection, statement: str, parameters: Parameters
) -> tuple[tuple[str, ...], Iterator[tuple[Any, ...]]]:
    """Run a SELECT; return the names of its columns, and an iterator over its rows.

    Raises `SelectionError` if the statement is not a single SELECT, gives two columns the same name, or takes
    too long.
    """
    patience = Patience()
    _check_words(statement, parameters)
    with watched(connection, patience, statement, "sql"):
        _check_names(statement, parameters)
        cursor = connection.execute(statement, dict(parameters))
        if cursor.description is None:
            raise ValueError("write a single SELECT")
    names = tuple(column for column, *_ in cursor.description)
    if twice := [name for place, name in enumerate(names) if name in names[:place]]:
        raise SelectionError(
            _refusal(statement, f"column {twice[0]!r} occurs twice: rename one of them with AS", "sql")
        )
    return names, _fetched(connection, statement, cursor, patience)


def _fetched(
    connection: Connection, statement: str, cursor: sqlite3.Cursor, patience: Patience
) -> Iterator[tuple[Any, ...]]:
    while True:
        with watched(connection, patience, statement, "sql"):
            block = cursor.fetchmany(_BLOCK)
        if not block:
            return
        begun = time.monotonic()
        # BLOBs become hexadecimal digits, which every format can write
        yield from (tuple(v.hex() if isinstance(v, bytes) else v for v in row) for row in block)
        patience.deadline += time.monotonic() - begun  # the time that the caller took


def _refusal(sql: str, message: str, what: str) -> str:
    """Return a message that says which SQL was refused, why, and what to change."""
    _, no_table, name = message.partition("no such table: ")
    if no_table:
        message = f"{message}: {guess(name, READABLE)}it can read {', '.join(READABLE)}"
    elif "no such column" in message:
        name = message.split()[-1]
        where_from = "only catalogue has it; " if name in _COLUMNS else guess(name, _COLUMNS)
        message = f"{message}; {where_from}'orbitdb columns' lists all columns"
    elif "binding" in message.lower():
        message = f"{message.rstrip('.')}: give each :name a value, with -P name=value or in parameters"
    return line(f"{what} {shortened(sql, 200)!r}: {message}")


# words in SQL


_QUOTED = r"'(?:[^']|'')*'"
_ITEM = rf"(?:{_QUOTED}|:\w+|[+-]?\.?\w[\w.]*)"
_LISTED = rf"\(?\s*{_ITEM}(?:\s*,\s*{_ITEM})*"
_SIGN = r"(?:[=<>!]{1,2}|\b(?:is|not|like|glob|in|between)\b)"
_COLUMN = r'(?:\b|")(?:code|representative)\b"?(?!\s*\()'
_CALL = rf"\bcode\s*\(\s*({_ITEM})\s*\)"
_SEARCH = rf"\bcontains\s*\([^,()]*,\s*({_ITEM})\s*\)"
_LIKE = rf"{_COLUMN}\s*(?:not\s+)?(?:like|glob)\s*'[%*]([0-5]+)[%*]'"

_COMPARED = re.compile(
    rf"{_COLUMN}\s*(?:{_SIGN}\s*)+(?!\s*\(?\s*code\s*\()(?P<right>{_LISTED})"
    rf"|(?<![\w.])(?P<left>{_ITEM})\s*(?:{_SIGN}\s*)+{_COLUMN}|{_QUOTED}",
    re.IGNORECASE,
)
_CALLED = re.compile(rf"{_CALL}|{_QUOTED}", re.IGNORECASE)
_SEARCHED = re.compile(rf"{_SEARCH}|{_QUOTED}", re.IGNORECASE)
_CONDITION = re.compile(
    rf"(?:^|\b(?:where|and|or|not|on|when|having)\b)[\s(]*(?:iif\s*\([^()]*,\s*)?{_CALL}(?:\s*,[^()]*)?[\s)]*"
    r"(?:$|\b(?:and|or|then|group|order|limit)\b)",
    re.IGNORECASE,
)
"""A call that is not compared with anything, which is not a condition; SQLite would take it as true."""

_BESIDE_NUMBER = (
    rf"\w\s*(?:{_SIGN}\s*)+\(?\s*(?:{_ITEM}\s*(?:,|\band\b)\s*)*:NAME\b|:NAME\b\s*{_SIGN}\s*\w"
    r"|[-+*/%]\s*:NAME\b|:NAME\b\s*[-+*/%]"
)
"""A name beside a column, or in arithmetic."""

_BETWEEN = re.compile(r"\bbetween\b(?:(?!\band\b).)*$", re.IGNORECASE | re.DOTALL)
_LARGEST_INTEGER = 2**63


def bound_names(sql: str) -> list[str]:
    """Return the names (``:name``) in SQL, outside quotes."""
    return [match[1] for match in re.finditer(rf"{_QUOTED}|(?<!:):([A-Za-z_]\w*)", sql) if match[1]]


def _check_names(sql: str, parameters: Parameters) -> None:
    """Raise `ValueError` if SQL lacks the name of a value."""
    if idle := parameters.keys() - set(bound_names(sql)):
        raise ValueError(f"it has no :{', :'.join(sorted(idle))}: leave out its value")


def _check_words(sql: str, parameters: Parameters) -> None:
    """Raise `SelectionError` if SQL compares a code with a number, or calls a function of words wrongly."""
    for item in (*_compared(sql), *_called(sql), *_searched(sql)):
        value = parameters.get(item[1:]) if item.startswith(":") else None
        if isinstance(value, int | float):
            raise SelectionError(f"{item} is the number {value}, but codes are texts: give it as '{value}'")
        if re.fullmatch(r"[+-]?\.?[0-9][\w.]*", item):
            raise SelectionError(f"codes are texts, so write words in quotes: '{item}', not {item}")
    for item in _called(sql):
        word = item[1:-1] if item.startswith("'") else parameters.get(item[1:])
        try:
            parse_primitive(word) if isinstance(word, str) else None
        except WordError as error:
            raise SelectionError(f"code({item}): {error}") from error
    for item in _searched(sql):
        pattern = item[1:-1] if item.startswith("'") else parameters.get(item[1:])
        if item.lower() == "code":
            raise SelectionError("contains() takes the word first: write contains(code, '0202')")
        try:
            parse(pattern) if isinstance(pattern, str) else None
        except WordError as error:
            raise SelectionError(f"contains(..., {item}): {error}") from error
    for bare in _CONDITION.finditer(sql):
        if not _BETWEEN.search(sql, 0, bare.start()):
            raise SelectionError(f"code({bare[1]}) is a word, not a condition: write code = code({bare[1]})")


def hint(sql: str) -> str | None:
    """Return a hint if SQL compares a code with a word that is not a least rotation, or with part of it."""
    for item in _compared(sql):
        word = item[1:-1]
        if item.startswith("'") and word and set(word) <= set(SYMBOLS):
            root = primitive_root(word)
            if least_rotation(root) != word:
                return f"no row has code = '{word}', as codes are least rotations: write code('{root}')"
    if part := re.search(_LIKE, sql, re.IGNORECASE):
        return f"this misses words that {part[1]} wraps around: write contains(code, '{part[1]}')"
    return None


def _compared(sql: str) -> list[str]:
    """Return the quoted texts, names and numbers that are compared with a column of codes."""
    beside = (match["right"] or match["left"] or "" for match in _COMPARED.finditer(sql))
    return [item for text in beside for item in re.findall(_ITEM, text)]


def _called(sql: str) -> list[str]:
    """Return the quoted texts, names and numbers that SQL passes to ``code()``."""
    return [match[1] for match in _CALLED.finditer(sql) if match[1]]


def _searched(sql: str) -> list[str]:
    """Return the quoted texts, names and numbers that SQL passes to ``contains()`` as patterns."""
    return [match[1] for match in _SEARCHED.finditer(sql) if match[1]]


def parse_parameters(texts: Iterable[str], sql: str) -> dict[str, Value]:
    """Read the values of names in SQL, such as ``cut=0.5`` or ``word=0103``.

    A value in quotes is a text. Digits that could be a word or a number, such as 13, are what they are
    compared with in the SQL.

    Raises
    ------
    SelectionError
        If a text is not of the form ``name=value``, or digits could be a word or a number.
    """
    return dict(_parameter(text, sql) for text in texts)


def _parameter(text: str, sql: str) -> tuple[str, Value]:
    name, sign, value = text.partition("=")
    name, value = name.strip(), value.strip()
    if not sign or not name.isidentifier():
        raise SelectionError(f"-P {text!r}: write it as name=value")
    if len(value) > 1 and value[0] == value[-1] and value[0] in "'\"":
        return name, value[1:-1]
    of_words = (*_compared(sql), *_called(sql), *_searched(sql))
    is_word = f":{name}" in of_words or (len(value) > 1 and value[0] == "0")
    try:
        number: float = real(value)
    except ValueError:
        return name, value
    if not re.fullmatch(r"[+-]?[0-9]+", value):
        return name, number
    if abs(number) >= _LARGEST_INTEGER or (is_word and value.isdigit()):
        return name, value
    if len(value) == 1 or not set(value) <= set(SYMBOLS) or _is_number(name, sql):
        return name, int(value)
    raise SelectionError(
        f"-P {text}: this could be a word or a number: write \"{name}='{value}'\" for the word, "
        f"{name}=+{value} for the number"
    )


def _is_number(name: str, sql: str) -> bool:
    pattern = _BESIDE_NUMBER.replace("NAME", name)
    return name not in bound_names(sql) or re.search(pattern, sql, re.IGNORECASE) is not None
