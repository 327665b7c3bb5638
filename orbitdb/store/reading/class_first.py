"""Class first: what is asked of rows, answered from the symmetry classes, of which there are fewer.

Most conditions and sort keys hold for all words of a class. Rows of few classes are looked up by their
words, and those of many are counted by their classes, without a pass over all the words.
"""

from collections.abc import Iterable, Iterator, Sequence
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
"""Classes whose words are looked up one by one, at least: a pass over all words takes longer."""

_WORDS_A_CLASS = 4000
"""Words that a pass looks at in less time than it takes to look up those of a class."""

OF_FEW_VALUES = ("p", "status", "class_size", "walls", "time_reversal", "symmetry", "iterations", "solver")
"""Columns of classes in which a value is that of many."""

_MANY = 100_000
"""Words of which a pass takes some tenths of a second; for fewer it is not worth while to do without."""


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
    few, limits = few_classes(connection), list[sa.ColumnElement[bool]]()
    classes = class_view().c
    query = sa.select(classes.representative, classes.p).where(*conditions_of(selection, classes))
    with answering(connection, selection, patience):
        key, falling = next(iter(parse_order(order).items()))
        if wanted is not None and 0 < wanted <= few and key in classes and key not in OF_FEW_VALUES:
            limits = up_to(connection, query, classes[key], falling, wanted)
        found = connection.execute(query.where(*limits).limit(few + 1)).all()
    if len(found) > few or (not limits and pruned_words(connection, selection)):
        return None
    return words_of(found)


def words_of(classes: Iterable[Sequence[Any]]) -> list[str]:
    """Return all words of some classes, which are given by least word and period.

    Raises
    ------
    StoreError
        If one of them is no word of this period.
    """
    least = list(classes)
    need_words([word for word, _ in least], [p for _, p in least])
    return [word for representative, _ in least for word in symmetry.members(representative)]


def goes_by_class(connection: sa.Connection, selection: Selection) -> bool:
    """Tell whether a subset takes all words of a class or none, and a pass over all words would be long."""
    return selection.contains is None and is_long(connection) and same_for_classes(selection)


def is_long(connection: sa.Connection) -> bool:
    """Tell whether a pass over all words would be long."""
    return _words_filled(connection) >= _MANY


def few_classes(connection: sa.Connection) -> int:
    """Return the number of classes whose words are looked up in less time than a pass takes."""
    return max(_FEW, _words_filled(connection) // _WORDS_A_CLASS)


def _words_filled(connection: sa.Connection) -> int:
    return connection.scalar(sa.select(sa.func.sum(fill.c.words))) or 0


def up_to(
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


def pruned_words(connection: sa.Connection, selection: Selection) -> dict[int, int]:
    """Return by order how many geometrically pruned words a subset has, of the orders where it has some."""
    wanted = list(orders_with_pruned(connection, selection))
    if not wanted or _are_all_admissible(connection):
        return {}
    found = {p: _pruned_of(connection, p) for p in wanted}
    return {p: count for p, count in found.items() if count}


def _are_all_admissible(connection: sa.Connection) -> bool:
    """Tell whether all words are those of filled periods: all together are counted in a fifth of the time."""
    filled = sa.select(fill.c.p, fill.c.n_t).where(fill.c.state == DONE, fill.c.n_t.is_not(None))
    admissible = dict(map(tuple, connection.execute(filled)))
    stored = connection.scalar(sa.select(sa.func.count()).select_from(sequence))
    return stored == sum(admissible.get(p, 0) for p in orders(connection))


def _pruned_of(connection: sa.Connection, p: int) -> int:
    """Return how many words of one order have no class: where it is filled, all but the admissible ones."""
    here = sa.select(sa.func.count()).select_from(sequence).where(sequence.c.p == p)
    admissible = connection.scalar(sa.select(fill.c.n_t).where(fill.c.p == p, fill.c.state == DONE).limit(1))
    if admissible is None:
        return connection.scalar(here.where(sequence.c.rules.is_not(None))) or 0
    return (connection.scalar(here) or 0) - admissible


def orders_with_pruned(connection: sa.Connection, selection: Selection) -> Iterator[int]:
    """Yield the orders of which geometrically pruned words, which have no class, would be in a subset."""
    names = [column.name for column in class_view().c if column.name not in ("a", "p", "status")]
    for p in filter(selection.includes, orders(connection)):
        word = sa.select(
            stadium.c.a,
            sa.cast(p, sa.Integer).label(
                "p"
            ),  # as of a column: it makes numbers of texts it is compared with
            sa.literal(Status.GEOMETRIC.value).label("status"),
            *(sa.null().label(name) for name in names),
        ).subquery(view.name)
        with answering(connection, selection, Patience()):
            chosen = connection.scalar(sa.select(word.c.p).where(*conditions_of(selection, word.c)))
        if chosen is not None:
            yield p


def orders(connection: sa.Connection) -> list[int]:
    """Return the orders of all words, each by a look at where the next one begins."""
    here = sa.select(sa.func.min(sequence.c.p).label("p")).cte("orders", recursive=True)
    following = sa.select(sa.func.min(sequence.c.p)).where(sequence.c.p > here.c.p).scalar_subquery()
    here = here.union_all(sa.select(following).where(here.c.p.is_not(None)))
    return [p for p in connection.scalars(sa.select(here.c.p)) if p is not None]
