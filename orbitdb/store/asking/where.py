"""SQL expressions that choose rows (``--where``), and what they may read and call.

An expression may read the columns of the view, call the functions of `FUNCTIONS`, and contain subqueries that
each read the view once; ``code('1232131')`` is replaced first (`spelled_out`). Everything else is refused
before SQLite runs any of it. What remains is bounded: no function makes a text longer, and no subquery
contains another subquery or a join, so neither the compiled program nor a result can outgrow the catalogue.
A query is stopped after `orbitdb.store.asking.limits.SECONDS`.
"""

import sqlite3
from collections.abc import Callable, Sequence, Set
from contextlib import closing
from itertools import pairwise
from typing import TypeAlias

import sqlalchemy as sa

from orbitdb.plaintext import guess, line, shortened
from orbitdb.store.asking.codes import spelled_out
from orbitdb.store.asking.selection import SelectionError
from orbitdb.store.file.tables import catalogue
from orbitdb.store.file.tokens import Token, meaningful, tokens

FUNCTIONS = {
    "avg", "count", "max", "min", "sum", "total",
    "coalesce", "ifnull", "iif", "nullif", "typeof",
    "glob", "instr", "length", "like", "lower", "replace", "substr", "substring", "upper",
    "abs", "ceil", "ceiling", "floor", "mod", "pow", "power", "round", "sign", "sqrt", "trunc",
    "exp", "ln", "log", "log10", "log2", "degrees", "pi", "radians",
    "acos", "acosh", "asin", "asinh", "atan", "atan2", "atanh", "cos", "cosh", "sin", "sinh", "tan", "tanh",
}  # fmt: skip
"""The functions that an expression may call.

Only these are allowed, because versions and extensions of SQLite have many others: some make texts of any
size (printf, group_concat, zeroblob), some decode binary data.
"""

LONGEST = 20_000
"""Maximum length of an expression with its values; `_LONGEST_WITH_SUBQUERY` if it has a subquery."""

_LONGEST_WITH_SUBQUERY = 4_000
_WORDS = {
    "and", "between", "case", "cast", "collate", "distinct", "else", "end", "escape", "exists", "from",
    "glob", "in", "is", "isnull", "like", "nocase", "not", "notnull", "null", "or", "select", "then",
    "when", "where", *FUNCTIONS, *catalogue.c.keys(),
}  # fmt: skip
"""The words that an expression may use; an unfinished one may end in the beginning of one of them."""

Parameters = dict[str, str | int | float]
Authorizer: TypeAlias = Callable[[int, str | None, str | None, str | None, str | None], int]


def expression(where: str, parameters: Parameters) -> sa.TextClause:
    """Return an expression as an SQL clause, bound to its named values."""
    parts, used = [], {}
    for token in tokens(spelled_out(where, parameters)):
        name = token.text[1:]
        if token.kind == "value" and name in parameters:
            used[name] = parameters[name]
            parts.append(token.text)
        else:
            parts.append(token.text.replace(":", "\\:"))
    return sa.text(f"(\n{''.join(parts)}\n)").bindparams(**used)


def check(where: str, parameters: Parameters) -> None:
    """Raise `SelectionError`, with the reason, unless the text is a single expression over the view."""
    try:
        check_size(where, parameters)
        plain = spelled_out(where, parameters)
        check_size(plain, parameters)
        _check_shape(meaningful(plain))
        check_names(where, parameters)
        for text in (plain, f"(\n{plain}\n)"):
            _compile(text, parameters, allowing({catalogue.name}))
    except (sqlite3.Error, sqlite3.Warning, ValueError, OverflowError) as error:
        message = "it is not text in UTF-8" if isinstance(error, UnicodeError) else str(error)
        if message.endswith('\n"'):  # the line end added by `_compile`
            message = f'{message[:-2]}"'
        raise refusal(where, message) from error


def names_in(where: str) -> set[str]:
    """Return the names (``:name``) that an expression uses."""
    return {token.text[1:] for token in tokens(where) if token.kind == "value"}


def unfinished(where: str, reason: str) -> bool:
    """Tell whether an expression may just be unfinished, given the reason why `check` refused it."""
    found = tokens(where)
    if "incomplete input" in reason or any(t.kind == "sign" and t.text in "'\"`[" for t in found):
        return True
    last = found[-1] if found else Token("blank", "")
    if last.kind == "number":
        return "unrecognized token" in reason
    if last.kind == "value" or last.text == ":":
        return "-P" in reason
    blamed = f'near "{last.text}"' in reason or f"no such column: {last.text};" in reason
    begun = last.text.lower()
    return last.kind == "word" and blamed and any(n.startswith(begun) and n != begun for n in _WORDS)


def check_size(where: str, parameters: Parameters) -> None:
    """Raise `ValueError` if an expression is too long; the work of `instr` grows with the length squared."""
    size = len(where) + sum(len(str(value)) for value in parameters.values())
    if size > LONGEST:
        raise ValueError(f"it has {size} characters with its values; at most {LONGEST} are allowed")


def check_names(where: str, parameters: Parameters) -> None:
    """Raise `ValueError` if a value's name is not in the expression; SQLite reports names without a value."""
    if idle := [name for name in parameters if name not in names_in(where)]:
        raise ValueError(f"it has no :{', :'.join(idle)}: leave out its value")


