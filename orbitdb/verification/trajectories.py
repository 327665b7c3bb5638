"""Stored averages over random trajectories, against exact means and a new run.

A run of other trajectories tells the exponents again, up to both errors, and how small an error may be: it
falls as the root of the number of bounces. The mean free path is known exactly. No check here can tell that
an error is too large.
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import sqlalchemy as sa

from orbitdb.averages.exact_means import exact_means
from orbitdb.billiard.stadium import Stadium
from orbitdb.store.file.tables import stadium, trajectory
from orbitdb.trajectories.ensemble import Reference, simulate
from orbitdb.trajectories.legwise import simulate_legs
from orbitdb.verification.blocks import Part
from orbitdb.verification.check import Check, Step
from orbitdb.verification.provenance import parameters_of

_BOUNCES = 100_000
"""Of the new run, a tenth of a second at most a."""

_MANY = 12.0
"""Errors from few groups have long tails, above all on short runs."""

_TOO_SMALL = 4.0
_ROUNDING = 1e-12
_LEGWISE_FROM = 0.1
"""Below, trajectories leg by leg are less exact than plain ones."""


def trajectory_parts(connection: sa.Connection, path: Path) -> Iterator["TrajectoryPart"]:
    """Yield one part for each a at which there are averages."""
    here = sa.select(stadium.c.a).where(stadium.c.id.in_(sa.select(trajectory.c.stadium)))
    return (TrajectoryPart(path, a) for a in connection.scalars(here.order_by(stadium.c.a)))


@dataclass(frozen=True, eq=False)
class TrajectoryPart(Part):
    """The averages at one a."""

    a: float

    def checked(self, connection: sa.Connection) -> Step:
        """Return what is found in the rows that a connection reads."""
        query = sa.select(trajectory).join(stadium).where(stadium.c.a == self.a).order_by(trajectory.c.id)
        rows = [dict(row) for row in connection.execute(query).mappings()]
        parameters = parameters_of(connection)
        wrong = [
            f"at a = {self.a:g}: {fault}"
            for row in rows
            if (fault := self._fault(row, parameters.get(row["run"], {}))) is not None
        ]
        check = Check("trajectories", len(rows), len(wrong), first=wrong[0] if wrong else None)
        return Step("trajectories", 0, 1, (check,))

    def _fault(self, row: Mapping[str, Any], run: Mapping[str, Any]) -> str | None:
        """Return what is wrong with one row, None if nothing is."""
        asked = (run.get("command"), run.get("a"), run.get("bounces"), str(run.get("seed")))
        if asked != ("simulate", self.a, row["bounces"], row["seed"]):
            return "it is not what its run was asked for"
        errors = [row[f"{name}_error"] for name in ("lambda_d", "lambda_c", "mean_free_path")]
        if row["groups"] < 2 or not all(0 < error < math.inf for error in errors):
            return "errors that are none"
        exact, free = Stadium(self.a).mean_free_path, row["mean_free_path"]
        if not abs(free - exact) <= _MANY * row["mean_free_path_error"]:
            return f"mean free path {free:g}, not {exact:g}"
        for name in ("", "_error"):
            per_bounce, per_length = row[f"lambda_d{name}"], row[f"lambda_c{name}"]
            if not abs(per_length * exact - per_bounce) <= _ROUNDING * per_bounce:
                return f"lambda_c{name} is not lambda_d{name} over the mean free path"
        return _at_odds(row, _new_run(self.a))


def _new_run(a: float) -> Reference:
    if a < _LEGWISE_FROM:
        return simulate(Stadium(a), _BOUNCES)
    growth = exact_means(a).growth
    return simulate_legs(Stadium(a), _BOUNCES, (growth.value, growth.error))


def _at_odds(row: Mapping[str, Any], new: Reference) -> str | None:
    """Say where a row and a new run differ; None if they agree."""
    allowed = _MANY * math.hypot(row["lambda_d_error"], new.lambda_d_error)
    if not abs(row["lambda_d"] - new.lambda_d) <= allowed:
        return f"lambda_d {row['lambda_d']:g}, not {new.lambda_d:g}"
    fewer = min(1.0, math.sqrt(new.bounces / row["bounces"])) / _TOO_SMALL
    for name in ("lambda_d_error", "mean_free_path_error"):
        if row[name] < fewer * getattr(new, name):
            return f"{name} {row[name]:.1e} is too small for {row['bounces']} bounces"
    return None
