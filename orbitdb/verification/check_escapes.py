"""Check what is stored about open stadiums, against new trajectories and a coarser transfer matrix."""

from collections.abc import Iterator
from functools import partial

import numpy as np

from orbitdb.open_stadium.escape import AT, Escape, ways
from orbitdb.open_stadium.question import Question
from orbitdb.open_stadium.transfer import GridLegs
from orbitdb.selection import Selection
from orbitdb.store.stored_values import stored_escapes
from orbitdb.text import format_float
from orbitdb.verification.checks import Check, Part, Scope

_TRAJECTORIES, _GRID = 20_000, 100
_SIGMAS = 6.0
_COARSE = 0.03
"""Relative change of a rate that a coarser grid may cause."""


def escapes(scope: Scope) -> Iterator[Part]:
    """Check escape at the chosen a, unless words are chosen."""
    chosen = {selection.a for selection in scope.selections if selection == Selection(selection.a)}
    for found in stored_escapes(scope.connection):
        if found.a in chosen:
            yield Part(f"escape at a = {format_float(found.a)}", partial(_escape, found))


def _escape(found: Escape, _: Scope) -> Iterator[Check]:
    """Check survival at every row, and the rate per leg."""
    asked = Question.of(found.a, found.opening, found.without, _TRAJECTORIES, found.bounces, found.seed + 1)
    label = f"{ways(found.opening, found.without)} at a = {format_float(found.a)}"
    anew = asked.sampled(task() for task in asked.tasks())
    for by, other in zip(AT, anew, strict=True) if found.trajectories else ():
        own = getattr(found, by)
        if np.isnan([own.survival, other.survival]).any():  # at large a, no leg may have begun
            continue
        falls = np.diff(own.survival, prepend=1.0) <= 0
        yield Check.judged("escapes", [f"{label}, {AT[by]} = {at:g}" for at in own.at], ~falls)
        allowed = _SIGMAS * np.hypot(own.error, other.error)
        off = np.abs(own.survival - other.survival)
        yield Check.measured("escapes", [f"{label}, {AT[by]} = {at:g}" for at in own.at], off, allowed)
    if found.rate_leg is not None and found.rate_leg_error is not None:
        legs = GridLegs.of(asked.opened, _GRID)
        rate = -legs.growth(1.0, np.ones(legs.size))[0]
        allowed = found.rate_leg_error + _COARSE * rate
        yield Check.measured(
            "escapes", [label], np.abs(np.array([found.rate_leg - rate])), np.array([allowed])
        )
