"""Find the classes and words of a chosen subset; every query for a selection comes through here.

Conditions with the same value for all words of a class are one query of the view `class`. Conditions on
single words are one query of the view `catalogue`. Orders of single words are sorted in memory, because
SQLite takes ten times as long to sort that many rows.

Geometrically pruned words have no class; they are found only if the selection names their status.
"""

import math
import re
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from orbitdb.columns import IN_CATALOGUE
from orbitdb.orbits.status import Status
from orbitdb.store.connection import Connection
from orbitdb.store.fills import of_spans
from orbitdb.store.lives import NEAR
from orbitdb.store.rows import OF_ONE_WORD, Chosen, as_array, sorted_words, stabilisers_of
from orbitdb.store.schema import BORN, DIED, LONG, OF_CLASS, PRUNED_ROWS, SHARED, id_of_class
from orbitdb.store.selection import Selection, SelectionError, unknown_column
from orbitdb.store.where import Patience, never, of_classes, watched
from orbitdb.symbols.pruning import rules_of
from orbitdb.symbols.symmetry import ODD, class_of, members, places_of_elements

COLUMNS = tuple(column.name for column in IN_CATALOGUE)
"""The columns of the view ``catalogue``."""

_CODED = "(cycle << 2) + (class_size > 1) + (class_size > 2) + (class_size > 4) AS coded"
"""Id and size of a class in a single integer, because a second column would take half as long again."""

_AREA = f"iif(element IN {tuple(ODD)}, 0.0 - area, area)"
"""The area of the representative, from that of a word."""

BLOCK = 1 << 14

_FEW = 1 << 16
"""Above this many rows, SQLite sorts everything faster than it keeps the first N."""

_LARGEST = 2**63 - 1
"""SQLite's largest integer."""


def choose(
    connection: Connection,
    selection: Selection,
    order: str = "p",
    columns: Sequence[str] = (),
    most: int | None = None,
    counted: bool = False,
    cancelled: Callable[[], bool] = never,
    by_class: bool = False,
) -> Chosen:
    """Find a chosen subset in the catalogue.

    Parameters
    ----------
    connection, selection
    order : str, optional
        Columns to sort by, separated by commas; ``desc`` after a name, or ``-`` before it, reverses the
        order. Ties are broken by period, representative and element, in ascending order.
    columns : sequence of str, optional
        Further columns of the view ``class`` to read.
    most : int, optional
        Number of rows that are needed, from the first on; later rows may be in any order, or missing.
    counted : bool, optional
        Whether the total number of rows is needed even so.
    cancelled : callable, optional
        Called now and then; if it returns True, `CancelledError` is raised.
    by_class : bool, optional
        Whether a class with chosen words has one row, for its representative.
    """
    keys = parse_order(order)
    if by_class:
        renamed = {"representative" if name == "code" else name: falls for name, falls in keys.items()}
        keys = {name: falls for name, falls in renamed.items() if name != "element"}
    by_words = not by_class and any(name in keys for name in OF_ONE_WORD)
    of_words = not is_of_classes(selection)
    names = [*columns, *(["symmetry", *(name for name in keys if name not in columns)] if by_words else [])]
    query, values = _classes(connection, selection, of_words, {} if by_words else keys, names)
    sorted_far = order != "p" and (most or 0) > _FEW
    if most is not None and not (counted or by_words or sorted_far):
        query += f" LIMIT {min(most, _LARGEST)}"  # every class has at least one row
    own = ["mask", "symmetry"] if of_words else []
    with _answering(connection, selection, cancelled):
        coded, *more = _arrays(connection, query, values, ("coded", *own, *names))
    sizes = np.uint8(1) << (coded & 3).astype(np.uint8)
    masks = ((np.uint16(1) << sizes) - 1).astype(np.uint8)
    ids = np.right_shift(coded, 2, out=coded)
    if of_words:
        elements, symmetries = more.pop(0).astype(np.uint8), more.pop(0)
        masks &= places_of_elements(elements, stabilisers_of(symmetries))
    if by_class:
        masks = np.ones_like(masks)
    read = dict(zip(names, more, strict=True))
    chosen = Chosen(selection, ids, masks, None, {name: read[name] for name in columns})
    return replace(chosen, rows=sorted_words(connection, chosen, keys, read)) if by_words else chosen


def _answering(
    connection: Connection, selection: Selection, cancelled: Callable[[], bool]
) -> AbstractContextManager[None]:
    """Return a context in which to query a subset; it confines the expression of the subset, if any."""
    if selection.where is not None:
        return watched(connection, Patience(cancelled=cancelled), selection.where)
    return nullcontext() if cancelled is never else watched(connection, Patience(math.inf, cancelled))


