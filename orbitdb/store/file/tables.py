"""SQLAlchemy's tables and views, made from the text of the schema."""

from collections.abc import Iterable
from typing import Any

import sqlalchemy as sa

from orbitdb.columns import IN_CATALOGUE, kind_of
from orbitdb.store.file.schema import OF_CLASS, SHARED, TABLES

_KINDS: dict[str, type[sa.types.TypeEngine[Any]]] = {
    "text": sa.Text, "integers": sa.Text, "integer": sa.Integer, "number": sa.REAL, "numbers": sa.LargeBinary,
}  # fmt: skip

metadata = sa.MetaData()


with sa.create_engine("sqlite://").begin() as _empty:  # SQLite, which has made them, says what they are
    for _statement in TABLES.values():
        _empty.exec_driver_sql(_statement)
    metadata.reflect(_empty)


def view(name: str, columns: Iterable[str]) -> sa.TableClause:
    """Return a view with some columns."""
    return sa.table(name, *(sa.column(each, _KINDS[kind_of(each)]) for each in columns))


(
    stadium, run, cycle, element, pruned, orbit, fill, certificate, change, birth_fill, trajectory,
    entropy_bound, level_fill, level, sweep, sweep_block,
) = map(metadata.tables.__getitem__, TABLES)  # fmt: skip

classes = view("class", SHARED | OF_CLASS)
"""The view of the classes: one row a class and a."""

catalogue = view("catalogue", [each.name for each in IN_CATALOGUE])
"""The view of the words: one row a word and a."""

ENDS = ("born", "dies")
"""The first birth and the first death of a word, as the views have them.

No `born` for a word that is an orbit from a = 0 on, as for one of which no births are stored."""

life = view("life", ("cycle", "p", "class_size", "word", "born", "born_error", "dies", "dies_error"))
"""The view of the lives of classes."""
