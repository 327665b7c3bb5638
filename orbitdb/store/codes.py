"""Words in the SQL of users: calls of ``code()``, words without quotes, and the values of ``-P``.

Rows contain the least rotation of a word, which is what SQLite's function ``code()`` returns
(`orbitdb.store.connection`), so that ``code = code('310')`` finds a word in any rotation.
"""

import re
from collections.abc import Iterable, Mapping

from orbitdb.store.selection import SelectionError
from orbitdb.symbols.words import SYMBOLS, WordError, least_rotation, parse_primitive, primitive_root
from orbitdb.text import real

Value = str | int | float
Parameters = Mapping[str, Value]

_QUOTED = r"'(?:[^']|'')*'"
_ITEM = rf"(?:{_QUOTED}|:\w+|[+-]?\.?\w[\w.]*)"
_LISTED = rf"\(?\s*{_ITEM}(?:\s*,\s*{_ITEM})*"
_SIGN = r"(?:[=<>!]{1,2}|\b(?:is|not|like|glob|in|between)\b)"
_COLUMN = r'(?:\b|")(?:code|representative)\b"?(?!\s*\()'
_CALL = rf"\bcode\s*\(\s*({_ITEM})\s*\)"

_BESIDE_COLUMN = re.compile(
    rf"{_COLUMN}\s*(?:{_SIGN}\s*)+(?!\s*\(?\s*code\s*\()(?P<right>{_LISTED})"
    rf"|(?P<left>{_ITEM})\s*(?:{_SIGN}\s*)+{_COLUMN}|{_QUOTED}",
    re.IGNORECASE,
)
_CALLED = re.compile(rf"{_CALL}|{_QUOTED}", re.IGNORECASE)
_CONDITION = re.compile(
    rf"(?:^|\b(?:where|and|or|not|on|when|having)\b)[\s(]*{_CALL}[\s)]*"
    r"(?:$|\b(?:and|or|then|group|order|limit)\b)",
    re.IGNORECASE,
)
"""A call that is not compared with anything, which is not a condition; SQLite would take it as true."""

_BESIDE_NUMBER = (
    rf"\w\s*(?:{_SIGN}\s*)+\(?\s*(?:{_ITEM}\s*(?:,|\band\b)\s*)*:NAME\b|:NAME\b\s*{_SIGN}\s*\w"
    r"|[-+*/%]\s*:NAME\b|:NAME\b\s*[-+*/%]"
)
"""A name beside a column, or in arithmetic."""

_NUMBER = re.compile(r"[+-]?\.?[0-9][\w.]*")
_INTEGER = re.compile(r"[+-]?[0-9]+")
_LARGEST_INTEGER = 2**63

NAMES = re.compile(rf"{_QUOTED}|\"[^\"]*\"|--[^\n]*|(?<!:):([A-Za-z_]\w*)|:")
"""Quoted texts, names with a colon (group 1), and other colons, which SQLAlchemy must not take for names."""


def bound_names(sql: str) -> list[str]:
    """Return the names (``:name``) in SQL, outside quotes."""
    return [match[1] for match in NAMES.finditer(sql) if match[1]]


def check_words(sql: str, parameters: Parameters) -> None:
    """Raise `SelectionError` if SQL compares a code with a number, or calls ``code()`` wrongly."""
    called = _called(sql)
    for item in (*_beside_columns(sql), *called):
        value = parameters.get(item[1:]) if item.startswith(":") else None
        matched = re.search(rf"\b(?:like|glob)\s*{re.escape(item)}", sql, re.IGNORECASE)  # its digits are
        if isinstance(value, int | float) and not matched:
            raise SelectionError(f"{item} is the number {value}, but codes are texts: give it as '{value}'")
        if _NUMBER.fullmatch(item):
            raise SelectionError(f"codes are texts, so write words in quotes: '{item}', not {item}")
    for item in called:
        word = item[1:-1] if item.startswith("'") else parameters.get(item[1:])
        try:
            parse_primitive(str(word)) if word is not None else None
        except WordError as error:
            raise SelectionError(f"code({item}): {error}") from error
    if bare := _CONDITION.search(sql):
        raise SelectionError(f"code({bare[1]}) is a word, not a condition: write code = code({bare[1]})")


def hint(sql: str) -> str | None:
    """Return a hint if SQL compares a code with a word that is not a least rotation, else None."""
    for item in _beside_columns(sql):
        word = item[1:-1]
        if item.startswith("'") and word and set(word) <= set(SYMBOLS):
            root = primitive_root(word)
            if least_rotation(root) != word:
                return f"no row has code = '{word}', as codes are least rotations: write code('{root}')"
    return None


def _beside_columns(sql: str) -> list[str]:
    """Return the quoted texts, names and numbers that are compared with a column of codes."""
    beside = (match["right"] or match["left"] or "" for match in _BESIDE_COLUMN.finditer(sql))
    return [item for text in beside for item in re.findall(_ITEM, text)]


def _called(sql: str) -> list[str]:
    """Return the quoted texts, names and numbers that SQL passes to ``code()``."""
    return [match[1] for match in _CALLED.finditer(sql) if match[1]]


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
    if _INTEGER.fullmatch(value) and abs(number) < _LARGEST_INTEGER:
        number = int(value)
    if len(value) == 1 or not value.isdigit():
        return name, number
    of_words = f":{name}" in (*_beside_columns(sql), *_called(sql))
    if value[0] == "0" or (set(value) <= set(SYMBOLS) and (of_words or abs(number) >= _LARGEST_INTEGER)):
        return name, value
    if not set(value) <= set(SYMBOLS):
        return name, number
    if name not in bound_names(sql) or re.search(_BESIDE_NUMBER.replace("NAME", name), sql, re.IGNORECASE):
        return name, number
    raise SelectionError(
        f"-P {text}: this could be a word or a number: write \"{name}='{value}'\" for the word, "
        f"{name}=+{value} for the number"
    )
