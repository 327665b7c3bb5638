"""Turn selections into SQL conditions on the view ``catalogue``, and read the columns to sort by.

`divide` splits the conditions of a subset into conditions for SQL and patterns for the packed words.
"""

import math
import re
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import sqlalchemy as sa

from orbitdb.store.asking import where as free
from orbitdb.store.asking.limits import LONGEST_PATTERN, Patience, confined, heeding, never
from orbitdb.store.asking.selection import Selection, SelectionError, unknown_column
from orbitdb.store.file.schema import BORN, DIED, SHARED
from orbitdb.store.file.tables import ENDS, catalogue, change
from orbitdb.store.file.tokens import Token, meaningful, tokens
from orbitdb.symbols.patterns import Factor, Like, Pattern

COLUMNS = tuple(catalogue.c.keys())
"""The columns of the view ``catalogue``."""

NEAR = 2.0
"""Within this many error bounds of a birth or death, births and deaths do not decide the status of a word."""

_ORDER = re.compile(r"(-?)(\w+)(?:\s+(asc|desc))?", re.IGNORECASE)


def conditions_of(
    selection: Selection, view: sa.ColumnCollection[str, Any] = catalogue.c
) -> list[sa.ColumnElement[bool] | sa.TextClause]:
    """Return a selection, except for `contains`, as conditions on a view or on columns with the same names.

    Raises `SelectionError` if the expression of the selection is invalid.
    """
    found: list[sa.ColumnElement[bool] | sa.TextClause] = [view.a == selection.a]
    if selection.periods:
        found.append(sa.or_(*(view.p.between(low, high) for low, high in selection.periods)))
    if selection.statuses:
        found.append(view.status.in_([status.value for status in selection.statuses]))
    if selection.time_reversal:
        found.append(view.time_reversal == selection.time_reversal)
    if selection.symmetry:
        found.append(view.symmetry == selection.symmetry)
    found += [alive_at(view.cycle, a) for a in selection.exists]
    has_life = sa.exists().where(change.c.cycle == view.cycle, change.c.number == 1)
    found += [sa.and_(has_life, sa.not_(alive_at(view.cycle, a))) for a in selection.not_at]
    for name, (low, high) in selection.ranges.items():
        found += [] if low is None else [view[name] >= low]
        found += [] if high is None else [view[name] <= high]
    if selection.where is not None:
        free.check(selection.where, dict(selection.parameters))
        found.append(free.expression(selection.where, dict(selection.parameters)))
    return found


def alive_at(number: sa.ColumnElement[int], a: float) -> sa.ColumnElement[bool]:
    """Return the condition that a class, given by its id, is an orbit at a given a, from births and deaths.

    A class does not count as an orbit if a is within the error of a birth or death, where the orbit may run
    exactly through a joint.
    """
    reach = NEAR * change.c.error
    begun = sa.and_(change.c.kind == BORN, change.c.a + reach < a)
    ended = sa.and_(change.c.kind == DIED, change.c.a - reach <= a)
    lives = sa.func.coalesce(sa.func.sum(sa.case((begun, 1), (ended, -1), else_=0)), 0)
    return sa.select(lives).where(change.c.cycle == number).scalar_subquery() > 0


def asks_of_lives(selection: Selection, names: Sequence[str] = (), order: str = "p") -> bool:
    """Tell whether a subset, its columns or its order depends on births and deaths."""
    named = set(selection.ranges) | set(names) | set(parse_order(order))
    if selection.where is not None:
        named |= {each.text.lower() for each in tokens(selection.where) if each.kind in ("word", "name")}
    return bool(selection.exists or selection.not_at or named & set(ENDS))


def answering(
    connection: sa.Connection, selection: Selection, cancelled: Callable[[], bool]
) -> AbstractContextManager[None]:
    """Return a context in which to query a subset; it confines the expression of the subset, if any."""
    if selection.where is None:
        return nullcontext() if cancelled is never else heeding(connection, Patience(math.inf, cancelled))
    return confined(connection, Patience(cancelled=cancelled), partial(free.refusal, selection.where))


