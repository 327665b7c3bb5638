"""Counts as text: a line each, with a bar that is drawn in eighths of a cell."""

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any

from orbitdb.catalogue.tallies import Histogram
from orbitdb.cli.render import number
from orbitdb.cli.tui.table.columns import EVERY
from orbitdb.columns import IN_CATALOGUE

_EIGHTHS = " ▏▎▍▌▋▊▉█"
_LEAST_BAR = 4
_FINER = 50.0
"""How many times finer the edges are written than the bins are wide."""
_COLUMNS = {column.name: column for column in IN_CATALOGUE}

Counts = Sequence[tuple[str, int]]
"""Labels, and how many there are of each."""

DRAWN = tuple(name for name in EVERY if name not in ("code", "representative", "cycle"))
"""The columns of which counts say something: not those that name a word or a class."""


def counts_by(column: str, counts: Mapping[Any, int]) -> Counts:
    """Return counts by the value of a column, with labels, in the order of the values."""
    known = sorted(value for value in counts if value is not None)
    return [(number(column, value), counts[value]) for value in known]


def counts_in(histogram: Histogram) -> Counts:
    """Return the counts of the bins, each labelled with where it begins."""
    edges = histogram.edges.tolist()
    near = min(end - start for start, end in pairwise(edges)) / _FINER
    digits = next((n for n in range(3, 17) if all(abs(float(f"{x:.{n}g}") - x) <= near for x in edges)), 17)
    return [(f"{edge:.{digits}g}", n) for edge, n in zip(edges, histogram.counts.tolist(), strict=False)]


def lines_of(counts: Counts, width: int, without: int = 0) -> list[str]:
    """Return a line a count: its label, the number, and a bar as long as there is room for.

    Behind them stands how many are without a value, and so in none of the counts.
    """
    every = [*counts, *([("without", without)] if without else [])]
    if not every:
        return ["none"]
    label = max(len(text) for text, _ in every)
    figures = max(len(f"{count:,}") for _, count in every)
    most = max((count for _, count in counts), default=0)
    room = max(width - label - figures - 2, 0)
    room = room if room >= _LEAST_BAR else 0
    bars = [*(_bar(count, most, room) for _, count in counts), ""]
    lines = (f"{text:>{label}} {n:>{figures},} {bar}" for (text, n), bar in zip(every, bars, strict=False))
    return [line.rstrip() for line in lines]


def _bar(count: int, most: int, room: int) -> str:
    """Return a bar of eighths of cells; what there is can be seen, be it little."""
    eighths = max(round(8 * room * count / most), 1) if count and room else 0
    return "█" * (eighths // 8) + (_EIGHTHS[eighths % 8] if eighths % 8 else "")


def title_of(column: str) -> str:
    """Return what a column is, in a few words."""
    known = _COLUMNS[column]
    unit = f" ({known.unit})" if known.unit not in ("", "1") else ""
    return f"{column}: {known.brief}{unit}"


def is_measured(column: str) -> bool:
    """Tell whether a column has numbers that are not whole, and so bins."""
    return _COLUMNS[column].kind == "number"
