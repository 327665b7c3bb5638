"""Figures against the half length a: births and deaths, the life of an orbit, and bounds on the entropy."""

import math
from collections.abc import Iterable, Sequence
from decimal import ROUND_CEILING, ROUND_FLOOR
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.markers import CARETDOWN
from matplotlib.ticker import FixedLocator, LogLocator, MaxNLocator, NullFormatter

from orbitdb.answers.entropy import enclosure
from orbitdb.arrays import Floats
from orbitdb.averages.by_period import entropy_of_counts
from orbitdb.billiard.stadium import Stadium
from orbitdb.entropy_bounds.windows import geometric_entropy
from orbitdb.errors import InputError
from orbitdb.orbits.orbit import Orbit
from orbitdb.orbits.solve import solve_word, with_existence
from orbitdb.plots import paths
from orbitdb.plots.averages import ENTROPY
from orbitdb.plots.registry import EmptyFigureError
from orbitdb.plots.style import BLUE, GREEN, GREY, ORANGE, PURPLE, SMALL, Picture, figure, short
from orbitdb.selection import Selection
from orbitdb.text import format_float, outward

if TYPE_CHECKING:
    from orbitdb.catalogue import Catalogue
    from orbitdb.entropy_bounds.bounds import EntropyBounds
    from orbitdb.store.lookup import Life

_TICKS = ((1,), (1, 3), (1, 2, 5), tuple(range(1, 10)))
"""Leading digits of the values of a to label, from few to many."""
_ENOUGH = 4
"""Number of labels that an axis over a should have."""


def over_a(ax: Axes, low: float, high: float) -> None:
    """Make the horizontal axis that of the half length a: logarithmic, with plain numbers such as 0.3."""
    ax.set(xscale="log", xlim=(low, high), xlabel="half length $a/R$")
    decades = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    grids = [[digit * 10.0**decade for decade in decades for digit in digits] for digits in _TICKS]
    grids.append([*map(float, MaxNLocator(_ENOUGH).tick_values(low, high))])
    inside = [[tick for tick in ticks if low <= tick <= high] for ticks in grids]
    ticks = next((ticks for ticks in inside if len(ticks) >= _ENOUGH), inside[-1])
    ax.xaxis.set_major_locator(FixedLocator(ticks))
    ax.xaxis.set_major_formatter(lambda tick, _: f"{tick:.6g}")
    ax.xaxis.set_minor_locator(LogLocator(subs=range(1, 10)))
    ax.xaxis.set_minor_formatter(NullFormatter())


# births and deaths

Changes = dict[int, tuple[Floats, Floats]]
"""By period: the values of a of births and deaths, ascending, and numbers of words, negative for deaths."""

PLACES = 400
_LOW, _WIDER = 0.02, 1.5
_BINS = 60
_STYLES = ((BLUE, "-"), (ORANGE, "--"), (GREEN, "-."), (PURPLE, ":"))
"""Colours and line styles of the highest periods."""


def changes_of(births: Iterable["Life"]) -> tuple[Floats, Floats]:
    """Return the values of a of births and deaths, ascending, and the words gained there, below 0 if lost."""
    lives = list(births)
    ends = [(life.born or 0.0, life.class_size) for life in lives]
    ends += [(life.dies, -life.class_size) for life in lives if life.dies is not None]
    a, words = np.array(sorted(ends), dtype=float).reshape(-1, 2).T
    return a, words


def draw_births(ax: Axes, births: Sequence["Life"]) -> None:
    """Draw the number of words that are orbits against a, given their births and deaths."""
    a, words = changes_of(births)
    first = a[a > 0].min(initial=a.max()) / 2 or 1.0
    ends = np.concatenate([np.maximum(a, first), [2 * max(float(a[-1]), first)]])
    number = np.cumsum(words)
    ax.step(ends, np.append(number, number[-1]), where="post", color=BLUE)
    ax.set(ylabel=f"$N_c({births[0].p}; a)$", ylim=(0, 1.05 * number.max()))
    over_a(ax, ends[0], ends[-1])


