"""Figures of numbers: averages by period, lengths of orbits, levels and their spectrum, run times."""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.colors import LogNorm
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from orbitdb.plots.style import BLUE, GREEN, GREY, INK, ORANGE, PURPLE

if TYPE_CHECKING:
    from orbitdb.benchmarks.work_precision import WorkPrecision
    from orbitdb.quantum.spectrum import Spectrum

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

_OF_METHODS = {
    "newton": ("o-", BLUE, "Newton on leg directions"),
    "balls": ("D-", GREEN, "ball arithmetic (proved radius)"),
    "root": ("^--", PURPLE, "scipy.optimize.root"),
    "relaxation": ("s:", ORANGE, "relaxation (Biham and Kvale)"),
}
_DOUBLE = 2.0**-53
_METHODS = ("_pair", "_zeta", "_sum_rule", "_sum_rule_error")


def draw_entropy(
    ax: Axes,
    p: Integers,
    k_0: Floats,
    h_zeta: Floats,
    band: tuple[float, float],
) -> None:
    """Draw the topological entropy against the period, as in the paper's Fig. 5, and its zeta value.

    Parameters
    ----------
    ax : Axes
    p : ndarray of int, shape (n,)
    k_0 : ndarray, shape (n,)
        ln N(p) / p, per bounce.
    h_zeta : ndarray, shape (n,)
        The value from the zeta function cut off at order p.
    band : (float, float)
        Proved bounds.
    """
    low, high = _span(np.concatenate([k_0[p > 2], h_zeta[len(h_zeta) // 2 :], band]), k_0)
    ax.axhspan(*band, color=PURPLE, alpha=0.5, linewidth=1, label="proved bounds")
    shown = (h_zeta > low) & (h_zeta < high)
    label = "$h(p)$, zero of the zeta function to order $p$"
    ax.plot(p[shown], h_zeta[shown], "s", color=ORANGE, markersize=5, label=label)
    ax.plot(p, k_0, "o-", color=BLUE, markersize=5, label=r"$K_0(p) = \ln N(p)\,/\,p$")
    for period, value in zip(p[k_0 < low], k_0[k_0 < low], strict=True):
        ax.annotate(f"↓ {value:.4f}", (period, low), xytext=(0, 4), textcoords="offset points", ha="center")
    ax.set_ylim(low, high)
    _by_period(ax, "topological entropy (per bounce)")
    ax.set_xlim(p[0] - 0.7, p[-1] + 0.5)


def draw_lyapunov(
    ax: Axes,
    p: Integers,
    values: Mapping[str, Floats],
    name: str,
    label: str,
    reference: tuple[float, float] | None,
) -> None:
    """Draw one kind of Lyapunov average against the period, as in the paper's Fig. 6.

    Parameters
    ----------
    ax : Axes
    p : ndarray of int, shape (n,)
    values : mapping of str to ndarray, shape (n,)
        Averages by their names (`orbitdb.averages`), NaN where there is none.
    name, label : str
        Which are drawn, ``lambda_d`` or ``lambda_c``, and what the axis says.
    reference : (float, float) or None
        The value of random trajectories, with its standard error.
    """
    plain, pair, zeta, rule, error = (values[name + end] for end in ("", *_METHODS))
    ax.plot(p, plain, "x:", color=BLUE, markersize=6, linewidth=1, label="average over fixed points")
    ax.plot(p, pair, "^-", color=GREEN, markersize=5, label="mean of $p - 1$ and $p$")
    ax.plot(p, zeta, "s--", color=ORANGE, markersize=4, linewidth=1, label="zeta function to order $p$")
    if not np.isnan(values["lambda_d_sum_rule"]).all():
        ax.fill_between(p, rule - error, rule + error, color=INK, alpha=0.15, linewidth=0)
        ax.plot(p, rule, "o-", color=INK, markersize=3, linewidth=1, label="sum rules (band: error)")
    if reference is not None:
        value, error_of_value = reference
        ax.axhspan(
            value - 2 * error_of_value, value + 2 * error_of_value, color=PURPLE, alpha=0.35, linewidth=0
        )
        ax.axhline(value, color=INK, linewidth=1, label=r"random trajectories (band: $\pm 2$ errors)")
    _by_period(ax, label)


def _by_period(ax: Axes, label: str) -> None:
    ax.set(xlabel="period $p$ (bounces)", ylabel=label)
    ax.xaxis.set_major_locator(MaxNLocator(integer=True, min_n_ticks=1))


def _span(values: Floats, fallback: Floats) -> tuple[float, float]:
    """Return limits around values, a little wider than they are."""
    finite = values[np.isfinite(values)]
    if not len(finite):
        finite = fallback[np.isfinite(fallback)]
    low, high = (float(finite.min()), float(finite.max())) if len(finite) else (0.0, 1.0)
    room = 0.12 * (high - low) or 0.1
    return low - room, high + room


def draw_staircase(ax: Axes, length: Floats, count: Integers, complete: float | None = None) -> None:
    """Draw how many orbits are no longer than L.

    Parameters
    ----------
    ax : Axes
    length : ndarray, shape (n,)
        Lengths, in units of the radius.
    count : ndarray of int, shape (n,)
        How many orbits have each.
    complete : float, optional
        Up to which length these are all orbits.
    """
    order = np.argsort(length, kind="stable")
    ax.step(length[order], np.cumsum(count[order]), where="post", color=BLUE)
    if complete is not None:
        end = math.floor(complete * 100) / 100
        label = f"complete, by proof, up to $L = {end:.2f}\\,R$"
        ax.axvline(end, color=ORANGE, linewidth=1, linestyle="--", label=label)
    ax.set(yscale="log", xlabel="length $L/R$", ylabel="orbits not longer than $L$")


def draw_density(ax: Axes, p: Integers, length: Floats, count: Integers, bins: int = 120) -> QuadMesh:
    """Draw how many orbits of each period there are per unit of length, as colours.

    Parameters
    ----------
    ax : Axes
    p : ndarray of int, shape (n,)
        Periods.
    length, count
        As in `draw_staircase`.
    bins : int, optional
        How many intervals of length.

    Returns
    -------
    QuadMesh
        For a colour bar.
    """
    edges = np.linspace(length.min() - 0.5, length.max() + 0.5, bins + 1)
    periods = np.arange(p.min(), p.max() + 2) - 0.5
    orbits, _, _ = np.histogram2d(p, length, [periods, edges], weights=count)
    density = np.ma.masked_equal(orbits / (edges[1] - edges[0]), 0)
    drawn = ax.pcolormesh(edges, periods, density, norm=LogNorm(), cmap="viridis")
    ax.set(xlabel="length $L/R$", ylabel="period $p$ (bounces)")
    ax.yaxis.set_major_locator(MaxNLocator(integer=True, min_n_ticks=1))
    return drawn


def draw_spectrum(ax: Axes, found: "Spectrum", label: Callable[[str], str]) -> None:
    """Draw |F| of levels upwards, that of orbits downwards, and the labels that peaks' codes get."""
    side = -1 if found.quantum is None else 1
    if found.quantum is not None:
        ax.plot(found.length, np.abs(found.quantum), color=BLUE, label="levels")
    ax.plot(found.length, -np.abs(found.orbits), color=ORANGE, label="orbits, downwards")
    first, last = found.length[[0, -1]]
    if found.complete < last:
        beyond = max(found.complete, first)
        ax.axvspan(beyond, last, color=GREY, alpha=0.12, label="orbits may be missing")
    for peak in found.peaks(1):
        ax.annotate(label(peak.code), (peak.length, side * peak.height), xytext=(0, 4 * side),
                    textcoords="offset points", fontsize=7, rotation=90, ha="center",
                    va="bottom" if side > 0 else "top")  # fmt: skip
    ax.axhline(0, color=INK, linewidth=0.6)
    ax.margins(x=0, y=0.25)
    ax.set(xlabel="length $x/R$", ylabel=r"$|F(x)|$")


def draw_level_count(
    above: Axes, below: Axes, k: Floats, at: Floats, smooth: Floats, family: Floats, orbits: Floats, p: int
) -> None:
    """Draw the number of levels, and how far it is from its smooth part.

    Parameters
    ----------
    above, below : Axes
    k : ndarray, shape (N,)
        The levels.
    at, smooth, family, orbits : ndarray, shape (n,)
        Wavenumbers, the smooth part there, and what bouncing balls and orbits make of the rest.
    p : int
        The highest period of the orbits.
    """
    above.step(np.append(0.0, k), np.arange(len(k) + 1), where="post", color=BLUE, label="levels")
    above.plot(at, smooth, color=ORANGE, linestyle="--", linewidth=1, label="Weyl's law")
    above.set(ylabel="levels below $k$")
    rest = np.searchsorted(k, at) - smooth
    below.plot(at, rest, color=BLUE, linewidth=0.8, label="levels, less Weyl's law")
    below.plot(at, family, color=GREEN, linestyle=":", label="bouncing balls")
    label = f"bouncing balls and orbits to $p = {p}$, a partial sum"
    below.plot(at, family + orbits, color=ORANGE, linewidth=0.8, label=label)
    below.set(xlabel="$kR$", ylabel="fluctuation")


def draw_work_precision(ax: Axes, rows: "Sequence[WorkPrecision]") -> None:
    """Draw the run time per word against the largest error of a coordinate.

    Parameters
    ----------
    ax : Axes
    rows : sequence of WorkPrecision
        All methods and settings of one run.
    """
    for method, (line, colour, label) in _OF_METHODS.items():
        mine = [row for row in rows if row.method == method]
        errors = [row.coordinates_max for row in mine]
        times = [row.seconds_per_sequence for row in mine]
        ax.loglog(errors, times, line, color=colour, markersize=5, label=label)
    ax.axvline(_DOUBLE, color=INK, linewidth=0.8, linestyle="--")
    ax.annotate("double", (_DOUBLE, 0), xycoords=("data", "axes fraction"), xytext=(-3, 4), ha="right",
                textcoords="offset points", color=INK, fontsize=8)  # fmt: skip
    ax.set_xlabel("largest error of a coordinate (units of $R$, rad)")
    ax.set_ylabel("run time per word (s)")
