"""Figures of numbers: entropy and Lyapunov averages by period, phase space, the length spectrum."""

import math
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.colors import LogNorm
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from orbitdb.billiard.stability import birkhoff
from orbitdb.billiard.stadium import Stadium
from orbitdb.plots.style import BLUE, GREEN, GREY, INK, ORANGE, PURPLE

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

Period = tuple[NDArray[np.uint8], Floats, Floats]
"""The orbits of one period: symbols and coordinates, shape (N, p), and lambda per bounce, shape (N,)."""

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


def bounces(stadium: Stadium, periods: Iterable[Period]) -> tuple[Floats, Floats, Floats]:
    """Return place, sine and lambda per bounce of all bounces of orbits, shape (N,) each."""
    place, sine, colour = [np.zeros(0)], [np.zeros(0)], [np.zeros(0)]
    for symbols, coordinates, lambda_d in periods:
        along, sines = birkhoff(stadium, symbols, coordinates)
        place.append(along.ravel())
        sine.append(sines.ravel())
        colour.append(np.repeat(lambda_d, symbols.shape[1]))
    return np.concatenate(place), np.concatenate(sine), np.concatenate(colour)


def draw_phase_space(ax: Axes, stadium: Stadium, place: Floats, sine: Floats, colour: Floats) -> Any:
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
