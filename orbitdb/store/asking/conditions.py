"""Turn selections into SQL conditions on the views, and read the columns to sort by."""

import re
from collections.abc import Sequence
from typing import Any

import sqlalchemy as sa

from orbitdb.store.asking import where as free
from orbitdb.store.asking.selection import Selection, SelectionError, unknown_column
from orbitdb.store.file.schema import BORN, DIED
from orbitdb.store.file.tables import ENDS, catalogue, change

COLUMNS = tuple(catalogue.c.keys())
"""The columns of the view ``catalogue``."""

NEAR = 2.0
"""Within this many error bounds of a birth or death, births and deaths do not decide the status of a word."""

_ORDER = re.compile(r"(-?)(\w+)(?:\s+(asc|desc))?", re.IGNORECASE)


def conditions_of(
    selection: Selection, view: sa.ColumnCollection[str, Any] = catalogue.c, stored: bool = True
) -> list[sa.ColumnElement[bool] | sa.TextClause]:
    """Return a selection, with an expression that is checked, as conditions on a view with these columns.

    The rows are not `stored` in the views if they are those of pruned words.
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
    if selection.contains is not None:
        found.append(sa.func.instr(view.code.concat(view.code), selection.contains) > 0)
    if selection.where is not None:
        found.append(free.expression(selection.where, selection.parameters, by_class=stored))
    return found


def is_of_classes(selection: Selection) -> bool:
    """Tell whether each class is chosen with all its words or not at all.

    Raises `SelectionError` if the expression of the selection is invalid.
    """
    of_classes = selection.where is None or free.of_classes(selection.where, selection.parameters)
    return of_classes and selection.contains is None


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
        named |= set(re.findall(r"\w+", selection.where.lower()))
    return bool(selection.exists or selection.not_at or named & set(ENDS))


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
