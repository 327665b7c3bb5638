"""Figures of the symbol plane."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import typer
from matplotlib.figure import Figure

from orbitdb.cli.figures.averages import NOTHING
from orbitdb.cli.reading import note_gaps, note_nothing
from orbitdb.errors import InputError
from orbitdb.orbits.status import Status
from orbitdb.plots import symbol_plane
from orbitdb.plots.symbol_plane import Points, Size
from orbitdb.store.connection import Moment
from orbitdb.store.query import choose
from orbitdb.store.rows import blocks_of
from orbitdb.store.selection import Selection
from orbitdb.symbols.words import from_strings
from orbitdb.text import exact
from orbitdb.trajectories.pruning_front import PruningFront

MOST_WORDS = 1_000_000
"""Largest number of words whose points can still be told apart."""

_WITH_POINTS = (Status.ORBIT, Status.DYNAMICAL)


def draw_symbol_plane(moment: Moment, chosen: Selection, size: Size | None = None) -> Figure:
    """Draw the points of orbits and of dynamically pruned words, with the pruning front."""
    statuses = tuple(status for status in _WITH_POINTS if status in (chosen.statuses or _WITH_POINTS))
    if not statuses:
        raise InputError("only orbits and dynamically pruned words have points: --status orbit,dynamical")
    shown = replace(chosen, statuses=statuses)
    note_gaps(moment, shown)
    words = choose(moment, shown)
    if not len(words):
        note_nothing(moment, shown, more=NOTHING)
        raise typer.Exit(1)
    if len(words) > MOST_WORDS:
        raise InputError(f"{len(words)} words: draw at most {MOST_WORDS}, such as --p 2-12")
    parts = []
    for codes, states in blocks_of(moment, words, ["code", "status"]):
        periods = np.array([len(code) for code in codes])
        for p in np.unique(periods).tolist():
            places = np.flatnonzero(periods == p)
            orbit = np.array([states[place] == Status.ORBIT for place in places.tolist()])
            parts.append(Points.of(from_strings([codes[place] for place in places.tolist()]), orbit))
    points = Points(*map(np.concatenate, zip(*parts, strict=True)))
    return symbol_plane.symbol_plane(PruningFront(chosen.a), points, shown.describe(), size)


def draw_fronts(values: Sequence[float], size: Size | None = None) -> Figure:
    """Draw the pruning fronts at several a."""
    fronts = [PruningFront(a) for a in values]
    return symbol_plane.fronts(fronts, f"pruning fronts at a = {', '.join(map(exact, values))}", size)
