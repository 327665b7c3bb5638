"""A catalogue as a plain list of dicts, built directly from its tables, to check every answer against."""

import re
import sqlite3
from collections import defaultdict
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np

from orbitdb.symbols.symmetry import image_coordinates, members

Row = dict[str, Any]


class Rows(list[Row]):
    """Rows; a short repr keeps them out of the output of failed tests."""

    def __repr__(self) -> str:
        return f"<{len(self)} rows>"


OF_ORBIT = ("status", "length", "lyapunov", "margin", "residual", "error", "length_error", "lyapunov_error",
            "area", "area_error", "iterations", "solver")  # fmt: skip


TEXTS = ("code", "half", "representative", "status", "time_reversal", "symmetry", "solver")
INTEGERS = ("p", "element", "class_size", "walls", "maslov", "cycle", "iterations")


def rows_of(path: Path) -> Rows:
    """Return every word at every a, including pruned words, in natural order."""
    with closing(sqlite3.connect(path)) as plain:
        plain.row_factory = sqlite3.Row
        changes = defaultdict(list)
        for each in plain.execute("SELECT cycle, a, error, kind FROM change ORDER BY cycle, number"):
            changes[each["cycle"]].append(each)
        values = [a for (a,) in plain.execute("SELECT a FROM stadium")]
        stored = plain.execute(
            "SELECT * FROM orbit JOIN cycle ON cycle.id = orbit.cycle"
            " JOIN stadium ON stadium.id = orbit.stadium"
        ).fetchall()
        pruned = plain.execute("SELECT * FROM pruned").fetchall()
    found = [row for each in stored for row in _class(each, changes[each["cycle"]])]
    found += [_pruned(each, a) for each in pruned for a in values]
    return Rows(sorted(found, key=natural))


def natural(row: Row) -> tuple[Any, ...]:
    """Return the key of the natural order."""
    none = row["representative"] is None
    return row["a"], row["p"], none, row["representative"] or row["code"], row["element"] or 0


