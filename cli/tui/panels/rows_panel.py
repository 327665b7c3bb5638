"""The panel of the rows: the table, notes on gaps, and the position of the cursor."""

import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from functools import partial

from textual.app import ComposeResult
from textual.containers import Vertical
from textual.reactive import reactive
from textual.widgets import Static

from orbitdb.catalogue import Catalogue
from orbitdb.cli.advice import completed
from orbitdb.cli.tui.dialogs import ColumnDialog
from orbitdb.cli.tui.panels.facts import brief
from orbitdb.cli.tui.panels.paged_table import PagedTable
from orbitdb.cli.tui.screens import Working, in_shell
from orbitdb.cli.tui.stored import (
    NONE,
    USUAL,
    Kept,
    Ordering,
    Pages,
    Row,
    known_columns,
    said_by,
    stamp_of,
)
from orbitdb.orbits.orbit import Orbit
from orbitdb.orbits.status import Status
from orbitdb.selection import Selection
from orbitdb.symbols.symmetry import class_of
from orbitdb.symbols.words import least_rotation

_AT_WORK = ("reading …", "sorting …")
_PAUSE = 0.25
"""Seconds without a key before the rows of a filter that is being typed are read."""

_FIRST = 100
_SHOWN = 12
"""Maximum number of characters shown for a word that has no row."""


