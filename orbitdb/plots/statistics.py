"""Figures of the statistics of levels: spacings, the number variance and the spectral rigidity."""

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from matplotlib.axes import Axes

from orbitdb.answers.level_lists import assessed, lacking
from orbitdb.arrays import Floats
from orbitdb.billiard.stadium import Stadium
from orbitdb.plots.style import BLUE, GREY, INK, ORANGE, Picture, figure
from orbitdb.quantum.level_statistics import (
    FAMILY_TO,
    delta3,
    goe_delta3,
    goe_variance,
    number_variance,
    unfolded,
)
from orbitdb.quantum.weyl import Parity
from orbitdb.selection import Selection
from orbitdb.text import format_float, several

if TYPE_CHECKING:
    from orbitdb.catalogue import Catalogue

Parts = Mapping[Parity, Floats]
"""The levels k of each parity, in ascending order."""

_LAST, _WIDTH = 4.0, 0.2
"""End of the axis and width of the bars of spacings, in mean spacings."""
_LONGEST, _STEP = 25.0, 0.5
"""The longest stretch of levels, and the step from one to the next, in mean spacings."""


def spacings(catalogue: "Catalogue", chosen: Selection, parts: Parts) -> Picture:
    """Draw the distribution of level spacings, in units of their mean, with those of Wigner and Poisson."""
    count = sum(len(k) - 1 for k in parts.values())
    with figure(
        6.4, 4.2, f"{several(count, 'spacing')} at a = {format_float(chosen.a)}: {', '.join(parts)}"
    ) as made:
        draw_spacings(made.add_subplot(), chosen.a, parts)
    return made


def draw_spacings(ax: Axes, a: float, parts: Parts) -> None:
    """Draw the distribution of the spacings of levels of each parity, unfolded by Weyl's law."""
    gaps = np.concatenate([np.diff(unfolded(k, Stadium(a), parity)) for parity, k in parts.items()])
    edges = np.arange(0, _LAST + _WIDTH / 2, _WIDTH)
    count, _ = np.histogram(gaps, edges)
    middle, unit = edges[:-1] + _WIDTH / 2, len(gaps) * _WIDTH
    error = np.sqrt(count * (1 - count / len(gaps)))  # of a multinomial distribution
    ax.bar(middle, count / unit, _WIDTH, color=BLUE, alpha=0.35)
    some = count > 0
    ax.errorbar(middle[some], count[some] / unit, error[some] / unit, fmt=".", color=BLUE, capsize=2,
                linewidth=1, label="levels, with standard errors")  # fmt: skip
    s = np.linspace(0, _LAST, 200)
    wigner = np.pi / 2 * s * np.exp(-np.pi / 4 * s**2)
    ax.plot(s, wigner, color=INK, label="random matrices (Wigner)")
    ax.plot(s, np.exp(-s), color=GREY, linestyle="--", label="uncorrelated levels (Poisson)")
    ax.set(xlabel="spacing (in units of the mean)", ylabel="density", xlim=(0, _LAST), ylim=(0, None))


class _Statistic(NamedTuple):
    """A statistic of stretches of levels: its name, and its values for levels, the GOE and Poisson levels."""

    name: str
    of: Callable[[Floats, float, float], float | None]
    goe: Callable[[float], float]
    poisson: Callable[[float], float]


STATISTICS = {
    "delta3": _Statistic(r"$\Delta_3(L)$", delta3, goe_delta3, lambda length: length / 15),
    "variance": _Statistic(
        r"number variance $\Sigma^2(L)$", number_variance, lambda length: float(goe_variance(length)), float
    ),
}


def rigidity(catalogue: "Catalogue", chosen: Selection, parts: Parts, window: bool = False) -> Picture:
    """Draw Delta_3 and the number variance, the mean over the parities, with and without bouncing balls.

    They allow for the levels that the lists lack, as far as orbits tell. The curves of the GOE and of
    uncorrelated (Poisson) levels are drawn for comparison.
    """
    title = f"spectral rigidity at a = {format_float(chosen.a)}: {', '.join(parts)}"
    with catalogue._reading() as connection:
        found = {parity: assessed(connection, chosen.a, k, parity, window) for parity, k in parts.items()}
    missing = {parity: each.missing_share for parity, each in found.items() if each is not None}
    notes = [line for each in found.values() for line in lacking(each)]
    notes += [f"bouncing balls up to length {FAMILY_TO:g} are subtracted for the dashed lines"]
    with figure(6.4, 6.4, title, notes) as made:
        axes = made.subplots(2, 1, sharex=True)
        for ax, name in zip(axes, STATISTICS, strict=True):
            draw_rigidity(ax, chosen.a, parts, name, missing)
        axes[0].set(xlabel="")
    return made


def draw_rigidity(
    ax: Axes,
    a: float,
    parts: Parts,
    name: str = "delta3",
    missing: Mapping[Parity, float | None] | None = None,
) -> None:
    """Draw a statistic of stretches of levels against their length L: ``delta3`` or ``variance``.

    The curve is the mean over the parities; the band around it is their standard deviation. `missing` is the
    share of the levels of a parity that its list lacks.
    """
    shares = [(missing or {}).get(parity) or 0.0 for parity in parts]
    statistic, lengths = STATISTICS[name], np.arange(_STEP, _LONGEST + _STEP / 2, _STEP)
    shown = {}
    for balls in (False, True):
        levels = [np.sort(unfolded(k, Stadium(a), parity, balls)) for parity, k in parts.items()]
        values = np.array(
            [
                [statistic.of(x, length, share) for length in lengths]
                for x, share in zip(levels, shares, strict=True)
            ],
            float,
        )
        shown[balls] = values[:, np.isfinite(values).all(axis=0)]
    lengths = lengths[: min(values.shape[1] for values in shown.values())]
    for (balls, values), (colour, style) in zip(shown.items(), ((BLUE, "-"), (ORANGE, "--")), strict=True):
        mean, spread = values[:, : len(lengths)].mean(axis=0), values[:, : len(lengths)].std(axis=0)
        ax.plot(lengths, mean, style, color=colour, label="without bouncing balls" if balls else "levels")
        if len(values) > 1:
            ax.fill_between(lengths, mean - spread, mean + spread, color=colour, alpha=0.2, linewidth=0)
    high = ax.dataLim.y1
    goe, poisson = ([curve(length) for length in lengths] for curve in (statistic.goe, statistic.poisson))
    ax.plot(lengths, goe, color=INK, linewidth=1, label="random matrices (GOE)")
    ax.plot(lengths, poisson, ":", color=GREY, label="uncorrelated levels (Poisson)")
    ax.set(xlabel="$L$ (mean spacings)", ylabel=statistic.name, ylim=(0, 1.15 * high), xlim=(0, lengths[-1]))