def births(catalogue: "Catalogue", chosen: Selection) -> Picture:
    """Draw the share of words that are orbits, the entropy, and the births and deaths, each against a."""
    changes = _changes(catalogue, chosen)
    shown = [p for p, (places, _) in changes.items() if chosen.includes(p) and places.max(initial=0) > 0]
    shown = shown[-len(_STYLES) :]
    if not shown:
        raise EmptyFigureError(["no births to draw: `catalogue.fill_births(p=11)` finds them"])
    a = np.geomspace(_LOW, _WIDER * max(changes[p][0][-1] for p in shown), PLACES)
    edges = np.geomspace(a[0], a[-1], _BINS + 1)
    with figure(6.4, 7.2) as made:
        above, middle, below = axes = made.subplots(3, 1, sharex=True)
        for p, (colour, style) in zip(shown, _STYLES, strict=False):
            share = _orbits(changes, p, a) / changes[p][1].sum()
            below_too = p in shown[-2:]  # more would only hide one another
            above.plot(a, share, style, color=colour, label=f"$p = {p}${'' if below_too else ' (top only)'}")
            if not below_too:
                continue
            places = changes[p][0][changes[p][0] > 0]
            below.stairs(np.histogram(places, edges)[0] / len(places), edges, color=colour, linestyle=style)
            if _gapless(changes, p):
                values = _entropies(changes, p, a)
                middle.plot(a, values, style, color=colour)
                _mark_ends(middle, a, values, colour)
        draw_limit(middle)
        above.set(ylabel=r"$N_c(p; a)\,/\,N_t(p)$", ylim=(0, 1.03))
        middle.set(ylabel="entropy $h(p; a)$")
        below.set(ylabel="share of births\nand deaths")
        for ax in axes:
            over_a(ax, a[0], a[-1])
            ax.label_outer()
        made.set_label("births and deaths of orbits")
    return made


def _changes(catalogue: "Catalogue", chosen: Selection) -> Changes:
    """Return the births and deaths of all complete periods up to the highest chosen one."""
    whole = [fill.p for fill in catalogue.birth_fills() if fill.done]
    highest = max((p for p in whole if chosen.includes(p)), default=0)
    return {p: changes_of(catalogue.births(p)) for p in whole if p <= highest}


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


def _mark_ends(ax: Axes, a: Floats, values: Floats, colour: str) -> None:
    """Mark with dots where a curve of the entropy ends inside the figure, also at gaps, and say why."""
    known = np.isfinite(values)
    ends = np.flatnonzero(known & ~(np.append(True, known[:-1]) & np.append(known[1:], True)))
    if len(ends):
        ax.plot(
            a[ends], values[ends], "o", color=colour, markersize=3, label="no estimate beyond: no usable zero"
        )


def draw_limit(ax: Axes) -> float:
    """Draw the bound on the entropy that holds for every a, and return it."""
    limit = geometric_entropy()
    ax.axhline(limit, color=GREY, linewidth=0.8, label="upper bound at every $a$")
    return limit


# bounds on the entropy

PLACES_OF_BOUNDS = 200
_BESIDE_BOUNDS = 1.25
"""Factor between the first or last a with bounds, or the first birth of a life, and the end of the axis."""
_FEW = 3
"""The legend writes out at most this many proved intervals."""
_PLACES = 5
"""Decimals of a proved interval in the legend."""


def entropy_over_a(catalogue: "Catalogue", *chosen: Selection, grid: Sequence[float] = ()) -> Picture:
    """Draw proved bounds on the entropy against a, with the entropy from births if births are stored.

    The bounds are the stored ones or, if a grid is given, those on its points, where missing ones are
    computed.
    """
    with catalogue._reading() as connection:
        computed = [enclosure(connection, a).bounds for a in grid]
    bounds: Sequence[EntropyBounds] = computed or catalogue.entropy_curve()
    if not bounds:
        raise EmptyFigureError(["no proved bounds to draw: `catalogue.prove_bounds(a=1)` finds some"])
    changes = _changes(catalogue, chosen[0])
    first, last = bounds[0].a / _BESIDE_BOUNDS, bounds[-1].a * _BESIDE_BOUNDS
    with figure(6.4, 4.2) as made:
        ax = made.add_subplot()
        draw_bounds(ax, bounds)
        limit = draw_limit(ax)
        heights = [limit - 0.1, *(each.lower for each in bounds if each.lower > 0)]
        for p in [p for p in changes if chosen[0].includes(p) and _gapless(changes, p)][-1:]:
            first, last = (min(first, 0.2), max(last, 20.0)) if len(bounds) <= _FEW else (first, last)
            places = np.geomspace(first, last, PLACES_OF_BOUNDS)
            values = _entropies(changes, p, places)
            ax.plot(places, values, color=BLUE, linewidth=1, label=f"$h({p}; a)$, estimated from births")
            made.notes += _outside(bounds, _entropies(changes, p, np.array([each.a for each in bounds])), p)
            _mark_ends(ax, places, values, BLUE)
            heights += values[np.isfinite(values)].tolist()
        low = min(heights) - 0.02
        beyond = [each.a for each in bounds if each.lower < low]  # the bound 0, which needs no proof
        if beyond:  # constrained layout would leave room for an empty line
            ax.plot(beyond, [low] * len(beyond), linestyle="", marker=CARETDOWN, color=PURPLE, clip_on=False)
        ax.set(ylabel=ENTROPY, ylim=(low, limit + 0.02))
        over_a(ax, first, last)
        made.set_label("topological entropy against a")
    return made


