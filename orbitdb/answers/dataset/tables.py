"""The tables of a dataset: columns and rows of each, from one moment of a catalogue."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import astuple
from typing import Any, NamedTuple

import sqlalchemy as sa

from orbitdb.answers.entropy import table
from orbitdb.answers.lyapunov import AVERAGES, lyapunov
from orbitdb.answers.results import Result
from orbitdb.answers.spectrum import stored_levels
from orbitdb.columns import EVERY, OF_BOUNDS, OF_COUNTS, OF_ENSEMBLES, OF_LEVELS, OF_LIVES, WRITTEN, Column
from orbitdb.quantum.amplitudes import Parity
from orbitdb.store.asking.selection import Selection
from orbitdb.store.file.tables import cycle
from orbitdb.store.reading.moment import Moment
from orbitdb.store.reading.rows import COORDINATES

Rows = Iterable[Sequence[Any]]

ORBITS = [EVERY[name] for name in (*WRITTEN, COORDINATES) if name != "rules"]
_OF_CLASS = [EVERY[name] for name in ("representative", "p", "class_size")]
_CLASSES = [*_OF_CLASS, *(EVERY[name] for name in ("symmetry", "time_reversal", "walls"))]
_LEVELS = [each for each in OF_LEVELS if each.name in ("k", "parity", "number", "error")]
_COUNTS = [EVERY["p"], *OF_COUNTS]
_AVERAGES = [EVERY["p"]] + [
    Column(name, "number", f"{EVERY[name[:8]].brief}; {average.label.replace('$', '')}", EVERY[name[:8]].unit)
    for average in AVERAGES
    for name in average.columns
]


class Table(NamedTuple):
    """A table of a dataset, whose file ends in ``.parquet`` or ``.csv``."""

    path: str
    title: str
    columns: Sequence[Column]
    rows: Rows

    @property
    def names(self) -> list[str]:
        """The names of its columns."""
        return [column.name for column in self.columns]


def tables(moment: Moment, chosen: Sequence[Selection], filled: set[int]) -> list[Table]:
    """Return all tables but the orbits; `filled` are the periods of the orbits."""
    born = [each.p for each in moment.birth_fills() if each.whole and chosen[0].includes(each.p)]
    lives = (astuple(life) for p in born for life in moment.births(p))
    found = [
        Table("classes.parquet", "Symmetry classes", _CLASSES, _classes(moment, filled.union(born))),
        Table("births.parquet", "Births and deaths of all classes", [*_OF_CLASS, *OF_LIVES], lives),
    ]
    for path, title, columns, ask in _AT_EACH_A:
        rows = [(each.a, *row) for each in chosen for row in ask(moment, each)]
        found.append(Table(path, title, [EVERY["a"], *columns], rows))
    return found


def _classes(moment: Moment, periods: set[int]) -> Rows:
    names = ("word", *(column.name for column in _CLASSES[1:]))
    query = sa.select(*(cycle.c[name] for name in names)).where(cycle.c.p.in_(periods)).order_by(cycle.c.id)
    return map(tuple, moment.connection.execute(query))


def _by_period(found: Result, chosen: Selection, columns: Sequence[Column]) -> Rows:
    """Return the rows of the chosen periods."""
    rows = found.rows([column.name for column in columns]) if len(found) else ()
    return [row for row in rows if chosen.includes(row[0])]


def _counts(moment: Moment, chosen: Selection) -> Rows:
    return _by_period(table(moment, Selection(chosen.a)), chosen, _COUNTS)


def _averages(moment: Moment, chosen: Selection) -> Rows:
    return _by_period(lyapunov(moment, Selection(chosen.a)), chosen, _AVERAGES)


def _ensembles(moment: Moment, chosen: Selection) -> Rows:
    found = moment.reference(chosen.a)
    return [] if found is None else [astuple(found)]


def _bounds(moment: Moment, chosen: Selection) -> Rows:
    found = moment.entropy_bounds(chosen.a)
    return [] if found is None else [astuple(found)[1:]]


def _levels(moment: Moment, chosen: Selection) -> Rows:
    for parity in Parity:
        for window in stored_levels(moment.connection, chosen.a, parity):
            pairs = zip(window.k.tolist(), window.error.tolist(), strict=True)
            for number, (k, error) in enumerate(pairs, window.below + 1):
                yield k, str(parity), number, error


_AT_EACH_A: Sequence[tuple[str, str, Sequence[Column], Callable[[Moment, Selection], Rows]]] = (
    ("counts.csv", "Counts of all words by period", _COUNTS, _counts),
    ("averages.csv", "Averages over all orbits by period", _AVERAGES, _averages),
    ("trajectories.csv", "Averages over random trajectories", OF_ENSEMBLES, _ensembles),
    ("bounds.csv", "Bounds on the topological entropy", OF_BOUNDS, _bounds),
    ("levels.csv", "Quantum levels", _LEVELS, _levels),
)
"""Tables with rows for each a, after whose value they give the columns."""
