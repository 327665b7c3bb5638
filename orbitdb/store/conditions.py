"""A selection as conditions of SQL, and an order as its sort keys."""

import re
from collections.abc import Sequence
from typing import Any

import sqlalchemy as sa
from sqlalchemy import Boolean, ColumnElement, FromClause, func, select, type_coerce
from sqlalchemy.sql.base import ReadOnlyColumnCollection

from orbitdb.columns import WRITTEN
from orbitdb.criteria import unknown_column
from orbitdb.errors import SelectionError, check_text
from orbitdb.orbits.status import Status
from orbitdb.selection import Selection
from orbitdb.store import tables as t
from orbitdb.store.lookup import NEAR
from orbitdb.store.views import PRUNED, VIEWED
from orbitdb.store.where import check, expression, may_hold
from orbitdb.symbols.symmetry import (
    class_of,
    images_of_pattern,
)
from orbitdb.symbols.words import MAX_KEYED, key

_ORDER = re.compile(r"(-?)(\w+)(?:\s+(asc|desc))?", re.IGNORECASE)


def conditions_of(selection: Selection, view: FromClause) -> list[ColumnElement[bool]]:
    """Return a selection as conditions on a view with the name ``catalogue``.

    The expression of the selection must have been checked (`is_of_classes`).
    """
    own = view.c
    found = [own.a == selection.a, t.in_spans(own.p, selection.periods)]
    if selection.statuses:
        found.append(own.status.in_([status.value for status in selection.statuses]))
    if selection.time_reversal:
        found.append(own.time_reversal == selection.time_reversal)
    if selection.symmetry:
        found.append(own.symmetry == selection.symmetry)
    found += [_lives_at(view, a) > 0 for a in selection.exists]
    found += [_lives_at(view, a) <= 0 for a in selection.not_at]
    for name, (low, high) in selection.ranges.items():
        found += [] if low is None else [own[name] >= low]
        found += [] if high is None else [own[name] <= high]
    if selection.codes:
        found.append(own.code.in_(selection.codes))
        if "id" in own:  # pruned words have an index by period and word
            found.append(own.p.in_({len(code) for code in selection.codes}))
        elif max(map(len, selection.codes)) <= MAX_KEYED:
            found.append(own.cycle.in_([key(class_of(code).representative) for code in selection.codes]))
    if selection.contains is not None:
        found.append(_has(own, selection.contains))
        if len(selection.contains) <= _LONGEST_PATTERN and "id" not in own:
            found.append(own.cycle.in_(select(t.cycle.c.id).where(_needed_symbols(selection.contains))))
    found += [sa.not_(_has(own, pattern)) for pattern in selection.without]
    if selection.opening:
        found.append(sa.false() if "id" in own else _avoids(selection, view))
    if selection.where is not None:
        found.append(type_coerce(expression(selection.where, selection.parameters), Boolean))
    return found


def _has(own: ReadOnlyColumnCollection[str, Any], pattern: str) -> ColumnElement[bool]:
    """Return the condition that a cyclic word contains a pattern.

    SQLite's own function is faster, but sees all positions only if the pattern is short enough.
    """
    inside = func.instr(own.code.concat(own.code), pattern) > 0
    found = func.iif(own.p >= len(pattern) - 1, inside, func.contains(own.code, pattern))
    return type_coerce(found, Boolean)


def _avoids(selection: Selection, view: FromClause) -> ColumnElement[bool]:
    """Return the condition that a word has bounces, and none of them in an opening."""
    own, cycle = t.orbit.c, t.cycle.c
    selection.check_opening()
    texts = " ".join(map(str, selection.opening))
    found = func.elements_through(cycle.word.concat(""), own.coordinates, texts, type_=sa.Integer)
    this = t.at_a(t.orbit, selection.a), own.cycle == view.c.cycle, cycle.id == view.c.cycle
    mask = select(found).where(*this).correlate(view).scalar_subquery()
    return mask.bitwise_rshift(view.c.element).bitwise_and(1) == 0


def _lives_at(view: FromClause, a: float) -> ColumnElement[Any]:
    """Return the births minus the deaths of a class up to an a, or NULL if no births are stored.

    A class does not count as an orbit if a is within the error of a birth or death, where the orbit may run
    exactly through a joint.
    """
    own = t.change.c
    counted = sa.case(
        (sa.and_(own.kind == t.BORN, own.a + NEAR * own.error < a), 1),
        (sa.and_(own.kind == t.DIED, own.a - NEAR * own.error <= a), -1),
        else_=0,
    )
    return select(func.sum(counted)).where(own.cycle == view.c.cycle).scalar_subquery()


def is_of_classes(selection: Selection) -> bool:
    """Tell whether each class is chosen with all its words or not at all.

    Raises `SelectionError` if the expression of the selection is invalid.
    """
    by_class = selection.where is None or check(selection.where, selection.parameters).of_classes
    of_words = selection.codes or selection.contains or selection.without or selection.opening
    return by_class and not of_words


def may_choose_pruned(selection: Selection, p: int | None = None) -> bool:
    """Tell whether a subset may contain geometrically pruned words, of one period if it is given.

    They have a code, rules, and neither a symmetry nor numbers. For the expression of the subset, SQLite says
    whether it can hold for them.
    """
    numbers = selection.ranges or selection.exists or selection.not_at or selection.opening
    if Status.GEOMETRIC not in selection.statuses or selection.time_reversal or selection.symmetry or numbers:
        return False
    if selection.where is None:
        return True
    known: dict[str, str | float] = {"a": float(selection.a), "status": Status.GEOMETRIC.value}
    known |= {} if p is None else {"p": p}
    return may_hold(selection.where, selection.parameters, known, PRUNED.keys() - known.keys())


def asks_of_lives(selection: Selection, names: Sequence[str] = (), order: str = "p") -> bool:
    """Tell whether a subset, its columns or its order depends on births and deaths."""
    named: set[str | None] = {*selection.ranges, *names, *parse_order(order)}
    if selection.where is not None:
        named |= check(selection.where, selection.parameters).columns
    return bool(selection.exists or selection.not_at or named & {"born", "dies"})


def parse_order(order: str) -> dict[str, bool]:
    """Return the columns to sort by, each mapped to whether its order is descending.

    Raises `SelectionError` if the text cannot be read or names an unknown column.
    """
    check_text("order", order, "length desc")
    keys: dict[str, bool] = {}
    for part in order.split(","):
        key = _ORDER.fullmatch(part.strip())
        if key is None:
            raise SelectionError(f"order {order!r}: write columns such as 'length' or 'p,lambda_c desc'")
        falling = bool(key[1]) != ((key[3] or "").lower() == "desc")
        if key[2] in set(WRITTEN) - set(VIEWED):
            raise SelectionError(
                f"order {order!r}: column {key[2]} is computed afterwards, for the chosen rows"
            )
        if key[2] not in VIEWED:
            raise unknown_column(key[2], VIEWED)
        keys.setdefault(key[2], falling)
    return keys


_LONGEST_PATTERN = 40
"""Number of symbols of a pattern beyond which the texts of its images would take too long to compare."""


def _needed_symbols(pattern: str) -> ColumnElement[bool]:
    """Return a condition that the table `cycle` fulfils for each class with words that contain a pattern.

    SQLite then need not look at most words, eight to a class, which is what takes long.
    """
    own = t.cycle.c
    twice = own.word.concat(own.word)
    images = (func.instr(twice, image) > 0 for image in sorted(images_of_pattern(pattern)))
    return sa.or_(own.p < len(pattern) - 1, *images)
