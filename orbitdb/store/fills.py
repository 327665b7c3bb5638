"""Read fills and sweeps: their progress, and the counts and sums of finished periods."""

import sqlite3
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, fields
from itertools import groupby
from typing import TYPE_CHECKING, Any

from orbitdb.billiard.stadium import Stadium
from orbitdb.entropy.bounds import BALLS, DOUBLES, EntropyBounds
from orbitdb.errors import InputError
from orbitdb.extras import Record
from orbitdb.orbits.status import Status
from orbitdb.store.connection import Connection
from orbitdb.store.schema import AT_A, DONE, SWEPT
from orbitdb.store.selection import written_periods
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


def read_fills(connection: Connection, a: float) -> list[Fill]:
    """Return the fills at a given a, in order of period."""
    return [_as_fill(row) for row in connection.records(f"SELECT * FROM fill WHERE {AT_A} ORDER BY p", (a,))]


def _as_fill(row: Mapping[str, Any]) -> Fill:
    pruned = tuple(row[f"rule_{number}"] for number in range(1, 7))
    names = (column.name for column in fields(Fill) if column.name != "pruned")
    return Fill(pruned=pruned, **{name: row[name] for name in names})


def words_up_to(connection: Connection, stadium: int | None, p: int, last: str) -> int:
    """Count the words of a period in the stored classes with representatives up to `last`.

    A class counts as stored if it has an orbit at the stadium or, if that is None, if it has births.
    """
    rows, only = ("change", "number = 1") if stadium is None else ("orbit", f"stadium = {stadium}")
    query = f"""SELECT sum(class_size) FROM {rows} JOIN cycle ON cycle.id = {rows}.cycle
        WHERE {only} AND cycle.id BETWEEN ? AND ?"""
    return connection.scalar(query, (keys_of_period(p)[0], key(last))) or 0


def status_counts(
    connection: Connection, stadium: int, p: int | None = None
) -> dict[int, dict[str, tuple[int, int]]]:
    """Return the numbers of words and classes at a stadium, by period and status."""
    of_period = "" if p is None else "AND orbit.cycle BETWEEN {} AND {}".format(*keys_of_period(p))
    query = f"""SELECT cycle.p, orbit.status, sum(cycle.class_size), count(*)
        FROM orbit JOIN cycle ON cycle.id = orbit.cycle WHERE orbit.stadium = ? {of_period} GROUP BY 1, 2"""
    counts: dict[int, dict[str, tuple[int, int]]] = {}
    for period, status, words, classes in connection.execute(query, (stadium,)):
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


def read_sweeps(connection: Connection, a: float) -> list[Sweep]:
    """Return the sweeps at a given a, in order of period."""
    rows = connection.records(f"SELECT * FROM sweep WHERE {AT_A} ORDER BY p", (a,))
    return [_as_sweep(row) for row in rows]


def moments_of(sweeps: Iterable[Sweep]) -> "list[Mapping[int, TiltMoments]]":
    """Return the moments of the swept periods above `EXACT`, up to the first period that has none."""
    from orbitdb.averages.sum_rules import EXACT

    by_period = {stored.p: stored.moments for stored in sweeps}
    moments: list[Mapping[int, TiltMoments]] = []
    while stored := by_period.get(EXACT + 1 + len(moments)):
        moments.append(stored)
    return moments


def _as_sweep(row: Mapping[str, Any]) -> Sweep:
    from orbitdb.averages.by_period import PeriodSums
    from orbitdb.averages.tilting import from_bytes
    from orbitdb.orbits.exponents import Tally

    p, tally = row["p"], Tally(*(row[name] for name in SWEPT))
    sums, moments = None, {}
    if row["state"] == DONE:
        sums, moments = PeriodSums.from_numbers(p, row["sums"] or b""), from_bytes(row["moments"])
    spent = row["blocks"], row["seconds"], row["processor"]
    return Sweep(p, row["state"], tally, *spent, sums, moments)


# bounds on the entropy, levels, trajectories, and the size of rows


def bounds_by_a(
    connection: Connection, proof: str | None = None, a: float | None = None
) -> list[EntropyBounds]:
    """Return the tightest stored bounds on the entropy at every a, or at a given a, in order of a.

    If two are equally tight, the one proved in ball arithmetic is returned. With `proof`, only bounds with
    this proof count.
    """
    if proof not in (None, DOUBLES, BALLS):
        raise InputError(f"proof {proof!r}: use {DOUBLES} or {BALLS}")
    query = """SELECT a, edges, lower, upper, windows, undecided, proof FROM entropy_bound
        WHERE proof = coalesce(?, proof) AND a = coalesce(?, a) ORDER BY a, edges, proof"""
    stored = (EntropyBounds(*row) for row in connection.execute(query, (proof, a)))
    by_a = groupby(stored, key=lambda bounds: bounds.a)
    return [min(group, key=lambda bounds: (bounds.width, bounds.proof)) for _, group in by_a]


