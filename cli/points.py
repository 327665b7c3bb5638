"""Places as they are given on the command line and in files: numbers, and points one a line."""

import json
import re
import sys
from collections.abc import Callable, Sequence
from typing import Any, TextIO

from orbitdb.errors import InputError
from orbitdb.numerals import real
from orbitdb.plaintext import printable

_MOST = 1_000_000
"""Characters; far more than the points that are taken need."""

_BETWEEN = re.compile(r"\s*[,;\t]\s*|\s+")


def parse_start(text: str) -> list[float]:
    """Read a start such as ``0,0.5,1.2``."""
    try:
        return [real(part) for part in text.split(",")]
    except ValueError as error:
        raise InputError(f"--start: {error}; write x,y,angle, such as 0,0.5,1.2") from None


def read_points(name: str) -> Any:
    """Return the points in a file, or on stdin for ``-``: csv, with or without names, json or json lines.

    Raises
    ------
    InputError
        If it cannot be read, or a line has no two numbers. Whether they are bounces is not looked at.
    """
    text = _text(name).strip()
    shown = "stdin" if name == "-" else printable(name)
    try:
        return _from_json(text) if text[:1] in ("[", "{") else _from_lines(text)
    except (ValueError, RecursionError) as error:
        why = "" if isinstance(error, RecursionError) else f"{error}: "
        raise InputError(f"{shown}: {why}write x,y of one bounce a line, or a json array of pairs") from None


def _text(name: str) -> str:
    try:
        if name == "-":
            return _bounded(sys.stdin)
        with open(name, encoding="utf-8-sig") as file:
            return _bounded(file)
    except UnicodeDecodeError:
        raise InputError(f"{printable(name)} is not text: write x,y of one bounce a line") from None
    except OSError as error:
        raise InputError(f"{printable(name)} cannot be read ({error.strerror})") from None


def _bounded(file: TextIO) -> str:
    text = file.read(_MOST + 1)
    if len(text) > _MOST:
        raise InputError(f"more than {_MOST} characters of points: give those of one trajectory")
    return text


def _from_json(text: str) -> Any:
    """Return the pairs of an array, or x and y of objects in an array or one a line."""
    try:
        found = json.loads(text)
    except json.JSONDecodeError as error:
        if text[0] != "{":
            raise ValueError(f"line {error.lineno} is no json") from None
        found = [_object(line, number) for number, line in enumerate(text.splitlines(), 1) if line.strip()]
    rows = [found] if isinstance(found, dict) else found
    if any(isinstance(row, dict) and not {"x", "y"} <= row.keys() for row in rows):
        raise ValueError("an object has no x and y")
    return [[row["x"], row["y"]] if isinstance(row, dict) else row for row in rows]


def _object(line: str, number: int) -> Any:
    try:
        return json.loads(line)
    except json.JSONDecodeError:
        raise ValueError(f"line {number} is no json") from None


def _from_lines(text: str) -> list[list[float]]:
    """Return two numbers a line, or those in the columns x and y if the first line names them."""
    lines = [(number, line.strip()) for number, line in enumerate(text.splitlines(), 1)]
    rows = [(number, _BETWEEN.split(line)) for number, line in lines if line and not line.startswith("#")]
    take: Callable[[Sequence[str]], Sequence[str]] = list
    if rows and {"x", "y"} <= set(names := rows[0][1]):
        x, y = names.index("x"), names.index("y")
        rows, take = rows[1:], lambda row: [row[place] for place in (x, y) if place < len(row)]
    return [_pair(number, take(row)) for number, row in rows]


def _pair(number: int, values: Sequence[str]) -> list[float]:
    if len(values) != 2:
        raise ValueError(f"line {number} has not two numbers")
    try:
        return [real(value) for value in values]
    except ValueError as error:
        raise ValueError(f"line {number}: {error}") from None
