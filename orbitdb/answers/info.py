"""`Info`: what a catalogue contains, and the time and disk space that it took."""

from dataclasses import dataclass
from html import escape
from itertools import groupby
from operator import attrgetter, itemgetter
from typing import TYPE_CHECKING, Any

from orbitdb.answers.completeness import periods_with_births
from orbitdb.display import columns_of, data_frame, html_of
from orbitdb.entropy_bounds.bounds import BALLS
from orbitdb.open_stadium.escape import ways
from orbitdb.period_ranges import written_periods
from orbitdb.store.lookup import a_values
from orbitdb.store.periods import read_fills, read_sweeps, room, schema_version, sqlite_version
from orbitdb.store.sqlite import Connection, path_of
from orbitdb.store.stored_values import bounds_by_a, level_windows, stored_escapes, trajectories
from orbitdb.text import format_float, gigabytes, several

if TYPE_CHECKING:
    import pandas

PERIOD_COLUMNS = ("a", "p", "state", "stored", "N_t", "N_c", "boundary", "unresolved",
           "seconds", "enumerating", "solving", "storing")  # fmt: skip
_OF_FILL = attrgetter("p", "state", "words", "n_t", "n_c", "boundary", "unresolved",
                     "seconds", "enumerating", "solving", "storing")  # fmt: skip
_OF_TALLY = attrgetter("words", "n_c", "boundary", "unresolved")
_FEW = 4
"""If the entropy is bounded at more values of a than this, only those with filled periods are listed."""


@dataclass(frozen=True, eq=False)
class Info:
    """What a catalogue contains.

    Attributes
    ----------
    facts : list of (str, str)
        The path, the size and the contents, each with its name.
    columns : tuple of str
    rows : list of tuple
        One row per filled or swept period, in order of a and p, with the processor times in seconds. All the
        processor time of a sweep is under ``solving``.
    """

    facts: list[tuple[str, str]]
    columns: tuple[str, ...]
    rows: list[tuple[Any, ...]]

    def __repr__(self) -> str:
        return f"<{several(len(self.rows), 'filled or swept period')}; print() shows more>"

    def __str__(self) -> str:
        width = max((len(name) for name, _ in self.facts), default=0)
        return "\n".join(f"{name.ljust(width)}  {text}" for name, text in self.facts)

    def _repr_html_(self) -> str:
        facts = "<br>".join(escape(f"{name}: {text}") for name, text in self.facts)
        return f"<p>{facts}</p>{html_of(columns_of(self.columns, self.rows))}"

    def to_pandas(self) -> "pandas.DataFrame":
        """Return the periods as a data frame (extra ``pandas``)."""
        return data_frame(self.rows, self.columns)


def read_info(connection: Connection, facts: bool = True) -> Info:
    """Return what a catalogue contains (`Catalogue.info`)."""
    rows = [row for a in a_values(connection) for row in _periods(connection, a)]
    return Info(_facts(connection) if facts else [], PERIOD_COLUMNS, sorted(rows, key=itemgetter(0, 1)))


def _periods(connection: Connection, a: float) -> list[tuple[Any, ...]]:
    """Return one row per filled or swept period at a given a."""
    fills = read_fills(connection, a)
    rows = [(a, *_OF_FILL(fill)) for fill in fills]
    filled = {fill.p for fill in fills if fill.done}
    for sweep in read_sweeps(connection, a):
        if sweep.p not in filled:
            counts = _OF_TALLY(sweep.tally) if sweep.done else (None,) * 4
            state = "swept" if sweep.done else "sweeping"
            rows.append((a, sweep.p, state, 0, *counts, sweep.seconds, None, sweep.processor, None))
    return rows


def _facts(connection: Connection) -> list[tuple[str, str]]:
    """Return the path, size and contents of the catalogue as pairs of a name and a text."""
    path = path_of(connection).resolve()
    size = gigabytes(path.stat().st_size if path.exists() else 0)
    facts = [("catalogue", str(path)), ("schema", str(schema_version(connection))), ("size", size)]
    facts.append(("SQLite", sqlite_version(connection)))
    for name, (count, each) in room(connection).items():
        facts.append((name, f"{count}" if each is None else f"{count}, {each:.0f} bytes each"))
    if born := periods_with_births(connection):
        facts.append(("births", written_periods(born)))
    for a, ranges in groupby(level_windows(connection), key=itemgetter(0)):
        parts = [f"{parity} k = {low:g}..{high:g} ({count})" for _, parity, low, high, count in ranges]
        facts.append(("levels", f"a = {format_float(a)}: {', '.join(parts)}"))
    for a, count, bounces in trajectories(connection):
        facts.append(
            ("simulated", f"a = {format_float(a)}: {several(count, 'average')}, up to {bounces} bounces")
        )
    for at, found in groupby(stored_escapes(connection), key=attrgetter("a")):
        ways_out = (ways(one.opening, one.without) for one in found)
        facts.append(("escape", f"a = {format_float(at)}: {', '.join(dict.fromkeys(ways_out))}"))
    return facts + _enclosures(connection)


def _enclosures(connection: Connection) -> list[tuple[str, str]]:
    """Return lines with the proved bounds on the entropy; if there are many a, only those that are filled."""
    curve, filled = bounds_by_a(connection), a_values(connection, ["fill"])
    listed = [bounds for bounds in curve if len(curve) <= _FEW or bounds.a in filled]
    lines = [
        f"a = {format_float(bounds.a)}: {bounds.between}, {bounds.edges} edges"
        f"{', balls' * (bounds.arithmetic == BALLS)}"
        for bounds in listed
    ]
    if others := [bounds.a for bounds in curve if bounds not in listed]:
        lines.append(
            f"enclosed at {len(others)} other values of a from {format_float(others[0])} "
            f"to {format_float(others[-1])}"
        )
    return [("entropy", text) for text in lines]
