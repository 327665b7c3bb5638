"""The facts about an orbit, as lines of text."""

import math
from collections.abc import Iterable, Sequence
from typing import ClassVar, NamedTuple

from rich.console import Console, ConsoleOptions, Group, RenderableType, RenderResult
from rich.style import Style
from rich.table import Table
from rich.text import Text
from textual import events
from textual.widgets import RichLog

from orbitdb.cli.orbit_facts import facts
from orbitdb.cli.output import code_text
from orbitdb.cli.tui.screens import SCROLLING, Scrolling
from orbitdb.orbits.bounces import bounce_rows
from orbitdb.orbits.orbit import Orbit
from orbitdb.orbits.status import Status
from orbitdb.symbols.symmetry import ELEMENTS, MIRROR_X, MIRROR_Y, REVERSE, images_of
from orbitdb.symbols.words import least_rotation, run_notation
from orbitdb.text import printable, upwards

Certificate = tuple[float, int] | None
"""Radius and precision, in bits, of a stored proof; None if there is no proof."""
Partners = Sequence[tuple[float, list[str]]]
"""The a of each birth of a word, with the representatives of the classes born there on the same path."""

_MOST_BOUNCES = 60
_BAR = 40
LONG = 16
"""Maximum number of symbols of a code in the title, so that a window of 80 columns shows the status, too."""
_SHORT = {"time_reversal": "reversal"}
_LEAST, _MOST = 0.05, 20.0
"""The values of a at the ends of the bar."""
_ALL_OF_A_BOUNCE = 66
"""Width, in characters, that the table of bounces needs to show all of its columns."""
_HEADS = ("coordinate", "x", "y", "arclength", "sine")

ELEMENT_NAMES = {
    MIRROR_X: "mirrored left-right",
    MIRROR_Y: "mirrored up-down",
    REVERSE: "reversed in time",
}


def brief(code: str, most: int) -> str:
    """Return a code of at most `most` characters: as it is, or else in run notation, cut if need be."""
    if len(code) <= most:
        return code
    runs = run_notation(code)
    shorter = runs if len(runs) < len(code) else code
    return shorter if len(shorter) <= most else f"{shorter[: most - 1]}…"


Fact = tuple[str, "str | Bar"]
"""The name of a fact, empty if it belongs to the one before, and its text."""


def facts_of(orbit: Orbit, certificate: Certificate = None, partners: Partners = ()) -> list[Fact]:
    """Return the facts about a word that its title does not give; a bar shows at which a it is an orbit."""
    left_out = {"code", "a", "p"} | ({"status"} if orbit.status is Status.ORBIT else set())
    lines: list[Fact] = []
    if run_notation(orbit.code) != orbit.code or orbit.p > LONG:
        lines.append(("runs", run_notation(orbit.code)))
    for name, text in facts(orbit, partners, "±"):
        if name.startswith(" "):  # it explains the fact before
            lines.append(("", printable(f"{name.strip()}{'' if 'born' in name else ':'} {text}")))
        elif name not in left_out:
            lines.append((_SHORT.get(name, name), printable(text.removeprefix("for "))))
        if name == "exists" and orbit.exists:
            lines.append(("", Bar(orbit.exists, orbit.a)))
    if orbit.length is not None:
        proof = f"radius {upwards(certificate[0])}, {certificate[1]} bits" if certificate else "none stored"
        lines.append(("proof", proof))
    return lines


class Bar(NamedTuple):
    """A bar, logarithmic in a from 0.05 to 20, with the current a and where a word is an orbit."""

    lives: Sequence[tuple[float, float | None]]
    a: float

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        width = max(1, min(options.max_width - 8, _BAR))
        yield Text(f"{_LEAST} {bar(self.lives, self.a, width)} {_MOST:g}")


