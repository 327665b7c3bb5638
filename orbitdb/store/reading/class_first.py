"""Class first: what is asked of rows, answered from the symmetry classes, of which there are fewer.

Most conditions and sort keys hold for all words of a class. Rows of few classes are looked up by their
words, and those of many are counted by their classes, without a pass over all the words.
"""

from collections.abc import Iterator
from typing import Any

import sqlalchemy as sa

from orbitdb.orbits.orbit import Status
from orbitdb.store.asking.conditions import answering, conditions_of, parse_order, sort_key
from orbitdb.store.asking.confinement import Patience
from orbitdb.store.asking.selection import Selection
from orbitdb.store.file.schema import DONE, fill, sequence, stadium
from orbitdb.store.file.schema import catalogue as view
from orbitdb.store.reading.class_view import class_view, same_for_classes
from orbitdb.store.reading.soundness import need_words
from orbitdb.symbols import symmetry

_FEW = 250
"""Classes whose words are looked up one by one: a pass over all words takes longer."""

_MANY = 100_000
"""Words of which a pass takes some tenths of a second; for fewer it is not worth while to do without."""


def count_rows(connection: sa.Connection, selection: Selection) -> int:
    """Return the number of rows in a subset."""
    scanned = sa.select(sa.func.count()).select_from(view)
    if not goes_by_class(connection, selection):
        with answering(connection, selection, Patience()):
            return connection.scalar(scanned.where(*conditions_of(selection))) or 0
    ragged = ragged_periods(connection)
    classes = class_view().c
    whole = sa.select(sa.func.sum(classes.class_size))
    with answering(connection, selection, Patience()):
        found = connection.scalar(whole.where(*conditions_of(selection, classes), classes.p.not_in(ragged)))
        if ragged:
            rest = scanned.where(*conditions_of(selection), view.c.p.in_(ragged))
            found = (found or 0) + (connection.scalar(rest) or 0)
    pruned = sa.select(sa.func.count()).where(sequence.c.rules.is_not(None))
    orders = (p for p in orders_with_pruned(connection, selection) if p not in ragged)
    return (found or 0) + sum(connection.scalar(pruned.where(sequence.c.p == p)) or 0 for p in orders)


def few_words(
    connection: sa.Connection, selection: Selection, order: str, wanted: int | None, patience: Patience
) -> list[str] | None:
    """Return some words of the catalogue among which are all the wanted ones, if these are of few classes.

    Parameters
    ----------
    connection : Connection
    selection : Selection
    order : str
        As in `orbitdb.store.reading.catalogue.Catalogue.rows`.
    wanted : int or None
        How many rows, the first ones in this order; None for all.
    patience : Patience

    Returns
    -------
    list of str or None
        Least rotations; None if only a pass over all words can tell.
    """
    if not goes_by_class(connection, selection):
        return None
    classes = class_view().c
    query = sa.select(classes.representative, classes.p).where(*conditions_of(selection, classes))
    with answering(connection, selection, patience):
        if wanted is not None and 0 < wanted <= _FEW:
            key, falling = next(iter(parse_order(order).items()))
            if key in classes:
                query = query.where(*_up_to(connection, query, classes[key], falling, wanted))
        found = connection.execute(query.limit(_FEW + 1)).all()
    if len(found) > _FEW:
        return None
    need_words([word for word, _ in found], [p for _, p in found])
    pruned = sa.select(sequence.c.p).where(sequence.c.rules.is_not(None)).limit(1)
    for p in orders_with_pruned(connection, selection):
        if connection.scalar(pruned.where(sequence.c.p == p)) is not None:
            return None
    return [word for representative, _ in found for word in symmetry.members(representative)]


def goes_by_class(connection: sa.Connection, selection: Selection) -> bool:
    """Tell whether a subset takes all words of a class or none, and a pass over all words would be long."""
    words = sa.select(sa.func.sum(fill.c.words))
    return (
        selection.contains is None
        and (connection.scalar(words) or 0) >= _MANY
        and same_for_classes(selection)
    )


def _up_to(
    connection: sa.Connection,
    chosen: sa.Select[tuple[str, int]],
    key: sa.ColumnElement[Any],
    falling: bool,
    wanted: int,
) -> list[sa.ColumnElement[bool]]:
    """Return the condition that a sort key is no later than that of the last wanted row.

    Every class has a row, so that it is no later than that of the class in this place. Where that one
    has no value, which is last, no row is too late.
    """
    ordered = chosen.with_only_columns(key).order_by(sort_key(key, falling))
    last = connection.scalar(ordered.offset(wanted - 1).limit(1))
    if last is None:
        return []
    return [key >= last] if falling else [key <= last]


def ragged_periods(connection: sa.Connection) -> list[int]:
    """Return the periods whose first fill goes on, or was stopped: not all words of a class are stored."""
    done = sa.select(fill.c.p).where(fill.c.state == DONE)
    return list(connection.scalars(sa.select(fill.c.p).where(fill.c.p.not_in(done)).distinct()))


def orders_with_pruned(connection: sa.Connection, selection: Selection) -> Iterator[int]:
    """Yield the orders of which geometrically pruned words, which have no class, would be in a subset."""
    names = [column.name for column in class_view().c if column.name not in ("a", "p", "status")]
    for p in filter(selection.includes, _orders(connection)):
        word = sa.select(
            stadium.c.a,
            sa.cast(p, sa.Integer).label(
                "p"
            ),  # as of a column: it makes numbers of texts it is compared with
            sa.literal(Status.GEOMETRIC.value).label("status"),
            *(sa.null().label(name) for name in names),
        ).subquery(view.name)
        with answering(connection, selection, Patience()):
            if connection.scalar(sa.select(word.c.p).where(*conditions_of(selection, word.c))) is not None:
                yield p


def _orders(connection: sa.Connection) -> list[int]:
    """Return the orders of all words, each by a look at where the next one begins."""
    here = sa.select(sa.func.min(sequence.c.p).label("p")).cte("orders", recursive=True)
    following = sa.select(sa.func.min(sequence.c.p)).where(sequence.c.p > here.c.p).scalar_subquery()
    here = here.union_all(sa.select(following).where(here.c.p.is_not(None)))
    return [p for p in connection.scalars(sa.select(here.c.p)) if p is not None]
