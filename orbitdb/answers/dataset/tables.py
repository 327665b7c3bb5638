"""The tables of a dataset: the columns and rows of each, read from a catalogue at one moment."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import astuple
from functools import partial
from typing import Any, NamedTuple

import sqlalchemy as sa

from orbitdb.answer_columns import OF_BOUNDS, OF_COUNTS, OF_ENSEMBLES, OF_LEVELS, OF_LIVES
from orbitdb.answers.entropy import table
from orbitdb.answers.levels import stored_levels
from orbitdb.answers.lyapunov import AVERAGES, EXPONENTS, lyapunov
from orbitdb.answers.results import Result
from orbitdb.column import Column
from orbitdb.columns import EVERY, WRITTEN
from orbitdb.numerals import exact
from orbitdb.quantum.weyl import Parity
from orbitdb.store.asking.selection import Selection
from orbitdb.store.file.tables import cycle
from orbitdb.store.reading.moment import Moment
from orbitdb.store.reading.rows import COORDINATES, Chosen

Rows = Iterable[Sequence[Any]]

_ORBITS = [EVERY[name] for name in (*WRITTEN, COORDINATES) if name != "rules"]
_OF_CLASS = [EVERY[name] for name in ("representative", "p", "class_size")]
_CLASSES = [*_OF_CLASS, *(EVERY[name] for name in ("symmetry", "time_reversal", "walls"))]
_LEVELS = [each for each in OF_LEVELS if each.name in ("k", "parity", "number", "error")]
_COUNTS = [EVERY["p"], *OF_COUNTS]
_AVERAGES = [EVERY["p"]] + [
    Column(
        name, "number", f"{part}average {exponent}; {average.label.partition(' (')[0].replace('$', '')}", unit
    )
    for average in AVERAGES
    for exponent, unit in zip(EXPONENTS, ("1", "1/radius"), strict=True)
    for name, part in (
        (average.of(exponent), ""),
        (f"{average.of(exponent)}_error", "estimated error of the "),
    )
    if name in average.columns
]


class Table(NamedTuple):
    """A table of a dataset, whose file ends in ``.parquet`` or ``.csv``.

    Attributes
    ----------
    words : int or None
        For a table of orbits, the number of words of its period, chosen or not; None for other tables.
    """

    path: str
    title: str
    columns: Sequence[Column]
    rows: Rows
    words: int | None = None

    @property
    def names(self) -> list[str]:
        """The names of the columns."""
        return [column.name for column in self.columns]


def orbits(moment: Moment, subset: Chosen, words: int) -> Table:
    """Return the table of the chosen words of one period at one a, ordered by class and element."""
    a, ((p, _),) = subset.selection.a, subset.selection.periods
    title = subset.selection.describe(count=len(subset))
    rows = moment.rows(subset, [column.name for column in _ORBITS])
    return Table(f"orbits/a={exact(a)}_p={p:02d}.parquet", title, _ORBITS, rows, words)


def others(moment: Moment, chosen: Sequence[Selection], filled: set[int]) -> Iterator[Table]:
    """Yield all tables except those of orbits; `filled` is the set of periods that have a table of orbits."""
    born = [each.p for each in moment.birth_fills() if each.whole and chosen[0].includes(each.p)]
    lives = (astuple(life) for p in born for life in moment.births(p))
    yield Table("classes.parquet", "Symmetry classes", _CLASSES, _classes(moment, filled.union(born)))
    yield Table("births.parquet", "Births and deaths of all classes", [*_OF_CLASS, *OF_LIVES], lives)
    for path, title, columns, ask in _AT_EACH_A:
        rows = [(each.a, *row) for each in chosen for row in ask(moment, each)]
        yield Table(path, title, [EVERY["a"], *columns], rows)


def _classes(moment: Moment, periods: set[int]) -> Rows:
    names = ("word", *(column.name for column in _CLASSES[1:]))
    query = sa.select(*(cycle.c[name] for name in names)).where(cycle.c.p.in_(periods)).order_by(cycle.c.id)
    return map(tuple, moment.connection.execute(query))


def _by_period(
    ask: Callable[[Moment, Selection], Result], columns: Sequence[Column], moment: Moment, chosen: Selection
) -> Rows:
    """Ask for a result over all words, and return its rows for the chosen periods."""
    found = ask(moment, Selection(chosen.a))
    rows = found.rows([column.name for column in columns]) if len(found) else ()
    return [row for row in rows if chosen.includes(row[0])]


def _ensembles(moment: Moment, chosen: Selection) -> Rows:
    return [astuple(found)] if (found := moment.reference(chosen.a)) else []


def _bounds(moment: Moment, chosen: Selection) -> Rows:
    return [astuple(found)[1:]] if (found := moment.entropy_bounds(chosen.a)) else []


def _levels(moment: Moment, chosen: Selection) -> Rows:
    for parity in Parity:
        for window in stored_levels(moment.connection, chosen.a, parity):
            pairs = zip(window.k.tolist(), window.error.tolist(), strict=True)
            for number, (k, error) in enumerate(pairs, window.below + 1):
                yield k, str(parity), number, error


_AT_EACH_A: Sequence[tuple[str, str, Sequence[Column], Callable[[Moment, Selection], Rows]]] = (
    ("counts.csv", "Counts of all words by period", _COUNTS, partial(_by_period, table, _COUNTS)),
    (
        "averages.csv",
        "Averages over all orbits by period",
        _AVERAGES,
        partial(_by_period, lyapunov, _AVERAGES),
    ),
    ("trajectories.csv", "Averages over random trajectories", OF_ENSEMBLES, _ensembles),
    ("bounds.csv", "Bounds on the topological entropy", OF_BOUNDS, _bounds),
    ("levels.csv", "Quantum levels", _LEVELS, _levels),
)
"""The tables with rows for each a: path, title, columns after a, and a function that returns the rows."""
