"""The formulas of columns that are computed from others, as SQL and as properties of Python objects."""

import re
from typing import Any, TypeVar

from orbitdb.column import NAME, Column
from orbitdb.columns import IN_CATALOGUE


def sql_of(column: Column) -> str:
    """Return SQL for the value of a column in a row of the joined tables, with any formula written out."""
    if not column.formula:
        return column.sql
    known = {each.name: each for each in IN_CATALOGUE}

    def source(found: re.Match[str]) -> str:
        inner = known[found[0]]
        return f"({sql_of(inner)})" if inner.formula else sql_of(inner)

    return NAME.sub(source, column.formula)


_Class = TypeVar("_Class", bound=type)


def with_formulas(cls: _Class) -> _Class:
    """Add to a class a property for each column with a formula.

    The value is computed from the attributes that the formula names, which can be numbers or arrays. It is
    None if one of them is None, or if the word has no symmetry class.
    """
    for column in IN_CATALOGUE:
        if column.formula:
            setattr(cls, column.name, _computed(column))
    return cls


def _computed(column: Column) -> property:
    code = compile(column.formula, column.name, "eval")

    def value(self: Any) -> Any:
        values = {name: getattr(self, name) for name in column.needs}
        if self.class_size is None or any(each is None for each in values.values()):
            return None
        return eval(code, {}, values)

    return property(value, doc=f"{column.means[0].upper()}{column.means[1:]} ({column.unit}).")
