"""Words in SQL: the function ``code('1232131')``, words without quotes, and the values of ``-P``.

Rows contain the least rotation of a word, which is what ``code()`` returns, so that ``code = code('310')``
finds a word in any rotation. A call that is not compared with anything, ``code('310', '3123')``, is a
condition by itself (`spelled_out`).
"""

import re
import sqlite3
import threading
from collections.abc import Callable, Iterable, Mapping

from orbitdb.numerals import real
from orbitdb.store.schema import LONG
from orbitdb.store.selection import SelectionError
from orbitdb.symbols.pruning import rules_of
from orbitdb.symbols.symmetry import class_of
from orbitdb.symbols.words import (
    MAX_KEYED,
    SYMBOLS,
    WordError,
    key,
    least_rotation,
    parse_primitive,
    primitive_root,
)

Value = str | int | float
Parameters = Mapping[str, Value]

_QUOTED = r"'(?:[^']|'')*'"
_ITEM = rf"(?:{_QUOTED}|:\w+|[+-]?\.?\w[\w.]*)"
_LISTED = rf"\(?\s*{_ITEM}(?:\s*,\s*{_ITEM})*"
_WORDS = re.compile(rf"\s*(?:{_QUOTED}|:\w+|[0-9]+)(?:\s*,\s*(?:{_QUOTED}|:\w+|[0-9]+))*\s*")
_INNER = rf"(?:{_QUOTED}|[^()'])*"
_SIGN = r"(?:[=<>!]{1,2}|\b(?:is|not|like|glob|in|between)\b)"
_CODE = r'(?:\b|")(?:code|representative)\b"?(?!\s*\()'

_CALL = re.compile(rf"{_QUOTED}|\"[^\"]*\"|\bcode\s*\(({_INNER})\)", re.IGNORECASE)
_COMPARED_BEFORE = re.compile(
    r"(?:[=<>!]|\bis(?:\s+not)?|\b(?:like|glob|between|select)|\|\||\bin\s*\((?!\s*(?:select|with)\b)(?:[^()]|\([^()]*\))*)$",
    re.IGNORECASE,
)
_COMPARED_AFTER = re.compile(r"[=<>!]|\|\||(?:not\s+)?\b(?:is|like|glob|in|between)\b", re.IGNORECASE)
_BESIDE_CODE = re.compile(
    rf"{_CODE}\s*(?:{_SIGN}\s*)+(?!\s*\(?\s*code\s*\()(?P<right>{_LISTED})"
    rf"|(?P<left>{_ITEM})\s*(?:{_SIGN}\s*)+{_CODE}|\bcode\s*\((?P<call>{_INNER})\)|{_QUOTED}",
    re.IGNORECASE,
)
_BESIDE_NUMBER = (
    rf"\w\s*(?:{_SIGN}\s*)+\(?\s*(?:{_ITEM}\s*(?:,|\band\b)\s*)*:NAME\b|:NAME\b\s*{_SIGN}\s*\w"
    r"|[-+*/%]\s*:NAME\b|:NAME\b\s*[-+*/%]"
)
"""A name beside a column, or in arithmetic."""

_NUMBER = re.compile(r"[+-]?\.?[0-9][\w.]*")

_last = threading.local()


def add_functions(connection: sqlite3.Connection) -> None:
    """Give a connection the function ``code()``, and those that `spelled_out` writes in its place."""
    for name, function in (("code", _least), ("representative_of", _representative), ("key_of", _key)):
        connection.create_function(name, 1, _complaining(function), deterministic=True)


def _complaining(function: Callable[[object], Value | None]) -> Callable[[object], Value | None]:
    """Keep the message of an error for `complaint`, because SQLite drops it."""

    def call(word: object) -> Value | None:
        try:
            return function(word)
        except WordError as error:
            _last.complaint = f"code(): {error}"
            raise

    return call


def complaint() -> str:
    """Return the last complaint of a function of this thread, once; empty if there is none."""
    message: str = getattr(_last, "complaint", "")
    _last.complaint = ""
    return message


def _least(word: object) -> str:
    if not isinstance(word, str):
        raise WordError("write words in quotes, as in code('1232131')")
    return least_rotation(parse_primitive(word))


def _representative(given: object) -> str | None:
    word = _least(given)
    return None if rules_of(word) else class_of(word).representative


def _key(given: object) -> int | None:
    """Return the id of a word's class; None if it has none or if the word is too long for a key."""
    least = _representative(given)
    return None if least is None or len(least) > MAX_KEYED else key(least)


_LONG_ID = f"SELECT id FROM cycle WHERE id >= {LONG} AND word = representative_of(WORD)"
_ID = f"coalesce(key_of(WORD), ({_LONG_ID}), 0)"
"""SQL for the id of the class of a word, 0 if it is not stored."""


