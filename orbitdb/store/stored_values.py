"""Results that are stored beside the orbits: entropy bounds, averages over trajectories, escape, levels."""

from dataclasses import fields
from itertools import groupby
from typing import TYPE_CHECKING

import numpy as np
from sqlalchemy import Connection, and_, func, select, true

from orbitdb.billiard.stadium import Stadium
from orbitdb.entropy_bounds.bounds import BALLS, DOUBLES, EntropyBounds
from orbitdb.errors import InputError
from orbitdb.store import tables as t
from orbitdb.store.sqlite import cursor_of

if TYPE_CHECKING:
    from orbitdb.open_stadium.escape import Escape
    from orbitdb.open_stadium.question import Question
    from orbitdb.open_stadium.rates import EscapeRates
    from orbitdb.quantum.exact_levels import LevelWindow
    from orbitdb.quantum.weyl import Parity
    from orbitdb.trajectories.ensemble import Reference


def bounds_by_a(
    connection: Connection, arithmetic: str | None = None, a: float | None = None
) -> list[EntropyBounds]:
    """Return the tightest stored bounds on the entropy at every a, or at a given a, in order of a.

    If two are equally tight, the one proved in ball arithmetic is returned. With `arithmetic`,
    only bounds proved in it count.
    """
    if arithmetic not in (None, DOUBLES, BALLS):
        raise InputError(f"arithmetic {arithmetic!r}: use {DOUBLES} or {BALLS}")
    own = t.entropy_bound.c
    columns = (own.a, own.edges, own.lower, own.upper, own.windows, own.undecided, own.proof)
    found = (true() if arithmetic is None else own.proof == arithmetic, true() if a is None else own.a == a)
    query = select(*columns).where(*found).order_by(own.a, own.edges, own.proof)
    rows = (t.checked(t.entropy_bound, row) for row in connection.execute(query).mappings())
    stored = (EntropyBounds(*row.values()) for row in rows)
    by_a = groupby(stored, key=lambda bounds: bounds.a)
    return [min(group, key=lambda bounds: (bounds.width, bounds.arithmetic)) for _, group in by_a]


def tightest_bounds(connection: Connection, a: float, arithmetic: str | None = None) -> EntropyBounds | None:
    """Return the tightest stored bounds on the entropy at a given a (`bounds_by_a`), or None."""
    return next(iter(bounds_by_a(connection, arithmetic, Stadium(a).a)), None)


def best_reference(connection: Connection, a: float) -> "Reference | None":
    """Return the averages over trajectories with the smallest error at a given a, or None."""
    from orbitdb.trajectories.ensemble import Reference

    own = t.trajectory
    columns = [own.c[field.name] for field in fields(Reference) if field.name in own.c]
    query = select(*columns).where(t.at_a(own, a)).order_by(own.c.lambda_d_error).limit(1)
    row = connection.execute(query).mappings().one_or_none()
    return None if row is None else Reference(**{**t.checked(own, row), "a": a, "seed": int(row["seed"])})


def stored_levels(connection: Connection, a: float, parity: "Parity") -> "list[LevelWindow]":
    """Return the stored windows of levels of one parity."""
    from orbitdb.quantum.exact_levels import LevelWindow

    own, fill = t.level.c, t.level_fill.c
    query = select(own.k, own.error).where(own.a == a, own.parity == str(parity))
    levels = np.array(cursor_of(connection, query).fetchall(), np.float64).reshape(-1, 2)
    columns = (fill.low, fill.high, fill.below, fill.seconds)
    windows = connection.execute(select(*columns).where(fill.a == a, fill.parity == str(parity)))
    parts = []
    for low, high, below, seconds in windows:
        k, error = levels[(levels[:, 0] >= low) & (levels[:, 0] < high)].T
        parts.append(LevelWindow(a, parity, low, high, below, k, error, seconds))
    return parts


def stored_escapes(connection: Connection, a: float | None = None) -> "list[Escape]":
    """Return what is stored about escape from open stadiums, at every a or at a given one."""
    from orbitdb.open_stadium.question import Question
    from orbitdb.open_stadium.rates import EscapeRates

    own = t.open_stadium.c
    names = ("a", "opening", "without", "trajectories", "bounces", "seed", *EscapeRates._fields, "survival")
    query = select(*(own[name] for name in names)).where(true() if a is None else own.a == a)
    found = []
    for at, opening, without, trajectories, bounces, seed, *rates, packed in connection.execute(
        query.order_by(*t.open_stadium.primary_key)
    ):
        asked = Question.of(at, opening.split(), without.split(), trajectories, bounces, int(seed))
        found.append(asked.answer(asked.unpacked(packed), EscapeRates(*rates)))
    return found


def stored_escape(connection: Connection, asked: "Question") -> "tuple[Escape | None, EscapeRates | None]":
    """Return the stored answer to a question, or else the stored rates of its open stadium."""
    from orbitdb.open_stadium.rates import EscapeRates

    known = None
    for one in stored_escapes(connection, asked.stadium.a):
        if (one.opening, one.without) == (asked.opening, asked.without):
            if (one.trajectories, one.bounces, one.seed) == (asked.trajectories, asked.bounces, asked.seed):
                return one, None
            known = EscapeRates(*(getattr(one, name) for name in EscapeRates._fields))
    return None, known


def level_windows(connection: Connection) -> list[tuple[float, str, float, float, int]]:
    """Return a, parity, least and greatest k, and number of levels of each range without a gap."""
    own, level = t.level_fill.c, t.level.c
    inside = and_(level.a == own.a, level.parity == own.parity, level.number > own.below, level.k < own.high)
    window = (own.a, own.parity, own.low, own.high)
    query = (
        select(*window, func.count(level.number))
        .join_from(t.level_fill, t.level, inside, isouter=True)
        .group_by(*window)
        .order_by(*window)
    )
    joined: list[tuple[float, str, float, float, int]] = []
    for a, parity, low, high, count in connection.execute(query):
        if joined and joined[-1][:2] == (a, parity) and joined[-1][3] == low:
            _, _, low, _, before = joined.pop()
            count += before
        joined.append((a, parity, low, high, count))
    return joined


def trajectories(connection: Connection) -> list[tuple[float, int, int]]:
    """Return each a with averages over random trajectories, their number, and the bounces of the longest."""
    query = (
        select(t.stadium.c.a, func.count(), func.max(t.trajectory.c.bounces))
        .join_from(t.trajectory, t.stadium)
        .group_by(t.stadium.c.a)
    )
    return [(a, count, bounces) for a, count, bounces in connection.execute(query)]