def bar(lives: Sequence[tuple[float, float | None]], a: float, width: int) -> str:
    """Return the cells of a `Bar`."""
    scale = math.log(_MOST / _LEAST)
    places = [_LEAST * math.exp(scale * (i + 0.5) / width) for i in range(width)]
    alive = [any(born < at and (dies is None or at < dies) for born, dies in lives) for at in places]
    cell_of_a = math.floor(width * math.log(a / _LEAST) / scale)
    return "".join("┃" if i == cell_of_a else "━" if alive[i] else "·" for i in range(width))


def table_of(facts: Iterable[Fact], muted: Style | str) -> Table:
    """Return facts as a table whose lines wrap at the available width."""
    table = Table.grid(padding=(0, 1, 0, 0), pad_edge=False)
    for name, fact in facts:
        table.add_row(Text(name, muted), Text(fact, overflow="fold") if isinstance(fact, str) else fact)
    return table


class BounceTable(NamedTuple):
    """The bounces of an orbit, one per line: coordinate, arclength, sine and, if there is room, x and y."""

    orbit: Orbit

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        rows = bounce_rows(self.orbit.a, [self.orbit.code], [self.orbit.coordinates])[0]
        shown = range(len(_HEADS)) if options.max_width >= _ALL_OF_A_BOUNCE else (0, 3, 4)
        yield Text(f"{'n':>4} {'symbol':>6}" + "".join(f"{_HEADS[place]:>11}" for place in shown), "bold")
        lines = (
            f"{n:>4} {symbol:>6}" + "".join(f"{values[place]:>z11.6f}" for place in shown)
            for n, symbol, *values in rows
        )
        yield Text("\n".join(lines))


def parts_of(
    orbit: Orbit,
    certificate: Certificate,
    partners: Partners = (),
    whole: bool = False,
    muted: Style | str = "",
) -> list[RenderableType]:
    """Return the facts about an orbit, followed by its bounces if there are at most `_MOST_BOUNCES`.

    If `whole`, return everything known about it: with the words of its class and all of its bounces. The
    names of the facts are `muted`.
    """
    facts = facts_of(orbit, certificate, partners)
    if not whole:
        few = orbit.coordinates is not None and orbit.p <= _MOST_BOUNCES
        return [table_of(facts, muted), "", BounceTable(orbit)] if few else [table_of(facts, muted)]
    if orbit.p > LONG:
        facts.insert(1, ("symbols", orbit.code))
    if orbit.solver is not None:
        facts.append(("solver", orbit.solver))
    parts: list[RenderableType] = [table_of(facts, muted)]
    if orbit.class_size is not None:
        parts += ["", Text("symmetry class", "bold"), table_of(_class(orbit), muted)]
    if orbit.coordinates is not None:
        parts += ["", Text("bounces", "bold"), BounceTable(orbit)]
    return parts


def _class(orbit: Orbit) -> list[Fact]:
    """Return the words of the class of an orbit, each with the symmetries that map the orbit to that word."""
    elements: dict[str, list[str]] = {}
    for element, image in zip(ELEMENTS, images_of(orbit.code), strict=True):
        how = ", ".join(name for bit, name in ELEMENT_NAMES.items() if element & bit) or "itself"
        elements.setdefault(least_rotation(image), []).append(how)
    return [(code_text(word), "; ".join(how)) for word, how in elements.items()]


class FactsPanel(RichLog, Scrolling):
    """Facts about the current orbit, rendered only if they or the width change, because it takes long."""

    COMPONENT_CLASSES: ClassVar[set[str]] = {"facts--name"}
    BINDINGS = SCROLLING

    def __init__(self, id: str | None = None) -> None:
        super().__init__(min_width=0, wrap=True, auto_scroll=False, id=id)
        self._parts: Sequence[RenderableType] = ()

    def show(self, *parts: RenderableType) -> None:
        self._parts = parts
        self.scroll_to(y=0, animate=False, immediate=True)
        self.clear().write(Group(*parts))

    def on_resize(self, event: events.Resize) -> None:
        self.clear().write(Group(*self._parts))
