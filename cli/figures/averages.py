"""Figures of averages by period: the topological entropy, and Lyapunov exponents."""

from dataclasses import replace

import numpy as np
import typer
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from orbitdb.answers.averaged import entropy, lyapunov
from orbitdb.answers.methods import AVERAGES
from orbitdb.answers.results import Result
from orbitdb.arrays import Floats
from orbitdb.cli.render import note
from orbitdb.plots.style import BLUE, INK, INKS, ORANGE, PURPLE, figure
from orbitdb.store.asking.periods import joined_spans
from orbitdb.store.asking.selection import Selection
from orbitdb.store.reading.moment import Moment

NOTHING = ": nothing to draw"
_ROOM = 0.12
"""How much higher and lower than its values the axes are, in units of their spread."""


def draw_entropy(moment: Moment, chosen: Selection) -> Figure:
    """Draw K_0 and h_zeta by period, as in the paper's Fig. 5, with the proved bounds."""
    found = entropy(moment, chosen)
    p, shown, title = _series(found, chosen)
    k_0, h_zeta, band = shown["K_0"], shown["h_zeta"], (found["h_lower"][0], found["h_upper"][0])
    values = np.concatenate([k_0[p > 2], h_zeta[len(h_zeta) // 2 :], band])
    values = values[np.isfinite(values)]
    room = _ROOM * np.ptp(values)
    low, high = values.min() - room, values.max() + room
    with figure(6.4, 4.2, title) as made:
        ax = made.add_subplot()
        ax.axhspan(*band, color=PURPLE, alpha=0.5, linewidth=1, label="proved bounds")
        inside = (h_zeta > low) & (h_zeta < high)
        label = "$h(p)$, zero of the zeta function to order $p$"
        ax.plot(p[inside], h_zeta[inside], "s", color=ORANGE, markersize=5, label=label)
        ax.plot(p, k_0, "o-", color=BLUE, markersize=5, label=r"$K_0(p) = \ln N(p)\,/\,p$")
        for period, value in zip(p[k_0 < low], k_0[k_0 < low], strict=True):
            ax.annotate(
                f"↓ {value:.4f}", (period, low), xytext=(0, 4), textcoords="offset points", ha="center"
            )
        _by_period(ax, "topological entropy (per bounce)")
        ax.set(xlim=(p[0] - 0.7, p[-1] + 0.5), ylim=(low, high))
    return made


def draw_lyapunov(moment: Moment, chosen: Selection) -> Figure:
    """Draw the exponents per bounce and per length by period, as in the paper's Fig. 6, by every method."""
    found = lyapunov(moment, chosen)
    p, shown, title = _series(found, chosen)
    with figure(6.4, 6.4, title) as made:
        above, below = made.subplots(2, 1, sharex=True)
        for ax, name, unit in ((above, "lambda_d", "bounce"), (below, "lambda_c", "length $R$")):
            for average in AVERAGES:
                values, colour = shown[average.of(name)], INKS[average.ink]
                if np.isnan(values).all():
                    continue
                ax.plot(p, values, average.line, color=colour, markersize=5, linewidth=1, label=average.label)
                if average.error:
                    error = shown[f"{average.of(name)}_error"]
                    ax.fill_between(p, values - error, values + error, color=colour, alpha=0.3, linewidth=0)
            if f"{name}_trajectory" in shown:
                value, off = found[f"{name}_trajectory"][0], 2 * found[f"{name}_error_trajectory"][0]
                ax.axhspan(value - off, value + off, color=INK, alpha=0.2, linewidth=0)
                label = r"random trajectories (band: $\pm 2$ errors)"
                ax.axhline(value, color=INK, linewidth=1, label=label)
            _by_period(ax, rf"$\langle \{name} \rangle$ (per {unit})")
        above.set(xlabel="")
    return made


def _series(found: Result, chosen: Selection) -> tuple[NDArray[np.int64], dict[str, Floats], str]:
    """Return all periods from the first to the last, the averages, NaN where there is none, and a title.

    So no line is drawn across a period that is not there. Notes say what is missing; the command ends if
    that is everything. The title names the periods that are drawn.
    """
    for text in found.notes:
        note(text if len(found) else f"{text}{NOTHING}")
    if not len(found):
        raise typer.Exit(1)
    here = np.array(found["p"])
    p = np.arange(here[0], here[-1] + 1)
    shown = {}
    for name in found.columns:
        if name not in ("p", "h_proof"):
            shown[name] = np.full(len(p), np.nan)
            shown[name][here - here[0]] = np.array(found[name], dtype=float)
    spans = joined_spans([(p, p) for p in found["p"]])
    drawn = replace(chosen, periods=tuple(spans)) if chosen.periods else chosen
    return p, shown, drawn.describe()


def _by_period(ax: Axes, label: str) -> None:
    ax.set(xlabel="period $p$ (bounces)", ylabel=label)
    ax.xaxis.set_major_locator(MaxNLocator(integer=True, min_n_ticks=1))
