"""The whole of an orbit on a screen of its own: facts, life, symmetry class, and every bounce."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import ClassVar, cast

from textual import work
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Vertical
from textual.message import Message
from textual.widgets import Footer, Header

from orbitdb.cli.render import code_text, number
from orbitdb.cli.tui.browser import Browser
from orbitdb.cli.tui.orbit.drawing import OrbitDrawing, View
from orbitdb.cli.tui.orbit.facts import Certificate, FactsPanel, Line, facts_of, folded
from orbitdb.cli.tui.orbit.lives import bar
from orbitdb.cli.tui.screens import OwnScreen
from orbitdb.errors import StoreError
from orbitdb.orbits.orbit import Orbit
from orbitdb.symbols.symmetry import ELEMENTS, MIRROR_X, MIRROR_Y, REVERSE, images_of
from orbitdb.symbols.words import least_rotation

_NAMES = {MIRROR_X: "mirrored left-right", MIRROR_Y: "mirrored up-down", REVERSE: "reversed in time"}
_WIDEST_BAR = 60
_SAME = 1e-9

Partners = Sequence[tuple[float, list[str]]]


def whole_lines(orbit: Orbit, certificate: Certificate, partners: Partners, width: int) -> list[Line]:
    """Return all that is known of an orbit as lines of at most some width.

    Parameters
    ----------
    orbit : Orbit
    certificate : tuple of float and int, or None
        Radius and bits of its proof.
    partners : sequence of (float, list of str)
        Its births, each with the least words of the classes that are one path with it there.
    width : int
    """
    facts = [fact for fact in facts_of(orbit, certificate) if fact[0] not in ("exists", "")]
    if facts[0][1] != orbit.code:
        facts.insert(1, ("symbols", orbit.code))
    if orbit.residual is not None:
        facts.append(("residual", number("residual", orbit.residual)))
    if orbit.solver is not None:
        facts.append(("solver", orbit.solver))
    lines = folded(facts, width)
    parts = (("life", _life(orbit, partners, width)), ("symmetry class", folded(_class(orbit), width)))
    for title, part in (*parts, ("bounces", _bounces(orbit))):
        if part:
            lines += [[], [(title, "name")], *part]
    return lines


def _life(orbit: Orbit, partners: Partners, width: int) -> list[Line]:
    """Return a bar over ln a, and the births and deaths with what is known of them."""
    from orbitdb.orbits.closed_forms import closed_form

    if not orbit.exists:
        return []
    long = min(width, _WIDEST_BAR)
    facts = []
    for born, dies in orbit.exists:
        for name, end in (("born", born), ("dies", dies)):
            if end:
                form = closed_form(end)
                told = f"a = {end:.12g}" + (f" = {form}, recognised numerically" if form else "")
                words = ", ".join(map(code_text, _born_at(end, partners))) if name == "born" else ""
                facts.append((name, told + (f"; one path there with {words}" if words else "")))
        if not born:
            facts.append(("born", "an orbit from a = 0 on"))
    ends = "a = 0.05" + "20".rjust(long - len("a = 0.05"))
    return [[(bar(orbit.exists, orbit.a, long), "")], [(ends, "name")], *folded(facts, width)]


def _born_at(a: float, partners: Partners) -> list[str]:
    """Return who is born with an orbit; births that are stored and found on the spot differ in rounding."""
    return [word for birth, words in partners for word in words if abs(birth - a) <= _SAME * a]


def _class(orbit: Orbit) -> list[tuple[str, str]]:
    """Return the words of the class, each with what carries the orbit into it."""
    if orbit.class_size is None:
        return []
    found: dict[str, list[str]] = {}
    for element, image in zip(ELEMENTS, images_of(orbit.code), strict=True):
        how = ", ".join(name for bit, name in _NAMES.items() if element & bit) or "itself"
        found.setdefault(least_rotation(image), []).append(how)
    return [(code_text(word), "; ".join(how)) for word, how in found.items()]


def _bounces(orbit: Orbit) -> list[Line]:
    """Return a line a bounce: where it is, and how the path leaves it."""
    from orbitdb.billiard.stadium import Stadium
    from orbitdb.orbits.bounce_rows import bounce_rows

    rows = bounce_rows(Stadium(orbit.a), [orbit.code], [orbit.coordinates])[0]
    heads = ("coordinate", "x", "y", "along wall", "sine")
    head = f"{'n':>4} {'symbol':>6}" + "".join(f"{name:>11}" for name in heads)
    lines: list[Line] = [[(head, "name")]] if rows else []
    for n, symbol, *values in rows:
        lines.append([(f"{n:>4} {symbol:>6}" + "".join(f"{value:>11.6f}" for value in values), "")])
    return lines


class WholeOrbitScreen(OwnScreen[None]):
    """Everything about one orbit.

    Parameters
    ----------
    orbit : Orbit
    """

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("escape", "dismiss", "back"),
        Binding("enter,q", "dismiss", show=False),
        Binding("v", "view", "view"),
        Binding("space", "particle", "run"),
        Binding("j,down", "scroll('down')", "Scroll down", show=False),
        Binding("k,up", "scroll('up')", "Scroll up", show=False),
        Binding("pagedown", "scroll('page_down')", "Page down", show=False),
        Binding("pageup", "scroll('page_up')", "Page up", show=False),
        Binding("g,home", "scroll('home')", "To the top", show=False),
        Binding("G,end", "scroll('end')", "To the end", show=False),
    ]

    @dataclass
    class Completed(Message):
        """A worker has found what took a while: lives, and who is born with it."""

        orbit: Orbit
        partners: Partners

    @dataclass
    class Failed(Message):
        """A worker could not."""

        reason: str

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
        self._show(self._orbit, ())
        self.query_one(FactsPanel).focus()
        self._complete()

    def _show(self, orbit: Orbit, partners: Partners) -> None:
        certificate = cast(Browser, self.app).certificate(orbit)
        panel = self.query_one(FactsPanel)
        panel.border_title = "the whole orbit"
        panel.show_lines(partial(whole_lines, orbit, certificate, partners))

    @work(thread=True)
    def _complete(self) -> None:
        from orbitdb.store.reading.lookup import born_with, with_existence

        browser = cast(Browser, self.app)
        try:
            orbit = with_existence(self._orbit)
            partners = born_with(browser.path if browser.catalogue is not None else None, orbit)
        except StoreError as error:
            self.post_message(self.Failed(str(error)))
            return
        self.post_message(self.Completed(orbit, partners))

    def on_whole_orbit_screen_completed(self, message: Completed) -> None:
        """Show all."""
        self._show(message.orbit, message.partners)

    def on_whole_orbit_screen_failed(self, message: Failed) -> None:
        """Say what went wrong."""
        self.notify(message.reason, severity="error")

    def action_view(self) -> None:
        """Change between the stadium and phase space."""
        drawing = self.query_one(OrbitDrawing)
        drawing.view = View.STADIUM if drawing.view is View.PHASE else View.PHASE

    def action_particle(self) -> None:
        """Send a particle along the orbit, or stop it."""
        self.query_one(OrbitDrawing).view = View.STADIUM
        self.query_one(OrbitDrawing).toggle_particle()

    def action_scroll(self, where: str) -> None:
        """Scroll the lines."""
        getattr(self.query_one(FactsPanel), f"scroll_{where}")(animate=False)
