"""Read fills and sweeps: their progress, and the counts and sums of finished periods."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, fields
from itertools import groupby
from typing import TYPE_CHECKING, Any

import sqlalchemy as sa

from orbitdb.billiard.stadium import Stadium
from orbitdb.entropy.bounds import BALLS, DOUBLES, EntropyBounds
from orbitdb.errors import InputError
from orbitdb.extras import Record
from orbitdb.orbits.status import Status
from orbitdb.store.schema import DONE, SWEPT
from orbitdb.store.selection import written_periods
from orbitdb.store.tables import (
    change,
    cycle,
    entropy_bound,
    fill,
    level,
    level_fill,
    orbit,
    pruned,
    stadium,
    sweep,
    trajectory,
)
from orbitdb.symbols.pruning import RULE_NUMBERS, count_admissible, count_primitive
from orbitdb.symbols.words import key, keys_of_period
from orbitdb.text import several

if TYPE_CHECKING:
    from orbitdb.averages.by_period import PeriodSums
    from orbitdb.averages.tilting import TiltMoments
    from orbitdb.orbits.exponents import Tally
    from orbitdb.trajectories.ensemble import Reference


@dataclass(frozen=True)
class Fill(Record):
    """How far a period is filled at one value of a, and the counts of the paper's Table 1.

    Attributes
    ----------
    p : int
        Period.
    state : str
        ``filling`` or ``done``; the counts exist once it is ``done``.
    words : int
        Number of words stored so far.
    seconds : float
        Elapsed time.
    enumerating, solving, storing : float
        Processor time in seconds for enumerating the classes, solving orbits, and writing to the file.
    primitive : int or None
        Number of all primitive cyclic words of the period.
    pruned : tuple of int or None
        Numbers of these words that break each of rules 1 to 6.
    n_t, n_c : int or None
        Numbers of words that the geometric rules allow, and of words that are orbits.
    classes : int or None
        Number of symmetry classes of the orbits.
    boundary, unresolved : int or None
        Numbers of words with these statuses.
    """

    p: int
    state: str
    words: int
    seconds: float
    enumerating: float
    solving: float
    storing: float
    primitive: int | None
    pruned: tuple[int | None, ...]
    n_t: int | None
    n_c: int | None
    classes: int | None
    boundary: int | None
    unresolved: int | None

    @property
    def whole(self) -> bool:
        """Whether all words of the period are stored; if not, a fill is running or was interrupted."""
        return self.state == DONE


def read_fills(connection: sa.Connection, a: float) -> list[Fill]:
    """Return the fills at a given a, in order of period."""
    query = sa.select(fill).join(stadium).where(stadium.c.a == a).order_by(fill.c.p)
    return [_as_fill(row) for row in connection.execute(query)]


def _as_fill(row: sa.Row[Any]) -> Fill:
    values = row._mapping
    pruned = tuple(values[f"rule_{number}"] for number in range(1, 7))
    names = (column.name for column in fields(Fill) if column.name != "pruned")
    return Fill(pruned=pruned, **{name: values[name] for name in names})


def words_up_to(connection: sa.Connection, stadium: int | None, p: int, last: str) -> int:
    """Count the words of a period in the stored classes with representatives up to `last`.

    A class counts as stored if it has an orbit at the stadium or, if that is None, if it has births.
    """
    size = sa.select(sa.func.sum(cycle.c.class_size))
    if stadium is None:
        rows = size.join_from(change, cycle).where(change.c.number == 1)
    else:
        rows = size.join_from(orbit, cycle).where(orbit.c.stadium == stadium)
    return connection.scalar(rows.where(cycle.c.id.between(keys_of_period(p)[0], key(last)))) or 0


def status_counts(
    connection: sa.Connection, stadium: int, p: int | None = None
) -> dict[int, dict[str, tuple[int, int]]]:
    """Return the numbers of words and classes at a stadium, by period and status."""
    of_period = [] if p is None else [orbit.c.cycle.between(*keys_of_period(p))]
    query = (
        sa.select(cycle.c.p, orbit.c.status, sa.func.sum(cycle.c.class_size), sa.func.count())
        .join(cycle, cycle.c.id == orbit.c.cycle)
        .where(orbit.c.stadium == stadium, *of_period)
        .group_by(cycle.c.p, orbit.c.status)
    )
    counts: dict[int, dict[str, tuple[int, int]]] = {}
    for p, status, words, classes in connection.execute(query):
        counts.setdefault(p, {})[status] = (words, classes)
    return counts


def counts_when_done(p: int, statuses: Mapping[str, tuple[int, int]]) -> dict[str, int]:
    """Return the counts of a filled period, given its numbers of words and classes by status."""
    primitive = count_primitive(p)
    n_c, of_orbits = statuses.get(Status.ORBIT, (0, 0))
    return {
        "primitive": primitive,
        **{f"rule_{n}": primitive - count_admissible(p, frozenset([n])) for n in sorted(RULE_NUMBERS)},
        "n_t": count_admissible(p),
        "n_c": n_c,
        "classes": of_orbits,
        "boundary": statuses.get(Status.BOUNDARY, (0, 0))[0],
        "unresolved": statuses.get(Status.UNRESOLVED, (0, 0))[0],
    }


@dataclass(frozen=True)
class Sweep(Record):
    """Progress and results of the sweep of a period at one value of a.

    Attributes
    ----------
    p : int
        Period.
    state : str
        ``filling`` or ``done``.
    tally : Tally
        The counts so far.
    blocks : int
        Number of blocks done so far.
    seconds, processor : float
        Elapsed time and processor time.
    sums : PeriodSums or None
        The sums over the orbits; None until the sweep is done.
    moments : mapping of int to TiltMoments
        Moments for sum rules, by level (`orbitdb.averages.sum_rules`); empty until the sweep is done.
    """

    p: int
    state: str
    tally: "Tally"
    blocks: int
    seconds: float
    processor: float
    sums: "PeriodSums | None" = field(repr=False)
    moments: "Mapping[int, TiltMoments]" = field(repr=False)

    @property
    def whole(self) -> bool:
        """Whether the sweep is complete; if not, it is running or was interrupted."""
        return self.state == DONE

    def row(self) -> dict[str, Any]:
        """Return the sweep as a dict, keyed by the names used in JSON."""
        counts = self.tally
        return {
            "p": self.p,
            "N_t": counts.words,
            "N_c": counts.n_c,
            "classes": counts.classes,
            "boundary": counts.boundary,
            "unresolved": counts.unresolved,
            "seconds": self.seconds,
            "processor_seconds": self.processor,
        }


def read_sweeps(connection: sa.Connection, a: float) -> list[Sweep]:
    """Return the sweeps at a given a, in order of period."""
    query = sa.select(sweep).join(stadium).where(stadium.c.a == a).order_by(sweep.c.p)
    return [_as_sweep(row) for row in connection.execute(query)]


def moments_of(sweeps: Iterable[Sweep]) -> "list[Mapping[int, TiltMoments]]":
    """Return the moments of the swept periods above `EXACT`, up to the first period that has none."""
    from orbitdb.averages.sum_rules import EXACT

    by_period = {stored.p: stored.moments for stored in sweeps}
    moments: list[Mapping[int, TiltMoments]] = []
    while stored := by_period.get(EXACT + 1 + len(moments)):
        moments.append(stored)
    return moments


def _as_sweep(row: sa.Row[Any]) -> Sweep:
    from orbitdb.averages.by_period import PeriodSums
    from orbitdb.averages.tilting import from_bytes
    from orbitdb.orbits.exponents import Tally

    values = row._mapping
    p, counts = values["p"], [values[name] for name in SWEPT]
    sums, moments = None, {}
    if values["state"] == DONE:
        sums, moments = PeriodSums.from_numbers(p, values["sums"] or b""), from_bytes(values["moments"])
    spent = values["blocks"], values["seconds"], values["processor"]
    return Sweep(p, values["state"], Tally(*counts), *spent, sums, moments)


# bounds on the entropy, levels, trajectories, and the size of rows


def bounds_by_a(
    connection: sa.Connection, proof: str | None = None, a: float | None = None
) -> list[EntropyBounds]:
    """Return the tightest stored bounds on the entropy at every a, or at a given a, in order of a.

    If two are equally tight, the one proved in ball arithmetic is returned. With `proof`, only bounds with
    this proof count.
    """
    if proof not in (None, DOUBLES, BALLS):
        raise InputError(f"proof {proof!r}: use {DOUBLES} or {BALLS}")
    table = entropy_bound.c
    names = (table.a, table.edges, table.lower, table.upper, table.windows, table.undecided, table.proof)
    query = sa.select(*names).order_by(table.a, table.edges, table.proof)
    if proof is not None:
        query = query.where(table.proof == proof)
    if a is not None:
        query = query.where(table.a == a)
    stored = (EntropyBounds(*row) for row in connection.execute(query))
    by_a = groupby(stored, key=lambda bounds: bounds.a)
    return [min(group, key=lambda bounds: (bounds.width, bounds.proof)) for _, group in by_a]


def tightest_bounds(connection: sa.Connection, a: float, proof: str | None = None) -> EntropyBounds | None:
    """Return the tightest stored bounds on the entropy at a given a (`bounds_by_a`), or None."""
    return next(iter(bounds_by_a(connection, proof, Stadium(a).a)), None)


def best_reference(connection: sa.Connection, a: float) -> "Reference | None":
    """Return the averages over trajectories with the smallest error at a given a, or None."""
    from orbitdb.trajectories.ensemble import Reference

    names = [field.name for field in fields(Reference)]
    query = (
        sa.select(*(trajectory.c[name] for name in names))
        .join(stadium)
        .where(stadium.c.a == a)
        .order_by(trajectory.c.lambda_d_error)
        .limit(1)
    )
    row = connection.execute(query).mappings().first()
    if row is None:
        return None
    return Reference(**{**row, "seed": int(row["seed"])})


@dataclass(frozen=True)
class Contents:
    """What is stored at one value of a, in all periods or in some.

    Attributes
    ----------
    words : int
        Number of words with an orbit or a status.
    filled, swept : tuple of int
        Periods that are filled or swept, completely or in part.
    levels, bounds, trajectories : int
        Number of quantum levels, bounds on the entropy, and averages over random trajectories; 0 if only some
        periods were asked for.
    """

    words: int
    filled: tuple[int, ...]
    swept: tuple[int, ...]
    levels: int = 0
    bounds: int = 0
    trajectories: int = 0

    def __bool__(self) -> bool:
        return any(getattr(self, field.name) for field in fields(self))

    def __str__(self) -> str:
        parts = [several(self.words, "word")] if self.words else []
        for noun, periods in (("fill", self.filled), ("sweep", self.swept)):
            if periods:
                parts.append(f"{several(len(periods), noun)} ({written_periods(periods)})")
        parts += [several(self.levels, "quantum level")] if self.levels else []
        parts += [several(self.bounds, "bound") + " on the entropy"] if self.bounds else []
        parts += [several(self.trajectories, "average") + " over trajectories"] if self.trajectories else []
        return ", ".join(parts) or "nothing"


def contents(connection: sa.Connection, a: float, spans: Sequence[tuple[int, int]] = ()) -> Contents:
    """Return what is stored at a given a, in the periods of `spans` or in all."""
    own = sa.select(stadium.c.id).where(stadium.c.a == a).scalar_subquery()

    def within(period: sa.Column[int]) -> sa.ColumnElement[bool]:
        return sa.or_(*(period.between(*span) for span in spans)) if spans else sa.true()

    def periods(table: sa.Table) -> tuple[int, ...]:
        query = sa.select(table.c.p).where(table.c.stadium == own, within(table.c.p)).distinct()
        return tuple(connection.scalars(query.order_by(table.c.p)))

    def count(table: sa.Table, where: sa.ColumnElement[bool]) -> int:
        return connection.scalar(sa.select(sa.func.count()).select_from(table).where(where)) or 0

    words = sa.select(sa.func.sum(cycle.c.class_size)).join_from(orbit, cycle)
    stored = connection.scalar(words.where(orbit.c.stadium == own, within(cycle.c.p))) or 0
    rest = (
        (level, level.c.a == a),
        (entropy_bound, entropy_bound.c.a == a),
        (trajectory, trajectory.c.stadium == own),
    )
    return Contents(
        stored, periods(fill), periods(sweep), *(() if spans else (count(*condition) for condition in rest))
    )


def level_windows(connection: sa.Connection) -> list[tuple[float, str, float, float, int]]:
    """Return a, parity, least and greatest k, and number of levels of each range without a gap."""
    inside = (level.c.a == level_fill.c.a) & (level.c.parity == level_fill.c.parity)
    inside &= (level.c.number > level_fill.c.below) & (level.c.k < level_fill.c.high)
    keys = level_fill.c.a, level_fill.c.parity, level_fill.c.low, level_fill.c.high
    query = sa.select(*keys, sa.func.count(level.c.number)).outerjoin(level, inside).group_by(*keys)
    joined: list[tuple[float, str, float, float, int]] = []
    for a, parity, low, high, count in connection.execute(query.order_by(*keys)):
        if joined and joined[-1][:2] == (a, parity) and joined[-1][3] == low:
            _, _, low, _, before = joined.pop()
            count += before
        joined.append((a, parity, low, high, count))
    return joined


def trajectories(connection: sa.Connection) -> list[tuple[float, int, int]]:
    """Return each a with averages over random trajectories, their number, and the bounces of the longest."""
    query = sa.select(stadium.c.a, sa.func.count(), sa.func.max(trajectory.c.bounces)).join_from(
        trajectory, stadium
    )
    return [(a, count, bounces) for a, count, bounces in connection.execute(query.group_by(stadium.c.a))]


def room(connection: sa.Connection) -> dict[str, tuple[int, float | None]]:
    """Return the numbers of classes, orbits and pruned words, each with the bytes per row.

    The bytes are None if there are no rows, or if SQLite was built without `dbstat`.
    """
    tables = {"classes": cycle, "orbits": orbit, "pruned words": pruned}
    counts = [sa.select(sa.func.count()).select_from(table).scalar_subquery() for table in tables.values()]
    rows, pages = connection.execute(sa.select(*counts)).one(), _bytes_of_tables(connection)
    sizes = zip(tables.items(), rows, strict=True)
    return {
        name: (count, pages[table.name] / count if pages and count else None)
        for (name, table), count in sizes
        if count or table is not pruned
    }


def _bytes_of_tables(connection: sa.Connection) -> dict[str, int]:
    try:
        rows = connection.exec_driver_sql("SELECT name, pgsize FROM dbstat WHERE aggregate = TRUE").all()
    except sa.exc.OperationalError:
        return {}
    return {str(row.name): int(row.pgsize) for row in rows}