def parse_order(order: str) -> dict[str, bool]:
    """Return the columns to sort by, each mapped to whether its order is descending.

    Raises `SelectionError` if the text cannot be read or names an unknown column.
    """
    keys: dict[str, bool] = {}
    for part in order.split(","):
        found = _ORDER.fullmatch(part.strip())
        if found is None:
            raise SelectionError(f"order {order!r}: write columns such as 'length' or 'p,lambda_c desc'")
        falling = bool(found[1]) != ((found[3] or "").lower() == "desc")
        if found[2] not in COLUMNS:
            raise unknown_column(found[2], COLUMNS)
        keys.setdefault(found[2], falling)
    return keys


_NAMES = ("CODE", "WORD")
_WILDCARDS = {"LIKE": ("%", "_"), "GLOB": ("*", "?")}
"""The wildcards for any number of symbols and for a single symbol."""


@dataclass(frozen=True)
class Divided:
    """A subset, divided into conditions for SQL and patterns that the packed words must match.

    `of_words` tells whether the conditions can have different values for the words of a class.
    """

    conditions: Selection
    patterns: tuple[Pattern, ...]
    of_words: bool


def divide(selection: Selection) -> Divided:
    """Divide a subset into conditions and patterns; raise `SelectionError` if its expression is invalid."""
    factors = () if selection.contains is None else (Factor(selection.contains),)
    plain = replace(selection, contains=None)
    if _is_of_classes(plain):
        return Divided(plain, factors, False)
    parts = [(part, _is_of_classes(part)) for part in _parts_of(plain)]
    patterns = [_pattern(part) for part, of_classes in parts if not of_classes]
    known = tuple(pattern for pattern in patterns if pattern is not None)
    if len(known) < len(patterns):
        return Divided(plain, factors, True)
    return Divided(_joined(plain, [part for part, of_classes in parts if of_classes]), factors + known, False)


def _is_of_classes(selection: Selection) -> bool:
    """Tell whether the expression has the same value for all words of a class."""
    if selection.where is None:
        return True
    parameters = dict(selection.parameters)
    free.check(selection.where, parameters)
    return free.same_for_class(selection.where, parameters, SHARED.keys() - {"cycle"})


def _joined(selection: Selection, parts: list[Selection]) -> Selection:
    where = " AND ".join(f"(\n{part.where}\n)" for part in parts) or None
    used = {name: value for part in parts for name, value in part.parameters.items()}
    return replace(selection, where=where, parameters=used)


def _parts_of(selection: Selection) -> list[Selection]:
    """Return one subset for each condition that AND joins, with the values of the names in it."""
    found, given = [], selection.parameters
    for part in _joined_by_and(selection.where or "") or [selection.where or ""]:
        values = {name: given[name] for name in given.keys() & free.names_in(part)}
        found.append(replace(selection, where=part, parameters=values))
    return found


def _joined_by_and(where: str) -> list[str]:
    """Return the conditions that an expression joins by AND; an empty list if it cannot be split safely."""
    parts, depth = [""], 0
    for token in tokens(where):
        depth += (token.text == "(") - (token.text == ")")
        if depth == 0 and token.keyword in ("OR", "BETWEEN", "CASE"):
            return []
        if depth == 0 and token.keyword == "AND":
            parts.append("")
        else:
            parts[-1] += token.text
    return parts if depth == 0 and len(parts) > 1 and all(map(str.strip, parts)) else []


def _pattern(part: Selection) -> Like | None:
    """Return the pattern of a condition such as ``code NOT LIKE '13%'``, or None for other conditions."""
    found = meaningful(part.where or "")
    wanted = [token.keyword for token in found[1:2]] != ["NOT"]
    if not wanted:
        del found[1]
    if len(found) != 3 or found[0].keyword not in _NAMES or found[1].keyword not in _WILDCARDS:
        return None
    text, (many, one) = _text(found[2], part), _WILDCARDS[found[1].keyword]
    plain = text is not None and re.fullmatch(rf"[0-9{re.escape(many + one)}]*", text) is not None
    if text is None or not plain or len(text) > LONGEST_PATTERN:
        return None
    return Like(text.replace(many, "%").replace(one, "_"), wanted)


def _text(token: Token, part: Selection) -> str | None:
    """Return the text of a quoted string or of a named value; None for anything else."""
    value = part.parameters.get(token.text[1:]) if token.kind == "value" else None
    return token.text[1:-1] if token.kind == "string" else value if isinstance(value, str) else None
