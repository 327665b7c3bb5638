"""How many rows a subset has: counted by classes, or else by a pass over all words."""

import sqlalchemy as sa

from orbitdb.store.asking.conditions import answering, conditions_of
from orbitdb.store.asking.confinement import Patience
from orbitdb.store.asking.selection import Selection
from orbitdb.store.file.schema import catalogue as view
from orbitdb.store.reading.class_first import goes_by_class, is_long, pruned_words, ragged_periods
from orbitdb.store.reading.class_view import class_view
from orbitdb.store.reading.counted_words import by_periods
from orbitdb.store.reading.first_rows import Asked


def count_rows(connection: sa.Connection, selection: Selection) -> int:
    """Return the number of rows in a subset."""
    if goes_by_class(connection, selection):
        return _count_by_class(connection, selection)
    asked = Asked(connection, selection, Patience())
    periods = by_periods(asked) if is_long(connection) else None
    if periods is not None:
        return sum(words.rows for words in periods)
    return int(asked.all(asked.rows(sa.func.count()))[0][0])


def _count_by_class(connection: sa.Connection, selection: Selection) -> int:
    ragged = ragged_periods(connection)
    classes = class_view().c
    whole = sa.select(sa.func.sum(classes.class_size))
    with answering(connection, selection, Patience()):
        found = connection.scalar(whole.where(*conditions_of(selection, classes), classes.p.not_in(ragged)))
        if ragged:
            rest = sa.select(sa.func.count()).where(*conditions_of(selection), view.c.p.in_(ragged))
            found = (found or 0) + (connection.scalar(rest) or 0)
    pruned = pruned_words(connection, selection)
    return (found or 0) + sum(count for p, count in pruned.items() if p not in ragged)
