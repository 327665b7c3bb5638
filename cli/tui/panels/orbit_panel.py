"""The panel of the current orbit: its drawing, its facts, and moves to other orbits and stadiums."""

import math
from collections.abc import Sequence
from dataclasses import replace

from rich.console import RenderableType
from textual.app import ComposeResult
from textual.containers import Vertical
from textual.reactive import reactive

from orbitdb.billiard.stadium import MAX_A, MIN_A
from orbitdb.catalogue import Catalogue
from orbitdb.cli.output import code_text, repeats
from orbitdb.cli.tui.dialogs import LineDialog, describe_code
from orbitdb.cli.tui.panels.drawing import OrbitDrawing
from orbitdb.cli.tui.panels.facts import ELEMENT_NAMES, LONG, FactsPanel, brief, parts_of
from orbitdb.cli.tui.screens import Working
from orbitdb.cli.tui.stored import Kept
from orbitdb.errors import StoreError
from orbitdb.orbits.orbit import Orbit
from orbitdb.orbits.solve import with_existence
from orbitdb.symbols.symmetry import REVERSE, images_of
from orbitdb.symbols.words import least_rotation, parse, primitive_root
from orbitdb.text import format_float

STEP = 0.02
"""Step in ln a per key press."""
_DIGITS, _DIGITS_BESIDE = 4, 11
"""Significant digits of a after a step, and beside a birth or death."""
_BESIDE = 1e-9
_FOLLOWING = "following …"

Lives = Sequence[tuple[float, float | None]]


def stops_of(lives: Lives) -> list[float]:
    """Return the values of a just below and just above each birth and death.

    There one sees the last margin of an orbit before it disappears.
    """
    ends = [end for life in lives for end in life if end]
    return [float(f"{end * (1 + side * _BESIDE):.{_DIGITS_BESIDE}g}") for end in ends for side in (-1, 1)]


def next_a(lives: Lives, a: float, up: bool, home: float) -> float:
    """Return the a that is one step away, or the first stop on the way there (`stops_of`, or `home`)."""
    way = 1 if up else -1
    new = min(max(float(f"{a * math.exp(way * STEP):.{_DIGITS}g}"), MIN_A), MAX_A)
    stop = next_change(lives, a, up, home)
    return new if stop is None else way * min(way * stop, way * new)


def next_change(lives: Lives, a: float, up: bool, *others: float) -> float | None:
    """Return the a beside the next birth or death, on its far side if a is beside it already, or None.

    `others` are further values of a at which to stop.
    """
    way = 1 if up else -1
    ahead = [stop for stop in (*stops_of(lives), *others) if way * (stop - a) > 0]
    return min(ahead, key=lambda stop: way * stop, default=None)


def change_between(lives: Lives, before: float, after: float) -> str | None:
    """Return a message about a birth or death between two values of a, or None."""
    low, high = sorted((before, after))
    for born, dies in lives:
        for end, begins in ((born, True), (dies, False)):
            if end and low < end < high:
                verb = "born" if begins is (after > before) else "gone"
                return f"{verb} at a = {end:.12g}"
    return None


