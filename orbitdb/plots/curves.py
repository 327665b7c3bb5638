"""Figures of results: averages by period, the length spectrum, levels, waves and Husimi functions."""

from collections.abc import Iterable, Sequence
from itertools import cycle
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator
from numpy.polynomial import Polynomial

from orbitdb.answers.lyapunov import AVERAGES, Average
from orbitdb.answers.results import Result
from orbitdb.arrays import Floats, Integers
from orbitdb.billiard.stadium import Stadium
from orbitdb.plots.style import BLUE, GREY, INK, INKS, ORANGE, PURPLE, short
from orbitdb.quantum.weyl import weyl
from orbitdb.text import exact

if TYPE_CHECKING:
    from orbitdb.orbits.orbit import Orbit
    from orbitdb.quantum.length_spectrum import Peak, Spectrum
    from orbitdb.quantum.levels import Levels
    from orbitdb.quantum.waves import Wave
    from orbitdb.store.lives import Life

_ROOM = 0.12
"""Margin above and below the values on the vertical axis, in units of their range."""
_EXPONENTS = {
    "lambda_d": r"$\langle \lambda_d \rangle$ (per bounce)",
    "lambda_c": r"$\langle \lambda_c \rangle$ (per length $R$)",
}


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
    inside = (h_zeta > low) & (h_zeta < high)
    label = "$h(p)$, zero of the zeta function to order $p$"
    ax.plot(p[inside], h_zeta[inside], "s", color=ORANGE, markersize=5, label=label)
    ax.plot(p, k_0, "o-", color=BLUE, markersize=5, label=r"$K_0(p) = \ln N(p)\,/\,p$")
    for period, value in zip(p[k_0 < low], k_0[k_0 < low], strict=True):
        ax.annotate(f"↓ {value:.4f}", (period, low), xytext=(0, 4), textcoords="offset points", ha="center")
    _over_periods(ax, "topological entropy (per bounce)")
    ax.set(xlim=(p[0] - 0.7, p[-1] + 0.5), ylim=(low, high))


def draw_exponent(ax: Axes, result: Result, name: str) -> None:
    """Draw every average of ``lambda_d`` or ``lambda_c`` against the period, as in the paper's Fig. 6."""
    p, shown = by_period(result)
    for average in AVERAGES:
        _draw_average(ax, p, shown, average, name, INKS[average.ink], average.label)
    if f"{name}_trajectory" in shown:
        value, off = shown[f"{name}_trajectory"][0], 2 * shown[f"{name}_error_trajectory"][0]
        ax.axhspan(value - off, value + off, color=INK, alpha=0.2, linewidth=0)
        ax.axhline(value, color=INK, linewidth=1, label=r"random trajectories (band: $\pm 2$ errors)")
    _over_periods(ax, _EXPONENTS[name])


def compare_exponents(ax: Axes, results: Sequence[Result], name: str) -> None:
    """Draw ``lambda_d`` or ``lambda_c`` at several a against the period, each by the best method it has."""
    for result, colour in zip(results, cycle(INKS.values()), strict=False):
        p, shown = by_period(result)
        for best in [average for average in AVERAGES if np.isfinite(shown[average.of(name)]).any()][-1:]:
            label = f"$a = {exact(result.selection.a)}$: {best.brief}"
            _draw_average(ax, p, shown, best, name, colour, label)
    _over_periods(ax, _EXPONENTS[name])


def _draw_average(
    ax: Axes, p: Integers, shown: dict[str, Floats], average: Average, name: str, colour: str, label: str
) -> None:
    """Draw an average with the band of its error, unless it has no values."""
    values = shown[average.of(name)]
    if np.isnan(values).all():
        return
    ax.plot(p, values, average.line, color=colour, markersize=5, linewidth=1, label=label)
    if average.error:
        error = shown[f"{average.of(name)}_error"]
        ax.fill_between(p, values - error, values + error, color=colour, alpha=0.3, linewidth=0)


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
    ax.set(xscale="log", xlabel="$a$", ylabel=f"$N_c({births[0].p}; a)$", xlim=(ends[0], ends[-1]))


def _over_periods(ax: Axes, label: str) -> None:
    ax.set(xlabel="period $p$ (bounces)", ylabel=label)
    ax.xaxis.set_major_locator(MaxNLocator(integer=True, min_n_ticks=1))


