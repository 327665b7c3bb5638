"""Progress of fills, and the counts of finished periods."""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

import sqlalchemy as sa

from orbitdb.extras import Record
from orbitdb.orbits.status import Status
from orbitdb.store.file.schema import DONE
from orbitdb.store.file.tables import change, cycle, fill, orbit, stadium
from orbitdb.store.reading.soundness import unsound
from orbitdb.symbols.pruning import RULE_NUMBERS, count_admissible, count_primitive
from orbitdb.symbols.words import MAX_PACKED, key, keys_of_period


@dataclass(frozen=True)
class Fill(Record):
    """Progress of a period at one a, and the counts of the paper's Table 1.

    Attributes
    ----------
    p : int
        Period.
    state : str
        ``filling`` or ``done``; counts exist once it is done.
    words : int
        Words stored so far.
    seconds : float
        Elapsed time.
    enumerating, solving, storing : float
        Processor time in seconds for words and classes, orbits, and the database.
    primitive : int or None
        All primitive cyclic words of the period.
    pruned : tuple of int or None
        Numbers of them that break rules 1 to 6.
    n_t, n_c : int or None
        Words left after geometric pruning, and orbits.
    classes : int or None
        Symmetry classes of the orbits.
    boundary, unresolved : int or None
        Words with these statuses.
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
        """Whether all words of the period are stored; otherwise a fill is running or was stopped."""
        return self.state == DONE


def fills(connection: sa.Connection, a: float) -> list[Fill]:
    """Return the fills at one a, by period."""
    query = sa.select(fill).join(stadium).where(stadium.c.a == a).order_by(fill.c.p)
    return [_as_fill(row) for row in connection.execute(query)]


def _as_fill(row: sa.Row[Any]) -> Fill:
    """Return a row of the table ``fill``; raise `StoreError` if its period is impossible."""
    values = row._mapping
    if not 2 <= values["p"] <= MAX_PACKED:
        raise unsound("a filled period of", values["p"])
    pruned = tuple(values[f"rule_{number}"] for number in range(1, 7))
    names = (each.name for each in fields(Fill) if each.name != "pruned")
    return Fill(pruned=pruned, **{name: values[name] for name in names})


def words_up_to(connection: sa.Connection, stadium: int | None, p: int, last: str) -> int:
    """Return the number of words in the classes of a period with representatives up to `last`.

    Counts classes with a row at the stadium; without a stadium, classes with births.
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
    """Return the numbers of words and classes at one stadium by period and status."""
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
    """Return the counts of a filled period, from its rows by status and the pruning rules."""
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