def _check_shape(found: list[Token]) -> None:
    """Raise `ValueError` for subqueries that could grow without limit, and for placeholders without a name.

    SQLite copies the definition of a name to every place that uses it. So a short text with WITH or nested
    subqueries can become a program of any size, and one with joins can have a result of any size.
    """
    levels = [_Level()]
    for token, behind in pairwise([*found, Token("sign", "")]):
        if token.text == "(":
            levels.append(_Level())
        elif token.text == ")" and len(levels) > 1:
            levels.pop()
        elif token.text in tuple(":?@#$"):
            raise ValueError("write a value as :name, and give it with -P name=value")
        elif token.keyword == "WITH":
            raise ValueError("WITH may not be used")
        elif token.keyword in ("SELECT", "VALUES"):
            if any(level.subquery for level in levels[:-1]):
                raise ValueError("a subquery may not contain another one")
            levels[-1] = _Level(subquery=True)
        elif token.text.strip("\"'`[]").lower() == catalogue.name and behind.text != ".":
            inner = next((level for level in reversed(levels) if level.subquery), levels[0])
            inner.tables += 1
            if inner.tables > 1:
                raise ValueError("a subquery may read the catalogue only once")
    if any(token.keyword in ("SELECT", "VALUES") for token in found):
        size = sum(len(token.text) for token in found)
        if size > _LONGEST_WITH_SUBQUERY:
            raise ValueError(
                f"it has {size} characters; with a subquery, at most {_LONGEST_WITH_SUBQUERY} are allowed"
            )


class _Level:
    """A pair of brackets: whether it contains a subquery, and how many tables the subquery reads."""

    def __init__(self, subquery: bool = False) -> None:
        self.subquery = subquery
        self.tables = 0


def same_for_class(where: str, parameters: Parameters, shared: Set[str]) -> bool:
    """Tell whether a checked expression reads only columns with the same value for all words of a class."""
    columns, selects = set(), 0

    def note(action: int, first: str | None, second: str | None, _base: str | None, _view: str | None) -> int:
        nonlocal selects
        if action == sqlite3.SQLITE_READ:
            columns.add(second)
        elif action == sqlite3.SQLITE_SELECT:
            selects += 1
        return sqlite3.SQLITE_OK

    _compile(spelled_out(where, parameters), parameters, note)
    return columns <= shared and selects == 1


def _compile(where: str, parameters: Parameters, authorize: Authorizer) -> None:
    """Compile an expression in an empty database, in which a table stands in for the view."""
    columns = ", ".join(catalogue.c.keys())
    with closing(sqlite3.connect(":memory:")) as stage:
        stage.execute(f"CREATE TABLE catalogue ({columns}, PRIMARY KEY (a, p, code)) WITHOUT ROWID")
        stage.set_authorizer(authorize)
        stage.execute(f"EXPLAIN SELECT 1 FROM catalogue WHERE {where}\n", parameters)


def allowing(
    readable: Set[str],
    views: Set[str] = frozenset(),
    behind: Set[str] = frozenset(),
    more: str | None = None,
    own: Set[str] = frozenset(),
) -> Authorizer:
    """Return an authorizer that allows expressions, the listed functions plus `more`, and some reads.

    The tables and views in `readable` may be read, and any table through the views in `views`. The tables in
    `behind` may also be read without a column, because SQLite reads none and names no view if it only checks
    that a row exists. If a view in `own` is read, it must be the connection's own, not that of the file.
    """

    def authorize(
        action: int, first: str | None, second: str | None, base: str | None, view: str | None
    ) -> int:
        seen = first in readable or view in views or (first in behind and not second)
        seen = seen and (first not in own or base == "temp")
        allowed = (
            action == sqlite3.SQLITE_SELECT
            or (action == sqlite3.SQLITE_READ and seen)
            or (action == sqlite3.SQLITE_FUNCTION and second in {*FUNCTIONS, more})
        )
        return sqlite3.SQLITE_OK if allowed else sqlite3.SQLITE_DENY

    return authorize


def refusal(
    where: str,
    message: str,
    what: str = "where",
    readable: Sequence[str] = ("the columns of the catalogue",),
) -> SelectionError:
    """Return the error for an expression that was refused, with a message that says what to change."""
    _, table, name = message.partition("no such table: ")
    if "authorized to use function" in message:
        name = message.rpartition(" ")[2]
        message = f"{name}() may not be called; the allowed functions are {', '.join(sorted(FUNCTIONS))}"
    elif table or any(part in message for part in ("not authorized", "prohibited", "vtable")):
        told = f"there is no {name}: {guess(name, readable)}" if table else ""
        message = f"{told}it may read {', '.join(readable)} and nothing else"
    elif "no such column" in message:
        name = message.split()[-1]
        meant = "only catalogue has it; " if name in catalogue.c else guess(name, catalogue.c.keys())
        message = f"{message}; {meant}'orbitdb columns' lists all columns"
    elif "binding" in message:
        message = f"{message.rstrip('.')}: give each name a value with -P name=value"
    elif "user-defined function" in message:
        message = "replace() takes texts only, and may not make them longer"
    return SelectionError(line(f"{what} {shortened(where, 200)!r}: {message}"))