class OrbitPanel(Vertical, Working):
    """The current orbit, which may differ from the row under the cursor, and may be at another a.

    `home` is the a of the rows. `sought` is the last orbit that was asked for, whose row is to be found.
    """

    orbit: reactive[Orbit | None] = reactive(None, always_update=True, init=False, repaint=False)
    whole: reactive[bool] = reactive(False, init=False, repaint=False)
    sought: reactive[Orbit | None] = reactive(None, always_update=True, init=False, repaint=False)

    def __init__(self, catalogue: Catalogue, kept: Kept, a: float) -> None:
        super().__init__(id="side")
        self._catalogue, self._kept, self.home = catalogue, kept, a
        self._paired = False
        self._codes: list[str] = []
        self._steps: list[tuple[bool, bool]] = []
        self._work = ""  # what is being computed

    def compose(self) -> ComposeResult:
        yield OrbitDrawing(self.home, id="drawing").data_bind(OrbitPanel.orbit)
        yield FactsPanel(id="facts")

    def on_mount(self) -> None:
        self.app.theme_changed_signal.subscribe(self, lambda _: self._show_facts())

    # what is shown

    def watch_orbit(self, orbit: Orbit | None) -> None:
        """Show the orbit and its facts; drop the steps that were meant for another one."""
        self._steps = []
        self._entitle()
        drawing = self.query_one(OrbitDrawing)
        drawing.a, drawing.partner = self.home if orbit is None else orbit.a, self._partner()
        self._show_facts()

    def watch_whole(self) -> None:
        self._entitle()
        self._show_facts()

    def _show_facts(self) -> None:
        """Show the facts at once. If all are wanted, add the births and deaths when they have been found."""
        orbit, facts = self.orbit, self.query_one(FactsPanel)
        self.give_up("lives")
        if orbit is None:
            facts.show()
            return
        muted = facts.get_component_rich_style("facts--name", partial=True)
        proof = self._catalogue.certificate(orbit)
        facts.show(*parts_of(orbit, proof, whole=self.whole, muted=muted))

        def find(_: object) -> list[RenderableType]:
            """Find the ranges of a in which the orbit exists, and the classes born with it."""
            found = with_existence(orbit)
            return parts_of(
                found, self._catalogue.certificate(found), self._catalogue.born_with(found), True, muted
            )

        if self.whole:
            self.in_thread("lives", find, lambda parts: facts.show(*parts))

    def _entitle(self, title: str = "") -> None:
        """Set the title of the facts to the work in progress, to `title`, or to the word and its status."""
        if not title and (orbit := self.orbit) is not None:
            code = brief(orbit.code, LONG)
            title = f"{code}, p = {orbit.p}, {orbit.status.value}"
            title += f", a = {format_float(orbit.a)}" if orbit.a != self.home else ""
        self.query_one(FactsPanel).border_title = self._work or title

    def clear(self, a: float) -> None:
        self.home, self.orbit = a, None

    def need(self) -> Orbit | None:
        if self.orbit is None:
            self.notify("no orbit is shown: press c and type a code", timeout=2)
        return self.orbit

    def show_word(self, word: str | None, anew: bool = False) -> None:
        """Show a word, given as its least rotation; if another rotation is shown, keep it unless `anew`."""
        shown = self.orbit
        if word is None:
            self.orbit = None
            return
        if shown is not None and not anew and word in (shown.code, least_rotation(shown.code)):
            if shown.stored or shown.a != self.home:
                return
            word = shown.code
        try:
            self.orbit = self._catalogue.orbit(word, a=self.home)
        except StoreError as error:
            self.orbit = None
            self.failed(str(error))

    def seek(self, orbit: Orbit) -> None:
        """Show an orbit as given, and ask for its row."""
        self.orbit = orbit
        self.sought = orbit

    # other orbits

    def ask_for(self, code: str) -> None:
        """Look up a word in the given rotation, or solve it if it is not stored; this runs in a worker."""
        word = parse(code)
        root, a = primitive_root(word), self.home
        if root != word:
            self.notify(repeats(word, root))
        self._begin(f"solving {code_text(root)} …")
        self.in_thread("find", lambda _: self._catalogue.orbit(root, a=a), self.take_found)

    def _begin(self, work: str = "") -> None:
        """Say what is being computed; without an argument, that nothing is."""
        self._work = work
        self._entitle()

    def failed(self, reason: str) -> None:
        self._steps = []
        self._begin()
        super().failed(reason)

    def take_found(self, orbit: Orbit) -> None:
        """Show an orbit that was looked up, unless a has changed meanwhile."""
        self._begin()
        if orbit.a == self.home:
            self.seek(orbit)

    def action_code(self) -> None:
        def take(code: str) -> None:
            self._codes.append(code)
            self.ask_for(code)

        title, example = "code, in any rotation", "1232131 or 1^20(02)^5 3"
        self.ask(LineDialog(title, "", example, describe_code, self._codes), take)

    def action_move_in_class(self, element: int) -> None:
        if (orbit := self.need()) is None:
            return
        word = images_of(orbit.code)[element]
        self.seek(replace(self._catalogue.orbit(word, a=orbit.a), exists=orbit.exists))
        same = least_rotation(word) == least_rotation(orbit.code)
        self._entitle(f"{'itself' if same else orbit.code[:20]}, {ELEMENT_NAMES[element]}")

    def action_pair(self) -> None:
        """Draw a second orbit with this one, or this one alone again."""
        if self.need() is not None:
            self._paired = not self._paired
            self.query_one(OrbitDrawing).partner = self._partner()

    def _partner(self) -> Orbit | None:
        """Return the orbit to draw with this one: the one marked last, if it is another, or the reverse."""
        if self.orbit is None or not self._paired:
            return None
        own = least_rotation(self.orbit.code)
        others = [word for word in self._kept.state.marked if word != own]
        word = others[-1] if others else images_of(self.orbit.code)[REVERSE]
        return self._catalogue.orbit(word, a=self.orbit.a)

    async def action_draw(self, action: str) -> None:
        if self.need() is not None:
            await self.query_one(OrbitDrawing).run_action(action)

    def action_copy(self) -> None:
        if (orbit := self.need()) is not None:
            self.app.copy_to_clipboard(orbit.code)
            self.notify(f"copied {orbit.code}", timeout=2)

    # other stadiums

    def action_follow(self, up: bool, to_change: bool = False) -> None:
        """Follow the orbit to a larger or smaller a by one step, or to its next birth or death.

        Steps that are asked for during a search are taken together afterwards.
        """
        if self.need() is not None:
            self._steps.append((up, to_change))
            self._go_on()

    def _go_on(self) -> None:
        orbit, home, steps = self.orbit, self.home, self._steps
        if self._work == _FOLLOWING or orbit is None or not steps:
            return
        self._steps = []
        self._begin(_FOLLOWING)

        def follow(_: object) -> Orbit:
            lives, a = with_existence(orbit).exists or (), orbit.a
            for up, to_change in steps:
                after = next_change(lives, a, up) if to_change else next_a(lives, a, up, home)
                a = a if after is None else after
            return replace(orbit if a == orbit.a else self._catalogue.orbit(orbit.code, a=a), exists=lives)

        def arrive(followed: Orbit) -> None:
            waiting = self._steps
            if self.orbit is orbit:
                self.orbit, self._steps = followed, waiting
                up, to_change = steps[-1]
                if followed.a == orbit.a and to_change:
                    self.notify(f"no birth or death at a {'larger' if up else 'smaller'} a", timeout=2)
                elif happened := change_between(followed.exists or (), orbit.a, followed.a):
                    self.notify(happened)
            self._begin()
            self._go_on()

        self.in_thread("follow", follow, arrive)