def spelled_out(sql: str, by_class: bool = True) -> str:
    """Write each ``code(...)`` that is a condition by itself in full, so that SQLite looks it up by class.

    Pruned words have no class, so for these leave out `by_class`.
    """

    def condition(found: re.Match[str]) -> str:
        words = found[1]
        before, after = sql[: found.start()].rstrip(), sql[found.end() :].lstrip()
        if words is None or _COMPARED_BEFORE.search(before) or _COMPARED_AFTER.match(after):
            return found[0]
        if not _WORDS.fullmatch(words):
            raise SelectionError("code() takes words in quotes with commas between, as in code('1232131')")
        items = re.findall(_ITEM, words)
        chosen = f"code IN ({', '.join(f'code({item})' for item in items)})"
        ids = ", ".join(_ID.replace("WORD", item) for item in items)
        return f"(cycle IN ({ids}) AND {chosen})" if by_class else f"({chosen})"

    return _CALL.sub(condition, sql)


def check_words(sql: str, parameters: Parameters) -> None:
    """Raise `SelectionError` if a code is compared with a number, in the SQL or among the named values."""
    for item in _beside_codes(sql):
        value = parameters.get(item[1:]) if item.startswith(":") else None
        matched = re.search(rf"\b(?:like|glob)\s*{re.escape(item)}", sql, re.IGNORECASE)  # its digits are
        if isinstance(value, int | float) and not matched:
            raise SelectionError(f"{item} is the number {value}, but codes are texts: give it as '{value}'")
        if _NUMBER.fullmatch(item):
            raise SelectionError(f"codes are texts, so write words in quotes: '{item}', not {item}")


def hint(sql: str) -> str | None:
    """Return a hint if SQL compares a code with a word that is not a least rotation, else None."""
    for item in _beside_codes(sql, calls=False):
        word = item[1:-1]
        if item.startswith("'") and word and set(word) <= set(SYMBOLS):
            root = primitive_root(word)
            if least_rotation(root) != word:
                return f"no row has code = '{word}', as codes are least rotations: write code('{root}')"
    return None


def _beside_codes(sql: str, calls: bool = True) -> list[str]:
    """Return the quoted texts, names and numbers that are compared with a code or, if `calls`, in code()."""
    items: list[str] = []
    for found in _BESIDE_CODE.finditer(sql):
        beside = found["right"] or found["left"] or (calls and found["call"]) or ""
        items += re.findall(_ITEM, beside)
    return items


def parse_parameters(texts: Iterable[str], sql: str) -> dict[str, Value]:
    """Read the values of names in SQL, such as ``cut=0.5`` or ``word=0103``.

    A value in quotes is a text. Digits that could be a word or a number, such as 13, are what they are
    compared with in the SQL.

    Raises
    ------
    SelectionError
        If a text is not of the form ``name=value``, or if digits could be a word or a number.
    """
    return dict(_parameter(text, sql) for text in texts)


_INTEGER = re.compile(r"[+-]?[0-9]+")
_LARGEST_INTEGER = 2**63


def _parameter(text: str, sql: str) -> tuple[str, Value]:
    name, sign, value = text.partition("=")
    name, value = name.strip(), value.strip()
    if not sign or not name.isidentifier():
        raise SelectionError(f"-P {text!r}: write it as name=value")
    if len(value) > 1 and value[0] == value[-1] and value[0] in "'\"":
        return name, value[1:-1]
    try:
        number: float = real(value)
    except ValueError:
        return name, value
    whole = bool(_INTEGER.fullmatch(value))
    if value.isdigit() and value[0] == "0" and len(value) > 1:
        return name, value
    if whole and abs(number) < _LARGEST_INTEGER:
        number = int(value)
    if len(value) == 1 or not set(value) <= set(SYMBOLS):
        return name, number
    if f":{name}" in _beside_codes(sql) or abs(number) >= _LARGEST_INTEGER:
        return name, value
    beside_number = re.search(_BESIDE_NUMBER.replace("NAME", name), sql, re.IGNORECASE)
    if beside_number or name not in bound_names(sql):
        return name, number
    raise SelectionError(
        f"-P {text}: this could be a word or a number: write \"{name}='{value}'\" for the word, "
        f"{name}=+{value} for the number"
    )


def bound_names(sql: str) -> list[str]:
    """Return the names (``:name``) in SQL, outside quotes."""
    return [found[1] for found in NAMES.finditer(sql) if found[1]]


NAMES = re.compile(rf"{_QUOTED}|\"[^\"]*\"|--[^\n]*|(?<!:):([A-Za-z_]\w*)|:")
"""Quoted texts, names with a colon (group 1), and other colons, which SQLAlchemy must not take for names."""
