"""The drawing of an orbit in its stadium, with or without a particle, or in phase space."""

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from textual.reactive import reactive
from textual.timer import Timer

from orbitdb.arrays import Floats
from orbitdb.billiard.stadium import Stadium
from orbitdb.cli.output import code_text
from orbitdb.cli.tui.panels.canvas import DOTS, Canvas, Line, PictureWidget
from orbitdb.open_stadium.openings import Opening, outline_parts
from orbitdb.orbits.orbit import Orbit
from orbitdb.orbits.solve import solve
from orbitdb.orbits.status import Status
from orbitdb.symbols.words import from_strings
from orbitdb.text import format_float

MOST_DRAWN = 5000
"""Maximum number of bounces to draw; more would only blacken the picture."""

_FRAMES_PER_SECOND = 20
_SPEED = 2.5
"""Speed of the particle, in units of the radius per second."""
_ARROWS = "→↗↑↖←↙↓↘"
_DOTS_OF_HEIGHT = 12
_TRAIL = 0.06
MOST_LABELLED = 24
"""Maximum number of bounces with their symbols beside them; more would cover one another."""
_MARGIN, _ROWS_WITH_LABELS = (2, 1), 7
_CENTRES = {"1": -1, "4": -1, "3": 1, "5": 1}
_LEAST_FOR_BOTH = 36
"""Rows above which the phase space has room below the stadium."""


def path_of(orbit: Orbit | None) -> Floats:
    """Return the closed path of an orbit, shape (p + 1, 2), whose last point repeats the first.

    A path of more than `MOST_DRAWN` bounces is cut there and left open. Without coordinates, it is empty.
    """
    if orbit is None or orbit.points is None:
        return np.zeros((0, 2))
    points = orbit.points[:MOST_DRAWN]
    return np.concatenate([points, points[:1]]) if orbit.p <= MOST_DRAWN else points


def along(path: Floats, share: float) -> Floats:
    """Return the point, shape (2,), at a fraction of the length of a path; the fraction is taken modulo 1."""
    way = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(path, axis=0).T))])
    place = (share % 1.0) * way[-1]
    return np.array([np.interp(place, way, path[:, axis]) for axis in (0, 1)])


def fixed_point(orbit: Orbit) -> Floats:
    """Return the closed path through the fixed point of a dynamically pruned word, shape (p + 1, 2).

    Its bounces lie on the lines of the walls and on the circles of the semicircles, some of them beyond the
    joints. Other words give an empty path.
    """
    if orbit.status is not Status.DYNAMICAL or orbit.p > MOST_DRAWN:
        return np.zeros((0, 2))
    word = from_strings([orbit.code])
    points = Stadium(orbit.a).points(word, solve(word, orbit.a).coordinates)[0]
    return np.concatenate([points, points[:1]])


def draw_orbit(
    a: float,
    path: Floats,
    columns: int,
    rows: int,
    particle: float | None = None,
    code: str = "",
    opening: Sequence[Opening] = (),
    other: Floats | None = None,
) -> tuple[list[Line], bool]:
    """Draw a path, shape (N, 2), in its stadium; return the picture and whether it is to scale.

    If the stadium is so long that it would look like a line, its height is stretched. An empty path gives the
    stadium alone. `particle` is the position of a particle, as a fraction of the path. The symbols of `code`
    stand at the bounces, unless there are too many; a bounce beyond a joint is a cross. Openings are gaps.
    The path of another orbit, if given, has another colour and its own arrow.
    """
    ends = np.concatenate([path, [(-a - 1, -1), (a + 1, 1)]])
    box = ends.min(axis=0), ends.max(axis=0)
    margin = _MARGIN if rows >= _ROWS_WITH_LABELS else (0, 0)
    canvas = Canvas(columns, rows, *box, margin=margin)
    true = bool(2 * canvas.scale[1] >= min(_DOTS_OF_HEIGHT, DOTS[1] * rows - 1))
    if not true:
        canvas = Canvas(columns, rows, *box, square=False, margin=margin)
    for part in outline_parts(Stadium(a), opening, 4 * (columns + rows)):
        canvas.line("wall", part)
    if other is not None and len(other):
        canvas.line("two", other)
        canvas.mark("two", other, "○")
        canvas.mark("two", [other[0] + 0.6 * (other[1] - other[0])], _arrow(other))
    if len(path):
        bounces = list(zip(path.tolist(), code[:MOST_DRAWN], strict=False))
        for (x, y), symbol in bounces if len(code) <= MOST_LABELLED else ():
            canvas.label("label", (x, y), (0.0 if symbol in "02" else x - _CENTRES[symbol] * a, y), symbol)
        canvas.line("path", path)
        canvas.mark("bounce", path, "•")
        canvas.mark("arrow", [path[0] + 0.4 * (path[1] - path[0])], _arrow(path))
        canvas.mark("start", path[:1], "◆")
        for (x, y), symbol in bounces:
            if (abs(x) > a) is (symbol in "02"):
                canvas.mark("trail", [(x, y)], "×")
    if particle is not None and len(path):
        tail = np.array([along(path, particle - _TRAIL * k / 24) for k in range(25)])
        canvas.line("trail", tail)
        canvas.mark("particle", tail[:1], "●")
    return canvas.lines(), true


