"""From where to where in a the stored classes are orbits, and what that says of any a without a fill.

A class is an orbit at a where a lies inside one of its lives. Where a is so near to the end of a life
that the end's error bound does not tell, the class's word is solved there, in ball arithmetic if need
be: so orbits through a joint are recognised as such, as in a fill.
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields

import sqlalchemy as sa

from orbitdb.billiard.stadium import Stadium
from orbitdb.orbits.orbit import Status
from orbitdb.store.asking.conditions import NEAR
from orbitdb.store.file.schema import DONE
from orbitdb.store.file.tables import birth_fill, change, cycle, life
from orbitdb.store.reading.fills import written_periods
from orbitdb.store.reading.soundness import is_written, unsound
from orbitdb.symbols.counting import count_admissible
from orbitdb.symbols.words import MAX_KEYED, from_strings, keys_of_period


@dataclass(frozen=True)
class BirthFill:
    """How far the births and deaths of a period are stored, and what they come to.

    Attributes
    ----------
    p : int
    state : str
        ``filling`` or ``done``; there are no counts before it is done.
    words : int
        Words of which the changes are stored.
    seconds : float
        Time spent.
    classes : int or None
        Symmetry classes of the period.
    births : int or None
        How often a class begins to be an orbit at some a above 0.
    deaths : int or None
        How many classes cease to be orbits at least once.
    always : int or None
        How many classes are orbits from a = 0 on.
    least, largest : float or None
        The first and the last birth.
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
    def whole(self) -> bool:
        """Whether the changes of all classes of the period are stored."""
        return self.state == DONE


@dataclass(frozen=True)
class Life:
    """One life of a symmetry class.

    Attributes
    ----------
    word : str
        The least word of the class.
    p, class_size : int
    born, born_error : float
        The a at which it begins to be an orbit, 0 if it always was, and how far off that may be.
    dies, dies_error : float or None
        The same of its end; None if it has none.
    """

    word: str
    p: int
    class_size: int
    born: float
    born_error: float
    dies: float | None
    dies_error: float | None


@dataclass(frozen=True)
class Counts:
    """The counts of the paper's Table 1 for one period at one a, from births.

    Attributes
    ----------
    p, n_t, n_c, classes, boundary, unresolved : int
        As those of `orbitdb.store.reading.fills.Fill`.
    """

    p: int
    n_t: int
    n_c: int
    classes: int
    boundary: int
    unresolved: int


def birth_fills(connection: sa.Connection) -> list[BirthFill]:
    """Return how far births are stored, by period."""
    names = [each.name for each in fields(BirthFill)]
    query = sa.select(*(birth_fill.c[name] for name in names)).order_by(birth_fill.c.p)
    found = [BirthFill(*row) for row in connection.execute(query)]
    for each in found:
        if not 2 <= each.p <= MAX_KEYED:
            raise unsound("births of a period of", each.p)
    return found


def lives(connection: sa.Connection, p: int) -> list[Life]:
    """Return the lives of all classes of one period, by their births."""
    names = [each.name for each in fields(Life)]
    here = life.c.cycle.between(*keys_of_period(p))
    query = sa.select(*(life.c[name] for name in names)).where(here).order_by(life.c.born, life.c.word)
    return [Life(*row) for row in connection.execute(query)]


def describe_lacking(periods: Sequence[int]) -> str | None:
    """Say in one line of which periods no births are stored, and what finds them; None if there are none."""
    if not periods:
        return None
    return (
        f"births of {written_periods(periods)} are not found, so that what depends on them is left out or "
        f"blank: 'orbitdb births --p {max(periods)}' finds them"
    )


def counts_at(connection: sa.Connection, a: float, p: int) -> Counts:
    """Return the counts of one period at one a, from the births of all its classes.

    Parameters
    ----------
    connection : sa.Connection
    a : float
        The stadium.
    p : int
        A period of which all births are stored.
    """
    here = change.c.cycle.between(*keys_of_period(p))
    near = sa.func.abs(change.c.a - a) <= NEAR * change.c.error
    doubtful = connection.execute(
        sa.select(cycle.c.id, cycle.c.word, cycle.c.class_size)
        .join_from(change, cycle)
        .where(here, near, change.c.a > 0)
        .distinct()
    ).all()
    inside = (life.c.born < a) & (life.c.dies.is_(None) | (life.c.dies > a))
    sums = sa.select(sa.func.coalesce(sa.func.sum(life.c.class_size), 0), sa.func.count())
    living = life.c.cycle.between(*keys_of_period(p)), inside
    orbits, classes = connection.execute(sums.where(*living)).one()
    numbers = [row.id for row in doubtful]
    if numbers:
        counted = connection.execute(sums.where(*living, life.c.cycle.in_(numbers))).one()
        orbits, classes = orbits - counted[0], classes - counted[1]
    words = dict.fromkeys((Status.ORBIT, Status.BOUNDARY, Status.UNRESOLVED), 0)
    if any(not is_written(row.word, p) for row in doubtful):
        raise unsound("a class of period", p)
    if doubtful:
        from orbitdb.orbits.newton import solve  # seldom needed

        found = solve(from_strings([row.word for row in doubtful]), Stadium(a))
        for status, row in zip(found.status.tolist(), doubtful, strict=True):
            if status in words:
                words[Status(status)] += row.class_size
            classes += status == Status.ORBIT
    return Counts(
        p, count_admissible(p), orbits + words[Status.ORBIT], classes,
        words[Status.BOUNDARY], words[Status.UNRESOLVED],
    )  # fmt: skip