class RowsPanel(Vertical, Working):
    """The panel that reads and shows the rows of a subset in some order.

    `total` is the number of rows without the filter; it is None until they are counted. `word` is set to the
    word under the cursor whenever it should be shown. When new rows arrive, the cursor goes to the `wanted`
    word.
    """

    wanted: str | None = None
    word: reactive[str | None] = reactive(None, always_update=True, init=False, repaint=False)
    ordering: reactive[Ordering] = reactive(Ordering(), init=False, repaint=False)
    columns: reactive[tuple[str, ...]] = reactive(USUAL, init=False, repaint=False)
    by_class: reactive[bool] = reactive(False, init=False, repaint=False)
    marked: reactive[frozenset[str]] = reactive(frozenset(), repaint=False)
    total: reactive[int | None] = reactive(None, repaint=False)
    report: reactive[str] = reactive("", repaint=False)

    def __init__(self, catalogue: Catalogue, kept: Kept) -> None:
        super().__init__(id="rows")
        self._catalogue, self._kept = catalogue, kept
        self.table = PagedTable(id="table")
        self._entitle()
        self._asked: Selection | None = None
        self._counted: tuple[Selection, bool, tuple[int, ...]] | None = (
            None  # what `total` counts, in which file
        )
        self._orbit: Orbit | None = None  # the current one
        self.set_reactive(RowsPanel.columns, known_columns(kept.state.columns))
        self.set_reactive(RowsPanel.marked, frozenset(kept.state.marked))
        self.set_reactive(RowsPanel.ordering, Ordering.of(kept.state.order))
        self.set_reactive(RowsPanel.by_class, kept.state.classes)
        self._entitle()

    def compose(self) -> ComposeResult:
        yield self.table.data_bind(RowsPanel.columns, RowsPanel.marked)
        yield Static(id="unfilled", markup=False)

    def on_mount(self) -> None:
        self.watch(self.table, "cursor", self._show_word, init=False)

    # sort order and columns

    def action_sort(self, descending: bool = False) -> None:
        """Sort by the column under the cursor; if the rows are sorted so, reverse the order."""
        self._sort_by(self.table.current, descending)

    def _sort_by(self, column: str, descending: bool = False) -> None:
        new = Ordering(column, descending)
        self.ordering = Ordering(column, not descending) if new == self.ordering else new

    def on_paged_table_heading_clicked(self, message: PagedTable.HeadingClicked) -> None:
        """Sort by the column; a second click on its heading reverses the order."""
        self._sort_by(message.column)

    def action_classes(self) -> None:
        self.by_class = not self.by_class

    def action_columns(self) -> None:
        self.ask(ColumnDialog(self.columns), partial(setattr, self, "columns"))

    def validate_columns(self, names: Iterable[str]) -> tuple[str, ...]:
        return known_columns(names)

    def _read_again(self) -> None:
        if self._asked is not None:
            self.read(self._asked)

    def watch_ordering(self, ordering: Ordering) -> None:
        """Read the rows again in the new order, and keep it for the next session."""
        with self._kept.changing() as state:
            state.order = str(ordering)
        self._read_again()

    def watch_by_class(self, by_class: bool) -> None:
        """Read the rows again, one for each word or class, and keep the choice for the next session."""
        with self._kept.changing() as state:
            state.classes = by_class
        self._read_again()

    def watch_columns(self, columns: tuple[str, ...]) -> None:
        """Read the rows again, with the new columns, and keep the columns for the next session."""
        with self._kept.changing() as state:
            state.columns = list(columns)
        self._read_again()

    # reading

    def read(self, selection: Selection, patient: bool = False) -> None:
        """Read the rows of a subset in a worker, and show them unless others are requested meanwhile.

        If `patient`, the worker begins after a pause. If the table is empty, the first rows of a subset
        without a filter in the default order are shown early.
        """
        if self._catalogue.missing:
            return
        catalogue, ordering, by_class = self._catalogue, self.ordering, self.by_class
        unfiltered = replace(selection, where=None, parameters={})
        counted = unfiltered, by_class, stamp_of(catalogue.path)
        total = self.total if self._counted == counted else None
        fields = tuple(dict.fromkeys((*self.columns, "status", ordering.column)))
        self._asked = selection
        self.report = self.border_title = _AT_WORK[ordering != self.table.ordering]
        natural = (selection, ordering, by_class) == (unfiltered, Ordering(), False)
        early = self.table.source is NONE and natural

        def find(cancelled: Callable[[], bool]) -> Iterator[tuple[Pages, str, int | None]]:
            """Yield rows, notes on gaps, and the number of rows without a filter (None for the first)."""
            time.sleep(_PAUSE if patient else 0.0)
            if cancelled():
                return
            with catalogue.snapshot(cancelled) as then:
                listing = then.rows(selection, columns=fields, order=str(ordering), classes=by_class)
                gaps = "; ".join(map(_with_key, listing.gaps))
                if early:
                    yield Pages.first(catalogue, selection, fields, then, _FIRST), gaps, None
                rows = Pages.read(catalogue, selection, ordering, fields, then, by_class)
                if not len(rows):
                    gaps = "; ".join(map(_with_key, listing.notes))
                count = len(rows) if selection == unfiltered else total
                if count is None and by_class:
                    count = sum(then.count(unfiltered, by=[])["classes"])  # without any, there is no row
                elif count is None:
                    count = then.count(unfiltered)
            yield rows, gaps, count

        def show(found: tuple[Pages, str, int | None]) -> None:
            rows, gaps, self.total = found
            self._counted = counted
            self.table.ordering = ordering
            self.table.left_out = said_by(selection)
            self.say_gaps(gaps)
            if self.total is not None:
                noun = "orbit" if selection.statuses == (Status.ORBIT,) else "word"
                one, many = ("class", "classes") if by_class else (noun, f"{noun}s")
                self.report = f"{len(rows):,} of {self.total:,} {one if self.total == 1 else many}"
                self.take(rows)
            elif self._orbit is None:  # otherwise the current word would lose its row
                self.table.show(rows)
                self._show_word()

        self.in_thread("rows", find, show, self.fail)

    def fail(self, reason: str) -> None:
        """Show the error and an empty table, because the old rows belong to another subset."""
        self._show(NONE)
        self.report = reason
        if self.screen.is_current:  # otherwise the filter dialog shows the error
            self.failed(reason)

    @property
    def reads(self) -> bool:
        return self.report in _AT_WORK

    # the cursor

    @property
    def alone(self) -> str | None:
        """The word of the current orbit; None if it is the word of the row under the cursor."""
        row, orbit = self.table.row, self._orbit
        word = None if orbit is None else least_rotation(orbit.code)
        return None if row is not None and self._is_row_of(row, word) else word

    def _is_row_of(self, row: Row, word: str | None) -> bool:
        """Tell whether a row is that of a word, or of its class if each class has one row."""
        if word is None or not self.table.source.chosen.by_class:
            return bool(row[0] == word)
        return class_of(row[0]).representative == class_of(word).representative

    def take(self, rows: Pages) -> None:
        """Show new rows.

        If the wanted word or the current orbit now has a row, the cursor goes to it. Otherwise the cursor
        stays on its word, if that is among the rows and not at the top, and an orbit without a row stays.
        """
        row, alone = self.table.row, self.alone
        word = self.wanted or alone or (row[0] if row is not None and self.table.cursor else None)
        place = rows.position(word) if word else None
        self._show(rows, place or 0)
        if alone is None or place is not None:
            self._show_word()
        self.say_place()

    def _show(self, rows: Pages, cursor: int = 0) -> None:
        self.table.show(rows, cursor)
        self.wanted = None
        self._entitle()

    def _entitle(self) -> None:
        self.border_title = "classes" if self.by_class else "words"

    def _show_word(self) -> None:
        """Have the word under the cursor shown, or the current one of its class; with no rows, none."""
        row, orbit = self.table.row, self._orbit
        belongs = row is not None and orbit is not None and self.alone is None
        self.word = least_rotation(orbit.code) if belongs and orbit else row[0] if row else None
        self.say_place()

    def go_to(self, orbit: Orbit | None) -> None:
        """Put the cursor on the row of an orbit, now or once the row arrives."""
        word = None if orbit is None else least_rotation(orbit.code)
        place = self.table.source.position(word) if word else None
        if place is not None:
            self.table.cursor = place
        elif self.reads:
            self.wanted = word
        self.say_place()

    def forget(self) -> None:
        """Show no rows, because those of another stadium are going to be read."""
        self.total = None
        self.say_gaps("")
        self._show(NONE)

    # notes

    def say_gaps(self, gaps: str) -> None:
        note = self.query_one("#unfilled", Static)
        if note.display or gaps:  # otherwise every key would lay out the screen again
            note.display = bool(gaps)
            note.update(gaps)

    def take_orbit(self, orbit: Orbit | None) -> None:
        self._orbit = orbit
        self.say_place()

    def say_place(self) -> None:
        """Show in the border where the cursor is, or that the current orbit has no row."""
        orbit, rows = self._orbit, len(self.table.source)
        total = "…" if self.total is None else f"{rows:,}"
        place = f"{self.table.cursor + 1:,} of {total}" if rows else "no rows"
        if orbit is not None and self.alone:
            place = f"{brief(orbit.code, _SHOWN)} {'has no row here' if orbit.stored else 'is not stored'}"
        self.border_subtitle = place


def _with_key(gap: str) -> str:
    """Add the key that does the same as the command of a note, if there is one."""
    fills = "catalogue.fill(p=" in gap and "geometric" not in gap
    return f"{completed(gap)}, or press f" if fills else in_shell(gap)
