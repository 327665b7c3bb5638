"""Figures over a: how many words are orbits, the topological entropy, and a number of one orbit."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import NullFormatter
from numpy.typing import NDArray

from orbitdb.equality import ByValue
from orbitdb.plots.style import BLUE, GREEN, GREY, INK, ORANGE, PURPLE

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

_STYLES = ((BLUE, "-"), (ORANGE, "--"), (GREEN, "-."), (PURPLE, ":"), (INK, "-"), (GREY, "--"))
_BINS = 60


@dataclass(frozen=True, eq=False)
class Steps(ByValue):
    """How many words of one period are orbits, a step at every birth and death.

    Attributes
    ----------
    a : ndarray, shape (n,)
        Where the number changes, rising; the first is 0.
    orbits : ndarray of int, shape (n,)
        Words that are orbits from there to the next.
    words : int
        All admissible words of the period.
    """

    a: Floats
    orbits: Integers
    words: int

    @classmethod
    def of(cls, births: Floats, deaths: Floats, born: Integers, died: Integers) -> "Steps":
        """Return the steps of births and deaths, shape (n,) and (m,), with so many words each."""
        a, change = np.concatenate([[0.0], births, deaths]), np.concatenate([[0], born, -died])
        order = np.argsort(a, kind="stable")
        orbits = np.cumsum(change[order])
        return cls(a[order], orbits, int(born.sum() - died.sum()))

    def at(self, a: Floats) -> Integers:
        """Return how many words are orbits at each a, shape (k,)."""
        found: Integers = self.orbits[np.searchsorted(self.a, a, side="right") - 1]
        return found


def draw_shares(ax: Axes, periods: Mapping[int, Steps], a: Floats) -> None:
    """Draw which share of the words of each period are orbits, at each a, shape (k,)."""
    for (p, steps), (colour, style) in zip(periods.items(), _STYLES, strict=False):
        ax.plot(a, steps.at(a) / steps.words, style, color=colour, label=f"$p = {p}$")
    _over_a(ax, r"$N_c(p; a)\,/\,N_t(p)$", a)
    ax.set_ylim(0, 1.03)
    ax.legend(loc="lower right")


def draw_entropies(ax: Axes, entropies: Mapping[int, Floats], a: Floats, limit: float) -> None:
    """Draw the entropy from zeta functions cut off at some periods, shape (k,) each, and its upper bound.

    NaN where a zeta function has no zero that can be used.
    """
    for (p, values), (colour, style) in zip(entropies.items(), _STYLES, strict=False):
        ax.plot(a, values, style, color=colour, label=f"$h({p}; a)$")
    ax.axhline(limit, color=GREY, linewidth=0.8, label="bound at every $a$")
    _over_a(ax, "topological entropy", a)
    ax.legend(loc="lower right")


def draw_entropy_over_a(
    ax: Axes,
    a: Floats,
    lower: Floats,
    upper: Floats,
    curves: Mapping[int, tuple[Floats, Floats]],
    limit: float,
) -> None:
    """Draw the bounds on the entropy over a as a band, with a bar where it is proved.

    Parameters
    ----------
    ax : Axes
    a, lower, upper : ndarray, shape (n,)
        Where the entropy is enclosed, rising, and between what; per bounce.
    curves : mapping of int to (ndarray, ndarray)
        By the highest period of a zeta function: values of a, and the entropy there, NaN where it has no
        zero that can be used.
    limit : float
        The bound that holds at every a.
    """
    ax.fill_between(a, lower, upper, color=PURPLE, alpha=0.35, linewidth=0)
    middle, half = (lower + upper) / 2, (upper - lower) / 2
    ax.errorbar(a, middle, half, fmt="none", color=PURPLE, capsize=2, linewidth=1.2, label="proved bounds")
    for (p, (places, values)), (colour, style) in zip(curves.items(), _STYLES, strict=False):
        ax.plot(places, values, style, color=colour, linewidth=1, label=f"$h({p}; a)$, from births")
    ax.axhline(limit, color=GREY, linewidth=0.8, label="bound at every $a$")
    ax.set(xscale="log", xlabel="$a$", ylabel="topological entropy (per bounce)")
    ax.set_ylim(min(float(lower.min()), limit - 0.1) - 0.02, limit + 0.02)


def draw_changes(ax: Axes, changes: Mapping[int, Floats], a: Floats) -> None:
    """Draw how the births and deaths of each period, shape (n,) each, are spread over ln a."""
    edges = np.geomspace(a[0], a[-1], _BINS + 1)
    for (p, places), (colour, style) in zip(changes.items(), _STYLES, strict=False):
        share = np.histogram(places, edges)[0] / max(len(places), 1)
        ax.stairs(share, edges, color=colour, linestyle=style, label=f"$p = {p}$")
    _over_a(ax, "share of births and deaths", a)
    ax.legend(loc="upper left")


def draw_followed(
    ax: Axes, a: Floats, values: Floats, label: str, ends: Sequence[float], colour: str
) -> None:
    """Draw a number of one orbit over a, shape (k,) each, NaN where it is none, and the ends of its lives."""
    ax.plot(a, values, color=colour)
    for end in ends:
        ax.axvline(end, color=GREY, linewidth=0.8, linestyle=":", label="birth or death")
    _over_a(ax, label, a)
    ax.xaxis.set_minor_formatter(NullFormatter())


def _over_a(ax: Axes, label: str, a: Floats) -> None:
    ax.set(xscale="log", ylabel=label, xlim=(a[0], a[-1]))