def _classes(
    connection: Connection,
    selection: Selection,
    of_words: bool,
    keys: Mapping[str, bool],
    columns: Sequence[str],
) -> tuple[str, dict[str, Any]]:
    """Return the query for the classes in order, and its values: coded ids, then `columns`.

    If the subset is `of_words`, the elements of the chosen words and the symmetry follow the coded ids.
    """
    names = dict.fromkeys(["p", *columns, *keys])
    listed = [
        _CODED,
        "representative AS least",
        *(f"{_of_class(name, of_words)} AS {name}" for name in names),
    ]
    lone, outputs = ["id * 4 AS coded", "code AS least", *names], ["coded", *columns]
    if of_words:
        listed += ["sum(1 << element) AS mask", "iif(class_size < 8, symmetry, '1') AS own"]
        lone += ["1 AS mask", "NULL AS own"]
        outputs[1:1] = ["mask", "own"]
    where, values = condition_of(selection)
    view, grouped = ("catalogue", "GROUP BY cycle") if of_words else ("class AS catalogue", "")
    stored = f"SELECT {', '.join(listed)} FROM {view} WHERE {where} {grouped}"
    pruned = f"SELECT {', '.join(lone)} FROM {PRUNED_ROWS} AS catalogue WHERE {where}"
    sources = [stored] if selection.statuses != (Status.GEOMETRIC,) else []
    sources += [pruned] if Status.GEOMETRIC in selection.statuses else []
    query = f"SELECT {', '.join(outputs)} FROM ({' UNION ALL '.join(sources)})"
    order = _order_of_classes(keys, _is_mixed(connection, selection))
    return f"{query} ORDER BY {', '.join(order)}" if order else query, values


def _is_mixed(connection: Connection, selection: Selection) -> bool:
    """Tell whether there may be words, pruned or long, whose ids do not increase with the period."""
    long = "SELECT EXISTS (SELECT 1 FROM cycle WHERE id >= ?)"
    return Status.GEOMETRIC in selection.statuses or bool(connection.scalar(long, (LONG,)))


def _order_of_classes(keys: Mapping[str, bool], mixed: bool) -> list[str]:
    """Return the sort keys of classes in SQL; there are none for the natural order, which the views have.

    The rows have ``p``, ``least`` (the representative), ``coded`` (`_CODED`) and the columns in `keys`, each
    with whether its order is descending.
    """
    natural = ["coded"]
    if mixed:
        natural = ["p", "coded < 0", f"iif(abs(coded) >= {4 * LONG}, least, NULL)", "abs(coded)"]
        keys = keys or {"p": False}
    elif [*keys.items()][-1:] == [("p", False)]:
        keys = dict([*keys.items()][:-1])  # because ids increase with the period
    # NULL is SQLite's least value, so it comes last in descending orders anyway
    sorting = [f"{name} DESC" if falls else f"{name} ASC NULLS LAST" for name, falls in keys.items()]
    return [*sorting, *natural] if keys else []


def _of_class(name: str, of_words: bool) -> str:
    """Return a column of a class from either view; the area is that of the representative."""
    if name == "area" and of_words:
        return _AREA
    return name if name in SHARED or (name in OF_CLASS and not of_words) else "NULL"


def _arrays(
    connection: Connection, query: str, values: Mapping[str, Any], names: Sequence[str]
) -> list[NDArray[Any]]:
    parts = [[_as_column(name, ()) for name in names]]
    cursor = connection.execute(query, values)
    while rows_of_block := cursor.fetchmany(BLOCK):  # so that few objects are in memory at a time
        columns = zip(names, zip(*rows_of_block, strict=True), strict=True)
        parts.append([_as_column(name, column) for name, column in columns])
    return [np.concatenate(column) for column in zip(*parts, strict=True)]


def _as_column(name: str, values: Sequence[Any]) -> NDArray[Any]:
    if name in ("coded", "mask"):
        return np.array(values, np.int64)
    return as_array(name, values)


# where a word is among the rows


def position_of(connection: Connection, chosen: Chosen, word: str) -> int | None:
    """Return the row number of a code in the subset, or None if it is not there."""
    if rules_of(word):
        lone = connection.scalar("SELECT id FROM pruned WHERE p = ? AND word = ?", (len(word), word))
        return None if lone is None else chosen.position(lone, 0)
    representative = class_of(word).representative
    place = [*members(representative)].index(word)
    return chosen.position(id_of_class(connection, representative), place)


