"""Figures of averages: entropy and Lyapunov exponents by period; births and the entropy against a."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import typer
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from sqlalchemy import Connection

from orbitdb.answers.entropy import enclosure, entropy
from orbitdb.answers.lyapunov import EXPONENTS, lyapunov
from orbitdb.answers.results import Result
from orbitdb.arrays import Floats
from orbitdb.averages.by_period import entropy_of_counts
from orbitdb.cli.output import note
from orbitdb.entropy.windows import geometric_entropy
from orbitdb.errors import InputError
from orbitdb.plots import curves
from orbitdb.plots.style import BLUE, GREEN, GREY, ORANGE, PURPLE, figure
from orbitdb.store.lives import read_birth_fills, read_lives
from orbitdb.store.results import bounds_by_a
from orbitdb.store.selection import Selection, joined_spans

NOTHING = ": nothing to draw"


def draw_entropy(moment: Connection, chosen: Selection) -> Figure:
    """Draw K_0 and h_zeta by period, as in Fig. 5 of the paper, with the proved bounds."""
    result = entropy(moment, chosen)
    with figure(6.4, 4.2, _title(result, chosen)) as made:
        curves.draw_entropy(made.add_subplot(), result)
    return made


def draw_lyapunov(moment: Connection, chosen: Selection, *others: Selection) -> Figure:
    """Draw the Lyapunov exponents by period from every method, as in Fig. 6 of the paper.

    If there are subsets at several a, only the best method of each is drawn.
    """
    subsets = (chosen, *others)
    results = [lyapunov(moment, subset) for subset in subsets]
    titles = [_title(result, subset) for result, subset in zip(results, subsets, strict=True)]
    title = chosen.describe([subset.a for subset in subsets]) if others else titles[0]
    with figure(6.4, 6.4, title) as made:
        axes = made.subplots(2, 1, sharex=True)
        for ax, name in zip(axes, EXPONENTS, strict=True):
            if others:
                curves.compare_exponents(ax, results, name)
            else:
                curves.draw_exponent(ax, results[0], name)
        axes[0].set(xlabel="")
    return made


def _title(result: Result, chosen: Selection) -> str:
    """Print the notes of a result, and return a title with its periods; exit if there is nothing to draw."""
    for text in result.notes:
        note(text if len(result) else f"{text}{NOTHING}")
    if not len(result):
        raise typer.Exit(1)
    spans = joined_spans([(p, p) for p in result["p"]])
    drawn = replace(chosen, periods=tuple(spans)) if chosen.periods else chosen
    return drawn.describe()


Changes = dict[int, tuple[Floats, Floats]]
"""By period: the values of a of births and deaths, ascending, and numbers of words, negative for deaths."""

PLACES = 400
PLACES_OF_BOUNDS, _ROOM = 200, 1.1
_LOW, _WIDER = 0.02, 1.5
_BINS = 60
_STYLES = ((BLUE, "-"), (ORANGE, "--"), (GREEN, "-."), (PURPLE, ":"))
"""Colours and line styles of the highest periods."""


def draw_births(moment: Connection, chosen: Selection) -> Figure:
    """Draw the share of words that are orbits, the entropy, and the births and deaths, each against a."""
    changes = _changes(moment, chosen)
    shown = [p for p, (places, _) in changes.items() if chosen.includes(p) and places.max(initial=0) > 0]
    shown = shown[-len(_STYLES) :]
    if not shown:
        raise InputError("no births to draw: 'orbitdb births --p 11' finds them")
    a = np.geomspace(_LOW, _WIDER * max(changes[p][0][-1] for p in shown), PLACES)
    edges = np.geomspace(a[0], a[-1], _BINS + 1)
    with figure(6.4, 7.6) as made:
        above, middle, below = made.subplots(3, 1, sharex=True)
        for p, (colour, style) in zip(shown, _STYLES, strict=False):
            share = _orbits(changes, p, a) / changes[p][1].sum()
            above.plot(a, share, style, color=colour, label=f"$p = {p}$")
        for p, (colour, style) in zip(shown[-2:], _STYLES, strict=False):
            if _gapless(changes, p):
                middle.plot(a, _entropies(changes, p, a), style, color=colour, label=f"$h({p}; a)$")
            places = changes[p][0][changes[p][0] > 0]
            share = np.histogram(places, edges)[0] / len(places)
            below.stairs(share, edges, color=colour, linestyle=style, label=f"$p = {p}$")
        _draw_bound(middle)
        for ax, label, corner in (
            (above, r"$N_c(p; a)\,/\,N_t(p)$", "lower right"),
            (middle, "topological entropy", "lower right"),
            (below, "share of births and deaths", "upper left"),
        ):
            ax.set(xscale="log", ylabel=label, xlim=(a[0], a[-1]))
            ax.legend(loc=corner)
        above.set_ylim(0, 1.03)
        below.set_xlabel("$a$")
        made.set_label("births and deaths of orbits")
    return made


def draw_over_a(moment: Connection, chosen: Selection, grid: Sequence[float] = ()) -> Figure:
    """Draw proved bounds on the entropy against a, with the entropy from births if births are stored.

    The bounds are the stored ones or, if a grid is given, those on its points, where missing ones are
    computed.
    """
    bounds = [enclosure(moment, a)[0] for a in grid] or bounds_by_a(moment)
    if not bounds:
        raise InputError("no proved bounds to draw: compute some, as with 'orbitdb bounds --a 0.3:10:40'")
    a, lower, upper = np.array([(proved.a, proved.lower, proved.upper) for proved in bounds]).T
    changes = _changes(moment, chosen)
    with figure(6.4, 4.2) as made:
        ax = made.add_subplot()
        ax.fill_between(
            a, lower, upper, color=PURPLE, alpha=0.35, linewidth=0, label="between the bounds (not proved)"
        )
        middle, half = (lower + upper) / 2, (upper - lower) / 2
        ax.errorbar(
            a, middle, half, fmt="none", color=PURPLE, capsize=2, linewidth=1.2, label="proved bounds"
        )
        for p in [p for p in changes if chosen.includes(p) and _gapless(changes, p)][-1:]:
            places = np.geomspace(a[0] / _ROOM, a[-1] * _ROOM, PLACES_OF_BOUNDS)
            label = f"$h({p}; a)$, from births"
            values = _entropies(changes, p, places)
            ax.plot(places, values, color=BLUE, linewidth=1, label=label)
            _mark_end(ax, places, values, p)
        limit = _draw_bound(ax)
        ax.set(xscale="log", xlabel="$a$", ylabel="topological entropy (per bounce)")
        ax.set_ylim(min(float(lower.min()), limit - 0.1) - 0.02, limit + 0.02)
        made.set_label("topological entropy against a")
    return made


def _mark_end(ax: Axes, a: Floats, values: Floats, p: int) -> None:
    """Explain why a curve of the entropy begins or ends inside the figure."""
    finite = np.flatnonzero(np.isfinite(values))
    if not len(finite):
        return
    for end, beside in ((finite[0], 0), (finite[-1], len(a) - 1)):
        if end != beside:
            ax.plot(a[end], values[end], "o", color=BLUE, markersize=3)
            why = f"no zero of the zeta function:\ntoo few orbits up to $p = {p}$"
            side = "left" if beside == 0 else "right"
            ax.annotate(why, (a[end], values[end]), xytext=(6 if beside == 0 else -6, -4), va="top",
                        textcoords="offset points", fontsize=7, color=BLUE, ha=side)  # fmt: skip


def _changes(moment: Connection, chosen: Selection) -> Changes:
    """Return the births and deaths of all whole periods up to the highest chosen one."""
    whole = [fill.p for fill in read_birth_fills(moment) if fill.whole]
    highest = max((p for p in whole if chosen.includes(p)), default=0)
    return {p: curves.changes_of(read_lives(moment, p)) for p in whole if p <= highest}


def _gapless(changes: Changes, highest: int) -> bool:
    return all(p in changes for p in range(2, highest + 1))


def _orbits(changes: Changes, p: int, a: Floats) -> Floats:
    """Return the number of orbits of a period at each of the given a."""
    places, words = changes[p]
    found: Floats = np.append(0, np.cumsum(words))[np.searchsorted(places, a, side="right")]
    return found


def _entropies(changes: Changes, highest: int, a: Floats) -> Floats:
    """Return the entropy at each a, from the zeta function up to a period; NaN if it has no usable zero."""
    counts = np.zeros((len(a), highest + 1), dtype=np.int64)
    for p in range(2, highest + 1):
        counts[:, p] = _orbits(changes, p, a)
    return np.array([entropy_of_counts(row).h_zeta[-1] for row in counts])


def _draw_bound(ax: Axes) -> float:
    """Draw the bound on the entropy that holds for every a, and return it."""
    limit = geometric_entropy()
    ax.axhline(limit, color=GREY, linewidth=0.8, label="bound at every $a$")
    return limit
