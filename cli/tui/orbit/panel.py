"""The panel of the current orbit: its drawing, its facts, and moves to other orbits and stadiums."""

from dataclasses import replace

from textual.app import ComposeResult
from textual.containers import Vertical
from textual.reactive import reactive

from orbitdb.cli.render import code_text, repeats
from orbitdb.cli.tui.catalogue_file import CatalogueFile, Partners
from orbitdb.cli.tui.dialogs.lines import LineDialog, code_told
from orbitdb.cli.tui.orbit.drawing import OrbitDrawing
from orbitdb.cli.tui.orbit.facts import ELEMENT_NAMES, FactsPanel, known_of, whole
from orbitdb.cli.tui.screens import Working
from orbitdb.cli.tui.table.following import Following
from orbitdb.cli.tui.table.pages import Pages
from orbitdb.cli.tui.table.panel import RowsPanel
from orbitdb.errors import StoreError
from orbitdb.orbits.orbit import Orbit
from orbitdb.store.reading.lookup import with_existence
from orbitdb.store.reading.soundness import need_words
from orbitdb.symbols.symmetry import images_of
from orbitdb.symbols.words import least_rotation, parse, primitive_root

_MOST_COMPARED = 6


class OrbitPanel(Vertical, Working):
    """The current orbit, which may differ from the row under the cursor, and orbits to compare with it."""

    orbit: reactive[Orbit | None] = reactive(None, always_update=True, init=False, repaint=False)
    whole: reactive[bool] = reactive(False, init=False, repaint=False)
    compared: reactive[tuple[Orbit, ...]] = reactive((), always_update=True, repaint=False)

    def __init__(self, file: CatalogueFile, rows: RowsPanel, a: float) -> None:
        super().__init__(id="side")
        self._file, self._rows = file, rows
        self.following = Following(file, rows, a, self._show)
        self._solving: str | None = None
        self._codes: list[str] = []

    def compose(self) -> ComposeResult:
        """Lay out the drawing and the facts."""
        drawing = OrbitDrawing(self.following.home, id="drawing")
        yield drawing.data_bind(OrbitPanel.orbit, OrbitPanel.compared)
        yield FactsPanel(id="facts")

    # what is shown

    def watch_orbit(self, orbit: Orbit | None) -> None:
        """Show the orbit and its facts, and let the rows follow it to its a."""
        self._entitle()
        self.query_one(OrbitDrawing).a = self.following.home if orbit is None else orbit.a
        self._tell()
        self._rows.say_orbit(orbit)
        self.following.take_orbit(orbit)

    def watch_whole(self) -> None:
        """Show all facts about the orbit, or only the most important ones."""
        self._entitle()
        self._tell()

    def _tell(self) -> None:
        """Show the facts at once. If all are wanted, add the births and deaths when they have been found."""
        orbit, facts = self.orbit, self.query_one(FactsPanel)
        if orbit is None:
            facts.show()
        elif self.whole:
            self._tell_whole((orbit, ()))
            self.in_thread("lives", lambda _: self._complete(orbit), self._tell_whole)
        else:
            self.give_up("lives")
            facts.show(*known_of(orbit, self._file.certificate(orbit)))

    def _complete(self, orbit: Orbit) -> tuple[Orbit, Partners]:
        """Return the orbit with the ranges of a in which it exists, and the classes born with it."""
        orbit = with_existence(orbit)
        return orbit, self._file.partners(orbit)

    def _tell_whole(self, known: tuple[Orbit, Partners]) -> None:
        orbit, partners = known
        self.query_one(FactsPanel).show(*whole(orbit, self._file.certificate(orbit), partners))

    def _entitle(self, title: str = "") -> None:
        """Set the title of the facts to the word being solved, or to `title`.

        Without either, the title gives the a of the orbit if the rows are at another a.
        """
        if self._solving is not None:
            title = f"solving {code_text(self._solving)} …"
        elif self.orbit is not None and self.orbit.a != self.following.home:
            title = title or f"facts at a = {self.orbit.a:.9g}"
        self.query_one(FactsPanel).border_title = title or ("all facts" if self.whole else "facts")

    def clear(self, a: float) -> None:
        """Move to another a, with no orbit shown and none to compare."""
        self.following.home = a
        self.orbit, self.compared = None, ()

    # the row

    def take_rows(self, rows: Pages) -> None:
        """Show new rows, then carry out the steps in a and the digits that waited for them."""
        self.catch_up()
        if not len(rows) and not self._rows.alone:
            self.orbit = None
        if self._rows.take(rows):
            self._say_no_row()
        self.catch_up()
        self.following.go_on()
        self._rows.position.go_on()

    def catch_up(self) -> None:
        """Show the word under the cursor now, even if the message about the cursor has not arrived yet."""
        row = self._rows.table.row
        if row is not None and row[0] != self._rows.left:
            self._rows.left = None
            self._show_word(row[0])

    def need(self) -> Orbit | None:
        """Return the current orbit, or report that there is none."""
        self.catch_up()
        if self.orbit is None:
            self.notify("no orbit is shown: press c and type a code", timeout=2)
        return self.orbit

    def _show(self, orbit: Orbit | None) -> None:
        self.orbit = orbit

    def _show_word(self, word: str, anew: bool = False) -> None:
        """Show a word, given as its least rotation; if another rotation is shown, keep it unless `anew`."""
        shown, away, home = self.orbit, self.following.away, self.following.home
        same = shown is not None and len(shown.code) == len(word) and shown.a == self.following.here
        if shown is not None and same and not anew and word in (shown.code, least_rotation(shown.code)):
            if shown.stored or away is not None:
                return
            word = shown.code
        try:
            need_words([word], [len(word)])
            stored = self._file.find(word, home)
            there = None if away is None else self._file.find(word, away)
            self.orbit = stored if there is None else replace(there, exists=stored.exists)
        except StoreError as error:
            self.orbit = None
            self.failed(str(error))

    def go_to(self, orbit: Orbit) -> bool:
        """Show an orbit as given, and put the cursor on its row; return whether it has a row now."""
        self.orbit = orbit
        return self._rows.go_to(least_rotation(orbit.code))

    def _say_no_row(self) -> None:
        """Explain why the current orbit has no row."""
        if (orbit := self.orbit) is not None:
            outside = f"{code_text(orbit.code)} is not among the rows"
            self.notify(outside if orbit.stored else "not stored: solved on the spot", timeout=4)

    def action_back(self) -> None:
        """Go back to where the cursor was before digits were typed, or show the current row as stored."""
        if self._rows.position.give_up_digits():
            return
        self.following.come_back()
        self._rows.left, row = None, self._rows.table.row
        if row is not None:
            self._show_word(row[0], anew=True)

    # other orbits

    def ask_for(self, code: str) -> None:
        """Look up a word in the given rotation, or solve it if it is not stored; this runs in a worker."""
        word = parse(code)
        root, a = primitive_root(word), self.following.here
        if root != word:
            self.notify(repeats(word, root))
        self._solve(root)
        self.in_thread("find", lambda _: self._file.find(root, a), self.take_found, self._solve_failed)

    def _solve(self, word: str | None) -> None:
        self._solving = word
        self._entitle()

    def _solve_failed(self, reason: str) -> None:
        self._solve(None)
        self.failed(reason)

    def take_found(self, orbit: Orbit) -> None:
        """Show an orbit that was looked up, unless a has changed meanwhile; report if it has no row."""
        self._solve(None)
        if orbit.a == self.following.here and not self.go_to(orbit) and self._rows.wanted is None:
            self._say_no_row()

    def action_code(self) -> None:
        """Ask for a code in any rotation."""

        def take(code: str) -> None:
            self._codes.append(code)
            self.ask_for(code)

        title, example = "code, in any rotation", "1232131 or 1^20(02)^5 3"
        self.ask(LineDialog(title, "", example, code_told, self._codes), take)

    def action_follow(self, up: bool) -> None:
        """Follow the orbit to a larger or smaller a, past its births and deaths."""
        if self.need() is not None:
            self.following.step(up)

    def action_move_in_class(self, element: int) -> None:
        """Show the image of the orbit under a reflection or time reversal."""
        if (orbit := self.need()) is None:
            return
        word = images_of(orbit.code)[element]
        self.go_to(replace(self._file.find(word, orbit.a), exists=orbit.exists))
        same = least_rotation(word) == least_rotation(orbit.code)
        self._entitle(f"{'itself' if same else orbit.code[:20]}, {ELEMENT_NAMES[element]}")

    def action_compare(self) -> None:
        """Add the orbit to the comparison in phase space, or remove it."""
        if (orbit := self.need()) is None:
            return
        if orbit.coordinates is None:
            self.notify("this word is not an orbit, so it has no bounces to compare", timeout=2)
            return
        others = tuple(other for other in self.compared if other.code != orbit.code)
        if len(others) == len(self.compared):
            others = (*others, orbit)[-_MOST_COMPARED + 1 :]
        self.compared = others
        self.notify(f"{len(others)} to compare; press v to see them in phase space", timeout=2)

    def action_compare_none(self) -> None:
        """Clear the comparison."""
        self.compared = ()

    def action_copy(self) -> None:
        """Copy the code to the clipboard."""
        if (orbit := self.need()) is not None:
            self.app.copy_to_clipboard(orbit.code)
            self.notify(f"copied {orbit.code}", timeout=2)
