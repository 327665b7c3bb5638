"""Figures of one orbit."""

from matplotlib.figure import Figure

from orbitdb.billiard.stadium import Stadium
from orbitdb.cli.render import code_text
from orbitdb.orbits.orbit import Orbit
from orbitdb.plots import paths
from orbitdb.plots.style import BLUE, ORANGE, explain, figure
from orbitdb.symbols.symmetry import REVERSE, images_of
from orbitdb.symbols.words import run_notation


def draw_orbit(found: Orbit) -> Figure:
    """Draw the path of an orbit that has coordinates in its stadium."""
    with figure(6.4, _height(found.a, 6.4)) as made:
        ax = made.add_subplot()
        assert found.points is not None
        paths.draw_orbit(ax, Stadium(found.a), found.points)
        ax.set_title(_caption(found))
        made.set_label(f"orbit {code_text(found.code)} at a = {found.a:g}")
        explain(made, ax)
    return made


def draw_reverse(found: Orbit) -> Figure:
    """Draw an orbit above its time reverse, whose bounces are those of the orbit backwards."""
    reverse = images_of(found.code)[REVERSE]
    same = found.time_reversal == "self"
    kind = "the same orbit: it retraces its path" if same else "another orbit, counted, too"
    with figure(6.4, 2 * _height(found.a, 6.4)) as made:
        above, below = made.subplots(2, 1)
        assert found.points is not None
        paths.draw_orbit(above, Stadium(found.a), found.points)
        above.set_title(f"(a) {_caption(found)}")
        made.set_label(f"orbit {code_text(found.code)} at a = {found.a:g}")
        paths.draw_orbit(below, Stadium(found.a), found.points[::-1], BLUE if same else ORANGE)
        below.set_title(f"(b) its time reverse {short(reverse)}: {kind}")
        explain(made, above)
    return made


def _height(a: float, width: float) -> float:
    """Return the height in inches of a stadium drawn this wide, with its title, axis and legend."""
    return max(2.2, (width - 0.8) * 2.7 / (2 * a + 2.7) + 1.1)


def _caption(found: Orbit) -> str:
    numbers = f"$a = {found.a:g}$,  $L = {found.length:.4f}\\,R$,  $\\lambda = {found.lyapunov:.4f}$"
    return f"{short(found.code)},  {numbers}"


def short(code: str) -> str:
    """Return a code for a title: as it is, or in run notation, cut if it is still long."""
    if len(code) <= 30:
        return code
    text = run_notation(code)
    return text if len(text) <= 40 else f"{text[:37]}..."
