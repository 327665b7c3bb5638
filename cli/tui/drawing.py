"""Widgets that show pictures: an orbit in its stadium or in phase space, and curves."""

from collections.abc import Sequence
from typing import ClassVar

from rich.style import Style
from rich.text import Text
from textual.reactive import reactive
from textual.timer import Timer
from textual.widget import Widget

from orbitdb.arrays import Floats
from orbitdb.cli.tui.braille import (
    COLOURS,
    Curve,
    Picture,
    draw_curves,
    draw_orbit,
    draw_phase,
    path_of,
    phase_points,
)
from orbitdb.orbits.orbit import Orbit
from orbitdb.text import exact

_FRAMES_PER_SECOND = 20
_LEAST = 4, 3
_SPEED = 2.5
"""Speed of the particle, in units of the radius per second."""


class PictureWidget(Widget):
    """A widget whose content is a `Picture`; its styles are component classes ``picture--NAME``."""

    COMPONENT_CLASSES: ClassVar[set[str]] = {
        f"picture--{name}"
        for name in ("wall", "path", "bounce", "start", "arrow", "trail", "particle", "label", *COLOURS)
    }

    def picture(self, columns: int, rows: int) -> Picture:
        raise NotImplementedError

    def render(self) -> Text:
        """Return the picture as text, or an empty text if there is no room for it."""
        columns, rows = self.size
        if columns < _LEAST[0] or rows < _LEAST[1]:
            return Text()
        picture, styles = self.picture(columns, rows), {"": Style.null()}
        for name in set(picture.styles.ravel()) - {""}:
            styles[name] = self.get_component_rich_style(f"picture--{name}", partial=True)
        lines = (Text.assemble(*((run, styles[name]) for run, name in picture.runs(y))) for y in range(rows))
        return Text("\n").join(lines)


class OrbitDrawing(PictureWidget):
    """An orbit in its stadium, with or without a particle, or in phase space."""

    orbit: reactive[Orbit | None] = reactive(None, always_update=True)
    phase: reactive[bool] = reactive(False)
    particle: reactive[float | None] = reactive(None)

    def __init__(self, a: float, id: str | None = None) -> None:
        super().__init__(id=id)
        self.a = a
        self._path: Floats = path_of(None)
        self._timer: Timer | None = None

    def watch_orbit(self, orbit: Orbit | None) -> None:
        """Use the path of the new orbit; a moving particle starts again at its first bounce."""
        self._path = path_of(orbit)
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
        if self.particle is not None and self.orbit is not None and self.orbit.length:
            self.particle = (self.particle + _SPEED / _FRAMES_PER_SECOND / self.orbit.length) % 1.0

    def picture(self, columns: int, rows: int) -> Picture:
        if self.phase:
            self._entitle("phase space: sine against arclength")
            return draw_phase(self.a, phase_points(self.orbit), columns, rows)
        picture, true = draw_orbit(self.a, self._path, columns, rows, self.particle)
        self._entitle(f"stadium, a = {exact(self.a)}" + ("" if true else " (not to scale)"))
        return picture

    def _entitle(self, title: str) -> None:
        if title != self.border_title:  # setting the title redraws everything
            self.border_title = title


class Plot(PictureWidget):
    """Curves against the period."""

    curves: reactive[Sequence[Curve]] = reactive((), always_update=True)

    def picture(self, columns: int, rows: int) -> Picture:
        return draw_curves(self.curves, columns, rows)
