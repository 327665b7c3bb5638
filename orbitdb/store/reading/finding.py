"""Where words stand among the rows of a chosen subset, and the first of a period or with a beginning."""

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
import sqlalchemy as sa

from orbitdb.store.asking.confinement import never
from orbitdb.store.file.schema import LONG
from orbitdb.store.file.tables import cycle, pruned
from orbitdb.store.reading.chosen import Chosen, Integers, orders_of
from orbitdb.store.reading.fitting import fitting
from orbitdb.store.reading.lives import Standings
from orbitdb.store.reading.word_order import stabilisers_of_chosen
from orbitdb.symbols.members import places_of_elements
from orbitdb.symbols.patterns import Like
from orbitdb.symbols.pruning import rules_of
from orbitdb.symbols.symmetry import class_of, members
from orbitdb.symbols.words import MAX_KEYED, key

if TYPE_CHECKING:
    from orbitdb.store.reading.catalogue import Catalogue

_CLASSES = 1 << 14
"""Classes that are looked at at a time."""


def position_of(catalogue: "Catalogue", chosen: Chosen, word: str) -> int | None:
    """Return in which row a word, a least rotation, stands; None if in none."""
    if len(word) > MAX_KEYED:
        return _position_of_long(catalogue, chosen, word) if (np.abs(chosen.ids) >= LONG).any() else None
    if rules_of(word):
        return chosen.position(-key(word), 0)
    least = class_of(word).representative
    return chosen.position(key(least), list(members(least)).index(word))


def _position_of_long(catalogue: "Catalogue", chosen: Chosen, word: str) -> int | None:
    p = len(word)
    known = sa.select(cycle.c.id, cycle.c.words).where(cycle.c.id >= LONG, cycle.c.p == p)
    queries = (
        known.where(sa.func.instr(cycle.c.words, word) > 0),
        sa.select(pruned.c.id, pruned.c.word).where(pruned.c.p == p, pruned.c.word == word),
    )
    with catalogue.reading() as connection:
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


def periods_without(connection: sa.Connection, ids: Integers, standings: Standings) -> list[int]:
    """Return the periods of classes of which no births are stored."""
    return np.unique(periods_of(connection, ids[standings.places == len(standings.cycles)])).tolist()


def first_of_period(catalogue: "Catalogue", chosen: Chosen, p: int) -> int | None:
    """Return the first row of a period; None if there is none."""
    with catalogue.reading() as connection:
        here = periods_of(connection, chosen.ids) == p
    return chosen.first(np.where(here, 0xFF, 0).astype(np.uint8))


def first_beginning(
    catalogue: "Catalogue", chosen: Chosen, code: str, cancelled: Callable[[], bool] = never
) -> int | None:
    """Return the first row whose code begins with some symbols; None if there is none.

    Raises
    ------
    CancelledError
        If nobody waits any more.
    """
    masks = np.zeros_like(chosen.masks)
    with catalogue.reading() as connection:
        for start in range(0, len(masks), _CLASSES):
            here = np.arange(start, min(start + _CLASSES, len(masks)))
            elements = fitting(connection, chosen.ids[here], (Like(f"{code}%", True),), cancelled)
            masks[here] = places_of_elements(elements, stabilisers_of_chosen(connection, chosen, here))
            if chosen.rows is None and (masks[here] & chosen.masks[here]).any():
                break
    return chosen.first(masks)
