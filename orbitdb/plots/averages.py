"""Figures of averages by period: the entropy and the Lyapunov exponents (Figs. 5 and 6 of the paper)."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import cycle
from typing import TYPE_CHECKING

import numpy as np
from matplotlib import rcParams
from matplotlib.axes import Axes
from matplotlib.markers import CARETDOWN, CARETUP
from matplotlib.ticker import MaxNLocator
from matplotlib.transforms import ScaledTranslation

from orbitdb.answers.lyapunov import AVERAGES, EXPONENTS, Average
from orbitdb.answers.results import Result
from orbitdb.arrays import Floats, Integers
from orbitdb.period_ranges import joined_spans
from orbitdb.plots.registry import EmptyFigureError
from orbitdb.plots.style import BLUE, INK, INKS, ORANGE, PURPLE, Picture, figure
from orbitdb.selection import Selection
from orbitdb.text import format_float

if TYPE_CHECKING:
    from orbitdb.catalogue import Catalogue

_ROOM = 0.12
"""Margin above and below the values on the vertical axis, in units of their range."""
ENTROPY = "topological entropy\n(per bounce)"
_EXPONENTS = {
    "lambda_d": r"$\langle \lambda_d \rangle$ (per bounce)",
    "lambda_c": r"$\langle \lambda_c \rangle$ (per length $R$)",
}


def entropy(catalogue: "Catalogue", chosen: Selection) -> Picture:
    """Draw K_0 and h_zeta by period, as in Fig. 5 of the paper, with the proved bounds."""
    result = catalogue.entropy(chosen)
    with figure(6.4, 4.2, _title(result, chosen), result.notes) as made:
        draw_entropy(made.add_subplot(), result)
    return made


def lyapunov(catalogue: "Catalogue", *chosen: Selection) -> Picture:
    """Draw the Lyapunov exponents by period from every method, as in Fig. 6 of the paper.

    If there are subsets at several a, only the best method of each is drawn.
    """
    results = [catalogue.lyapunov(subset) for subset in chosen]
    titles = [_title(result, subset) for result, subset in zip(results, chosen, strict=True)]
    title = chosen[0].describe([subset.a for subset in chosen]) if len(chosen) > 1 else titles[0]
    with figure(6.4, 6.4, title, [note for result in results for note in result.notes]) as made:
        axes = made.subplots(2, 1, sharex=True)
        for ax, name in zip(axes, EXPONENTS, strict=True):
            if len(chosen) > 1:
                compare_exponents(ax, results, name)
            else:
                draw_exponent(ax, results[0], name)
        axes[0].set(xlabel="")
    return made


def _title(result: Result, chosen: Selection) -> str:
    """Return a title with the periods of a result; raise `EmptyFigureError` if it has none."""
    if not len(result):
        raise EmptyFigureError(f"{note}: nothing to draw" for note in result.notes)
    spans = joined_spans([(p, p) for p in result["p"]])
    drawn = replace(chosen, periods=tuple(spans)) if chosen.periods else chosen
    return drawn.describe()


def by_period(result: Result) -> tuple[Integers, dict[str, Floats]]:
    """Return all periods from the first to the last, and the columns of a result at these periods.

    The columns are NaN for missing periods, which interrupts the line of a curve.
    """
    periods = np.array(result["p"])
    p = np.arange(periods[0], periods[-1] + 1)
    shown = {}
    for name, values in result.columns.items():
        if name not in ("p", "h_proof"):
            shown[name] = np.full(len(p), np.nan)
            shown[name][periods - p[0]] = np.array(values, dtype=float)
    return p, shown


def draw_entropy(ax: Axes, result: Result) -> None:
    """Draw K_0 and h_zeta against the period, as in the paper's Fig. 5, and any proved bounds."""
    p, shown = by_period(result)
    k_0, h_zeta = shown["K_0"], shown["h_zeta"]
    band = (shown["h_lower"][0], shown["h_upper"][0]) if "h_lower" in shown else ()
    values = np.concatenate([k_0[p > 2], h_zeta[len(h_zeta) // 2 :], band])
    values = values[np.isfinite(values)]
    room = _ROOM * np.ptp(values)
    low, high = values.min() - room, values.max() + room
    if band:
        ax.axhspan(*band, color=PURPLE, alpha=0.5, linewidth=1, label="proved bounds")
    ax.plot(p, h_zeta, "s", color=ORANGE, label="$h(p)$, zero of the zeta function to order $p$")
    ax.plot(p, k_0, "o-", color=BLUE, label=r"$K_0(p) = \ln N(p)\,/\,p$")
    _limit(ax, low, high)
    _over_periods(ax, ENTROPY)
    ax.set_xlim(p[0] - 0.7, p[-1] + 0.5)


def draw_exponent(ax: Axes, result: Result, name: str) -> None:
    """Draw every average of ``lambda_d`` or ``lambda_c`` against the period, as in the paper's Fig. 6."""
    p, shown = by_period(result)
    for average in AVERAGES:
        _draw_average(ax, p, shown, average, name, INKS[average.ink], average.label)
    if f"{name}_trajectory" in shown:
        value, off = shown[f"{name}_trajectory"][0], 2 * shown[f"{name}_error_trajectory"][0]
        ax.axhspan(value - off, value + off, color=INK, alpha=0.2, linewidth=0)
        ax.axhline(value, color=INK, linewidth=1, label=r"random trajectories (band: $\pm 2$ errors)")
    _show_later(ax)
    _over_periods(ax, _EXPONENTS[name])


def compare_exponents(ax: Axes, results: Sequence[Result], name: str) -> None:
    """Draw ``lambda_d`` or ``lambda_c`` at several a against the period, each by the best method it has."""
    bars = []
    for result, colour in zip(results, cycle(INKS.values()), strict=False):
        p, shown = by_period(result)
        for best in [average for average in AVERAGES if np.isfinite(shown[average.of(name)]).any()][-1:]:
            values, error = shown[best.of(name)], shown.get(f"{best.of(name)}_error")
            told = best.brief if error is None else f"{best.brief} (bars: error)"
            label = f"$a = {format_float(result.selection.a)}$: {told}"
            ax.plot(p, values, best.line, color=colour, linewidth=1, label=label)
            if error is not None:
                bars.append((p, values, error, colour))
    _show_later(ax)
    for p, values, error, colour in bars:  # last, so that long ones at low periods do not stretch the axis
        ax.errorbar(p, values, error, fmt="none", color=colour, elinewidth=0.8)
    _over_periods(ax, _EXPONENTS[name])


def _draw_average(
    ax: Axes, p: Integers, shown: dict[str, Floats], average: Average, name: str, colour: str, label: str
) -> None:
    """Draw an average with the band of its error, unless it has no values."""
    values = shown[average.of(name)]
    if np.isnan(values).all():
        return
    ax.plot(p, values, average.line, color=colour, linewidth=1, label=label)
    if average.error:
        error = shown[f"{average.of(name)}_error"]
        ax.fill_between(p, values - error, values + error, color=colour, alpha=0.3, linewidth=0)


def _show_later(ax: Axes) -> None:
    """Limit the vertical axis to the curves at the later half of the periods."""
    curves = [np.array(line.get_ydata(), float) for line in ax.lines]
    later = np.concatenate([y[len(y) // 2 if len(y) > 2 else 0 :] for y in curves])
    later = later[np.isfinite(later)]
    if room := _ROOM * np.ptp(later):
        _limit(ax, later.min() - room, later.max() + room)


def _limit(ax: Axes, low: float, high: float) -> None:
    """Limit the vertical axis; carets at its ends, side by side, mark the points of curves beyond them."""
    drawn = [(line, *np.array(line.get_data(), float)) for line in ax.lines]
    drawn = [(line, p, y) for line, p, y in drawn if ((y > high) | (y < low)).any()]
    for place, (line, p, y) in enumerate(drawn):
        aside = (place - (len(drawn) - 1) / 2) * 1.25 * rcParams["lines.markersize"]
        beside = ax.transData + ScaledTranslation(aside / 72, 0, ax.figure.dpi_scale_trans)
        for beyond, edge, caret in ((y > high, high, CARETUP), (y < low, low, CARETDOWN)):
            if beyond.any():
                ax.plot(p[beyond], np.full(beyond.sum(), edge), linestyle="", marker=caret,
                        color=line.get_color(), clip_on=False, transform=beside)  # fmt: skip
    ax.set_ylim(low, high)


def _over_periods(ax: Axes, label: str) -> None:
    ax.set(xlabel="period $p$ (bounces)", ylabel=label)
    ax.xaxis.set_major_locator(MaxNLocator(integer=True, min_n_ticks=1))
