"""Read fills and sweeps: their progress, and the counts and sums of finished periods."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, fields
from typing import TYPE_CHECKING, Any

from sqlalchemy import Connection, func, select, true

from orbitdb.display import Record
from orbitdb.orbits.status import Status
from orbitdb.store import tables as t
from orbitdb.store.tables import DONE, TALLIED
from orbitdb.symbols.pruning import RULE_NUMBERS, count_admissible, count_primitive
from orbitdb.symbols.words import key, keys_of_period

if TYPE_CHECKING:
    from orbitdb.averages.by_period import PeriodSums
    from orbitdb.averages.tilting import TiltMoments
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
    def complete(self) -> bool:
        """Whether all words of the period are stored; if not, a fill is running or was interrupted."""
        return self.state == DONE


def read_fills(connection: Connection, a: float) -> list[Fill]:
    """Return the fills at a given a, in order of period."""
    query = select(t.fill).where(t.at_a(t.fill, a)).order_by(t.fill.c.p)
    return [_as_fill(dict(row)) for row in connection.execute(query).mappings()]


def _as_fill(row: Mapping[str, Any]) -> Fill:
    pruned = tuple(row[f"rule_{number}"] for number in range(1, 7))
    names = (column.name for column in fields(Fill) if column.name != "pruned")
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
    def complete(self) -> bool:
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
    return [_as_sweep(dict(row)) for row in connection.execute(query).mappings()]


def moments_of(sweeps: Iterable[Sweep]) -> "list[Mapping[int, TiltMoments]]":
    """Return the moments of the swept periods above `ENUMERATED_TO`, up to the first period that has none."""
    from orbitdb.averages.sum_rules import ENUMERATED_TO

    by_period = {stored.p: stored.moments for stored in sweeps}
    moments: list[Mapping[int, TiltMoments]] = []
    while stored := by_period.get(ENUMERATED_TO + 1 + len(moments)):
        moments.append(stored)
    return moments


def _as_sweep(row: Mapping[str, Any]) -> Sweep:
    from orbitdb.averages.by_period import PeriodSums
    from orbitdb.averages.tilting import from_bytes
    from orbitdb.orbits.exponents import Tally

    p, tally = row["p"], Tally(*(row[name] for name in TALLIED))
    sums, moments = None, {}
    if row["state"] == DONE:
        sums, moments = PeriodSums.from_numbers(p, row["sums"] or b""), from_bytes(row["moments"])
    spent = row["blocks"], row["seconds"], row["processor"]
    return Sweep(p, row["state"], tally, *spent, sums, moments)
