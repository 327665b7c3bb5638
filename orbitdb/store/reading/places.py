"""Find words, periods and beginnings of codes among the rows of a chosen subset."""

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
import sqlalchemy as sa

from orbitdb.arrays import Integers
from orbitdb.store.asking.confinement import never
from orbitdb.store.file.schema import LONG
from orbitdb.store.file.tables import cycle, pruned
from orbitdb.store.reading.chosen import ALL, Chosen, orders_of
from orbitdb.store.reading.fitting import fitting, stabilisers_of_classes
from orbitdb.symbols.members import places_of_elements
from orbitdb.symbols.patterns import Like
from orbitdb.symbols.pruning import rules_of
from orbitdb.symbols.symmetry import class_of, members
from orbitdb.symbols.words import MAX_KEYED, key

if TYPE_CHECKING:
    from orbitdb.store.reading.lives import Standings


def position_of(connection: sa.Connection, chosen: Chosen, word: str) -> int | None:
    """Return the row of a code, or None."""
    if len(word) > MAX_KEYED:
        return _position_of_long(connection, chosen, word) if (np.abs(chosen.ids) >= LONG).any() else None
    if rules_of(word):
        return chosen.position(-key(word), 0)
    least = class_of(word).representative
    return chosen.position(key(least), list(members(least)).index(word))


def _position_of_long(connection: sa.Connection, chosen: Chosen, word: str) -> int | None:
    p = len(word)
    known = sa.select(cycle.c.id, cycle.c.words).where(cycle.c.id >= LONG, cycle.c.p == p)
    queries = (
        known.where(sa.func.instr(cycle.c.words, word) > 0),
        sa.select(pruned.c.id, pruned.c.word).where(pruned.c.p == p, pruned.c.word == word),
    )
    for number, words in (row for query in queries for row in connection.execute(query)):
        for place in range(len(words) // p):
            if words.startswith(word, place * p):
                return chosen.position(number, place)
    return None


def periods_of(connection: sa.Connection, ids: Integers) -> Integers:
    """Return the periods of classes and pruned words, shape (C,)."""
    found = orders_of(ids)
    if (found > MAX_KEYED).any():
        rows = connection.execute(
            sa.select(cycle.c.id, cycle.c.p)
            .where(cycle.c.id >= LONG)
            .union_all(sa.select(pruned.c.id, pruned.c.p).where(pruned.c.id <= -LONG))
        )
        known = {row.id: row.p for row in rows}
        for place in np.flatnonzero(found > MAX_KEYED).tolist():
            found[place] = known[int(ids[place])]
    return found


def periods_without(connection: sa.Connection, ids: Integers, standings: "Standings") -> list[int]:
    """Return the periods of classes without stored births."""
    return np.unique(periods_of(connection, ids[standings.places == len(standings.cycles)])).tolist()


def first_of_period(connection: sa.Connection, chosen: Chosen, p: int) -> int | None:
    """Return the first row of a period, or None."""
    here = periods_of(connection, chosen.ids) == p
    return chosen.first(np.where(here, 0xFF, 0).astype(np.uint8))


def first_beginning(
    connection: sa.Connection, chosen: Chosen, code: str, cancelled: Callable[[], bool] = never
) -> int | None:
    """Return the first row whose code begins with some symbols, or None."""
    elements = fitting(connection, chosen.ids, (Like(f"{code}%", True),), cancelled)
    stabilisers = stabilisers_of_classes(connection, chosen.ids, chosen.masks == ALL)
    return chosen.first(places_of_elements(elements, stabilisers))
