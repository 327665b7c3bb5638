"""What is known of an orbit, in words."""

import math
from collections.abc import Callable, Sequence
from functools import partial
from textwrap import wrap
from typing import ClassVar

from rich.segment import Segment
from textual.geometry import Size
from textual.scroll_view import ScrollView
from textual.strip import Strip

from orbitdb.billiard.stadium import Stadium
from orbitdb.cli.orbit_facts import facts
from orbitdb.cli.tui.screens import SCROLLING, Keys, bindings
from orbitdb.numerals import upwards
from orbitdb.orbits.bounce_rows import bounce_rows
from orbitdb.orbits.orbit import Orbit
from orbitdb.plaintext import printable
from orbitdb.symbols.words import run_notation

_MOST_BOUNCES = 60
_BAR = 24
_LEAST, _MOST = 0.05, 20.0
"""The ends of the bar."""
_ALL_OF_A_BOUNCE = 66
"""Columns."""
_SHORT = {"time reversal": "reversal"}

Certificate = tuple[float, int] | None
"""Radius and bits of a proof."""
Partners = Sequence[tuple[float, list[str]]]
"""Births, each with the least words of the classes that are one path with an orbit there."""
Line = list[tuple[str, str]]
"""A line as (text, style name), in pieces."""


def facts_of(orbit: Orbit, certificate: Certificate = None, partners: Partners = ()) -> list[tuple[str, str]]:
    """Return what is known of a word, name by name, with a bar over ln a that shows where it exists."""
    known = [(_SHORT.get(name, name), told) for name, told in facts(orbit, partners, "±") if name != "a"]
    if run_notation(orbit.code) != known[0][1]:
        known.insert(1, ("runs", run_notation(orbit.code)))
    if orbit.exists:
        place = [name for name, _ in known].index("exists")
        lives = bar(orbit.exists, orbit.a, _BAR)
        known[place : place + 1] = [("exists", f"0.05 {lives} 20"), ("", known[place][1])]
    if orbit.length is not None:
        proof = f"radius {upwards(certificate[0])}, {certificate[1]} bits" if certificate else "none stored"
        known.append(("certificate", proof))
    return [(name, printable(sentence)) for name, sentence in known]


def bar(lives: Sequence[tuple[float, float | None]], a: float, width: int) -> str:
    """Return a bar over ln a, from 0.05 to 20, that shows where an orbit exists, and a."""
    scale = math.log(_MOST / _LEAST)
    places = [_LEAST * math.exp(scale * (i + 0.5) / width) for i in range(width)]
    alive = [any(born < at and (dies is None or at < dies) for born, dies in lives) for at in places]
    here = math.floor(width * math.log(a / _LEAST) / scale)
    return "".join("┃" if i == here else "━" if alive[i] else "·" for i in range(width))


def folded(facts: Sequence[tuple[str, str]], width: int) -> list[Line]:
    """Return facts, (name, sentence) by (name, sentence), as aligned lines of at most some width."""
    margin = max((len(name) for name, _ in facts), default=0) + 2
    lines: list[Line] = []
    for name, sentence in facts:
        first, *others = wrap(sentence, max(width - margin, 8)) or [""]
        lines.append([(name.ljust(margin), "name"), (first, "")])
        lines += [[(" " * margin + more, "")] for more in others]
    return lines


def bounces_of(orbit: Orbit, width: int) -> list[Line]:
    """Return a line a bounce, as wide as there is room: where it is, and how the path leaves it."""
    rows = bounce_rows(Stadium(orbit.a), [orbit.code], [orbit.coordinates])[0]
    heads = ("coordinate", "x", "y", "along wall", "sine")
    shown = range(len(heads)) if width >= _ALL_OF_A_BOUNCE else (0, 3, 4)
    head = f"{'n':>4} {'symbol':>6}" + "".join(f"{heads[place]:>11}" for place in shown)
    lines: list[Line] = [[(head, "name")]] if rows else []
    for n, symbol, *values in rows:
        lines.append([(f"{n:>4} {symbol:>6}" + "".join(f"{values[place]:>11.6f}" for place in shown), "")])
    return lines


def lines_of(orbit: Orbit, certificate: Certificate, width: int) -> list[Line]:
    """Return the facts as aligned lines of at most some width, and below them the bounces if they are few."""
    bounces = bounces_of(orbit, width) if orbit.p <= _MOST_BOUNCES else []
    return [*folded(facts_of(orbit, certificate), width), [], *bounces]


class FactsPanel(ScrollView, can_focus=True):
    """What is known of the orbit that is shown; its lines are folded to its width."""

    COMPONENT_CLASSES: ClassVar[set[str]] = {"facts--name"}
    KEYS: ClassVar[Keys] = SCROLLING
    BINDINGS = bindings(SCROLLING)

    def __init__(self, id: str | None = None) -> None:
        super().__init__(id=id)
        self._shown: Callable[[int], list[Line]] = lambda _: []
        self._lines: list[Line] = []

    def show(self, orbit: Orbit | None, certificate: Certificate = None) -> None:
        """Show what is known of an orbit."""
        self.show_lines(partial(lines_of, orbit, certificate) if orbit is not None else lambda _: [])

    def show_lines(self, lines: Callable[[int], list[Line]]) -> None:
        """Show some lines, which are asked for with the width there is."""
        self._shown = lines
        self.on_resize()
        self.scroll_to(y=0, animate=False, immediate=True)

    def on_resize(self) -> None:
        """Fold the lines to the width there is."""
        width = self.scrollable_content_region.width
        self._lines = self._shown(width)
        height = max(len(self._lines), self.size.height)  # a change of it lays the whole screen out
        self.virtual_size = Size(width, height)
        self.refresh()

    def render_line(self, y: int) -> Strip:
        """Draw one line."""
        width, base = self.scrollable_content_region.width, self.rich_style
        place = self.scroll_offset.y + y
        if place >= len(self._lines):
            return Strip.blank(width, base)
        name = base + self.get_component_rich_style("facts--name", partial=True)
        pieces = [Segment(text, name if style else base) for text, style in self._lines[place]]
        return Strip(pieces).adjust_cell_length(width, base)
