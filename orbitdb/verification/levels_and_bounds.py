"""Check entropy bounds, quantum levels, and averages over trajectories.

Bounds must be possible and must not contradict one another, and their windows are counted again. Levels are
found again on another grid; their number must be the same, and they must agree within their errors.

New trajectories must give the same exponents within both errors. They also show how small an error can be,
because errors decrease with the square root of the number of bounces. The mean free path is known exactly.
None of these checks detects an error estimate that is too large.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
import sqlalchemy as sa

from orbitdb.answers.levels import stored_levels
from orbitdb.averages.exact_means import exact_means
from orbitdb.billiard.stadium import Stadium
from orbitdb.entropy.bounds import BALLS, EntropyBounds, levels
from orbitdb.errors import InputError, StoreError
from orbitdb.numerals import exact
from orbitdb.quantum.levels import ROUNDING, LevelWindow, windows
from orbitdb.quantum.weyl import Parity
from orbitdb.store.file.tables import entropy_bound, level, level_fill, stadium, trajectory
from orbitdb.store.reading.moment import Moment
from orbitdb.store.reading.records import bounds_stored, is_sound
from orbitdb.trajectories.ensemble import Reference, simulate
from orbitdb.trajectories.legwise import simulate_legs
from orbitdb.verification.check import Check, Part, judged, listed, measured, single
from orbitdb.verification.provenance import parameters_of, runs_of_here

RECOUNTED = 3000
"""Number of windows after which recounting stops at each a; this takes a few tenths of a second."""

_COUNTED = ("windows", "undecided", "lower", "upper")

_GRID = (20, 2)
"""Degree, and divisions of the cells at the joint: a finer grid than that on which levels are found."""

_BOUNCES = 100_000
"""Number of bounces of a new run, which takes a tenth of a second at most values of a."""

_MANY = 12.0
"""Allowed deviation, in standard errors; their estimates from few groups have long tails in short runs."""

_TOO_SMALL = 4.0
_ROUNDING = 1e-12
_LEGWISE_FROM = 0.1
"""Below this a, sampling leg by leg is less accurate than following trajectories bounce by bounce."""


def is_known(moment: Moment, a: float) -> bool:
    """Tell whether anything is stored for this a: rows, sums, averages, bounds or levels."""
    tables = (stadium, entropy_bound, level_fill)
    return any(moment.connection.scalar(sa.select(sa.exists().where(table.c.a == a))) for table in tables)


def record_parts(connection: sa.Connection) -> Iterator[Part]:
    """Yield parts that check the averages and the bounds at each a, and the levels of each parity."""
    runs = sa.select(stadium.c.a).where(stadium.c.id.in_(sa.select(trajectory.c.stadium)))
    for a in connection.scalars(runs.order_by(stadium.c.a)):
        yield Part("trajectories", partial(_trajectories, a))
    for a in connection.scalars(sa.select(entropy_bound.c.a).distinct().order_by(entropy_bound.c.a)):
        yield Part("entropy", partial(_bounds, a))
    named = sa.union(*(sa.select(table.c.a, table.c.parity) for table in (level_fill, level)))
    for a, parity in sorted(map(tuple, connection.execute(named))):
        yield Part(f"levels {parity} at a = {exact(a)}", partial(_levels, a, parity))


def _bounds(a: float, connection: sa.Connection) -> Iterator[Check]:
    found, table = bounds_stored(connection, a=a), entropy_bound.c
    made = sa.select(table.proof, table.edges).where(table.a == a, table.run.in_(runs_of_here(connection)))
    wrong = _wrong_bounds(found, {(proof, edges) for proof, edges in connection.execute(made)})
    labels = [f"windows of {each.window} edges at a = {exact(a)}" for each in wrong]
    yield listed("entropy", len(found), labels)


def _wrong_bounds(found: Sequence[EntropyBounds], ours: set[tuple[str, int]]) -> Iterator[EntropyBounds]:
    """Yield rows that are impossible, contradict new or tighter bounds, or differ from a new count.

    `ours` has the proof and the edges of each row that this version wrote with the same arithmetic.
    """
    sound = [each for each in found if is_sound(each)]
    new = _new_bounds(sound) if sound else {}
    for each in found:
        others: list[EntropyBounds] = [*new.values(), *(x for x in sound if x.width < each.width)]
        agrees = each in sound and all(x.lower <= each.upper and each.lower <= x.upper for x in others)
        counted = new.get(each.window) if (each.proof, each.window) in ours else None
        if not agrees or (counted is not None and not _is_recounted(each, counted)):
            yield each


def _new_bounds(found: Sequence[EntropyBounds]) -> Mapping[int, EntropyBounds]:
    """Return new bounds by the length of windows, up to the longest stored or to `RECOUNTED` windows."""
    new = {}
    for bounds in levels(Stadium(found[0].a)):
        new[bounds.window] = bounds
        if bounds.window >= max(each.window for each in found) or bounds.windows > RECOUNTED:
            break
    return new


def _is_recounted(one: EntropyBounds, new: EntropyBounds) -> bool:
    """Tell whether a row agrees with a new count; ball arithmetic may leave more windows undecided."""
    if all(getattr(one, name) == getattr(new, name) for name in _COUNTED):
        return True
    wider = one.lower <= new.lower and new.upper <= one.upper
    return one.proof == BALLS and wider and one.windows >= new.windows and one.undecided >= new.undecided


def _levels(a: float, parity: str, connection: sa.Connection) -> Iterator[Check]:
    try:
        for stored in stored_levels(connection, a, Parity(parity)):
            yield from _window(stored)
    except (StoreError, InputError, ValueError):
        yield Check("levels", 1, 1, first=f"levels {parity} at a = {exact(a)}")


def _window(stored: LevelWindow) -> Iterator[Check]:
    """Check the numbers of levels in and below a window and, if they are right, each level.

    Raises `InputError` if orbitdb never makes such a window.
    """
    tasks = windows(Stadium(stored.a), stored.parity, stored.low, stored.high)
    found = [task.solved(*_GRID) for task in tasks]
    k = np.concatenate([each.k for each in found])
    labels = [f"{stored.parity} {each:.6g}" for each in stored.k]
    if (stored.below, len(stored.k)) != (found[0].below, len(k)):
        yield judged("levels", [f"{stored.parity} {stored.low:g} to {stored.high:g}"], [True])
    else:
        impossible = stored.error < 0.99 * ROUNDING * stored.k  # orbitdb allows at least this for rounding
        deviation = np.where(impossible, math.inf, np.abs(stored.k - k))
        yield measured("levels", labels, deviation, stored.error + ROUNDING * k)


def _trajectories(a: float, connection: sa.Connection) -> Iterator[Check]:
    query = sa.select(trajectory).join(stadium).where(stadium.c.a == a).order_by(trajectory.c.id)
    runs = parameters_of(connection)
    for row in connection.execute(query).mappings():
        yield single("trajectories", f"at a = {exact(a)}", _faults(a, dict(row), runs.get(row["run"], {})))


def _faults(a: float, row: Mapping[str, Any], run: Mapping[str, Any]) -> Iterator[str]:
    """Yield the faults of a row of averages at this a, given the parameters of its run."""
    asked = (run.get("command"), run.get("a"), run.get("bounces"), str(run.get("seed")))
    if asked != ("simulate", a, row["bounces"], row["seed"]):
        yield "its run has other parameters"
    errors = [row[f"{name}_error"] for name in ("lambda_d", "lambda_c", "mean_free_path")]
    if row["groups"] < 2 or not all(0 < error < math.inf for error in errors):
        yield "its standard errors cannot be right"
    exact, free = Stadium(a).mean_free_path, row["mean_free_path"]
    if not abs(free - exact) <= _MANY * row["mean_free_path_error"]:
        yield f"mean free path {free:g}, not {exact:g}"
    for name in ("", "_error"):
        per_bounce, per_length = row[f"lambda_d{name}"], row[f"lambda_c{name}"]
        if not abs(per_length * exact - per_bounce) <= _ROUNDING * per_bounce:
            yield f"lambda_c{name} is not lambda_d{name} divided by the mean free path"
    new = _new_run(a)
    allowed = _MANY * math.hypot(row["lambda_d_error"], new.lambda_d_error)
    if not abs(row["lambda_d"] - new.lambda_d) <= allowed:
        yield f"lambda_d {row['lambda_d']:g}, not {new.lambda_d:g}"
    fewer = min(1.0, math.sqrt(new.bounces / row["bounces"])) / _TOO_SMALL
    for name in ("lambda_d_error", "mean_free_path_error"):
        if row[name] < fewer * getattr(new, name):
            yield f"{name} {row[name]:.1e} is too small for {row['bounces']} bounces"


def _new_run(a: float) -> Reference:
    if a < _LEGWISE_FROM:
        return simulate(Stadium(a), _BOUNCES)
    return simulate_legs(Stadium(a), _BOUNCES, exact_means(a).growth)
