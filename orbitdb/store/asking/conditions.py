"""Selections as SQL: conditions, columns and sort keys over the view ``catalogue``."""

import math
import re
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from functools import partial
from typing import Any, TypeAlias

import sqlalchemy as sa

from orbitdb.errors import StoreError
from orbitdb.store.asking import expressions as free
from orbitdb.store.asking.confinement import Patience, confined, heeding
from orbitdb.store.asking.parsing import unknown_column
from orbitdb.store.asking.selection import Selection, SelectionError
from orbitdb.store.file.schema import BORN, DIED
from orbitdb.store.file.tables import ENDS, catalogue, change
from orbitdb.store.file.tokens import tokens
from orbitdb.symbols.pruning import RULES

COLUMNS = tuple(catalogue.c.keys())
"""The columns of the view ``catalogue``."""

Columns: TypeAlias = sa.ColumnCollection[str, Any]

NEAR = 2.0
"""Times the error of a change: nearer than this its place does not tell what a word is."""

_RULES = {str(rule.number) for rule in RULES}
_ORDER = re.compile(r"(-?)(\w+)(?:\s+(asc|desc))?", re.IGNORECASE)


def conditions_of(
    selection: Selection, view: Columns = catalogue.c
) -> list[sa.ColumnElement[bool] | sa.TextClause]:
    """Return a selection, but for its factor, as conditions on a view or on columns of the same names.

    A `SelectionError` refuses its free expression.
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
    """Return the condition that a class, by its number, is an orbit at some a, as its changes tell.

    Where a is so near to a change that the change's error does not tell, as it is for an orbit exactly
    through a joint, the class is taken for none.
    """
    reach = NEAR * change.c.error
    begun = sa.and_(change.c.kind == BORN, change.c.a + reach < a)
    ended = sa.and_(change.c.kind == DIED, change.c.a - reach <= a)
    lives = sa.func.coalesce(sa.func.sum(sa.case((begun, 1), (ended, -1), else_=0)), 0)
    return sa.select(lives).where(change.c.cycle == number).scalar_subquery() > 0


def asks_of_lives(selection: Selection, names: Sequence[str] = (), order: str = "p") -> bool:
    """Tell whether a subset, the columns shown of it or its order depend on births and deaths."""
    words = {token.text.lower() for token in tokens(selection.where or "") if token.kind in ("word", "name")}
    named = words | set(selection.ranges) | set(names) | set(parse_order(order))
    return bool(selection.exists or selection.not_at or named & set(ENDS))


def answering(
    connection: sa.Connection, selection: Selection, cancelled: Callable[[], bool]
) -> AbstractContextManager[None]:
    """Let a connection answer a query over a subset; where this has a free expression, it is confined."""
    if selection.where is None:
        return heeding(connection, Patience(math.inf, cancelled))
    return confined(connection, Patience(cancelled=cancelled), partial(free.refusal, selection.where))


def rules_of(text: str | None) -> list[int]:
    """Return the numbers of the rules broken from the column ``rules``; a `StoreError` if it holds others."""
    parts = text.split(",") if text else []
    if not all(part in _RULES for part in parts):
        raise StoreError(f"rules {text!r} in the catalogue are none: 'orbitdb verify' tells what is wrong")
    return [int(part) for part in parts]


def parse_order(order: str) -> dict[str, bool]:
    """Return the columns to sort by, the first one first, and whether they fall.

    A `SelectionError` tells of an order that cannot be read, or names what is not a column.
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
