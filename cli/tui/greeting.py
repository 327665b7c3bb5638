"""What the screen shows in place of an empty catalogue: an orbit, and the keys to begin with."""

from functools import cache

from textual.containers import Vertical
from textual.widgets import Static

from orbitdb.billiard import USUAL_A
from orbitdb.cli.tui.panels.canvas import Line, PictureWidget
from orbitdb.cli.tui.panels.drawing import draw_orbit, path_of
from orbitdb.orbits.orbit import Orbit
from orbitdb.orbits.solve import solve_word

EXAMPLE = "1232131"
"""The orbit of the paper's Fig. 1."""

_TEXT = """\
The periodic orbits of the stadium billiard. Above: [b]{orbit.code}[/b], {orbit.p} bounces, \
L\u00a0=\u00a0{orbit.length:.4f}, λ\u00a0=\u00a0{orbit.lyapunov:.3f}.

[b $key]f[/]  fill the catalogue: the 89,789 words up to period 11 take a second
[b $key]c[/]  type a code, such as {orbit.code}, and see its orbit
[b $key]?[/]  all keys      [b $key]q[/]  quit"""


@cache
def _example() -> Orbit:
    return solve_word(EXAMPLE, USUAL_A)


class Example(PictureWidget):
    """The orbit `EXAMPLE` in its stadium."""

    def picture(self, columns: int, rows: int) -> list[Line]:
        return draw_orbit(USUAL_A, path_of(_example()), columns, rows, code=EXAMPLE)[0]


class Greeting(Vertical):
    """An orbit, a sentence, and keys."""

    def __init__(self) -> None:
        super().__init__(Example(id="example"), Static(id="words"), id="greeting")

    def on_show(self) -> None:
        self.query_one("#words", Static).update(_TEXT.format(orbit=_example()))
