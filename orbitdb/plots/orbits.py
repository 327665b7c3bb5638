"""Whole figures of orbits: one orbit, an orbit and its reverse, and sheets of many."""

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from matplotlib.axes import Axes

from orbitdb.billiard.stadium import Stadium
from orbitdb.open_stadium.openings import Opening, parse_openings
from orbitdb.orbits.orbit import Orbit
from orbitdb.orbits.status import EXISTING
from orbitdb.plots import paths
from orbitdb.plots.registry import EmptyFigureError, gaps, nothing
from orbitdb.plots.style import BLUE, ORANGE, Picture, figure, inches_wide, short, width_or, wrapped
from orbitdb.selection import Selection
from orbitdb.text import format_float, several

if TYPE_CHECKING:
    from orbitdb.catalogue import Catalogue

_WIDTH, _LEAST_HEIGHT = 6.4, 2.0
"""Usual width and least height of a figure of one orbit, in inches."""
_SHORT = 3.5
"""Symbols per inch of the width that leave room for the numbers after a code."""

_TITLE = 0.25
"""Height of a line of the title of a sheet, in inches."""
_MOST = 500
"""A sheet shows at most this many orbits; more would be too small to tell apart."""


def orbit(orbit: Orbit, opening: Any = ()) -> Picture:
    """Draw the path of an orbit, which must have coordinates, in its stadium, with openings as gaps."""
    openings = parse_openings(opening)
    wide = width_or(_WIDTH)
    with figure(wide, _height(orbit.a, wide)) as made:
        _draw_path(made, made.add_subplot(), orbit, "", openings)
    return made


def reverse(orbit: Orbit) -> Picture:
    """Draw an orbit above its time reverse, which has the same bounces in reverse order."""
    back, same = orbit.reverse(), orbit.time_reversal == "self"
    kind = "the same orbit: it retraces its path" if same else "another orbit, counted separately"
    wide = width_or(_WIDTH)
    with figure(wide, 2 * _height(orbit.a, wide)) as made:
        above, below = made.subplots(2, 1)
        _draw_path(made, above, orbit, "(a) ")
        assert back.points is not None
        paths.draw_orbit(below, Stadium(orbit.a), back.points, back.code, BLUE if same else ORANGE)
        title = f"(b) Its time reverse {short(back.code)}: {kind}"
        below.set_title(wrapped(title, inches_wide(below)))
    return made


def _draw_path(made: Picture, ax: Axes, orbit: Orbit, which: str, opening: Sequence[Opening] = ()) -> None:
    """Draw an orbit with its a, length and lambda above it, and label the figure."""
    assert orbit.points is not None
    paths.draw_orbit(ax, Stadium(orbit.a), orbit.points, orbit.code, opening=opening)
    numbers = (
        f"$a = {format_float(orbit.a)}$,  $L = {orbit.length:.4f}\\,R$,  $\\lambda = {orbit.lyapunov:.4f}$"
    )
    parted = ",  " if len(which + orbit.code) < _SHORT * made.get_figwidth() else "\n"  # in a narrow figure
    ax.set_title(f"{which}{short(orbit.code)}{parted}{numbers}")
    made.set_label(f"orbit {short(orbit.code)} at a = {format_float(orbit.a)}")


def _height(a: float, wide: float) -> float:
    """Return the height, in inches, of a stadium as wide as the figure, with its title and axis."""
    return max(_LEAST_HEIGHT, (wide - 0.8) * 2.7 / (2 * a + 2.7) + 0.8)


def sheet(catalogue: "Catalogue", chosen: Selection, limit: int = 120, order: str = "p") -> Picture:
    """Draw one orbit of each class of a subset, or only of the first `limit` classes in the given order."""
    chosen = with_paths(catalogue, chosen)
    listing = catalogue.rows(chosen, columns=("representative",), order=order, limit=limit, classes=True)
    found = (catalogue.find(word, a=chosen.a) for (word,) in listing)
    orbits = [orbit for orbit in found if orbit is not None and orbit.points is not None]
    if not orbits:
        raise nothing(catalogue, chosen)
    made = sheet_of(orbits, f"Classes of {chosen.describe()}")
    made.notes = tuple(gaps(catalogue, chosen, order))
    if (total := listing.total) > limit:
        rest = f"`limit={total}` draws them all" if total <= _MOST else "choose fewer to see them all"
        made.notes += (f"{limit} of {total} classes are drawn; {rest}",)
    return made


def sheet_of(orbits: Sequence[Orbit], title: str | None = None) -> Picture:
    """Draw each orbit in a stadium of its own; all have coordinates at the same a."""
    a = orbits[0].a
    named = f"{several(len(orbits), 'orbit')} at a = {format_float(a)}" if title is None else title
    with figure(*paths.size_of(len(orbits), a), named) as made:
        above = _TITLE * (1 + made.get_suptitle().count("\n")) / made.get_figheight()
        made.set_layout_engine("none")  # the drawings need all the room, and its size
        paths.draw_sheet(made.add_axes((0, 0, 1, 1 - above)), orbits)
    return made


def with_paths(catalogue: "Catalogue", chosen: Selection) -> Selection:
    """Return the part of a subset that has paths; raise `EmptyFigureError` if the subset has none."""
    statuses = tuple(status for status in chosen.statuses if status in EXISTING)
    if statuses or not chosen.statuses:
        return replace(chosen, statuses=statuses)
    if total := catalogue.count(chosen):
        what = chosen.describe(count=total)
        raise EmptyFigureError(
            [*gaps(catalogue, chosen), f"{what}: no path to draw; `status='orbit'` draws orbits instead"]
        )
    raise nothing(catalogue, chosen)