def _arrow(path: Floats) -> str:
    """Return the arrow that points along the first chord of a path, in the direction of the word."""
    step = path[1] - path[0]
    return _ARROWS[round(math.atan2(step[1], step[0]) / (math.pi / 4)) % 8]


def phase_points(orbit: Orbit | None) -> Floats:
    """Return the bounces of an orbit in phase space, shape (p, 2): arclength and sine, as in `birkhoff`."""
    if orbit is None or orbit.arclength is None or orbit.sine is None:
        return np.zeros((0, 2))
    return np.stack([orbit.arclength, orbit.sine], axis=1)


def draw_phase(a: float, points: Floats, columns: int, rows: int, other: Floats | None = None) -> list[Line]:
    """Draw the `phase_points` of an orbit, and of another one, with the names of the walls below."""
    length = Stadium(a).perimeter
    canvas = Canvas(columns, max(rows - 1, 1), (0, -1), (length, 1), square=False)
    joints = [0.0, 2 * a, 2 * a + math.pi, 4 * a + math.pi, length]
    grid = [(s, sine) for s in joints for sine in np.linspace(-1, 1, 2 * rows)]
    grid += [(s, 0.0) for s in np.linspace(0, length, columns // 2)]
    canvas.put("wall", canvas.dots(grid))
    if other is not None:
        canvas.mark("two", other, "○")
    canvas.mark("one", points, "●")
    names = [" "] * columns
    for name, (low, high) in zip(("0 bottom", "3 right", "2 top", "1 left"), pairwise(joints), strict=True):
        middle = int(canvas.dots([[(low + high) / 2, 0.0]])[0, 0]) // DOTS[0]
        width = int((high - low) * canvas.scale[0] / DOTS[0])
        text = name if len(name) <= width else name[: min(1, width)]
        start = middle - len(text) // 2
        names[start : start + len(text)] = text
    return [*canvas.lines(), [("".join(names[:columns]), "label")]]


class OrbitDrawing(PictureWidget):
    """An orbit in its stadium, with or without a particle, or in phase space."""

    orbit: reactive[Orbit | None] = reactive(None, always_update=True)
    phase: reactive[bool] = reactive(False)
    particle: reactive[float | None] = reactive(None)
    opening: reactive[tuple[Opening, ...]] = reactive(())
    partner: reactive[Orbit | None] = reactive(None)

    def __init__(self, a: float, id: str | None = None) -> None:
        super().__init__(id=id)
        self.a = self.opened_at = a  # openings are those of the chosen a
        self._path: Floats = path_of(None)
        self._timer: Timer | None = None

    def watch_orbit(self, orbit: Orbit | None) -> None:
        """Use the path of the new orbit; a moving particle starts again at its first bounce."""
        self._path = path_of(orbit)
        if orbit is not None and not len(self._path):
            self._path = fixed_point(orbit)
        if self.particle is not None:
            self.particle = 0.0

    def action_view(self) -> None:
        self.phase = not self.phase

    def action_particle(self) -> None:
        self.phase = False
        if self._timer is None:
            self.particle = 0.0
            self._timer = self.set_interval(1 / _FRAMES_PER_SECOND, self.step)
        else:
            self._timer.stop()
            self._timer, self.particle = None, None

    def step(self) -> None:
        """Move the particle, unless another screen or a dialog, which would be drawn again, is above it."""
        if self.app.screen is self.screen and self.particle is not None and self.orbit and self.orbit.length:
            self.particle = (self.particle + _SPEED / _FRAMES_PER_SECOND / self.orbit.length) % 1.0

    def picture(self, columns: int, rows: int) -> list[Line]:
        points, others = phase_points(self.orbit), phase_points(self.partner)
        what = "phase space" if self.phase else f"stadium, a = {format_float(self.a)}"
        alone = ": sine against arclength" if self.phase else ""
        self._entitle(what + (alone if self.partner is None else f", with {code_text(self.partner.code)}"))
        if self.phase:
            return draw_phase(self.a, points, columns, rows, others)
        below = rows // 2 if len(points) and rows > _LEAST_FOR_BOTH else 0
        code = "" if self.orbit is None else self.orbit.code
        opening = self.opening if self.a == self.opened_at else ()
        room, other = (columns, rows - below), path_of(self.partner)
        picture, true = draw_orbit(self.a, self._path, *room, self.particle, code, opening, other)
        if not true:
            self._entitle(f"{self.border_title} (not to scale)")
        if not len(self._path) and self.orbit is not None:
            picture[rows // 2] = [("no orbit at any a".center(columns), "label")]
        return [*picture, *draw_phase(self.a, points, columns, below, others)] if below else picture

    def _entitle(self, title: str) -> None:
        if title != self.border_title:  # setting the title redraws everything
            self.border_title, self.border_subtitle = title, f"v {'stadium' if self.phase else 'phase space'}"
