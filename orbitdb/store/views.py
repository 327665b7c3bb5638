"""The views of a catalogue: what each column of `orbitdb.columns` is, as an expression of its tables.

`class` has one row per class and value of a, `catalogue` one per word and value of a; both are ordered by a,
class and element. `life` has one row per life of a class. A new column of the catalogue is one expression
here, one entry in `orbitdb.columns`, and a property of `Orbit` and `Subset`. Files keep the views of the
version that wrote them, for other programs; every reading connection of this program makes its own. DuckDB
translates them: it has no iif(), for example.
"""

from collections.abc import Mapping
from decimal import Context, localcontext
from functools import cache
from typing import Any

from sqlalchemy import (
    REAL,
    ColumnElement,
    Connection,
    Label,
    Select,
    Subquery,
    and_,
    bindparam,
    case,
    func,
    literal,
    null,
    select,
)
from sqlalchemy.schema import CreateView, DropView

from orbitdb.columns import IN_CATALOGUE
from orbitdb.orbits.orbit import error_of_quotient
from orbitdb.store import tables as t
from orbitdb.symbols.symmetry import AXIS, ODD, QUARTER_SIGNS

Expressions = Mapping[str, ColumnElement[Any]]

_symmetries = literal(",") + t.cycle.c.symmetry + ","
_half = case(*((_symmetries.like(f"%,{name},%"), name) for name in ("x", "y", "xy")))
_parts = case((_half.is_(None), 1), else_=2)
_word = t.cycle.c.word.concat("")  # without the affinity of a column, which would make 0113 the text '113'
_maslov = 3 * t.cycle.c.p - t.cycle.c.walls
_lambda_c = t.orbit.c.lyapunov / t.orbit.c.length


def _end(value: ColumnElement[Any], number: int) -> ColumnElement[Any]:
    """Return a value of the change with this number, or NULL."""
    own = (t.change.c.cycle == t.orbit.c.cycle, t.change.c.number == number)
    return select(value).where(*own).correlate(t.orbit).scalar_subquery()


VIEWED = tuple(column.name for column in IN_CATALOGUE)
"""The columns of the view ``catalogue``."""

