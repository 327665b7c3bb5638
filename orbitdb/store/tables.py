"""SQLAlchemy's descriptions of the tables and views in a database file."""

from collections.abc import Iterable
from typing import Any

import sqlalchemy as sa

from orbitdb.columns import IN_CATALOGUE, kind_of
from orbitdb.orbits.status import Status
from orbitdb.store.schema import LIFE, OF_CLASS, SHARED, TABLES

_KINDS: dict[str, type[sa.types.TypeEngine[Any]]] = {
    "text": sa.Text, "integers": sa.Text, "integer": sa.Integer, "number": sa.REAL, "numbers": sa.LargeBinary,
}  # fmt: skip

metadata = sa.MetaData()


with sa.create_engine("sqlite://").begin() as _empty:  # reflects the tables from an empty database
    for _statement in TABLES.values():
        _empty.exec_driver_sql(_statement)
    metadata.reflect(_empty)


def view(name: str, columns: Iterable[str]) -> sa.TableClause:
    """Return SQLAlchemy's description of a view with the given columns."""
    return sa.table(name, *(sa.column(column, _KINDS[kind_of(column)]) for column in columns))


(
    stadium, run, cycle, element, pruned, orbit, fill, certificate, change, birth_fill, trajectory,
    entropy_bound, level_fill, level, sweep, sweep_block,
) = map(metadata.tables.__getitem__, TABLES)  # fmt: skip

classes = view("class", SHARED | OF_CLASS)
"""The view with one row per class and value of a."""

catalogue = view("catalogue", [each.name for each in IN_CATALOGUE])
"""The view with one row per word and value of a."""

ENDS = ("born", "dies")
"""The columns with a word's first birth and death.

`born` is NULL if the word is an orbit from a = 0 on, or if no births are stored."""

life = view("life", LIFE)
"""The view with one row per life of a class."""


def pruned_rows(a: float) -> sa.Subquery:
    """Return a query for the geometrically pruned words at a given a, with the columns of both views."""
    own = {
        "a": sa.cast(a, sa.REAL),
        "p": pruned.c.p,
        "code": pruned.c.word,
        "words": pruned.c.word,
        "status": sa.literal(Status.GEOMETRIC.value),
        "rules": pruned.c.rules,
    }
    names = {**dict(catalogue.c), **dict(classes.c)}
    listed = [own.get(name, sa.null()).label(name) for name in names]
    return sa.select(pruned.c.id, *listed).subquery(catalogue.name)
