"""One word: a code that is typed, looked up or solved, and where its row is."""

from dataclasses import dataclass

from textual import work
from textual.message import Message

from orbitdb.cli.render import code_text, repeats
from orbitdb.cli.tui.orbit.facts import FactsPanel
from orbitdb.cli.tui.orbit_screen import OrbitScreen
from orbitdb.cli.tui.table.paged_table import PagedTable
from orbitdb.cli.tui.table.source import Pages
from orbitdb.errors import InputError, StoreError
from orbitdb.orbits.orbit import Orbit
from orbitdb.store.asking.selection import Selection
from orbitdb.symbols.words import least_rotation, parse, primitive_root


class WordScreen(OrbitScreen):
    """The main screen, asked for one word."""

    @dataclass
    class OrbitFound(Message):
        """A worker has found, or solved, a word that was asked for."""

        orbit: Orbit

    def __init__(self, selection: Selection, code: str | None = None) -> None:
        super().__init__(selection)
        self._code = code
        self._solving: str | None = None
        self._awaits_rows: Orbit | None = None

    def on_mount(self) -> None:
        """Look the first word up, behind what `OrbitScreen` does."""
        if self._code is not None:
            self.call_next(self.ask_for, self._code)

    @property
    def facts_title(self) -> str:
        """What the facts are, or that a word is looked up."""
        return super().facts_title if self._solving is None else "solving …"

    def on_orbit_screen_failed(self, message: OrbitScreen.Failed) -> None:
        """Look for nothing any more; Textual calls the handler of `OrbitScreen`, too."""
        self._say_solving(None)

    def go_to(self, orbit: Orbit) -> bool:
        """Show an orbit in its rotation, the cursor on its row; return whether it has one."""
        table = self.query_one(PagedTable)
        self.orbit = orbit
        word = least_rotation(orbit.code)
        place = table.source.position(word) if orbit.a == self.here else None
        if place is not None:
            self._caught_up = word
            table.cursor = place
        elif not table.source.whole and self.browser.catalogue is not None:
            self._wanted, self._awaits_rows = word, orbit
            return True
        else:
            self._leave_the_row()
        return place is not None

    def show_rows(self, rows: Pages, cursor: int) -> None:
        """Show the rows that have been read; a word that was found before them stays, if it has none."""
        super().show_rows(rows, cursor)
        orbit, self._awaits_rows = self._awaits_rows, None
        if orbit is not None and orbit.a == self.here and rows.position(least_rotation(orbit.code)) is None:
            self._leave_the_row()
            self.orbit = orbit
            self._say_no_row(orbit)

    def ask_for(self, code: str) -> None:
        """Look a code up, or solve it, in a worker."""
        word = parse(code)
        root = primitive_root(word)
        if root != word:
            self.notify(repeats(word, root))
        self._say_solving(root)
        self._find(root, self.here)

    def _say_solving(self, word: str | None) -> None:
        """Say that a word is looked up or solved, which may take a while; None: no more."""
        self._solving = word
        self.query_one(FactsPanel).border_title = self.facts_title
        if word is None:
            self.say_choices()
        else:
            self.sub_title = f"solving {code_text(word)} …"

    @work(thread=True, exclusive=True, group="find")
    def _find(self, word: str, a: float) -> None:
        try:
            orbit = self.browser.find(word, a)
        except (InputError, StoreError) as error:
            self.post_message(self.Failed(str(error)))
            return
        self.post_message(self.OrbitFound(orbit))

    def on_word_screen_orbit_found(self, message: OrbitFound) -> None:
        """Show the orbit, unless another stadium is shown by now, and say where it comes from."""
        if message.orbit.code == self._solving:
            self._say_solving(None)
        if message.orbit.a != self.here or self.go_to(message.orbit):
            return
        self._say_no_row(message.orbit)

    def _say_no_row(self, orbit: Orbit) -> None:
        """Say why the orbit on show has no row."""
        told = "it is not in the chosen subset" if orbit.stored else "not stored: solved on the spot"
        self.notify(told, timeout=4)