def tightest_bounds(connection: Connection, a: float, proof: str | None = None) -> EntropyBounds | None:
    """Return the tightest stored bounds on the entropy at a given a (`bounds_by_a`), or None."""
    return next(iter(bounds_by_a(connection, proof, Stadium(a).a)), None)


def best_reference(connection: Connection, a: float) -> "Reference | None":
    """Return the averages over trajectories with the smallest error at a given a, or None."""
    from orbitdb.trajectories.ensemble import Reference

    names = ", ".join(field.name for field in fields(Reference) if field.name != "a")
    query = f"SELECT {names} FROM trajectory WHERE {AT_A} ORDER BY lambda_d_error LIMIT 1"
    row = next(connection.records(query, (a,)), None)
    return None if row is None else Reference(**{**row, "a": a, "seed": int(row["seed"])})


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


def contents(connection: Connection, a: float, spans: Sequence[tuple[int, int]] = ()) -> Contents:
    """Return what is stored at a given a, in the periods of `spans` or in all."""
    chosen = of_spans(spans)

    def periods(table: str) -> tuple[int, ...]:
        query = f"SELECT DISTINCT p FROM {table} WHERE {AT_A} AND {chosen} ORDER BY p"
        return tuple(p for (p,) in connection.execute(query, (a,)))

    def count(table: str, where: str) -> int:
        return int(connection.scalar(f"SELECT count(*) FROM {table} WHERE {where}", (a,)))

    words = "SELECT sum(class_size) FROM orbit JOIN cycle ON cycle.id = orbit.cycle"
    stored = connection.scalar(f"{words} WHERE {AT_A} AND {chosen}", (a,)) or 0
    rest = (("level", "a = ?"), ("entropy_bound", "a = ?"), ("trajectory", AT_A))
    counts = () if spans else (count(*condition) for condition in rest)
    return Contents(stored, periods("fill"), periods("sweep"), *counts)


def of_spans(spans: Sequence[tuple[int, int]]) -> str:
    """Return the condition that the column p is in one of the ranges; without ranges, every p is."""
    return f"({' OR '.join(f'p BETWEEN {low} AND {high}' for low, high in spans) or 'TRUE'})"


def level_windows(connection: Connection) -> list[tuple[float, str, float, float, int]]:
    """Return a, parity, least and greatest k, and number of levels of each range without a gap."""
    query = """SELECT own.a, own.parity, low, high, count(number) FROM level_fill AS own LEFT JOIN level
        ON level.a = own.a AND level.parity = own.parity AND number > below AND k < high
        GROUP BY 1, 2, 3, 4 ORDER BY 1, 2, 3, 4"""
    joined: list[tuple[float, str, float, float, int]] = []
    for a, parity, low, high, count in connection.execute(query):
        if joined and joined[-1][:2] == (a, parity) and joined[-1][3] == low:
            _, _, low, _, before = joined.pop()
            count += before
        joined.append((a, parity, low, high, count))
    return joined


def trajectories(connection: Connection) -> list[tuple[float, int, int]]:
    """Return each a with averages over random trajectories, their number, and the bounces of the longest."""
    query = """SELECT stadium.a, count(*), max(bounces) FROM trajectory JOIN stadium
        ON stadium.id = trajectory.stadium GROUP BY stadium.a"""
    return connection.execute(query).fetchall()


def room(connection: Connection) -> dict[str, tuple[int, float | None]]:
    """Return the numbers of classes, orbits and pruned words, each with the bytes per row.

    The bytes are None if there are no rows, or if SQLite was built without `dbstat`.
    """
    try:
        pages = dict(connection.execute("SELECT name, pgsize FROM dbstat WHERE aggregate = TRUE"))
    except sqlite3.OperationalError:
        pages = {}
    rows = {}
    for name, table in {"classes": "cycle", "orbits": "orbit", "pruned words": "pruned"}.items():
        count = int(connection.scalar(f"SELECT count(*) FROM {table}"))
        if count or table != "pruned":
            rows[name] = count, pages[table] / count if pages and count else None
    return rows
