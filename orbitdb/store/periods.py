"""What is stored, period by period: fills, sweeps, births; and how much there is at an a and in all."""

import sqlite3
from collections.abc import Collection, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, fields
from typing import TYPE_CHECKING, Any

import sqlalchemy as sa
from sqlalchemy import ColumnElement, Connection, Table, distinct, func, select, true

from orbitdb.display import Record
from orbitdb.errors import AlteredError
from orbitdb.orbits.status import Status
from orbitdb.period_ranges import written_periods
from orbitdb.store import tables as t
from orbitdb.store.tables import BORN, DIED, DONE, TALLIED
from orbitdb.symbols.pruning import RULE_NUMBERS, count_admissible, count_primitive
from orbitdb.symbols.words import key, keys_of_period
from orbitdb.text import several

if TYPE_CHECKING:
    from orbitdb.averages.by_period import PeriodSums
    from orbitdb.orbits.exponents import Tally


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
    def done(self) -> bool:
        """Whether all words of the period are stored; if not, a fill is running or was interrupted."""
        return self.state == DONE


def read_fills(connection: Connection, a: float) -> list[Fill]:
    """Return the fills at a given a, in order of period."""
    query = select(t.fill).where(t.at_a(t.fill, a)).order_by(t.fill.c.p)
    return [_as_fill(t.checked(t.fill, row)) for row in connection.execute(query).mappings()]


def _as_fill(row: Mapping[str, Any]) -> Fill:
    pruned = tuple(row[f"rule_{number}"] for number in range(1, 7))
    names = (column.name for column in fields(Fill) if column.name != "pruned")
    if row["state"] == DONE and row["n_c"] is None:
        raise AlteredError(f"the fill of period {row['p']} is done, but has no counts")
    return Fill(pruned=pruned, **{name: row[name] for name in names})


def words_up_to(connection: Connection, stadium: int | None, p: int, last: str) -> int:
    """Count the words of a period in the stored classes with representatives up to `last`.

    A class counts as stored if it has an orbit at the stadium or, if that is None, if it has births.
    """
    rows = t.change if stadium is None else t.orbit
    only = t.change.c.number == 1 if stadium is None else t.orbit.c.stadium == stadium
    query = select(func.sum(t.cycle.c.class_size)).join_from(rows, t.cycle, t.cycle.c.id == rows.c.cycle)
    own = t.cycle.c.id.between(keys_of_period(p)[0], key(last))
    return connection.scalar(query.where(only, own)) or 0