def _outside(bounds: Sequence["EntropyBounds"], values: Floats, p: int) -> tuple[str, ...]:
    """Return a note on the values of a at which the estimate from births contradicts the proved bounds."""
    pairs = zip(bounds, values.tolist(), strict=True)
    beyond = [format_float(each.a) for each, h in pairs if h < each.lower or h > each.upper]
    if not beyond:
        return ()
    many = len(beyond) > _FEW
    some = f"{len(beyond)} values of a from {beyond[0]} to {beyond[-1]}"
    where = some if many else f"a = {', '.join(beyond)}"
    return (
        f"h({p}; a) is an estimate from words up to period {p}; at {where}, it lies outside the bounds, "
        "which are proved",
    )


def draw_bounds(ax: Axes, bounds: Sequence["EntropyBounds"]) -> None:
    """Draw proved bounds on the entropy at several a, and the band between them."""
    a, lower, upper = np.array([(proved.a, proved.lower, proved.upper) for proved in bounds]).T
    middle, half = (lower + upper) / 2, (upper - lower) / 2
    look: dict[str, Any] = {"fmt": "o", "color": PURPLE, "capsize": 3, "linewidth": 1.2}
    if len(bounds) > _FEW:
        ax.fill_between(
            a, lower, upper, color=PURPLE, alpha=0.35, linewidth=0, label="interpolated bounds (not proved)"
        )
        ax.errorbar(a, middle, half, markersize=0, label="proved bounds, at single $a$", **look)
        return
    for number, proved in enumerate(bounds):
        low, high = outward(proved.lower, ROUND_FLOOR, _PLACES), outward(proved.upper, ROUND_CEILING, _PLACES)
        label = f"proved at $a = {format_float(proved.a)}$: ${low} < h < {high}$"
        marked = look | {"fmt": "osD"[number]}
        ax.errorbar(a[number], middle[number], half[number], label=label, zorder=3, **marked)


# one orbit

_FROM, _TO, _BESIDE = 0.1, 5.0, 1e-9


def life(orbit: Orbit) -> Picture:
    """Draw the orbit of a word at its birth, and its length and lambda against a.

    Raises
    ------
    InputError
        If the word is too long to be followed, or is an orbit at no a.
    """
    lives, name = with_existence(orbit).exists, short(orbit.code)
    if lives is None:
        raise InputError(f"{name} is too long to be followed as a changes")
    if not lives:
        raise InputError(f"{name} is not an orbit at any a: {orbit.status.sentence}")
    ends = [end for pair in lives for end in pair if end]
    start = lives[0][0] * (1 + _BESIDE) or orbit.a
    first = solve_word(orbit.code, start)
    low = lives[0][0] / _BESIDE_BOUNDS if lives[0][0] else min([_FROM, *(end / 2 for end in ends)])
    high = max([_TO, *(4 * end for end in ends)])
    beside = [end * (1 + sign * _BESIDE) for end in ends for sign in (-1, 1)]
    a = np.sort(np.concatenate([np.geomspace(low, high, PLACES), beside]))
    with figure(6.4, 7.2) as made:
        above, middle, below = made.subplots(3, 1, height_ratios=(1.2, 1, 1))
        assert first.points is not None
        paths.draw_orbit(above, Stadium(first.a), first.points, first.code)
        said = f"is born at $a = {first.a:.6g}$" if lives[0][0] else f"exists at $a = {first.a:.6g}$"
        above.set_title(f"{short(orbit.code)} {said}")
        draw_life((middle, below), orbit.code, a, lives)
        middle.label_outer()
        made.set_label(f"life of {name}")
    return made


def draw_life(
    axes: Sequence[Axes], code: str, a: Floats, lives: Sequence[tuple[float, float | None]]
) -> None:
    """Draw the length and lambda of a word against a, shape (n,), with the births and deaths of `lives`."""
    ends = [(end, said) for life in lives for end, said in zip(life, ("born", "dies"), strict=True) if end]
    orbits = [solve_word(code, at) for at in a.tolist()]
    numbers = np.array([
        (np.nan, np.nan) if solved.status != "orbit" else (solved.length or np.nan, solved.lyapunov or np.nan)
        for solved in orbits
    ])  # fmt: skip
    for ax, values, label, colour in zip(
        axes, numbers.T, ("length $L/R$", r"$\lambda$"), (BLUE, ORANGE), strict=True
    ):
        ax.plot(a, values, color=colour)
        for end, _ in ends:
            ax.axvline(end, color=GREY, linewidth=0.8, linestyle=":")
        ax.set(ylabel=label)
        over_a(ax, a[0], a[-1])
    for end, said in ends:
        axes[0].annotate(f"{said} {end:.4g}", (end, 1), xycoords=("data", "axes fraction"), xytext=(-2, -2),
                         textcoords="offset points", rotation=90, ha="right", va="top", fontsize=SMALL,
                         color=GREY)  # fmt: skip
