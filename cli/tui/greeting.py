"""What the screen shows in place of an empty catalogue: an orbit, and the keys to begin with."""

from textual.app import ComposeResult
from textual.containers import Vertical
from textual.widgets import Static

from orbitdb.billiard import USUAL_A
from orbitdb.cli.tui.panels.drawing import OrbitDrawing
from orbitdb.orbits.solve import solve_word

EXAMPLE = "1232131"
"""The orbit of the paper's Fig. 1."""

_TEXT = """\
The periodic orbits of the stadium billiard. Above: [b]{orbit.code}[/b], {orbit.p} bounces, \
L = {orbit.length:.4f}, λ = {orbit.lyapunov:.3f}.

[b $key]f[/]  fill the catalogue: the 89,789 words up to period 11 take a second
[b $key]c[/]  type a code, such as 1232131, and see its orbit
[b $key]?[/]  all keys      [b $key]q[/]  quit"""


class Greeting(Vertical):
    """The orbit `EXAMPLE`, a sentence, and keys."""

    def __init__(self) -> None:
        super().__init__(id="greeting")

    def compose(self) -> ComposeResult:
        orbit = solve_word(EXAMPLE, USUAL_A)
        drawing = OrbitDrawing(USUAL_A, id="example")
        drawing.orbit = orbit
        yield drawing
        yield Static(_TEXT.format(orbit=orbit))