def status_counts(
    connection: Connection, stadium: int, p: int | None = None
) -> dict[int, dict[str, tuple[int, int]]]:
    """Return the numbers of words and classes at a stadium, by period and status."""
    own = true() if p is None else t.orbit.c.cycle.between(*keys_of_period(p))
    query = (
        select(t.cycle.c.p, t.orbit.c.status, func.sum(t.cycle.c.class_size), func.count())
        .join_from(t.orbit, t.cycle, t.cycle.c.id == t.orbit.c.cycle)
        .where(t.orbit.c.stadium == stadium, own)
        .group_by(t.cycle.c.p, t.orbit.c.status)
    )
    counts: dict[int, dict[str, tuple[int, int]]] = {}
    for period, status, words, classes in connection.execute(query):
        counts.setdefault(period, {})[status] = (words, classes)
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
    """

    p: int
    state: str
    tally: "Tally"
    blocks: int
    seconds: float
    processor: float
    sums: "PeriodSums | None" = field(repr=False)

    @property
    def done(self) -> bool:
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


def read_sweeps(connection: Connection, a: float) -> list[Sweep]:
    """Return the sweeps at a given a, in order of period."""
    query = select(t.sweep).where(t.at_a(t.sweep, a)).order_by(t.sweep.c.p)
    return [_as_sweep(t.checked(t.sweep, row)) for row in connection.execute(query).mappings()]


def _as_sweep(row: Mapping[str, Any]) -> Sweep:
    from orbitdb.averages.by_period import PeriodSums
    from orbitdb.orbits.exponents import Tally

    p, tally = row["p"], Tally(*(row[name] for name in TALLIED))
    with t.readable(f"the sweep of period {p}"):
        sums = PeriodSums.from_numbers(p, row["sums"] or b"") if row["state"] == DONE else None
    return Sweep(p, row["state"], tally, row["blocks"], row["seconds"], row["processor"], sums)


@dataclass(frozen=True)
class BirthFill(Record):
    """How far the births and deaths of a period are stored, and their counts.

    Attributes
    ----------
    p : int
    state : str
        ``filling`` or ``done``; the counts exist once it is ``done``.
    words : int
        Number of words whose births and deaths are stored.
    seconds : float
        Elapsed time.
    classes : int or None
        Number of symmetry classes of the period.
    births : int or None
        Number of births at a > 0.
    deaths, always : int or None
        Numbers of classes that die at least once, and of those that are orbits from a = 0 on.
    least, largest : float or None
        The smallest and the largest a at which a class is born.
    """

    p: int
    state: str
    words: int
    seconds: float
    classes: int | None
    births: int | None
    deaths: int | None
    always: int | None
    least: float | None
    largest: float | None

    @property
    def done(self) -> bool:
        """Whether the births and deaths of all classes of the period are stored."""
        return self.state == DONE

    @property
    def notes(self) -> tuple[str, ...]:
        """What is missing, and how to find it."""
        missing = (
            f"births of period {self.p} are incomplete: `catalogue.fill_births(p={self.p})` completes them"
        )
        return () if self.done else (missing,)


def read_birth_fills(connection: Connection) -> list[BirthFill]:
    """Return how far births and deaths are stored, in order of period."""
    columns = [t.birth_fill.c[field.name] for field in fields(BirthFill)]
    rows = connection.execute(select(*columns).order_by(t.birth_fill.c.p)).mappings()
    return [BirthFill(**t.checked(t.birth_fill, row)) for row in rows]


_MOVING = t.change.c.a > 0
_COUNTS = select(
    func.sum(func.iif(t.change.c.number == 1, t.cycle.c.class_size, 0)).label("words"),
    func.count(distinct(t.change.c.cycle)).label("classes"),
    func.count().filter(t.change.c.kind == BORN, _MOVING).label("births"),
    func.count(distinct(t.change.c.cycle)).filter(t.change.c.kind == DIED, _MOVING).label("deaths"),
    func.count().filter(t.change.c.a == 0).label("always"),
    func.min(t.change.c.a).filter(t.change.c.kind == BORN, _MOVING).label("least"),
    func.max(t.change.c.a).filter(t.change.c.kind == BORN, _MOVING).label("largest"),
).join_from(t.change, t.cycle, t.cycle.c.id == t.change.c.cycle)


def count_births(connection: Connection, p: int) -> dict[str, Any]:
    """Count what the row of a period in `birth_fill` counts, from the births and deaths of the period."""
    return dict(connection.execute(_COUNTS.where(t.cycle.c.p == p)).mappings().one())


@dataclass(frozen=True)
class Contents:
    """What is stored at one value of a, in all periods or in some.

    Attributes
    ----------
    words : int
        Number of words with an orbit or a status.
    pruned : int
        Number of geometrically pruned words of periods that are filled at no other a.
    filled, swept : tuple of int
        Periods that are filled or swept, completely or in part.
    levels, bounds, trajectories, escapes : int
        Number of quantum levels, bounds on the entropy, averages over random trajectories, and open stadiums;
        0 if only some periods were asked for.
    """

    words: int
    pruned: int
    filled: tuple[int, ...]
    swept: tuple[int, ...]
    levels: int = 0
    bounds: int = 0
    trajectories: int = 0
    escapes: int = 0

    def __bool__(self) -> bool:
        return any(getattr(self, field.name) for field in fields(self))

    def __str__(self) -> str:
        parts = [several(self.words, "word")] if self.words else []
        parts += [several(self.pruned, "geometrically pruned word")] if self.pruned else []
        for noun, periods in (("fill", self.filled), ("sweep", self.swept)):
            if periods:
                parts.append(f"{several(len(periods), noun)} ({written_periods(periods)})")
        parts += [several(self.levels, "quantum level")] if self.levels else []
        parts += [several(self.bounds, "bound") + " on the entropy"] if self.bounds else []
        parts += [several(self.trajectories, "average") + " over trajectories"] if self.trajectories else []
        parts += [several(self.escapes, "open stadium")] if self.escapes else []
        return ", ".join(parts) or "nothing"


def contents(connection: Connection, a: float, spans: Sequence[tuple[int, int]] = ()) -> Contents:
    """Return what is stored at a given a, in the periods of `spans` or in all."""

    def periods(table: Table) -> tuple[int, ...]:
        own = (t.at_a(table, a), t.in_spans(table.c.p, spans))
        return tuple(connection.scalars(select(table.c.p).where(*own).order_by(table.c.p)))

    def count(table: Table, own: ColumnElement[bool]) -> int:
        return connection.scalar(select(func.count()).select_from(table).where(own)) or 0

    words = select(func.sum(t.cycle.c.class_size)).join_from(
        t.orbit, t.cycle, t.cycle.c.id == t.orbit.c.cycle
    )
    stored = connection.scalar(words.where(t.at_a(t.orbit, a), t.in_spans(t.cycle.c.p, spans))) or 0
    rest = (
        (t.level, t.level.c.a == a),
        (t.entropy_bound, t.entropy_bound.c.a == a),
        (t.trajectory, t.at_a(t.trajectory, a)),
        (t.open_stadium, t.open_stadium.c.a == a),
    )
    counts = () if spans else (count(*condition) for condition in rest)
    return Contents(
        stored, count(t.pruned, filled_last(t.pruned, a, spans)), periods(t.fill), periods(t.sweep), *counts
    )


_SIZES = sa.table("dbstat", sa.column("name"), sa.column("pgsize"), sa.column("aggregate"))
"""SQLite's own table of the space that each table takes."""