CLASS_COLUMNS: Expressions = {
    "p": t.cycle.c.p,
    "representative": _word,
    "class_size": t.cycle.c.class_size,
    "symmetry": t.cycle.c.symmetry,
    "time_reversal": t.cycle.c.time_reversal,
    "born": _end(func.nullif(t.change.c.a, 0.0), 1),
    "dies": _end(t.change.c.a, 2),
    "walls": t.cycle.c.walls,
    "maslov": _maslov,
    "half": _half,
    "quarter_maslov": _maslov // _parts,
    "quarter_signs": case(
        *((_half == name, ",".join(map(str, signs))) for name, signs in QUARTER_SIGNS.items() if name),
        else_=",".join(map(str, QUARTER_SIGNS[None])),
    ),
    "quarter_orientations": case((_word == AXIS, 1), else_=t.cycle.c.class_size * _parts // 4),
    "cycle": t.orbit.c.cycle,
    "a": t.stadium.c.a,
    "status": t.orbit.c.status,
    "length": t.orbit.c.length,
    "quarter_length": t.orbit.c.length / _parts,
    "quarter_lyapunov": t.orbit.c.lyapunov / _parts,
    "lyapunov": t.orbit.c.lyapunov,
    "lambda_d": t.orbit.c.lyapunov / t.cycle.c.p,
    "lambda_c": _lambda_c,
    "margin": t.orbit.c.margin,
    "residual": t.orbit.c.residual,
    "error": t.orbit.c.error,
    "length_error": t.orbit.c.length_error,
    "lyapunov_error": t.orbit.c.lyapunov_error,
    "lambda_c_error": error_of_quotient(
        _lambda_c, t.orbit.c.length, t.orbit.c.lyapunov_error, t.orbit.c.length_error
    ),
    "area_error": t.orbit.c.area_error,
    "iterations": t.orbit.c.iterations,
    "solver": t.orbit.c.solver,
}
"""Columns of both views, whose values all words of a class share."""

WORD_COLUMNS: Expressions = {
    "code": func.substr(t.cycle.c.words, 1 + t.cycle.c.p * t.element.c.n, t.cycle.c.p),
    "rules": null(),
    "element": t.element.c.element,
    "area": case((t.element.c.element.in_(ODD), 0.0 - t.orbit.c.area), else_=t.orbit.c.area),
}
"""Columns of `catalogue` whose values differ between the words of a class."""

STORED_COLUMNS: Expressions = {
    "codes": t.cycle.c.words,
    "coordinates": t.orbit.c.coordinates,
    "area": t.orbit.c.area,
}
"""Further columns of the view `class`: all codes, joined, and the area, both from the representative on."""


def _labelled(columns: Expressions) -> list[Label[Any]]:
    return [value.label(name) for name, value in columns.items()]


def _of_classes(columns: Expressions) -> Select[Any]:
    """Select columns of the classes at each a; the tables are in the order of the loops."""
    stored = t.stadium.join(t.orbit, t.orbit.c.stadium == t.stadium.c.id)
    return select(*_labelled(columns)).select_from(stored.join(t.cycle, t.cycle.c.id == t.orbit.c.cycle))


_death = t.change.alias("death")
_next = and_(_death.c.cycle == t.change.c.cycle, _death.c.number == t.change.c.number + 1)
_lives = (
    select(
        t.change.c.cycle,
        t.cycle.c.p,
        t.cycle.c.class_size,
        _word.label("word"),
        func.nullif(t.change.c.a, 0.0).label("born"),
        t.change.c.error.label("born_error"),
        _death.c.a.label("dies"),
        _death.c.error.label("dies_error"),
    )
    .select_from(t.change.join(t.cycle, t.cycle.c.id == t.change.c.cycle).outerjoin(_death, _next))
    .where(t.change.c.kind == t.BORN)
)

_words = _of_classes({**CLASS_COLUMNS, **WORD_COLUMNS}).join(
    t.element, t.element.c.symmetry == t.cycle.c.symmetry
)

VIEWS = {
    "class": CreateView(_of_classes({**CLASS_COLUMNS, **STORED_COLUMNS}), "class"),
    "catalogue": CreateView(_words, "catalogue"),
    "life": CreateView(_lives, "life"),
}
"""The views by name. In `life`, ``born`` is NULL for an orbit from a = 0 on, ``dies`` if it never dies."""

classes, catalogue, life = (view.table for view in VIEWS.values())

PRUNED: Expressions = {
    "a": bindparam("half_length", type_=REAL),
    "p": t.pruned.c.p,
    "code": t.pruned.c.word,
    "codes": t.pruned.c.word,
    "status": literal("geometric"),
    "rules": t.pruned.c.rules,
}
"""What the columns of the views are for a geometrically pruned word; the others are NULL."""


def pruned_at(a: float) -> Subquery:
    """Return the geometrically pruned words with their ids and the columns of both views."""
    names = dict.fromkeys([*CLASS_COLUMNS, *WORD_COLUMNS, *STORED_COLUMNS])
    columns = [PRUNED.get(name, null()).label(name) for name in names]
    return select(t.pruned.c.id, *columns).params(half_length=a).subquery("catalogue")


@cache
def view_texts() -> dict[str, str]:
    """Return the CREATE statements of the views by name, as SQLite stores them."""
    from sqlalchemy.dialects.sqlite import dialect

    with localcontext(Context()):  # SQLAlchemy writes numbers with decimal, whose context may be a caller's
        return {name: str(view.compile(dialect=dialect())).strip() for name, view in VIEWS.items()}


def create_views(connection: Connection) -> None:
    """Create the views in a file."""
    for text in view_texts().values():
        connection.exec_driver_sql(text)


def drop_views(connection: Connection) -> None:
    """Drop the views of a file, because SQLite renames no table while a view reads it."""
    for view in VIEWS.values():
        connection.execute(DropView(view.table, if_exists=True))
