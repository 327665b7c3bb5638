"""Check that every stored value is possible: the right type, within its range, and consistent in its row.

This needs no solutions, so it covers every column, also those that nothing else depends on.
"""

import math
from collections.abc import Iterable, Iterator, Mapping

from orbitdb.billiard.stadium import MAX_A, MIN_A
from orbitdb.filling.fill import METHODS
from orbitdb.orbits.births import JOINTS
from orbitdb.orbits.orbits import NUMBERS
from orbitdb.orbits.status import EXISTING, Status
from orbitdb.quantum.weyl import Parity
from orbitdb.store.tables import BORN, DIED, DONE, FILLING, TABLES
from orbitdb.symbols.symmetry import ELEMENT_ROWS
from orbitdb.symbols.words import MAX_KEYED
from orbitdb.verification.checks import Check, Scope


def _one_of(name: str, allowed: Iterable[str]) -> str:
    return f"{name} IN ({', '.join(repr(str(value)) for value in allowed)})"


_A = f"a BETWEEN {MIN_A!r} AND {MAX_A!r}"
_EXISTS = _one_of("status", EXISTING)
_COUNTED = f"(state = '{DONE}') = ({{name}} IS NOT NULL)"
"""Counts are stored when a period is done."""
_FREE_PATH = f"{math.pi} * ({math.pi} + 4 * a) / (2 * {math.pi} + 4 * a)"
"""The mean length of a link, pi times the area divided by the perimeter."""
_RATES = ("rate_leg", "rate_time", "rate_bounce")
_ERRORS = [name for name in NUMBERS if name.endswith("error")]
_NOT_NEGATIVE = (
    "commits", "iterations", "seconds", "words", "enumerating", "solving", "storing", "processor", "below",
    "lambda_d_error", "lambda_c_error", "mean_free_path_error",
)  # fmt: skip

_ANYWHERE: Mapping[str, str] = {
    "a": _A,
    "p": f"p BETWEEN 2 AND {MAX_KEYED}",
    "state": _one_of("state", (DONE, FILLING)),
    # the packed symbols up to which everything is stored; in the end, those are the last of the period
    "cursor": f"""iif(cursor IS NULL, state = '{FILLING}' AND words = 0,
        length(cursor) = p AND cursor NOT GLOB '*[^0-7]*'
        AND (state = '{FILLING}' OR cursor NOT GLOB '*[^7]*'))""",
    "version": "version GLOB '[0-9]*.[0-9]*'",
    "parity": _one_of("parity", Parity),
    **{name: f"{name} BETWEEN 0 AND 1e300" for name in _NOT_NEGATIVE},
}
"""Conditions on columns of the same name in any table, unless the table has its own."""

