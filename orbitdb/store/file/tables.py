"""SQLAlchemy's tables and views, made from the text of the schema."""

import re
from collections.abc import Iterable
from typing import Any

import sqlalchemy as sa

from orbitdb.columns import IN_CATALOGUE, kind_of
from orbitdb.store.file.schema import OF_CLASS, SHARED, TABLES

_TYPES: dict[str, type[sa.types.TypeEngine[Any]]] = {
    "INTEGER": sa.Integer,
    "TEXT": sa.Text,
    "REAL": sa.REAL,
    "BLOB": sa.LargeBinary,
}
_KINDS = {"text": "TEXT", "integers": "TEXT", "integer": "INTEGER", "number": "REAL", "numbers": "BLOB"}
_COLUMN = re.compile(r"^    (\w+) (INTEGER|TEXT|REAL|BLOB)( DEFAULT \d+)?( NOT NULL)?,?$", re.MULTILINE)
_KEY = re.compile(r"PRIMARY KEY \((.*?)\)")
_REFERENCE = re.compile(r"FOREIGN KEY\s*\((.*?)\)\s*REFERENCES (\w+) \((.*?)\)")

metadata = sa.MetaData()


def _table(name: str) -> sa.Table:
    """Return a table as its statement has it: columns, key and references."""
    text = TABLES[name]
    key = _listed(_KEY.search(text))
    columns = [
        sa.Column(column, _TYPES[kind], primary_key=column in key, nullable=not required)
        for column, kind, _, required in _COLUMN.findall(text)
    ]
    references = [
        sa.ForeignKeyConstraint(
            found[1].split(", "), [f"{found[2]}.{column}" for column in found[3].split(", ")]
        )
        for found in _REFERENCE.finditer(text)
    ]
    return sa.Table(name, metadata, *columns, *references)


def _listed(found: re.Match[str] | None) -> list[str]:
    return found[1].split(", ") if found else []


def view(name: str, columns: Iterable[str]) -> sa.TableClause:
    """Return a view with some columns."""
    return sa.table(name, *(sa.column(each, _TYPES[_KINDS[kind_of(each)]]) for each in columns))


stadium, run, cycle, element, pruned = map(_table, ("stadium", "run", "cycle", "element", "pruned"))
orbit, fill, certificate, trajectory = map(_table, ("orbit", "fill", "certificate", "trajectory"))
change, birth_fill, entropy_bound = map(_table, ("change", "birth_fill", "entropy_bound"))
sweep, sweep_block, level_fill, level = map(_table, ("sweep", "sweep_block", "level_fill", "level"))

classes = view("class", SHARED | OF_CLASS)
"""The view of the classes: one row a class and a."""

catalogue = view("catalogue", [each.name for each in IN_CATALOGUE])
"""The view of the words: one row a word and a."""

ENDS = ("born", "dies")
"""The first birth and the first death of a word, as the views have them.

No `born` for a word that is an orbit from a = 0 on, as for one of which no births are stored."""

life = view("life", ("cycle", "p", "class_size", "word", "born", "born_error", "dies", "dies_error"))
"""The view of the lives of classes."""
