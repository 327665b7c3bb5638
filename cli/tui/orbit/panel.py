"""The panel of the orbit: its drawing, and the facts about it."""

from collections.abc import Callable, Sequence

from rich.console import RenderableType
from textual.app import ComposeResult
from textual.containers import Vertical
from textual.reactive import reactive

from orbitdb.cli.render import code_text
from orbitdb.cli.tui.catalogue_file import CatalogueFile
from orbitdb.cli.tui.orbit.drawing import OrbitDrawing
from orbitdb.cli.tui.orbit.facts import FactsPanel, known_of
from orbitdb.cli.tui.screens import Working
from orbitdb.orbits.orbit import Orbit

_MOST_COMPARED = 6


class OrbitPanel(Working, Vertical):
    """The current orbit of the main screen, and others to compare with it; `home` is the a of the rows."""

    orbit: reactive[Orbit | None] = reactive(None, always_update=True, init=False, repaint=False)
    compared: reactive[tuple[Orbit, ...]] = reactive((), always_update=True, repaint=False)

    def __init__(self, file: CatalogueFile, home: float) -> None:
        super().__init__(id="side")
        self.file, self.home = file, home
        self._solving: str | None = None

    def compose(self) -> ComposeResult:
        """Lay out the drawing and the facts."""
        yield OrbitDrawing(self.home, id="drawing").data_bind(OrbitPanel.orbit, OrbitPanel.compared)
        yield FactsPanel(id="facts")

    def watch_orbit(self, orbit: Orbit | None) -> None:
        """Show the orbit and its facts."""
        self.entitle()
        self.query_one(OrbitDrawing).a = self.home if orbit is None else orbit.a
        known: Sequence[RenderableType] = ()
        if orbit is not None:
            known = known_of(orbit, self.file.certificate(orbit))
        self.query_one(FactsPanel).show(*known)

    def clear(self, home: float) -> None:
        """Show nothing, and compare nothing, at another a."""
        self.home = home
        self.orbit, self.compared = None, ()

    def entitle(self, title: str = "") -> None:
        """Title the facts, with their a if it differs from that of the rows, or with a word being solved."""
        if self._solving is not None:
            title = f"solving {code_text(self._solving)} …"
        elif self.orbit is not None and self.orbit.a != self.home:
            title = title or f"facts at a = {self.orbit.a:.9g}"
        self.query_one(FactsPanel).border_title = title or "facts"

    def solve(self, word: str, a: float, take: Callable[[Orbit], object]) -> None:
        """Look a word up, or solve it, in a worker."""
        self._solve(word)

        def found(orbit: Orbit) -> None:
            self._solve(None)
            take(orbit)

        def failed(reason: str) -> None:
            self._solve(None)
            self.failed(reason)

        self.in_thread("find", lambda _: self.file.find(word, a), found, failed)

    def _solve(self, word: str | None) -> None:
        self._solving = word
        self.entitle()

    def need(self) -> Orbit | None:
        """Return the current orbit, or say that there is none."""
        if self.orbit is None:
            self.notify("no orbit is shown: press c and type a code", timeout=2)
        return self.orbit

    def action_compare(self) -> None:
        """Add the orbit to the comparison in phase space, or remove it."""
        if (orbit := self.need()) is None:
            return
        if orbit.coordinates is None:
            self.notify("only orbits have bounces to compare", timeout=2)
            return
        others = tuple(other for other in self.compared if other.code != orbit.code)
        if len(others) == len(self.compared):
            others = (*others, orbit)[-_MOST_COMPARED + 1 :]
        self.compared = others
        self.notify(f"{len(others)} to compare; v shows phase space", timeout=2)

    def action_compare_none(self) -> None:
        """Compare none."""
        self.compared = ()

    def action_copy(self) -> None:
        """Copy the code."""
        if (orbit := self.need()) is not None:
            self.app.copy_to_clipboard(orbit.code)
            self.notify(f"copied {orbit.code}", timeout=2)
