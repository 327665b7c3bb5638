"""The whole of an orbit on a screen of its own: facts, symmetry class, and every bounce."""

from collections.abc import Callable
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
    """Return all that is known of an orbit, part by part."""
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
    """Return the words of the class, each with what carries the orbit into it."""
    found: dict[str, list[str]] = {}
    for element, image in zip(ELEMENTS, images_of(orbit.code), strict=True):
        how = ", ".join(name for bit, name in _NAMES.items() if element & bit) or "itself"
        found.setdefault(least_rotation(image), []).append(how)
    return [(code_text(word), "; ".join(how)) for word, how in found.items()]


class WholeOrbitScreen(OwnScreen[None]):
    """Everything about one orbit."""

    KEYS: ClassVar[Keys] = {
        "the whole orbit": [
            *RETURN,
            key("enter", "dismiss"),
            Binding("v", "view", "view", tooltip="stadium or phase space"),
            Binding("space", "particle", "run", tooltip="run a particle, or stop it"),
        ]
    }
    BINDINGS = bindings(KEYS)

    def __init__(self, orbit: Orbit) -> None:
        super().__init__()
        self._orbit = orbit

    def compose(self) -> ComposeResult:
        """Lay out the drawing and the lines."""
        yield Header()
        with Vertical(id="whole"):
            yield OrbitDrawing(self._orbit.a, id="drawing")
            yield FactsPanel(id="facts")
        yield Footer(show_command_palette=False, compact=True)

    def on_mount(self) -> None:
        """Show what is known, and find the rest meanwhile."""
        self.sub_title = f"{code_text(self._orbit.code)} at a = {self._orbit.a:.9g}"
        self.query_one(OrbitDrawing).orbit = self._orbit
        self._show((self._orbit, ()))
        self.query_one(FactsPanel).focus()
        self.in_thread("lives", self._complete, self._show)

    def _show(self, known: tuple[Orbit, Partners]) -> None:
        orbit, partners = known
        certificate = self.browser.certificate(orbit)
        panel = self.query_one(FactsPanel)
        panel.border_title = "the whole orbit"
        panel.show(*whole(orbit, certificate, partners))

    def _complete(self, cancelled: Callable[[], bool]) -> tuple[Orbit, Partners]:
        """Return the orbit with its lives, and with whom it is born."""
        orbit = with_existence(self._orbit)
        return orbit, born_with(self.browser.path if self.browser.catalogue is not None else None, orbit)

    def action_view(self) -> None:
        """Change between the stadium and phase space."""
        self.query_one(OrbitDrawing).toggle_phase()

    def action_particle(self) -> None:
        """Send a particle along the orbit, or stop it."""
        self.query_one(OrbitDrawing).toggle_particle()
