"""Read arguments given as text: codes, values of a, and the points of a trajectory."""

import json
import re
import sys
from collections.abc import Iterable, Iterator, Sequence
from contextlib import nullcontext
from itertools import chain
from typing import TYPE_CHECKING, Any

from orbitdb.billiard import USUAL_A
from orbitdb.cli.output import note, repeats
from orbitdb.errors import InputError
from orbitdb.text import printable, real, whole

if TYPE_CHECKING:
    from orbitdb.store.connection import Moment

_AROUND = " \t\r\n\ufeff"
"""Characters allowed around a code, including the byte order mark of files from Windows."""


def given_codes(*given: Iterable[str] | None) -> Iterator[str]:
    """Yield the words given as arguments or with ``--code``, unchecked; ``-`` reads one per line of stdin."""
    try:
        for code in chain.from_iterable(codes or () for codes in given):
            if code == "-":
                yield from (code for line in sys.stdin or () if (code := line.strip(_AROUND)))
            else:
                yield code
    except UnicodeDecodeError:
        raise InputError("stdin is not text: write one code per line") from None


def primitive(code: str) -> str:
    """Parse a code; if it repeats a shorter word, write a note and return the shorter word."""
    from orbitdb.symbols.words import parse, primitive_root

    word = parse(code)
    root = primitive_root(word)
    if root != word:
        note(repeats(word, root))
    return root


ALL = "all"
"""The value of --a that stands for every stored a."""


def many_a(asked: Sequence[str] | None) -> bool:
    """Tell whether --a may stand for several values, so that each row must show its a."""
    return asked is not None and (len(asked) > 1 or asked[0] == ALL or ":" in asked[0])


def named(asked: Sequence[str] | float | None) -> tuple[float, ...] | None:
    """Return the values given with --a, without duplicates; None for ``all``, or if --a is not given.

    Raises `InputError` for an invalid value, and for ``all`` together with other values.
    """
    if isinstance(asked, float):
        from orbitdb.billiard.stadium import Stadium

        return (Stadium(asked).a,)
    if not asked:
        return None
    if ALL in asked:
        if len(asked) > 1:
            raise InputError(f"--a {ALL} already means every stored a: leave out the others, or list each a")
        return None
    return tuple(dict.fromkeys(a for text in asked for a in lengths(text)))


def stored(moment: "Moment") -> tuple[float, ...]:
    """Return every a with stored orbits or sums over orbits, or else the default a."""
    from orbitdb.store.lookup import WITH_ORBITS, a_values

    return tuple(a_values(moment, WITH_ORBITS)) or (USUAL_A,)


_MOST_VALUES = 1000
_DIGITS = 6


def lengths(text: str) -> tuple[float, ...]:
    """Parse half lengths from a text such as ``1.6`` or ``0.3:10:40``.

    A grid is logarithmic. Its ends are exact; the values in between are rounded to 6 digits, so that the user
    can type each of them.
    """
    from orbitdb.billiard.stadium import Stadium

    parts = text.split(":")
    if len(parts) not in (1, 3):
        raise InputError(f"--a {text!r:.40}: give one value, or a grid FROM:TO:COUNT such as 0.3:10:40")
    try:
        ends = [Stadium(real(part)).a for part in parts[:2]]
        count = whole(parts[2]) if parts[2:] else 1
    except ValueError as error:
        raise InputError(f"--a: {error}") from None
    if len(ends) == 1:
        return (ends[0],)
    low, high = ends
    if not (low < high and 2 <= count <= _MOST_VALUES):
        raise InputError(
            f"--a {text:.40}: a grid has 2 to {_MOST_VALUES} values, from a smaller a to a larger one"
        )
    inner = (low * (high / low) ** (i / (count - 1)) for i in range(1, count - 1))
    found = (low, *(float(f"{a:.{_DIGITS}g}") for a in inner), high)
    if list(found) != sorted(set(found)):
        raise InputError(f"--a {text:.40}: the ends are too close for {count} values with {_DIGITS} digits")
    return found


_MOST_CHARACTERS = 1_000_000
"""Maximum number of characters to read; no trajectory needs that many."""

_BETWEEN, _INK = re.compile(r"\s*[,;\t]\s*|\s+"), re.compile(r"\S")


def parse_start(text: str) -> list[float]:
    """Parse a starting point and direction such as ``0,0.5,1.2``."""
    try:
        return [real(part) for part in text.split(",")]
    except ValueError as error:
        raise InputError(f"--start: {error}; write x,y,angle, such as 0,0.5,1.2") from None


def read_points(name: str) -> Any:
    """Read points from a file, or from stdin for ``-``, as csv with or without a header, json or json lines.

    Raises `InputError` if the file cannot be read or a line does not have two numbers. Whether the points are
    bounces is not checked.
    """
    text = _text(name).strip()
    shown = "stdin" if name == "-" else printable(name)
    try:
        return _from_json(text) if text[:1] in ("[", "{") else _from_lines(text)
    except (ValueError, RecursionError) as error:
        why = "" if isinstance(error, RecursionError) else f"{error}: "
        raise InputError(f"{shown}: {why}write one bounce x,y per line, or a json array of pairs") from None


def _text(name: str) -> str:
    try:
        with nullcontext(sys.stdin) if name == "-" else open(name, encoding="utf-8-sig") as file:
            text = file.read(_MOST_CHARACTERS + 1)
    except UnicodeDecodeError:
        raise InputError(f"{printable(name)} is not text: write one bounce x,y per line") from None
    except OSError as error:
        raise InputError(f"{printable(name)} cannot be read ({error.strerror})") from None
    if len(text) > _MOST_CHARACTERS:
        raise InputError(f"more than {_MOST_CHARACTERS} characters of points: give only one trajectory")
    return text


def _from_json(text: str) -> Any:
    """Return the pairs in an array, or x and y of each object in an array or on a line of its own."""
    decoder, place, rows = json.JSONDecoder(), 0, []
    try:
        while start := _INK.search(text, place):
            found, place = decoder.raw_decode(text, start.start())
            rows += found if isinstance(found, list) else [found]
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
            points.append([real(value) for value in values])
        except ValueError as error:
            raise ValueError(f"line {number}: {error}") from None
    return points
