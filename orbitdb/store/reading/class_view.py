"""What all words of a symmetry class share: the view of the classes, and which subsets it answers."""

from dataclasses import replace
from functools import cache

import sqlalchemy as sa

from orbitdb.orbits.orbit import NUMBERS
from orbitdb.store.asking import expressions as free
from orbitdb.store.asking.selection import Selection
from orbitdb.store.file.schema import ENDS, change, cycle, orbit, stadium
from orbitdb.store.file.schema import catalogue as view
from orbitdb.store.file.tokens import tokens


@cache
def class_view() -> sa.Subquery:
    """Return the columns of the view that all words of a class share, one row a stadium and class.

    By `class_order`, which is `cycle` once more, SQLite has the rows in order without sorting them.
    """
    return (
        sa.select(
            stadium.c.a,
            cycle.c.id.label("cycle"),
            cycle.c.p,
            cycle.c.word.label("representative"),
            *(cycle.c[name] for name in ("class_size", "walls", "time_reversal", "symmetry")),
            orbit.c.status,
            *(orbit.c[name] for name in (*NUMBERS, "iterations", "solver")),
            (orbit.c.lyapunov / cycle.c.p).label("lambda_d"),
            (orbit.c.lyapunov / orbit.c.length).label("lambda_c"),
            orbit.c.coordinates,
            orbit.c.cycle.label("class_order"),
            *(_end(name, number) for number, name in enumerate(ENDS, 1)),
        )
        .join_from(orbit, cycle, cycle.c.id == orbit.c.cycle)
        .join(stadium, stadium.c.id == orbit.c.stadium)
        .subquery("catalogue")
    )


def _end(name: str, number: int) -> sa.Label[float]:
    """Return the first birth or death of a class, None for a birth at a = 0, as the view has it."""
    found = sa.select(sa.func.nullif(change.c.a, 0.0)).where(change.c.cycle == cycle.c.id)
    return found.where(change.c.number == number).correlate(cycle).scalar_subquery().label(name)


def same_for_classes(selection: Selection) -> bool:
    """Tell whether a subset takes all words of a class or none, but for those that contain a factor."""
    if selection.where is None:
        return True
    shared = set(class_view().c.keys()) & set(view.c.keys()) - {"cycle"}
    parameters = dict(selection.parameters)
    free.check(selection.where, parameters)
    return free.same_for_class(selection.where, parameters, shared)


def class_part(selection: Selection) -> Selection:
    """Return the subset without what only single words of a class fulfil: it is the same or larger."""
    chosen = replace(selection, contains=None)
    if same_for_classes(chosen):
        return chosen
    shared = [part for part in parts_of(chosen) if same_for_classes(part)]
    where = " AND ".join(f"(\n{part.where}\n)" for part in shared) or None
    used = {name: value for part in shared for name, value in part.parameters.items()}
    return replace(chosen, where=where, parameters=used)


def parts_of(selection: Selection) -> list[Selection]:
    """Return a subset for each of the conditions that its expression joins by AND, be it a single one."""
    where = selection.where or ""
    return [_with_part(selection, part) for part in _joined_by_and(where) or [where]]


def _with_part(selection: Selection, where: str) -> Selection:
    """Return a subset with a part of its expression, and the values that this uses."""
    used = free.names_in(where)
    return replace(
        selection, where=where, parameters={n: v for n, v in selection.parameters.items() if n in used}
    )


def _joined_by_and(where: str) -> list[str]:
    """Return the conditions that an expression joins by AND; none where it is not plain that it does."""
    parts, depth = [""], 0
    for token in tokens(where):
        depth += (token.text == "(") - (token.text == ")")
        if depth == 0 and token.keyword in ("OR", "BETWEEN", "CASE"):
            return []
        if depth == 0 and token.keyword == "AND":
            parts.append("")
        else:
            parts[-1] += token.text
    return parts if depth == 0 and len(parts) > 1 and all(map(str.strip, parts)) else []
