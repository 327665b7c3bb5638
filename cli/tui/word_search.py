"""One word: a code that is typed, looked up or solved, and where its row is."""

from typing import TYPE_CHECKING

from orbitdb.cli.render import repeats
from orbitdb.cli.tui.screens import in_thread
from orbitdb.cli.tui.table.pages import Pages
from orbitdb.orbits.orbit import Orbit
from orbitdb.symbols.words import least_rotation, parse, primitive_root

if TYPE_CHECKING:
    from orbitdb.cli.tui.panels import Panels


class WordSearch:
    """A word that the main screen was asked for."""

    def __init__(self, screen: "Panels") -> None:
        self._screen = screen
        self.solving: str | None = None
        self._awaits_rows: Orbit | None = None

    def ask_for(self, code: str) -> None:
        """Look a code up, or solve it, in a worker."""
        word = parse(code)
        root = primitive_root(word)
        if root != word:
            self._screen.notify(repeats(word, root))
        self.say_solving(root)
        a = self._screen.here
        in_thread(self._screen, "find", lambda _: self._screen.browser.find(root, a), self.take)

    def say_solving(self, word: str | None) -> None:
        """Say that a word is looked up or solved, which may take a while; None: no more."""
        self.solving = word
        self._screen.entitle_facts()

    def take(self, orbit: Orbit) -> None:
        """Show the orbit, unless another stadium is shown by now, and say where it comes from."""
        if orbit.code == self.solving:
            self.say_solving(None)
        if orbit.a == self._screen.here and not self.go_to(orbit):
            self._say_no_row(orbit)

    def go_to(self, orbit: Orbit) -> bool:
        """Show an orbit in its rotation, the cursor on its row; return whether it has one."""
        screen, table = self._screen, self._screen.rows.table
        screen.orbit = orbit
        word = least_rotation(orbit.code)
        place = table.source.position(word) if orbit.a == screen.here else None
        if place is not None:
            screen.caught_up = word
            table.cursor = place
        elif not table.source.whole and screen.browser.catalogue is not None:
            screen.wanted, self._awaits_rows = word, orbit
            return True
        else:
            screen.leave_the_row()
        return place is not None

    def take_rows(self, rows: Pages) -> None:
        """Let a word that was found before the rows stay, if it has none."""
        orbit, self._awaits_rows = self._awaits_rows, None
        if orbit is None or orbit.a != self._screen.here:
            return
        if rows.position(least_rotation(orbit.code)) is None:
            self._screen.leave_the_row()
            self._screen.orbit = orbit
            self._say_no_row(orbit)

    def _say_no_row(self, orbit: Orbit) -> None:
        """Say why the orbit on show has no row."""
        told = "it is not in the chosen subset" if orbit.stored else "not stored: solved on the spot"
        self._screen.notify(told, timeout=4)