_OWN: Mapping[str, Mapping[str, str]] = {
    "stadium": {},
    "run": {
        "started": "julianday(started) > julianday('2020-01-01')",
        "parameters": "json_type(iif(json_valid(parameters), parameters, '0')) = 'object'",
    },
    "cycle": {
        "p": "p = length(word)",
        "class_size": "class_size BETWEEN 1 AND 8",
        "words": "length(words) = p * class_size",
    },
    "pruned": {"p": "p = length(word)"},
    "pruned_fill": {},
    "orbit": {
        "status": _one_of("status", Status),
        "coordinates": f"(coordinates IS NOT NULL) = ({_EXISTS})",
        **{name: f"({name} IS NOT NULL) = ({_EXISTS})" for name in ("length", "lyapunov", "area")},
        "margin": f"(margin IS NOT NULL) = ({_EXISTS} OR status = '{Status.DYNAMICAL}')",
        **{
            name: f"iif({_EXISTS} AND solver != 'relaxation', {name} BETWEEN 0 AND 1e300, {name} IS NULL)"
            for name in _ERRORS
        },
        "residual": f"iif({_EXISTS}, residual BETWEEN 0 AND 1, residual IS NULL)",
        "solver": _one_of("solver", METHODS),
    },
    "fill": {name: _COUNTED.format(name=name) for name in ("primitive", "n_t", "n_c", "classes", "boundary")},
    "certificate": {
        "radius": """radius >= 0 AND radius <= (SELECT coalesce(max(error), 1e300) FROM orbit
            WHERE orbit.stadium = certificate.stadium AND orbit.cycle = certificate.cycle)""",
        "bits": "bits BETWEEN 53 AND 1000000",
    },
    "change": {
        "number": "number >= 1",
        "a": f"a = 0 OR {_A}",
        "error": "error BETWEEN 0 AND a",
        "kind": _one_of("kind", (BORN, DIED)),
        "bounce": "(bounce IS NULL) = (a = 0) AND coalesce(bounce, 1) >= 1",
        "joint": f"(joint IS NULL) = (a = 0) AND coalesce({_one_of('joint', JOINTS)}, TRUE)",
        "event": "coalesce(event, 1) >= 1",
        "slope": f"(slope IS NULL) = (a = 0) AND coalesce((slope > 0) = (kind = '{BORN}'), TRUE)",
    },
    "birth_fill": {name: _COUNTED.format(name=name) for name in ("classes", "births", "deaths", "always")},
    "trajectory": {
        "bounces": "bounces >= 1",
        "groups": "groups BETWEEN 1 AND bounces",
        "seed": "seed != '' AND seed NOT GLOB '*[^0-9]*'",
        "lambda_c": f"""abs(lambda_c * (SELECT {_FREE_PATH} FROM stadium WHERE id = trajectory.stadium)
            - lambda_d) <= 8 * lambda_d_error + 1e-9""",
        "mean_free_path": f"""abs(mean_free_path - (SELECT {_FREE_PATH} FROM stadium
            WHERE id = trajectory.stadium)) <= 8 * mean_free_path_error + 1e-9""",
    },
    "entropy_bound": {
        "proof": "proof IN ('doubles', 'balls')",
        "edges": "edges BETWEEN 1 AND 1000",
        "lower": "lower BETWEEN 0 AND upper",
        "upper": "upper BETWEEN 0 AND 1.21875573",  # of the rules alone, at any a
        "undecided": "undecided BETWEEN 0 AND windows",
    },
    "open_stadium": {
        "trajectories": "trajectories >= 0",
        "bounces": "bounces >= 1",
        "seed": "seed != '' AND seed NOT GLOB '*[^0-9]*'",
        **{
            f"{name}_error": f"({name} IS NULL) = ({name}_error IS NULL) AND coalesce({name}_error > 0, TRUE)"
            for name in _RATES
        },
        **{name: f"coalesce({name} BETWEEN 0 AND 100, TRUE)" for name in _RATES},
        "survival": "length(survival) % 16 = 0 AND (length(survival) = 0) = (trajectories = 0)",
    },
    "level_fill": {"low": "low BETWEEN 0 AND high"},
    "level": {
        "number": "number >= 1",
        "k": """EXISTS (SELECT 1 FROM level_fill WHERE level_fill.a = level.a
            AND level_fill.parity = level.parity AND k >= low AND k < high AND number > below)""",
        "error": "error BETWEEN 0 AND 0.1 * k",
    },
    "sweep": {
        "blocks": "blocks >= (state = 'done')",
        "sums": _COUNTED.format(name="sums"),
        "run": _COUNTED.format(name="run"),
    },
    "sweep_block": {
        "number": """number >= 0 AND number < (SELECT blocks FROM sweep
            WHERE sweep.stadium = sweep_block.stadium AND sweep.p = sweep_block.p)""",
        "sums": "length(sums) % 8 = 0 AND length(sums) > 0",
    },
}
"""The other conditions, by table and column."""

RULES = {
    table: {name: rule for name, rule in _ANYWHERE.items() if name in TABLES[table].c} | dict(own)
    for table, own in _OWN.items()
}
"""For each column of a table, a condition that all its values fulfil."""


def values(scope: Scope) -> Iterator[Check]:
    """Check every value by itself."""
    for table, rules in RULES.items():
        counts = ", ".join(f"sum(NOT coalesce({rule}, FALSE))" for rule in rules.values())
        ((rows, *wrong),) = scope.query(f"SELECT count(*), {counts} FROM {table}")
        faults = [
            f"{table}.{name} has {count} impossible value{'s' * (count > 1)}"
            for name, count in zip(rules, wrong, strict=True)
            if count
        ]
        yield Check.listed("values", rows, faults)
    stored = set(scope.query("SELECT symmetry, n, element FROM element"))
    faults = [f"element: {row} is missing or wrong" for row in sorted(stored ^ set(ELEMENT_ROWS), key=repr)]
    yield Check.listed("values", len(ELEMENT_ROWS), faults)
