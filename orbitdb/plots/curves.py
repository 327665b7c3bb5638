"""Figures of numbers: entropy and Lyapunov averages by period, phase space, the length spectrum."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from orbitdb.billiard.stadium import Stadium
from orbitdb.equality import ByValue
from orbitdb.plots.style import BLUE, FAINT, GREEN, GREY, INK, ORANGE, PURPLE

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

_MOST_NAMED = 16


def draw_entropy(
    ax: Axes,
    p: Integers,
    k_0: Floats,
    h_zeta: Floats,
    h_change: Floats,
    band: tuple[float, float] | None = None,
) -> None:
    """Draw the topological entropy against the period, as in the paper's Fig. 5, and its zeta value.

    Parameters
    ----------
    ax : Axes
    p : ndarray of int, shape (n,)
    k_0 : ndarray, shape (n,)
        ln N(p) / p, per bounce.
    h_zeta, h_change : ndarray, shape (n,)
        The value from the zeta function cut off at order p, and its change from the order before,
        drawn as its error.
    band : (float, float), optional
        Proved bounds.
    """
    low, high = _span(np.concatenate([k_0[p > 2], h_zeta[len(h_zeta) // 2 :], band or ()]), k_0)
    if band is not None:
        ax.axhspan(*band, color=PURPLE, alpha=0.5, linewidth=1, label="proved bounds")
    shown = (h_zeta > low) & (h_zeta < high)
    ax.errorbar(
        p[shown], h_zeta[shown], h_change[shown], fmt="s", color=ORANGE, markersize=5, capsize=3, linewidth=1,
        label="$h(p)$, zero of the zeta function to order $p$ (bar: last change)",
    )  # fmt: skip
    ax.plot(p, k_0, "o-", color=BLUE, markersize=5, label=r"$K_0(p) = \ln N(p)\,/\,p$")
    for period, value in zip(p[k_0 < low], k_0[k_0 < low], strict=True):
        ax.annotate(f"↓ {value:.4f}", (period, low), xytext=(0, 4), textcoords="offset points", ha="center")
    ax.set_ylim(low, high)
    _by_period(ax, "topological entropy (per bounce)")
    ax.set_xlim(p[0] - 0.7, p[-1] + 0.5)


@dataclass(frozen=True)
class Line:
    """A reference value with its standard error."""

    value: float
    error: float


@dataclass(frozen=True, eq=False)
class LyapunovRows(ByValue):
    """One kind of Lyapunov average by period; arrays of shape (n,).

    Attributes
    ----------
    plain : ndarray
        The paper's average over fixed points.
    pair : ndarray
        Mean of the values at p - 1 and p.
    zeta : ndarray
        From the zeta function cut off at order p; NaN where it has no zero.
    reference : Line or None
        Of random trajectories.
    sum_rule, sum_rule_error : ndarray or None
        By sum rules, and the estimate of its error; None where they have no meaning.
    """

    plain: Floats
    pair: Floats
    zeta: Floats
    reference: Line | None
    sum_rule: Floats | None = None
    sum_rule_error: Floats | None = None


def draw_lyapunov(ax: Axes, p: Integers, rows: LyapunovRows, symbol: str, unit: str) -> None:
    """Draw one kind of Lyapunov average against the period, as in the paper's Fig. 6.

    Parameters
    ----------
    ax : Axes
    p : ndarray of int, shape (n,)
    rows : LyapunovRows
    symbol, unit : str
        What the axis says: ``\\\\lambda_d`` and ``per bounce``.
    """
    ax.plot(p, rows.plain, "x:", color=BLUE, markersize=6, linewidth=1, label="average over fixed points")
    ax.plot(p, rows.pair, "^-", color=GREEN, markersize=5, label="mean of $p - 1$ and $p$")
    ax.plot(p, rows.zeta, "s--", color=ORANGE, markersize=4, linewidth=1, label="zeta function to order $p$")
    if rows.sum_rule is not None and rows.sum_rule_error is not None:
        low, high = rows.sum_rule - rows.sum_rule_error, rows.sum_rule + rows.sum_rule_error
        ax.fill_between(p, low, high, color=INK, alpha=0.15, linewidth=0)
        ax.plot(p, rows.sum_rule, "o-", color=INK, markersize=3, linewidth=1, label="sum rules (band: error)")
    if rows.reference is not None:
        value, error = rows.reference.value, rows.reference.error
        ax.axhspan(value - 2 * error, value + 2 * error, color=PURPLE, alpha=0.35, linewidth=0)
        ax.axhline(value, color=INK, linewidth=1, label=r"random trajectories (band: $\pm 2$ errors)")
    _by_period(ax, rf"$\langle {symbol} \rangle$ ({unit})")


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


def draw_birkhoff(ax: Axes, stadium: Stadium, place: Floats, sine: Floats, colour: Floats) -> Any:
    """Draw bounces in phase space: place along the boundary against tangential momentum.

    Parameters
    ----------
    ax : Axes
    stadium : Stadium
    place : ndarray, shape (n,)
        Arc length, as `Stadium.arclength` counts it.
    sine : ndarray, shape (n,)
        Sine of the angle between the leaving path and the inward normal, positive anticlockwise.
    colour : ndarray, shape (n,)
        A number of each bounce that its colour shows.

    Returns
    -------
    PathCollection
        For a colour bar.
    """
    size = float(np.clip(6e4 / max(len(place), 1), 0.3, 12))
    low, high = np.percentile(colour, [2, 98])
    dots = ax.scatter(
        place, sine, c=colour, s=size, cmap="viridis", vmin=low, vmax=high, linewidths=0, rasterized=True
    )
    joints = np.cumsum([0, 2 * stadium.a, np.pi, 2 * stadium.a, np.pi])
    for joint in joints[1:-1]:
        ax.axvline(joint, color=GREY, linewidth=0.8)
    for middle, name in zip(
        (joints[1:] + joints[:-1]) / 2, ("0: bottom", "3, 5: right", "2: top", "1, 4: left"), strict=True
    ):
        ax.annotate(name, (middle, 1.02), xycoords=("data", "axes fraction"), ha="center", color=GREY)
    ax.set(xlim=(0, stadium.perimeter), ylim=(-1, 1), xlabel="$s/R$", ylabel=r"$\sin\,\varphi$")
    ax.grid(False)
    return dots


def draw_staircase(ax: Axes, length: Floats, count: Integers) -> None:
    """Draw how many orbits are no longer than L.

    Parameters
    ----------
    ax : Axes
    length : ndarray, shape (n,)
        Lengths, in units of the radius.
    count : ndarray of int, shape (n,)
        How many orbits have each.
    """
    order = np.argsort(length, kind="stable")
    ax.step(length[order], np.cumsum(count[order]), where="post", color=BLUE)
    ax.set(yscale="log", xlabel="length $L/R$", ylabel="orbits not longer than $L$")


def draw_density(ax: Axes, p: Integers, length: Floats, count: Integers, bins: int = 120) -> None:
    """Draw how many orbits there are per unit of length, each period by itself and all together.

    Parameters
    ----------
    ax : Axes
    p : ndarray of int, shape (n,)
        Periods.
    length, count
        As in `draw_staircase`.
    bins : int, optional
        How many intervals of length.
    """
    edges = np.linspace(length.min() - 0.5, length.max() + 0.5, bins + 1)
    step = edges[1] - edges[0]
    total, _ = np.histogram(length, edges, weights=count / step)
    ax.stairs(total, edges, color=FAINT, fill=True, label="all")
    periods = np.unique(p)
    for period, shade in zip(periods, np.linspace(0, 0.85, len(periods)), strict=True):
        here = p == period
        density, _ = np.histogram(length[here], edges, weights=count[here] / step)
        ax.stairs(density, edges, color=colormaps["viridis"](shade), linewidth=1, label=f"{period}")
    ax.set(yscale="log", xlabel="length $L/R$", ylabel="orbits per unit of $L/R$")
    ax.set_ylim(bottom=0.5 * total[total > 0].min())
    if len(periods) <= _MOST_NAMED:
        ax.legend(title="$p$", loc="upper left", bbox_to_anchor=(1, 1), handlelength=1.2)
