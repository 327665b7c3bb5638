"""Figures of one orbit: its path, its time reverse, and its life as a increases."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter
from numpy.typing import NDArray

from orbitdb.billiard.stadium import Stadium
from orbitdb.cli.render import code_text
from orbitdb.numerals import exact
from orbitdb.orbits.orbit import Orbit
from orbitdb.orbits.single_word import solve_word
from orbitdb.plots import paths
from orbitdb.plots.curves import short
from orbitdb.plots.style import BLUE, GREY, ORANGE, figure
from orbitdb.symbols.symmetry import REVERSE, images_of

PLACES = 400
_WIDTH = 6.4
_LOW, _HIGH, _BESIDE = 0.1, 5.0, 1e-9


def draw_orbit(found: Orbit) -> Figure:
    """Draw the path of an orbit, which must have coordinates, in its stadium."""
    with figure(_WIDTH, _height(found.a)) as made:
        ax = made.add_subplot()
        _draw_path(made, ax, found, "")
    return made


def draw_reverse(found: Orbit) -> Figure:
    """Draw an orbit above its time reverse, which has the same bounces in reverse order."""
    reverse, same = images_of(found.code)[REVERSE], found.time_reversal == "self"
    kind = "the same orbit: it retraces its path" if same else "another orbit, counted separately"
    with figure(_WIDTH, 2 * _height(found.a)) as made:
        above, below = made.subplots(2, 1)
        points = _draw_path(made, above, found, "(a) ")
        paths.draw_orbit(below, Stadium(found.a), points[::-1], BLUE if same else ORANGE)
        below.set_title(f"(b) its time reverse {short(reverse)}: {kind}")
    return made


def _draw_path(made: Figure, ax: Axes, found: Orbit, which: str) -> NDArray[np.float64]:
    """Draw an orbit with its a, length and lambda above it, and label the figure; return the bounces."""
    assert found.points is not None
    paths.draw_orbit(ax, Stadium(found.a), found.points)
    numbers = f"$a = {exact(found.a)}$,  $L = {found.length:.4f}\\,R$,  $\\lambda = {found.lyapunov:.4f}$"
    ax.set_title(f"{which}{short(found.code)},  {numbers}")
    made.set_label(f"orbit {code_text(found.code)} at a = {exact(found.a)}")
    return found.points


def _height(a: float) -> float:
    """Return the height, in inches, of a stadium as wide as the figure, with its title, axis and legend."""
    return max(2.2, (_WIDTH - 0.8) * 2.7 / (2 * a + 2.7) + 1.1)


def draw_life(found: Orbit) -> Figure:
    """Draw the orbit of a word at its birth, and its length and lambda against a."""
    lives = found.exists or ()
    ends = [end for life in lives for end in life if end]
    start = lives[0][0] * (1 + _BESIDE) or found.a
    first = solve_word(found.code, start)
    a = np.geomspace(
        min([_LOW, *(end / 2 for end in ends)]), max([_HIGH, *(4 * end for end in ends)]), PLACES
    )
    beside = [end * (1 + sign * _BESIDE) for end in ends for sign in (-1, 1)]
    a = np.sort(np.concatenate([a, beside]))
    orbits = [solve_word(found.code, at) for at in a.tolist()]
    numbers = np.array([
        (np.nan, np.nan) if each.status != "orbit" else (each.length or np.nan, each.lyapunov or np.nan)
        for each in orbits
    ])  # fmt: skip
    with figure(_WIDTH, 7.6) as made:
        above, middle, below = made.subplots(3, 1)
        assert first.points is not None
        paths.draw_orbit(above, Stadium(first.a), first.points)
        above.set_title(
            f"{short(found.code)} {'is born' if lives[0][0] else 'exists'} at $a = {first.a:.6g}$"
        )
        for ax, values, label, colour in zip(
            (middle, below), numbers.T, ("length $L$", r"$\lambda$"), (BLUE, ORANGE), strict=True
        ):
            ax.plot(a, values, color=colour)
            for end in ends:
                ax.axvline(end, color=GREY, linewidth=0.8, linestyle=":", label="birth or death")
            ax.set(xscale="log", ylabel=label, xlim=(a[0], a[-1]))
            ax.xaxis.set_minor_formatter(NullFormatter())
        below.set_xlabel("$a$")
        made.set_label(f"life of {code_text(found.code)}")
    return made
