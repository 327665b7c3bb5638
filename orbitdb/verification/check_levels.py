"""Check quantum levels: found again on another grid, they must be as many, and agree within their errors."""

from collections.abc import Iterator
from functools import partial

import numpy as np

from orbitdb.billiard.stadium import Stadium
from orbitdb.quantum.exact_levels import ROUNDING, level_tasks
from orbitdb.quantum.weyl import Parity
from orbitdb.selection import Selection
from orbitdb.store.stored_values import stored_levels
from orbitdb.text import format_float
from orbitdb.verification.checks import Check, Part, Scope

_GRID = (20, 2)
"""Degree, and divisions of the cells at the joint: a finer grid than that on which levels are found."""


def levels(scope: Scope) -> Iterator[Part]:
    """Check the quantum levels of each parity at the chosen a, unless words are chosen."""
    chosen = {selection.a for selection in scope.selections if selection == Selection(selection.a)}
    stored = scope.query("SELECT DISTINCT a, parity FROM level_fill ORDER BY a, parity")
    for a, parity in (row for row in stored if row[0] in chosen):
        yield Part(f"levels {parity} at a = {format_float(a)}", partial(_levels, a, parity))


def _levels(a: float, parity: str, scope: Scope) -> Iterator[Check]:
    """Check the numbers of levels in and below each window and, if they are right, each level."""
    for stored in stored_levels(scope.connection, a, Parity(parity)):
        anew = [
            task.solved(*_GRID) for task in level_tasks(Stadium(a), stored.parity, stored.low, stored.high)
        ]
        k = np.concatenate([window.k for window in anew])
        query = "SELECT number FROM level WHERE (a, parity) = (:a, :parity) AND k >= :low AND k < :high"
        window = {"a": a, "parity": parity, "low": stored.low, "high": stored.high}
        numbers = [number for (number,) in scope.query(f"{query} ORDER BY k", **window)]
        right = anew[0].below, [*range(anew[0].below + 1, anew[0].below + 1 + len(k))]
        if (stored.below, numbers) != right or len(stored.k) != len(k):
            yield Check.judged("levels", [f"{parity} {stored.low:g} to {stored.high:g}"], [True])
        else:
            labels = [f"{parity} {level:.6g}" for level in stored.k]
            yield Check.measured("levels", labels, np.abs(stored.k - k), stored.error + ROUNDING * k)
