"""The whole of an orbit on a screen of its own: facts, symmetry class, and every bounce."""

from typing import ClassVar

from rich.console import RenderableType
from rich.text import Text
from textual.app import ComposeResult
from textual.containers import Vertical
from textual.widgets import Footer, Header

from orbitdb.cli.render import code_text
from orbitdb.cli.tui.catalogue_file import Certificate, Partners
from orbitdb.cli.tui.keys import WHOLE_ORBIT, Keys, bindings
from orbitdb.cli.tui.orbit.drawing import OrbitDrawing
from orbitdb.cli.tui.orbit.facts import ELEMENT_NAMES, Bounces, FactsPanel, facts_of, table_of
from orbitdb.cli.tui.orbit.panel import OrbitPanel
from orbitdb.cli.tui.screens import OwnScreen
from orbitdb.orbits.orbit import Orbit
from orbitdb.store.reading.lookup import with_existence
from orbitdb.symbols.symmetry import ELEMENTS, images_of
from orbitdb.symbols.words import least_rotation


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
        how = ", ".join(name for bit, name in ELEMENT_NAMES.items() if element & bit) or "itself"
        found.setdefault(least_rotation(image), []).append(how)
    return [(code_text(word), "; ".join(how)) for word, how in found.items()]


class WholeOrbitScreen(OwnScreen[None]):
    """Everything about the current orbit of the main screen."""

    KEYS: ClassVar[Keys] = WHOLE_ORBIT
    BINDINGS = bindings(WHOLE_ORBIT)

    def __init__(self, panel: OrbitPanel) -> None:
        super().__init__()
        self._panel = panel

    def compose(self) -> ComposeResult:
        """Lay out the drawing and the lines."""
        yield Header()
        with Vertical(id="whole"):
            yield OrbitDrawing(self._panel.home, id="drawing")
            yield FactsPanel(id="facts")
        yield Footer(show_command_palette=False, compact=True)

    def on_mount(self) -> None:
        """Follow the main screen."""
        facts = self.query_one(FactsPanel)
        facts.border_title = "the whole orbit"
        facts.focus()
        self.watch(self._panel, "orbit", self._take)

    def _take(self, orbit: Orbit | None) -> None:
        """Show the facts at once, then the rest; the last orbit stays until the next is there."""
        if orbit is None:
            return
        self.sub_title = f"{code_text(orbit.code)} at a = {orbit.a:.9g}"
        drawing = self.query_one(OrbitDrawing)
        drawing.a, drawing.orbit = orbit.a, orbit
        self._show((orbit, []))
        self.in_thread("lives", lambda _: self._complete(orbit), self._show)

    def _show(self, known: tuple[Orbit, Partners]) -> None:
        orbit, partners = known
        certificate = self._panel.file.certificate(orbit)
        self.query_one(FactsPanel).show(*whole(orbit, certificate, partners))

    def _complete(self, orbit: Orbit) -> tuple[Orbit, Partners]:
        """Return the orbit with its lives and the words born with it."""
        orbit = with_existence(orbit)
        return orbit, self._panel.file.partners(orbit)

    async def action_main(self, action: str) -> None:
        """Do something on the main screen."""
        await self.app.run_action(action, self._panel.screen)
