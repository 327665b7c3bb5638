"""The panels of the main screen: the chosen subset as a table, and the orbit under the cursor."""

from collections.abc import Sequence
from dataclasses import replace

from rich.console import RenderableType
from textual.app import ComposeResult
from textual.containers import Horizontal, Vertical
from textual.reactive import reactive
from textual.widgets import Footer, Header, Static

from orbitdb.cli.render import code_text, repeats
from orbitdb.cli.tui import choices
from orbitdb.cli.tui.orbit.drawing import OrbitDrawing
from orbitdb.cli.tui.orbit.facts import FactsPanel, known_of
from orbitdb.cli.tui.screens import OwnScreen
from orbitdb.cli.tui.table.columns import COLUMNS, Column, fields_of
from orbitdb.cli.tui.table.following import Following
from orbitdb.cli.tui.table.paged_table import PagedTable
from orbitdb.cli.tui.table.pages import NONE, Ordering, Pages
from orbitdb.cli.tui.table.panel import RowsPanel
from orbitdb.errors import StoreError
from orbitdb.orbits.orbit import Orbit
from orbitdb.store.asking.codes import hint
from orbitdb.store.asking.selection import Selection
from orbitdb.store.asking.where import check, names_in
from orbitdb.store.reading.soundness import need_words
from orbitdb.symbols.words import least_rotation, parse, primitive_root

GREETING = """\
[b]Nothing is stored here yet.[/b]

{path}

Press [b]f[/b] to fill it: the periods up to 11 take a few seconds
and hold 89,789 words, the paper's Table 1.

Press [b]c[/b] to type a code, such as 1232131, and see its orbit.
Press [b]?[/b] for the keys, [b]q[/b] to leave."""