def room(connection: Connection) -> dict[str, tuple[int, float | None]]:
    """Return the numbers of classes, of classes solved at each a, and of pruned words, with bytes per row.

    The bytes are None if there are no rows, or if SQLite was built without `dbstat`.
    """
    pages: dict[str, int] = {}
    with suppress(sqlite3.OperationalError):
        sizes = connection.execute(select(_SIZES.c.name, _SIZES.c.pgsize).where(_SIZES.c.aggregate == 1))
        pages = dict(tuple(row) for row in sizes)
    rows = {}
    for name, stored in {"classes": t.cycle, "solved": t.orbit, "pruned words": t.pruned}.items():
        count = connection.scalar(select(func.count()).select_from(stored)) or 0
        if count or stored is not t.pruned:
            rows[name] = count, pages[stored.name] / count if pages and count else None
    return rows


def schema_version(connection: Connection) -> int:
    """Return the schema version of the file."""
    return int(connection.exec_driver_sql("PRAGMA user_version").scalar_one())


def sqlite_version(connection: Connection) -> str:
    """Return the version of SQLite that reads the catalogue."""
    return str(connection.scalar(select(func.sqlite_version())))


def class_rows(
    connection: Connection, names: Sequence[str], periods: Collection[int]
) -> list[tuple[Any, ...]]:
    """Return columns of the table `cycle` for all stored classes of some periods, in order."""
    query = select(*(t.cycle.c[name] for name in names)).where(t.cycle.c.p.in_(periods))
    return [tuple(row) for row in connection.execute(query.order_by(t.cycle.c.id))]


def runs(connection: Connection) -> list[tuple[str, str]]:
    """Return the version and the parameters, as JSON, of every run that wrote to the file."""
    query = select(t.run.c.version, t.run.c.parameters).order_by(t.run.c.id)
    return [(version, parameters) for version, parameters in connection.execute(query)]


def read_pruned_fills(connection: Connection) -> dict[int, tuple[int, bool]]:
    """Return the number of pruned words stored so far, and whether these are all, for each period begun."""
    rows = connection.execute(select(t.pruned_fill.c.p, t.pruned_fill.c.words, t.pruned_fill.c.state))
    return {p: (words, state == DONE) for p, words, state in rows}


def pruned_up_to(connection: Connection, p: int, last: str) -> int:
    """Count the stored geometrically pruned words of a period up to `last`."""
    own = t.pruned.c.id.between(-key(last), -keys_of_period(p)[0])
    return connection.scalar(select(func.count()).select_from(t.pruned).where(own)) or 0


def filled_last(table: Table, a: float, spans: Sequence[tuple[int, int]] = ()) -> ColumnElement[bool]:
    """Return the condition for rows of periods that are filled at this a, and at no other.

    Geometrically pruned words, which are the same at every a, are deleted with the last fill of their period.
    """
    here, fills = t.at_a(t.fill, a), select(t.fill.c.p)
    own = fills.where(here, t.in_spans(t.fill.c.p, spans))
    return sa.and_(table.c.p.in_(own), table.c.p.not_in(fills.where(~here)))
