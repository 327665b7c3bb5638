"""The whole of an orbit on a screen of its own: facts, symmetry class, and every bounce."""

from typing import ClassVar

from rich.console import RenderableType
from rich.text import Text
from textual.app import ComposeResult
from textual.binding import Binding
from textual.containers import Vertical
from textual.widgets import Footer, Header

from orbitdb.cli.render import code_text
from orbitdb.cli.tui.orbit.drawing import OrbitDrawing
from orbitdb.cli.tui.orbit.facts import Bounces, Certificate, FactsPanel, Partners, facts_of, table_of
from orbitdb.cli.tui.screens import RETURN, Keys, OwnScreen, bindings, key
from orbitdb.orbits.orbit import Orbit
from orbitdb.store.reading.lookup import born_with, with_existence
from orbitdb.symbols.symmetry import ELEMENTS, MIRROR_X, MIRROR_Y, REVERSE, images_of
from orbitdb.symbols.words import least_rotation

_NAMES = {MIRROR_X: "mirrored left-right", MIRROR_Y: "mirrored up-down", REVERSE: "reversed in time"}


def whole(orbit: Orbit, certificate: Certificate, partners: Partners) -> list[RenderableType]:
    """Return all facts about an orbit in parts."""
    facts = facts_of(orbit, certificate, partners)
    if facts[0][1] != orbit.code:
        facts.insert(1, ("symbols", orbit.code))
    if orbit.solver is not None:
        facts.append(("solver", orbit.solver))
    parts: list[RenderableType] = [table_of(facts)]
    if orbit.class_size is not None:
        parts += ["", Text("symmetry class", "bold"), table_of(_class(orbit))]
    if orbit.coordinates is not None:
        parts += ["", Text("bounces", "bold"), Bounces(orbit)]
    return parts


def _class(orbit: Orbit) -> list[tuple[str, str]]:
    """Return the words of the class, each with the symmetry that leads to it."""
    found: dict[str, list[str]] = {}
    for element, image in zip(ELEMENTS, images_of(orbit.code), strict=True):
        how = ", ".join(name for bit, name in _NAMES.items() if element & bit) or "itself"
        found.setdefault(least_rotation(image), []).append(how)
    return [(code_text(word), "; ".join(how)) for word, how in found.items()]


def _main(keys: str, action: str, told: str, name: str = "") -> Binding:
    """Return a key with its action on the main screen; the footer shows keys with a name."""
    return Binding(keys, f"main({action!r})", name, show=bool(name), tooltip=told)


class WholeOrbitScreen(OwnScreen[None]):
    """Everything about the current orbit of the main screen."""

    KEYS: ClassVar[Keys] = {
        "the whole orbit": [
            *RETURN,
            key("enter", "dismiss"),
            Binding("v", "view", "view", tooltip="stadium or phase space"),
            Binding("space", "particle", "run", tooltip="run a particle, or stop it"),
            _main("n", "next(1)", "orbit of the next row", "next"),
            _main("p", "next(-1)", "orbit of the previous row", "previous"),
            _main("less_than_sign", "follow(False)", "follow the orbit to a smaller a"),
            _main("greater_than_sign", "follow(True)", "follow the orbit to a greater a"),
            _main("a", "choose_a(True)", "the same word at another a", "other a"),
            _main("c", "code", "any code", "code"),
            _main("T,t", f"move_in_class({REVERSE})", "time reverse"),
            _main("X,x", f"move_in_class({MIRROR_X})", "mirror left and right"),
            _main("Y", f"move_in_class({MIRROR_Y})", "mirror up and down"),
            _main("asterisk", "mark", "mark the orbit, or unmark it"),
            _main("y", "copy", "copy the code"),
            _main("e", "export(True)", "export to a file", "export"),
        ]
    }
    BINDINGS = bindings(KEYS)

    def __init__(self, main: OwnScreen[None], orbit: Orbit) -> None:
        super().__init__()
        self._main, self._orbit = main, orbit

    def compose(self) -> ComposeResult:
        """Lay out the drawing and the lines."""
        yield Header()
        with Vertical(id="whole"):
            yield OrbitDrawing(self._orbit.a, id="drawing")
            yield FactsPanel(id="facts")
        yield Footer(show_command_palette=False, compact=True)

    def on_mount(self) -> None:
        """Follow the main screen."""
        self.query_one(FactsPanel).focus()
        self.watch(self._main, "orbit", self._take)

    def _take(self, orbit: Orbit | None) -> None:
        """Show the facts at once, then the rest; the last orbit stays until the next is there."""
        if orbit is None:
            return
        self._orbit, drawing = orbit, self.query_one(OrbitDrawing)
        self.sub_title = f"{code_text(orbit.code)} at a = {orbit.a:.9g}"
        drawing.a = orbit.a
        drawing.orbit = orbit
        self._show((orbit, ()))
        self.in_thread("lives", lambda _: self._complete(orbit), self._show)

    def _show(self, known: tuple[Orbit, Partners]) -> None:
        orbit, partners = known
        certificate = self.browser.certificate(orbit)
        panel = self.query_one(FactsPanel)
        panel.border_title = "the whole orbit"
        panel.show(*whole(orbit, certificate, partners))

    def _complete(self, orbit: Orbit) -> tuple[Orbit, Partners]:
        """Return the orbit with its lives and the words born with it."""
        orbit = with_existence(orbit)
        return orbit, born_with(self.browser.path if self.browser.catalogue is not None else None, orbit)

    async def action_main(self, action: str) -> None:
        """Do something on the main screen."""
        await self.app.run_action(action, self._main)

    def action_view(self) -> None:
        """Change between the stadium and phase space."""
        self.query_one(OrbitDrawing).toggle_phase()

    def action_particle(self) -> None:
        """Send a particle along the orbit, or stop it."""
        self.query_one(OrbitDrawing).toggle_particle()
