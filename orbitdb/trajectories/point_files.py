"""Read points of a trajectory from files: a pair per line, a table, or json."""

import json
import re
import sys
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import numpy as np

from orbitdb.arrays import Floats
from orbitdb.errors import InputError, as_floats
from orbitdb.text import printable, real_in_file

_MOST_CHARACTERS = 1_000_000
"""Maximum number of characters to read; no trajectory needs that many."""

_BETWEEN, _INK = re.compile(r"\s*[,;\t]\s*|\s+"), re.compile(r"\S")


def read_points(path: Path | str) -> Floats:
    """Return the points in a file, such as the bounces of a measured trajectory, as pairs x, y.

    `Catalogue.identify` takes them. The file has one x,y per line, separated by a comma, semicolon, tab or
    blanks, or is csv with a header that names x and y (lines that begin with # are comments), a json array
    of pairs or of objects with x and y, or json lines. Whether the points are bounces is not checked.

    Parameters
    ----------
    path : path
        The file; ``-`` reads stdin.

    Returns
    -------
    ndarray, shape (N, 2)
        The pairs in the order of the file, in its unit; the unit of `Catalogue.identify` is the radius.

    Raises
    ------
    InputError
        If the file cannot be read, or a line does not have two numbers.
    """
    from_stdin = str(path) == "-"
    name = "stdin" if from_stdin else printable(str(path))
    try:
        with nullcontext(sys.stdin) if from_stdin else open(path, encoding="utf-8-sig") as file:
            text = file.read(_MOST_CHARACTERS + 1).strip()
        if len(text) > _MOST_CHARACTERS:
            raise ValueError(f"it has more than {_MOST_CHARACTERS} characters")
        points = _from_json(text) if text[:1] in ("[", "{") else _from_lines(text)
        return _as_pairs(points)
    except OSError as error:
        raise InputError(f"{name} cannot be read ({error.strerror})") from None
    except (ValueError, RecursionError) as error:
        why = "not text" if isinstance(error, UnicodeDecodeError) else str(error)
        raise InputError(f"{name}: {why}: write one bounce x,y per line, or a json array of pairs") from None


def _as_pairs(points: list[Any]) -> Floats:
    pairs = as_floats(points or np.zeros((0, 2)), "these are not pairs x,y of numbers")
    if pairs.ndim != 2 or pairs.shape[1] != 2:
        raise ValueError("these are not pairs x,y of numbers")
    return pairs


def _from_json(text: str) -> Any:
    """Return the pairs in an array, or x and y of each object in an array or one after another."""
    decoder, place, rows = json.JSONDecoder(), 0, []
    try:
        while start := _INK.search(text, place):
            value, place = decoder.raw_decode(text, start.start())
            rows += value if isinstance(value, list) else [value]
    except json.JSONDecodeError as error:
        raise ValueError(f"line {error.lineno} is not json") from None
    if any(isinstance(row, dict) and not {"x", "y"} <= row.keys() for row in rows):
        raise ValueError("an object lacks x or y")
    return [[row["x"], row["y"]] if isinstance(row, dict) else row for row in rows]


def _from_lines(text: str) -> list[list[float]]:
    """Return the two numbers on each line, or the columns x and y if the first line names columns."""
    lines = [(number, line.strip()) for number, line in enumerate(text.splitlines(), 1)]
    rows = [(number, _BETWEEN.split(line)) for number, line in lines if line and not line.startswith("#")]
    named = bool(rows) and {"x", "y"} <= set(rows[0][1])
    places = [rows[0][1].index(name) for name in "xy"] if named else []
    points = []
    for number, cells in rows[named:]:
        values = [cells[place] for place in places if place < len(cells)] if named else cells
        if len(values) != 2:
            raise ValueError(f"line {number} does not have two numbers")
        try:
            points.append([real_in_file(value) for value in values])
        except ValueError as error:
            raise ValueError(f"line {number}: {error}") from None
    return points
