"""Read fills and sweeps: their progress, and the counts and sums of finished periods."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, fields
from typing import TYPE_CHECKING, Any

import sqlalchemy as sa

from orbitdb.extras import Record
from orbitdb.orbits.status import Status
from orbitdb.store.file.schema import DONE, SWEPT
from orbitdb.store.file.tables import change, cycle, fill, orbit, stadium, sweep
from orbitdb.store.reading.soundness import unsound
from orbitdb.symbols.enumeration import MAX_PERIOD
from orbitdb.symbols.pruning import RULE_NUMBERS, count_admissible, count_primitive
from orbitdb.symbols.words import MAX_PACKED, key, keys_of_period

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
    def whole(self) -> bool:
        """Whether all words of the period are stored; if not, a fill is running or was interrupted."""
        return self.state == DONE


def fills(connection: sa.Connection, a: float) -> list[Fill]:
    """Return the fills at a given a, in order of period."""
    query = sa.select(fill).join(stadium).where(stadium.c.a == a).order_by(fill.c.p)
    return [_as_fill(row) for row in connection.execute(query)]


def _as_fill(row: sa.Row[Any]) -> Fill:
    values = row._mapping
    if not 2 <= values["p"] <= MAX_PACKED:
        raise unsound("a fill of period", values["p"])
    pruned = tuple(values[f"rule_{number}"] for number in range(1, 7))
    names = (each.name for each in fields(Fill) if each.name != "pruned")
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
    here = [] if p is None else [orbit.c.cycle.between(*keys_of_period(p))]
    query = (
        sa.select(cycle.c.p, orbit.c.status, sa.func.sum(cycle.c.class_size), sa.func.count())
        .join(cycle, cycle.c.id == orbit.c.cycle)
        .where(orbit.c.stadium == stadium, *here)
        .group_by(cycle.c.p, orbit.c.status)
    )
    found: dict[int, dict[str, tuple[int, int]]] = {}
    for p, status, words, classes in connection.execute(query):
        found.setdefault(p, {})[status] = (words, classes)
    return found


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


def sweeps(connection: sa.Connection, a: float) -> list[Sweep]:
    """Return the sweeps at a given a, in order of period."""
    query = sa.select(sweep).join(stadium).where(stadium.c.a == a).order_by(sweep.c.p)
    return [_as_sweep(row) for row in connection.execute(query)]


def moments_of(found: Iterable[Sweep]) -> "list[Mapping[int, TiltMoments]]":
    """Return the moments of the swept periods above `EXACT`, up to the first period that has none."""
    from orbitdb.averages.sum_rules import EXACT

    known = {each.p: each.moments for each in found}
    moments: list[Mapping[int, TiltMoments]] = []
    while each := known.get(EXACT + 1 + len(moments)):
        moments.append(each)
    return moments


def _as_sweep(row: sa.Row[Any]) -> Sweep:
    from orbitdb.averages.by_period import PeriodSums
    from orbitdb.averages.tilting import from_bytes
    from orbitdb.orbits.exponents import Tally

    values = row._mapping
    p, counts = values["p"], [values[name] for name in SWEPT]
    if not 2 <= p <= MAX_PERIOD or min(counts) < 0:
        raise unsound("a sweep of period", p)
    sums, moments = None, {}
    if values["state"] == DONE:
        try:
            sums = PeriodSums.from_numbers(p, values["sums"] or b"")
            moments = from_bytes(values["moments"])
        except ValueError as error:
            raise unsound("sums of a sweep:", error) from error
    spent = values["blocks"], values["seconds"], values["processor"]
    return Sweep(p, values["state"], Tally(*counts), *spent, sums, moments)
