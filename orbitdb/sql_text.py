"""The text of SQL that users write: the names and the words in it, and the values that names get."""

import re
from collections.abc import Iterable, Mapping
from numbers import Integral, Real

from orbitdb.errors import SelectionError
from orbitdb.symbols.words import SYMBOLS, least_rotation
from orbitdb.text import real

Value = str | int | float
Parameters = Mapping[str, Value]

LEXED = re.compile(
    r"""'[^']*'|"[^"]*"|`[^`]*`|\[[^\]]*\]|--[^\n]*|/\*.*?(?:\*/|\Z)|[:@$](?P<name>[^\W\d]\w*)?""", re.DOTALL
)
"""Quoted parts, comments and names of values in SQL."""

_OF_CODES = {"code", "codes", "representative", "word", "words", "contains"}
"""The columns of views and tables that hold codes, and the functions of words."""

_LARGEST = 2**63
"""SQLite's whole numbers are less than this; larger ones become real numbers."""

_AS_TYPED = re.compile(
    r"\b(?:code|representative|word)\s*(?:[=<>!]+|in\s*\()\s*'?([0-5]{2,})\b", re.IGNORECASE
)
_WORDS = re.compile(r"(\bcode\s*\(\s*)?'([0-5]{2,})'", re.IGNORECASE)
_WITH_ZEROS = re.compile(r"(?<![\w.])0+([1-9][0-9]*)(?![\w.])")


def on_codes(sql: str) -> str:
    """Return a sentence that says how to write the words in an expression or a statement.

    It is empty if the SQL names no codes, or has its words as least rotations or with ``code()``.
    """
    words = _WORDS.findall(sql)
    if not reads_codes(sql) or (words and all(call or least_rotation(word) == word for call, word in words)):
        return ""
    typed = _AS_TYPED.search(sql)
    example = f"code('{typed[1] if typed else '31'}')"
    return f"codes are texts, each the least rotation of its word: write words with code(), such as {example}"


def as_typed(message: str, sql: str) -> str:
    """Give the numbers in a message the zeros with which they begin in SQL, which SQLite drops."""
    for typed in _WITH_ZEROS.finditer(LEXED.sub("", sql)):
        message = re.sub(rf"(?<![\w.]){typed[1]}(?![\w.])", typed[0], message)
    return message


def reads_codes(sql: str) -> bool:
    """Tell whether an expression or a statement names a column or a function of codes."""
    return not _OF_CODES.isdisjoint(re.findall(r"\w+", LEXED.sub("", sql).lower()))


def names_in(sql: str) -> set[str]:
    """Return the names and keywords in an expression in lower case, quoted names among them."""

    def kept(part: re.Match[str]) -> str:
        return part[0][1:-1] if part[0][0] in '"`[' else " "

    return set(re.findall(r"[^\W\d]\w*", LEXED.sub(kept, sql).lower()))


def bound_names(sql: str) -> set[str]:
    """Return the names (``:name``) in an expression or a statement."""
    return {part["name"] for part in LEXED.finditer(sql) if part["name"]}


def parse_parameters(texts: Iterable[str], sql: str) -> dict[str, Value]:
    """Read the values of names in SQL, such as ``cut=0.5`` or ``word=0103``.

    A value in quotes is a text, and so are digits that begin with 0.

    Raises
    ------
    SelectionError
        If a text is not of the form ``name=value``, or digits such as 13 could be a word or a number in SQL
        that reads codes.
    """
    found = [_parameter(text, sql) for text in texts]
    names = [name for name, _ in found]
    if twice := [name for place, name in enumerate(names) if name in names[:place]]:
        raise SelectionError(f"--parameter {twice[0]} is given twice: give it once")
    return dict(found)


def _parameter(text: str, sql: str) -> tuple[str, Value]:
    name, sign, value = text.partition("=")
    name, value = name.strip(), value.strip()
    if not sign or not name.isidentifier():
        raise SelectionError(f"--parameter {text!r}: write it as name=value")
    if len(value) > 1 and value[0] == value[-1] and value[0] in "'\"":
        return name, value[1:-1]
    try:
        number: float = real(value)
    except ValueError:
        return name, value
    if not re.fullmatch(r"[+-]?[0-9]+", value):
        return name, number
    if abs(number) >= _LARGEST or (len(value) > 1 and value[0] == "0"):
        return name, value
    if len(value) == 1 or not set(value) <= set(SYMBOLS) or not reads_codes(sql):
        return name, int(value)
    raise SelectionError(
        f"--parameter {text}: this could be a word or a number: write \"{name}='{value}'\" for the word, "
        f"{name}=+{value} for the number"
    )


def plain_values(parameters: Mapping[str, object]) -> dict[str, str | int | float]:
    """Return values of names in SQL as texts and numbers that SQLite stores as such."""
    if not isinstance(parameters, Mapping):
        raise SelectionError(f"parameters = {parameters!r:.40}: give a dict of values for names in the SQL")
    if odd := [name for name in parameters if not str(name).isidentifier()]:
        raise SelectionError(f"parameters: {odd[0]!r:.40} is not a name such as :cut")
    return {name: plain_value(name, value) for name, value in parameters.items()}


def plain_value(name: str, value: object) -> str | int | float:
    """Return a text or a number of any type as one that SQLite stores as such.

    Raises `SelectionError`, which names the value, for anything else.
    """
    if isinstance(value, str):
        return str(value)
    if isinstance(value, Real):
        return plain_number(name, value)
    raise SelectionError(f"{name} = {value!r:.40}: give a number or a text")


def plain_number(name: str, value: Real) -> int | float:
    """Return a number of any type as one of Python; raise `SelectionError` if it is too large."""
    try:
        whole = int(value) if isinstance(value, Integral) else None
        return float(value) if whole is None or abs(whole) >= _LARGEST else whole
    except OverflowError:
        raise SelectionError(f"{name}: {value!r:.20}... is too large") from None