def first_where(
    connection: Connection, chosen: Chosen, condition: str, cancelled: Callable[[], bool] = never
) -> int | None:
    """Return the number of the first row that meets a further condition, in SQL, or None."""
    where = chosen.selection.where
    both = f"(\n{where}\n) AND {condition}" if where else condition
    part = choose(connection, replace(chosen.selection, where=both), cancelled=cancelled)
    masks, by_id = np.zeros_like(chosen.masks), np.argsort(chosen.ids)
    masks[by_id[np.searchsorted(chosen.ids, part.ids, sorter=by_id)]] = part.masks
    return chosen.first(masks)


# conditions and orders as SQL


_ORDER = re.compile(r"(-?)(\w+)(?:\s+(asc|desc))?", re.IGNORECASE)


def condition_of(selection: Selection) -> tuple[str, dict[str, Any]]:
    """Return a selection as a condition on a view with the name ``catalogue``, and the values of its names.

    The expression of the selection must have been checked (`is_of_classes`).
    """
    values: dict[str, Any] = {**selection.parameters, "0": selection.a}  # names of users begin with no digit

    def bound(value: object) -> str:
        name = str(len(values))
        values[name] = value
        return f":{name}"

    statuses = ", ".join(f"'{status.value}'" for status in selection.statuses)
    conditions = ["a = :0", of_spans(selection.periods)]
    if statuses:
        conditions.append(f"status IN ({statuses})")
    if selection.time_reversal:
        conditions.append(f"time_reversal = {bound(selection.time_reversal)}")
    if selection.symmetry:
        conditions.append(f"symmetry = {bound(selection.symmetry)}")
    conditions += [f"{_LIVES.format(a=bound(a))} > 0" for a in selection.exists]
    conditions += [f"{_LIVES.format(a=bound(a))} <= 0" for a in selection.not_at]
    for name, (low, high) in selection.ranges.items():
        conditions += [] if low is None else [f"{name} >= {bound(low)}"]
        conditions += [] if high is None else [f"{name} <= {bound(high)}"]
    if selection.contains is not None:
        conditions.append(_has(selection.contains, bound(selection.contains)))
    conditions += [f"NOT {_has(pattern, bound(pattern))}" for pattern in selection.without]
    if selection.where is not None:
        conditions.append(f"(\n{selection.where}\n)")
    return " AND ".join(conditions), values


def _has(pattern: str, name: str) -> str:
    """Return the condition that a cyclic word contains a pattern, the value of a name.

    SQLite's own function is faster, but sees all positions only if the pattern is short enough.
    """
    return f"iif(p >= {len(pattern) - 1}, instr(code || code, {name}) > 0, contains(code, {name}))"


_LIVES = f"""(SELECT sum(CASE WHEN kind = '{BORN}' AND a + {NEAR} * error < {{a}} THEN 1
    WHEN kind = '{DIED}' AND a - {NEAR} * error <= {{a}} THEN -1 ELSE 0 END)
    FROM change WHERE change.cycle = catalogue.cycle)"""
"""The births minus the deaths of a class up to an a, or NULL if no births are stored.

A class does not count as an orbit if a is within the error of a birth or death, where the orbit may run
exactly through a joint."""


def is_of_classes(selection: Selection) -> bool:
    """Tell whether each class is chosen with all its words or not at all.

    Raises `SelectionError` if the expression of the selection is invalid.
    """
    by_class = selection.where is None or of_classes(selection.where, selection.parameters)
    return by_class and selection.contains is None and not selection.without


def asks_of_lives(selection: Selection, names: Sequence[str] = (), order: str = "p") -> bool:
    """Tell whether a subset, its columns or its order depends on births and deaths."""
    named = set(selection.ranges) | set(names) | set(parse_order(order))
    if selection.where is not None:
        named |= set(re.findall(r"\w+", selection.where.lower()))
    return bool(selection.exists or selection.not_at or named & {"born", "dies"})


def parse_order(order: str) -> dict[str, bool]:
    """Return the columns to sort by, each mapped to whether its order is descending.

    Raises `SelectionError` if the text cannot be read or names an unknown column.
    """
    keys: dict[str, bool] = {}
    for part in order.split(","):
        key = _ORDER.fullmatch(part.strip())
        if key is None:
            raise SelectionError(f"order {order!r}: write columns such as 'length' or 'p,lambda_c desc'")
        falling = bool(key[1]) != ((key[3] or "").lower() == "desc")
        if key[2] not in COLUMNS:
            raise unknown_column(key[2], COLUMNS)
        keys.setdefault(key[2], falling)
    return keys