def draw_spectrum(ax: Axes, spectrum: "Spectrum") -> None:
    """Draw the length spectrum of the orbits downwards, and that of the levels, if there are any, upwards."""
    side = -1 if spectrum.quantum is None else 1
    if spectrum.quantum is not None:
        ax.plot(spectrum.length, np.abs(spectrum.quantum), color=BLUE, label="levels")
    ax.plot(spectrum.length, -np.abs(spectrum.orbits), color=ORANGE, label="orbits, downwards")
    first, last = spectrum.length[[0, -1]]
    if spectrum.complete < last:
        beyond = max(spectrum.complete, first)
        ax.axvspan(beyond, last, color=GREY, alpha=0.12, label="orbits may be missing")
    for peak in spectrum.peaks(1):
        ax.annotate(times(peak), (peak.length, side * peak.height), xytext=(0, 4 * side),
                    textcoords="offset points", fontsize=7, rotation=90, ha="center",
                    va="bottom" if side > 0 else "top")  # fmt: skip
    ax.axhline(0, color=INK, linewidth=0.6)
    ax.margins(x=0, y=0.25)
    ax.set(xlabel="length $x/R$", ylabel=r"$|F(x)|$")


def times(peak: "Peak") -> str:
    """Return a label for a peak, with the code of its orbit and the number of traversals, such as 1½."""
    whole, half = divmod(peak.repetitions, 1)
    count = f"{int(whole) or ''}{'½' if half else ''}"
    return short(peak.code) if count == "1" else f"{count} × {short(peak.code)}"


def draw_levels(ax: Axes, levels: "Levels") -> None:
    """Draw the number of levels from the lower end of their range up to k, and Weyl's law."""
    smooth = sum((weyl(Stadium(levels.a), parity) for parity in levels.parities), Polynomial([0.0]))
    k = np.linspace(levels.low, levels.high, 400)
    below = smooth(levels.low) if levels.low else 0.0
    ends = [levels.low, *np.sort(levels.k), levels.high]
    count = [*range(len(levels) + 1), len(levels)]
    ax.step(ends, count, where="post", color=BLUE, label="levels")
    ax.plot(k, smooth(k) - below, color=INK, linestyle="--", linewidth=1, label="Weyl's law")
    ax.set(xlabel="$kR$", ylabel=f"levels from {levels.low:g} to $k$" if levels.low else "levels below $k$")


_PIXELS = 130
"""Number of pixels in half the height of the stadium."""
_PLACES, _SINES = 300, 121


def draw_wave(ax: Axes, wave: "Wave", orbit: "Orbit | None" = None) -> None:
    """Draw psi^2 in the stadium; if an orbit is given, draw it on top."""
    a = wave.stadium.a
    y = (np.arange(_PIXELS) + 0.5) / _PIXELS
    x = (np.arange(round(_PIXELS * (1 + a))) + 0.5) / _PIXELS
    quarter = wave.psi(*np.meshgrid(x, y)) ** 2
    half = np.concatenate([quarter[:, ::-1], quarter], axis=1)
    whole = np.concatenate([half[::-1], half])
    ax.imshow(whole, cmap="Blues", extent=(-1 - a, 1 + a, -1, 1), origin="lower", interpolation="nearest")
    ax.plot(*wave.stadium.outline().T, color=INK, linewidth=1)
    if orbit is not None and orbit.points is not None:
        ax.plot(*np.concatenate([orbit.points, orbit.points[:1]]).T, color=ORANGE, linewidth=1)
    ax.set_axis_off()
    ax.set_aspect("equal")


def draw_husimi(ax: Axes, wave: "Wave", orbit: "Orbit | None" = None) -> None:
    """Draw the Husimi function in phase space; if an orbit is given, draw its bounces on top."""
    s = (np.arange(_PLACES) + 0.5) * wave.stadium.perimeter / _PLACES
    sine = np.linspace(-1, 1, _SINES)
    ax.imshow(
        wave.husimi(s, sine).T,
        cmap="Blues",
        extent=(0, wave.stadium.perimeter, -1, 1),
        origin="lower",
        aspect="auto",
    )
    if orbit is not None and orbit.arclength is not None and orbit.sine is not None:
        ax.plot(orbit.arclength, orbit.sine, "o", color=ORANGE, markersize=4, markeredgecolor=INK)
    ax.grid(visible=False)
    ax.set(xlabel="arc length $s/R$", ylabel=r"$\sin\alpha$")