class Panels(OwnScreen[None]):
    """The state of the main screen: a subset in some order, and an orbit.

    The cursor goes to the `wanted` word when the rows arrive. `left` is the word of the row under the cursor
    while another word without a row is shown. `solving` is the word being looked up or solved.
    """

    wanted: str | None = None
    left: str | None = None
    solving: str | None = None
    selection: reactive[Selection] = reactive(Selection, repaint=False)
    ordering: reactive[Ordering] = reactive(Ordering(), repaint=False)
    orbit: reactive[Orbit | None] = reactive(None, always_update=True, repaint=False)
    compared: reactive[tuple[Orbit, ...]] = reactive((), always_update=True, repaint=False)
    columns: reactive[tuple[Column, ...]] = reactive(COLUMNS, repaint=False)
    marked: reactive[frozenset[str]] = reactive(frozenset(), repaint=False)

    def __init__(self, selection: Selection, code: str | None = None) -> None:
        super().__init__()
        self.set_reactive(Panels.selection, selection)
        self._code = code
        self._values = dict(selection.parameters)
        self.following = Following(self)

    @property
    def rows(self) -> RowsPanel:
        """The panel of the rows."""
        return self.query_one(RowsPanel)

    @property
    def here(self) -> float:
        """The current a: that of the rows, or the one they are followed to."""
        return self.selection.a if self.following.away is None else self.following.away

    @property
    def periods(self) -> list[int]:
        """The filled periods, whole or partial."""
        catalogue = self.browser.catalogue
        if catalogue is None:
            return []
        with catalogue.moment() as moment:
            return [fill.p for fill in moment.fills(self.selection.a)]

    def compose(self) -> ComposeResult:
        """Lay out the panels."""
        yield Header()
        yield Static(id="chips")
        with Vertical(id="greeting"):
            yield Static(GREETING.format(path=choices.escaped(str(self.browser.path))))
        with Horizontal(id="body"):
            yield RowsPanel(PagedTable(id="table").data_bind(Panels.columns, Panels.marked))
            with Vertical(id="side"):
                yield OrbitDrawing(self.selection.a, id="drawing").data_bind(Panels.orbit, Panels.compared)
                yield FactsPanel(id="facts")
        yield Footer(show_command_palette=False, compact=True)

    def on_mount(self) -> None:
        """Read the rows, and look the first word up."""
        self.refresh_catalogue()
        self.rows.table.focus()
        if self._code is not None:
            self.call_next(self.ask_for, self._code)

    # the subset

    def refresh_catalogue(self) -> None:
        """Read the file again, at the start and after changes."""
        filled = self.browser.a_values()
        self.set_class(not filled and self.orbit is None, "-empty")
        self.rows.total = None
        self.say_choices()
        if filled:
            self.read()

    action_look_again = refresh_catalogue

    def watch_selection(self, old: Selection, selection: Selection) -> None:
        """Show the new subset; at another a, nothing stays on screen."""
        if not self.is_mounted:
            return
        if selection.a != old.a:
            self.wanted = self.left = self.rows.total = None
            self.orbit, self.compared = None, ()
            self.rows.say_gaps("", "")
            self.rows.table.show(NONE)
        self.say_choices()
        self.read()

    def say_choices(self) -> None:
        """Show the choices in the subtitle and as links, after the progress of a fill."""
        fill = self.browser.fill_state
        told = choices.chips(self.selection, self.browser.a_values())
        if fill is not None and fill.runs:
            told = f"[b]{fill.sentence()}[/b] │ {told}"
        self.query_one("#chips", Static).update(told)
        self.sub_title = self.selection.describe()

    def read(self) -> None:
        """Read the chosen rows."""
        if self.browser.catalogue is not None:
            fields, asked = fields_of(self.columns, self.ordering.column), (self.selection, self.ordering)
            self.rows.read(self.browser.catalogue, asked, fields, self.begin_rows, self.take_rows)

    def watch_ordering(self) -> None:
        """Read the rows in another order, or with other columns."""
        if self.is_mounted:
            self.read()

    watch_columns = watch_ordering

    def check_filter(self, where: str) -> str:
        """Refuse an invalid filter; hint at comparisons of codes that name no row."""
        check(where, dict(self._filtered(where).parameters))
        return hint(where) or ""

    def try_filter(self, where: str, word: str | None) -> None:
        """Show the rows of a valid filter, with the cursor on a word if it is among them."""
        if (where or None) != self.selection.where:
            self.wanted = word
            self.selection = self._filtered(where or None)
        elif self.rows.asked is None:  # reading was stopped
            self.read()

    def _filtered(self, where: str | None) -> Selection:
        """Return the selection with another filter, and the values of -P that it uses."""
        used = names_in(where or "")
        known = self._values | dict(self.selection.parameters)
        values = {name: value for name, value in known.items() if name in used}
        return replace(self.selection, where=where, parameters=values)

    def begin_rows(self, rows: Pages) -> None:
        """Show the first rows while the others are read, unless the current word has another row."""
        if self.orbit is None:
            self.rows.table.show(rows)

    def take_rows(self, rows: Pages) -> None:
        """Show the rows; the cursor stays on its word if it is among them, and at the top if it was there.

        A shown orbit without a row moves to its row once it has one.
        """
        self.catch_up()
        table = self.rows.table
        row, shown = table.row, None if self.orbit is None else least_rotation(self.orbit.code)
        alone = None if row is not None and row[0] == shown else shown
        word = self.wanted or alone or (row[0] if row is not None and table.cursor else None)
        place, asked_for = rows.position(word) if word else None, self.wanted == alone
        self.wanted = self.left = None
        if not len(rows) and alone is None:
            self.orbit = None
        self.rows.show(rows, place or 0)
        if alone is not None and place is None:
            self.leave_the_row()
            if asked_for:
                self._say_no_row()
        self.following.go_on()
        self.rows.jumping.go_on()

    def failed(self, reason: str) -> None:
        """Show the error of a worker, and drop its results."""
        super().failed(reason)
        self.following.stop()
        self.solving = None
        self.entitle_facts()
        self.rows.say()

    # the orbit

    def ask_for(self, code: str) -> None:
        """Look a code up, or solve it, in a worker."""
        word = parse(code)
        root = primitive_root(word)
        if root != word:
            self.notify(repeats(word, root))
        self.solving, a = root, self.here
        self.entitle_facts()
        self.in_thread("find", lambda _: self.browser.find(root, a), self.take_found)

    def take_found(self, orbit: Orbit) -> None:
        """Show the orbit and its source, unless another stadium is shown by now."""
        self.solving = None
        self.entitle_facts()
        if orbit.a == self.here and not self.go_to(orbit) and self.wanted is None:
            self._say_no_row()

    def go_to(self, orbit: Orbit) -> bool:
        """Show an orbit in its rotation, the cursor on its row; return whether it has one."""
        table, word = self.rows.table, least_rotation(orbit.code)
        self.orbit = orbit
        place = table.source.position(word)
        if place is not None:
            self.left, table.cursor = None, place
        else:
            self.wanted = word if self.rows.reads else None
            self.leave_the_row()
        return place is not None

    def _say_no_row(self) -> None:
        """Explain why the current orbit has no row."""
        if (orbit := self.orbit) is not None:
            outside = f"{code_text(orbit.code)} is not among the rows"
            self.notify(outside if orbit.stored else "not stored: solved on the spot", timeout=4)

    def leave_the_row(self) -> None:
        """Keep the shown orbit until the cursor moves."""
        row = self.rows.table.row
        self.left = None if row is None else row[0]

    def catch_up(self) -> None:
        """Show the word under the cursor, which may be ahead of its messages."""
        row = self.rows.table.row
        if row is not None and row[0] != self.left:
            self.left = None
            self._show_word(row[0])

    def on_paged_table_moved(self) -> None:
        """Show the word under the cursor."""
        self.catch_up()
        self.rows.say_orbit(self.orbit)

    def shown_orbit(self) -> Orbit | None:
        """Return the current orbit, or say that there is none."""
        self.catch_up()
        if self.orbit is None:
            self.notify("no orbit is shown: press c and type a code", timeout=2)
        return self.orbit

    def _show_word(self, word: str, anew: bool = False) -> None:
        """Show a word, given as its least rotation; a shown rotation of it stays unless `anew`."""
        shown, away = self.orbit, self.following.away
        same = shown is not None and shown.a == self.here and len(shown.code) == len(word) and not anew
        if shown is not None and same and word in (shown.code, least_rotation(shown.code)):
            if shown.stored or away is not None:
                return
            word = shown.code
        try:
            need_words([word], [len(word)])
            stored = self.browser.find(word, self.selection.a)
            there = None if away is None else self.browser.find(word, away)
            self.orbit = stored if there is None else replace(there, exists=stored.exists)
        except StoreError as error:
            self.orbit = None
            self.notify(str(error), severity="error")

    def watch_orbit(self, orbit: Orbit | None) -> None:
        """Show the facts of the orbit, and let the rows follow it."""
        if not self.is_mounted:
            return
        self.entitle_facts()
        self.query_one(OrbitDrawing).a = self.selection.a if orbit is None else orbit.a
        known: Sequence[RenderableType] = ()
        if orbit is not None:
            self.remove_class("-empty")
            known = known_of(orbit, self.browser.certificate(orbit))
        self.query_one(FactsPanel).show(*known)
        self.rows.say_orbit(orbit)
        self.following.take_orbit(orbit)

    def entitle_facts(self) -> None:
        """Title the facts, with their a if it differs from that of the rows, or with a word being solved."""
        title = "facts"
        if self.orbit is not None and self.orbit.a != self.selection.a:
            title = f"facts at a = {self.orbit.a:.9g}"
        if self.solving is not None:
            title = f"solving {code_text(self.solving)} …"
        self.query_one(FactsPanel).border_title = title

    def action_back(self) -> None:
        """Go back to where digits began, or show the row under the cursor as stored."""
        if self.rows.jumping.under_way:
            self.rows.jumping.give_up()
            return
        self.following.come_back()
        self.left, row = None, self.rows.table.row
        if row is not None:
            self._show_word(row[0], anew=True)
