"""Check which run wrote each row, and how: runs, methods and certificates must agree."""

import json
from collections.abc import Iterator, Mapping
from datetime import datetime
from typing import Any

import sqlalchemy as sa

from orbitdb import __version__
from orbitdb.arithmetic import arithmetic
from orbitdb.entropy.bounds import BALLS
from orbitdb.numerals import exact
from orbitdb.orbits.balls import PRECISION
from orbitdb.plaintext import shortened
from orbitdb.store.file.schema import SCHEMA_VERSION
from orbitdb.store.file.tables import (
    certificate,
    change,
    cycle,
    entropy_bound,
    level_fill,
    orbit,
    run,
    stadium,
    sweep,
)
from orbitdb.verification.check import Check, judged, listed

_COMMANDS = {
    orbit: "fill", change: "births", certificate: "verify --rigorous", entropy_bound: "bounds",
    level_fill: "levels", sweep: "sweep",
}  # fmt: skip
"""For each table, the only command whose runs may have written its rows."""


def parameters_of(connection: sa.Connection) -> dict[int, dict[str, Any]]:
    """Return the parameters of every run whose parameters can be read."""
    found = {}
    for number, text in connection.execute(sa.select(run.c.id, run.c.parameters)):
        try:
            asked = json.loads(text)
        except ValueError:
            continue
        if isinstance(asked, dict):
            found[number] = asked
    return found


def runs_of_here(connection: sa.Connection) -> set[int]:
    """Return the runs of this version with this machine's arithmetic, which can be reproduced bit by bit."""
    same = set(connection.scalars(sa.select(run.c.id).where(run.c.version == __version__)))
    asked, here = parameters_of(connection), arithmetic()
    return {number for number in same if asked.get(number, {}).get("arithmetic") == here}


def check_provenance(connection: sa.Connection) -> Iterator[Check]:
    """Check Alembic's schema number, all runs, and the columns that refer to runs."""
    found = connection.exec_driver_sql("SELECT version_num FROM alembic_version").scalars().all()
    yield judged("schema", ["alembic_version"], [found != [f"{SCHEMA_VERSION:04}"]])
    yield from _runs(connection, parameters_of(connection))
    yield from _certificates(connection)


def _runs(connection: sa.Connection, asked: Mapping[int, Mapping[str, Any]]) -> Iterator[Check]:
    """Check that each run wrote only what its command writes, and that orbits have its method and its a."""
    rows = connection.execute(sa.select(run.c.id, run.c.started, run.c.version)).all()
    wrong = [f"run {row.id}" for row in rows if row.id not in asked or not _is_told(row.started, row.version)]
    yield listed("provenance", len(rows), wrong)
    for table, command in _COMMANDS.items():
        groups = connection.execute(sa.select(table.c.run, sa.func.count()).group_by(table.c.run)).all()
        strange = [
            f"{table.name} of run {number}"
            for number, _ in groups
            if number is not None and asked.get(number, {}).get("command") != command
        ]
        yield listed("provenance", 0, strange)
    proved = sa.select(entropy_bound.c.a, entropy_bound.c.proof, entropy_bound.c.run)
    strange = [
        f"entropy bounds at a = {exact(a)}"
        for a, proof, number in connection.execute(proved)
        if (proof == BALLS) != bool(asked.get(number, {}).get("prove"))
    ]
    yield listed("provenance", 0, strange)
    columns = orbit.c.run, orbit.c.solver, stadium.c.a
    query = sa.select(*columns, sa.func.min(orbit.c.cycle), sa.func.count()).join_from(orbit, stadium)
    for number, solver, a, first, count in connection.execute(query.group_by(*columns)):
        by = asked.get(number, {})
        fits = (by.get("method"), by.get("a")) == (solver, a)
        named = None if fits else f"{_word(connection, first)} at a = {exact(a)}, solver {solver!r}"
        yield Check("provenance", count, 0 if fits else count, first=named)


def _is_told(started: str, version: str) -> bool:
    """Tell whether a run has a valid starting time and a version."""
    try:
        datetime.fromisoformat(started)
    except ValueError:
        return False
    return bool(version)


def _certificates(connection: sa.Connection) -> Iterator[Check]:
    """Check that certificates have a possible precision and radius, and the version of their run."""
    own = certificate.c
    columns = own.bits, own.version, run.c.version
    query = sa.select(*columns, sa.func.min(own.radius), sa.func.min(own.cycle), sa.func.count())
    for bits, version, by, radius, first, count in connection.execute(query.join(run).group_by(*columns)):
        steps, rest = divmod(bits, PRECISION)
        fits = rest == 0 and steps.bit_count() == 1 and version == by and radius >= 0
        named = None if fits else f"certificate of {_word(connection, first)}"
        yield Check("provenance", count, 0 if fits else count, first=named)


def _word(connection: sa.Connection, number: int) -> str:
    """Return the representative of a class, shortened to a label."""
    return shortened(connection.scalar(sa.select(cycle.c.word).where(cycle.c.id == number)) or "?")
