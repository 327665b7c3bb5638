"""The first rows of a subset in some order, found without a pass over all words.

Where many words share a value that rows are sorted by, those of one value are read in the order of the
table; where few do, and all words of a class share it, the classes are sorted, and their words looked up.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import sqlalchemy as sa

from orbitdb.orbits.orbit import Status
from orbitdb.store.asking.conditions import answering, conditions_of, parse_order, sort_key
from orbitdb.store.asking.confinement import Patience
from orbitdb.store.asking.selection import Selection
from orbitdb.store.file.schema import DONE, fill, stadium
from orbitdb.store.file.schema import catalogue as view
from orbitdb.store.reading.class_first import (
    OF_FEW_VALUES,
    few_classes,
    is_long,
    orders,
    pruned_words,
    up_to,
    words_of,
)
from orbitdb.store.reading.class_view import class_part, class_view, same_for_classes
from orbitdb.symbols import symmetry

Keys = Sequence[tuple[str, bool]]
"""Columns to sort by, and whether they fall."""

MOST = 2000
"""Rows that are looked up one by one, at most, with those that are passed over."""

_STEPS = (64, 512, 2048)
"""How many classes, the first ones in an order, are asked for words that fulfil a condition."""

_LOOKUPS = 2000
_NAMES = ("code", "word")
_NATURAL = ([("p", False), ("code", False)], [("p", False), ("word", False)], [("p", False)])
_ELEMENTS = len(symmetry.ELEMENTS)


def first_words(
    connection: sa.Connection, selection: Selection, order: str, wanted: int | None, patience: Patience
) -> list[str] | None:
    """Return words of a catalogue among which are those of the wanted rows; None if only a pass can tell.

    The arguments are those of `orbitdb.store.reading.class_first.few_words`.
    """
    keys = keys_before_words(order)
    if wanted is None or not 0 < wanted <= MOST or not keys or not is_long(connection):
        return None  # in the order of the table a pass ends as soon as it has them
    return Asked(connection, selection, patience).first(keys, wanted)


def keys_before_words(order: str) -> Keys:
    """Return the columns to sort by before the order of the table, which is that of (p, word)."""
    keys = list(parse_order(order).items())
    named = next((place for place, (name, _) in enumerate(keys) if name in _NAMES), len(keys))
    keys = keys[: named + 1]  # no two rows have the same word
    natural = next((end for end in _NATURAL if keys[-len(end) :] == end), [])
    return keys[: len(keys) - len(natural)]


@dataclass(frozen=True)
class Asked:
    """A subset, of which some columns may have but one value.

    Attributes
    ----------
    connection : Connection
    selection : Selection
    patience : Patience
        Of all queries together.
    fixed : tuple of (str, value)
        The columns, each with its value.
    """

    connection: sa.Connection
    selection: Selection
    patience: Patience
    fixed: tuple[tuple[str, Any], ...] = ()

    @cached_property
    def by_class(self) -> bool:
        """Whether it takes all words of a class or none."""
        alone = all(name in class_view().c for name, _ in self.fixed)
        return alone and self.selection.contains is None and same_for_classes(self.selection)

    @cached_property
    def whole_periods(self) -> dict[int, int]:
        """How many admissible words the filled periods have, if all classes are asked for; none otherwise."""
        a = self.selection.a
        if self.fixed or replace(class_part(self.selection), periods=()) != Selection(a):
            return {}
        filled = sa.select(fill.c.p, fill.c.n_t).join(stadium).where(stadium.c.a == a, fill.c.state == DONE)
        return dict(map(tuple, self.connection.execute(filled)))

    def where(self, name: str, value: Any) -> "Asked":
        """Return those of which a column has one value."""
        return replace(self, fixed=(*self.fixed, (name, value)))

    def all(self, query: sa.Select[Any]) -> Sequence[Any]:
        """Return the answer to a query over the subset."""
        with answering(self.connection, self.selection, self.patience):
            return self.connection.execute(query).all()

    def rows(self, *columns: sa.ColumnElement[Any]) -> sa.Select[Any]:
        """Return the query for columns of the view."""
        fixed = (_is(view.c[name], value) for name, value in self.fixed)
        return sa.select(*columns).where(*conditions_of(self.selection), *fixed)

    def classes(self, *columns: sa.ColumnElement[Any]) -> sa.Select[Any]:
        """Return the query for columns of the classes that have such words, perhaps among others."""
        chosen = class_part(self.selection)
        known = class_view().c
        fixed = (_is(known[name], value) for name, value in self.fixed if name in known)
        return sa.select(*columns).where(*conditions_of(chosen, known), *fixed)

    def first(self, keys: Keys, wanted: int) -> list[str] | None:
        """Return words among which are the first rows, sorted by some columns and then as the table is."""
        if not keys:
            return self._in_order_of_table(wanted)
        (name, falling), *rest = keys
        if name in _NAMES:
            return self._by_name(falling, wanted)
        if name in class_view().c and name not in OF_FEW_VALUES:
            return (
                self._by_class(name, falling, rest, wanted)
                if self.by_class
                else self._walk(name, falling, wanted)
            )
        if name == "element" or name in OF_FEW_VALUES:
            return self._by_value(name, falling, rest, wanted) if self.by_class else None
        return None

    def _in_order_of_table(self, wanted: int) -> list[str]:
        query = self.rows(view.c.word).order_by(view.c.p, view.c.word)
        return [word for (word,) in self.all(query.limit(wanted))]

    def _by_name(self, falling: bool, wanted: int) -> list[str]:
        """Return the first words of every order, among which are the first ones of all."""
        query = self.rows(view.c.word).limit(wanted)
        query = query.order_by(view.c.word.desc() if falling else view.c.word)
        periods = filter(self.selection.includes, orders(self.connection))
        return [word for p in periods for (word,) in self.all(query.where(view.c.p == p))]

    def _by_value(self, name: str, falling: bool, rest: Keys, wanted: int) -> list[str] | None:
        """Return the first words of one value after the other, until they are enough."""
        found: list[str] = []
        for value, classes in self._values(name, falling):
            inner, few = self.where(name, value), 0 < classes <= few_classes(self.connection)
            words = inner._of_all_classes() if few else inner.first(rest, wanted - len(found))
            if words is None:
                return None
            found += words
            if len(found) >= wanted:
                break
        return found

    def _values(self, name: str, falling: bool) -> Iterator[tuple[Any, int]]:
        """Yield the values of a column in their order, none last, each with its number of classes.

        The number is 0 where it is not known, or words without a class may have the value, too.
        """
        pruned = pruned_words(self.connection, self.selection)
        if name in class_view().c:
            column = class_view().c[name]
            query = self.classes(column, sa.func.count()).group_by(column)
            known: dict[Any, int] = dict(map(tuple, self.all(query)))
        else:
            known = dict.fromkeys(range(_ELEMENTS), 0)
        if pruned:
            of_pruned = {"p": pruned, "status": [Status.GEOMETRIC.value]}.get(name, [None])
            known |= dict.fromkeys(of_pruned, 0)
        yield from (
            (each, known[each]) for each in sorted((v for v in known if v is not None), reverse=falling)
        )
        if None in known:
            yield None, known[None]

    def _of_all_classes(self) -> list[str]:
        known = class_view().c
        return words_of(self.all(self.classes(known.representative, known.p)))

    def _by_class(self, name: str, falling: bool, rest: Keys, wanted: int) -> list[str] | None:
        """Return the words of the first classes; those without a value come behind them."""
        known, few = class_view().c, few_classes(self.connection)
        query = self.classes(known.representative, known.p)
        with answering(self.connection, self.selection, self.patience):
            limits = up_to(self.connection, query, known[name], falling, wanted)
        found = self.all(query.where(*(limits or [known[name].is_not(None)])).limit(few + 1))
        if len(found) > few:
            return None
        words = words_of(found)
        if limits or len(words) >= wanted:
            return words
        behind = self.where(name, None).first(rest, wanted - len(words))
        return None if behind is None else words + behind

    def _walk(self, name: str, falling: bool, wanted: int) -> list[str] | None:
        """Ask the first classes for words that fulfil all conditions, and more of them if those do not do.

        None if too few are found: they are then so rare that a pass is short.
        """
        known = class_view().c
        query = self.classes(known.representative, known.p, known[name])
        query = query.where(known[name].is_not(None)).order_by(sort_key(known[name], falling))
        classes, rows, begun = self.all(query.limit(_STEPS[-1] + 1)), list[tuple[str, Any]](), 0
        for step in _STEPS:
            rows += self._fulfilling(words_of((word, p) for word, p, _ in classes[begun:step]), name)
            begun = step
            if len(classes) <= step:
                break
            beyond = classes[step][-1]  # words of other classes may share this value
            found = [word for word, value in rows if value != beyond]
            if len(found) >= wanted:
                return found
        return None

    def _fulfilling(self, words: list[str], name: str) -> Iterator[tuple[str, Any]]:
        """Yield those of some words that are in the subset, each with a column's value."""
        query = self.rows(view.c.word, view.c[name])
        for start in range(0, len(words), _LOOKUPS):
            part = words[start : start + _LOOKUPS]
            yield from map(tuple, self.all(query.where(*among(part))))


def among(words: Sequence[str]) -> tuple[sa.ColumnElement[bool], ...]:
    """Return the conditions that a row is that of one of some words."""
    return view.c.p.in_(sorted(set(map(len, words)))), view.c.word.in_(words)


def _is(column: sa.ColumnElement[Any], value: Any) -> sa.ColumnElement[bool]:
    return column.is_(None) if value is None else column == value