def _class(stored: sqlite3.Row, changes: list[sqlite3.Row]) -> list[Row]:
    p, least, blob = stored["p"], stored["word"], stored["coordinates"]
    shared = {name: stored[name] for name in ("a", "p", "class_size", "walls", "time_reversal", "symmetry")}
    shared |= {name: stored[name] for name in OF_ORBIT}
    length, lyapunov = stored["length"], stored["lyapunov"]
    shared |= {
        "representative": least,
        "cycle": stored["cycle"],
        "maslov": 3 * p - stored["walls"],
        "lambda_d": None if lyapunov is None else lyapunov / p,
        "lambda_c": None if lyapunov is None else lyapunov / length,
        "lambda_c_error": _error_of_quotient(stored),
        "half": (half := _half(stored["symmetry"])),
        "quarter_length": None if length is None else length / 2 if half else length,
        "quarter_lyapunov": None if lyapunov is None else lyapunov / 2 if half else lyapunov,
        "quarter_maslov": (3 * p - stored["walls"]) // (2 if half else 1),
        "quarter_signs": {None: [1] * 4, "x": [1, 1, -1, -1], "y": [1, -1, 1, -1], "xy": [1, -1, -1, 1]}[
            half
        ],
        "quarter_orientations": max(1, stored["class_size"] // (2 if half else 4)),
        "born": changes[0]["a"] or None if changes else None,
        "dies": changes[1]["a"] if len(changes) > 1 else None,
        "rules": [],
        "changes": [(each["a"], each["error"], each["kind"] == "born") for each in changes],
    }
    found, elements = [], members(least)
    for start in range(0, len(stored["words"]), p):
        word = stored["words"][start : start + p]
        element = elements[word]
        own: list[float] | None = None
        if blob is not None:
            places = np.frombuffer(blob, "<f8")[None, :]
            own = image_coordinates([word], [least], element, places)[0].tolist()
        area = stored["area"]
        if area and element.bit_count() % 2:  # x, y and T each reverse the sense
            area = -area
        found.append({**shared, "code": word, "element": element, "coordinates": own, "area": area})
    return found


_SIGNS = {None: [1, 1, 1, 1], "x": [1, 1, -1, -1], "y": [1, -1, 1, -1], "xy": [1, -1, -1, 1]}


def _half(symmetry: str) -> str | None:
    return next((name for name in ("x", "y", "xy") if name in symmetry.split(",")), None)


def _error_of_quotient(stored: sqlite3.Row) -> float | None:
    if stored["length_error"] is None:
        return None
    quotient = stored["lyapunov"] / stored["length"]
    least = stored["length"] - stored["length_error"]
    exact = (stored["lyapunov_error"] + quotient * stored["length_error"]) / least
    rounding: float = 1.000001 * (exact + 1.2e-16 * quotient)
    return rounding


def _pruned(stored: sqlite3.Row, a: float) -> Row:
    names = ("representative", "cycle", "element", "class_size", "walls", "maslov", "time_reversal",
             "symmetry", "half", "quarter_length", "quarter_lyapunov", "quarter_maslov",
             "quarter_signs", "quarter_orientations", "lambda_d",
             "lambda_c", "lambda_c_error", "born", "dies",
             "coordinates", *OF_ORBIT)  # fmt: skip
    known = {"a": a, "p": stored["p"], "code": stored["word"], "changes": []}
    rules = [int(rule) for rule in stored["rules"].split(",")]
    return {**dict.fromkeys(names), **known, "status": "geometric", "rules": rules}


def chosen(rows: list[Row], criteria: dict[str, Any], conditions: dict[str, Any]) -> list[Row]:
    """Return the rows that criteria choose; for an SQL expression, `conditions` has a Python function."""
    statuses = (criteria.get("status") or usual(criteria)).split(",")
    periods = re.findall(r"(\d+)(?:-(\d+))?", criteria.get("p", "2-99"))
    where = conditions.get(criteria.get("where", ""))
    return [row for row in rows if all(_tests(row, criteria, statuses, periods, where))]


def usual(criteria: dict[str, Any]) -> str:
    """Return the statuses that are meant if none is named; ``solved`` are all but the geometric ones."""
    where = criteria.get("where", "")
    if any(text in where for text in ("rules", "geometric", "status <>")):
        return "all"
    lives = criteria.keys() & {"exists", "not_at", "born", "dies"}
    return "solved" if lives or any(name in where for name in ("status", "born", "dies")) else "orbit"


def _tests(
    row: Row, criteria: dict[str, Any], statuses: list[str], periods: list[tuple[str, str]], where: Any
) -> Iterator[bool]:
    yield row["a"] == criteria.get("a", 1.6)
    yield (
        statuses == ["all"]
        or row["status"] in statuses
        or (statuses == ["solved"] and row["status"] != "geometric")
    )
    yield any(int(low) <= row["p"] <= int(high or low) for low, high in periods)
    yield from (criteria[name] == row[name] for name in ("time_reversal", "symmetry") if name in criteria)
    endless = row["code"] * 20
    yield criteria.get("contains", "") in endless
    yield not any(pattern in endless for pattern in criteria.get("without", ()))
    if criteria.get("opening"):
        yield row["coordinates"] is not None and not _bounces_in(row, criteria["opening"])
    yield all(lives(row, a) for a in criteria.get("exists", ()))
    yield all(row["changes"] and not lives(row, a) for a in criteria.get("not_at", ()))
    yield from (_within(row[name], *_pair(criteria[name])) for name in RANGES if name in criteria)
    yield where is None or bool(where(row))


def _bounces_in(row: Row, openings: list[str]) -> bool:
    """Tell whether a word has a bounce in an interval of the boundary."""
    walls = {"top": "2", "bottom": "0", "left": "14", "right": "35"}
    for opening in openings:
        wall, low, high = opening.split(":")
        for symbol, place in zip(row["code"], row["coordinates"], strict=True):
            if symbol in walls[wall] and float(low or "-inf") <= place <= float(high or "inf"):
                return True
    return False


RANGES = ("length", "lambda_c", "margin", "born", "walls", "quarter_length")


def _pair(bounds: Any) -> tuple[float | None, float | None]:
    return (bounds, bounds) if isinstance(bounds, int) else bounds


def lives(row: Row, at: float) -> bool:
    """Tell whether a word is an orbit at a given a, beyond twice the errors of its births and deaths."""
    known = [(a + 2 * error < at) if born else -(a - 2 * error <= at) for a, error, born in row["changes"]]
    return sum(known) > 0


def left_open(row: Row, at: float) -> bool:
    """Tell whether a given a is within twice the error of a birth or death of a word."""
    return any(abs(a - at) <= 2 * error for a, error, _ in row["changes"])


def _within(value: float | None, low: float | None, high: float | None) -> bool:
    return value is not None and (low is None or value >= low) and (high is None or value <= high)


def in_order(rows: list[Row], order: str) -> list[Row]:
    """Sort rows by columns, last column first because sorts are stable; missing values come last."""
    for part in reversed(order.split(",")):
        name, _, direction = part.strip().lstrip("-").partition(" ")
        falling = part.strip().startswith("-") != (direction == "desc")
        known = [row for row in rows if row[name] not in (None, [])]
        known.sort(key=lambda row: _comparable(row[name]), reverse=falling)
        rows = known + [row for row in rows if row[name] in (None, [])]
    return rows


def _comparable(value: Any) -> Any:
    return ",".join(map(str, value)) if isinstance(value, list) else value


def cut(rows: list[Row], limit: int | None, offset: int) -> list[Row]:
    """Return at most `limit` rows from `offset` on."""
    return rows[offset:] if limit is None else rows[offset : offset + limit]


def by_class(rows: list[Row]) -> list[Row]:
    """Return the row of the least word of each class, with the number of its words; rows in natural order."""
    classes = defaultdict(list)
    for row in rows:
        classes[row["a"], row["representative"] or row["code"]].append(row)
    return [min(own, key=lambda row: str(row["code"])) | {"words": len(own)} for own in classes.values()]


def columns_of(rows: list[Row], names: tuple[str, ...]) -> list[tuple[Any, ...]]:
    """Return the named columns, row by row."""
    return [tuple(row[name] for name in names) for row in rows]
