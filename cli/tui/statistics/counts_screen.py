"""Counts of the chosen subset: by status, period and symmetry, and how the values of any column spread."""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, ClassVar

from rich.text import Text
from textual.app import ComposeResult
from textual.binding import Binding
from textual.containers import Horizontal
from textual.reactive import reactive
from textual.widgets import Footer, Header, Static

from orbitdb.cli.tui.dialogs.basic import ChoiceDialog
from orbitdb.cli.tui.screens import RETURN, Keys, OwnScreen, ScrollBox, bindings, key
from orbitdb.cli.tui.statistics.bars import (
    DRAWN,
    Counts,
    counts_by,
    counts_in,
    is_measured,
    lines_of,
    title_of,
)
from orbitdb.cli.tui.table.columns import EVERY
from orbitdb.store.asking.selection import Selection

if TYPE_CHECKING:
    from orbitdb.catalogue.catalogue import Catalogue

_BY = ("status", "p", "symmetry", "time_reversal")
_MOST_BINS = 40
_LEAST_BINS = 8

Spread = tuple[Counts, int, str]
"""Counts, how many rows have no value, and a note."""


class CountsScreen(OwnScreen[None]):
    """How many words of a subset there are of each kind, and a histogram of one column or another."""

    KEYS: ClassVar[Keys] = {
        "counts": [
            *RETURN,
            key("d", "dismiss"),
            Binding("s", "column", "column", tooltip="histogram of another column"),
            Binding("right_square_bracket", "next_column(1)", "next column"),
            key("left_square_bracket", "next_column(-1)", "column before"),
        ]
    }
    BINDINGS = bindings(KEYS)

    column: reactive[str] = reactive("length", init=False, repaint=False)

    def __init__(self, catalogue: "Catalogue", selection: Selection, column: str) -> None:
        super().__init__()
        self._catalogue, self._selection = catalogue, selection
        self.set_reactive(CountsScreen.column, column if column in DRAWN else "length")
        self._counts: Sequence[tuple[str, Counts, int]] = ()
        self._spread: Spread | None = None
        self._bins = 0

    def compose(self) -> ComposeResult:
        """Lay out the counts and the histogram."""
        yield Header()
        with Horizontal(id="counts"):
            for name in ("tallies", "histogram"):
                with ScrollBox(id=name):
                    yield Static("counting …")
        yield Footer(show_command_palette=False, compact=True)

    def on_mount(self) -> None:
        """Begin to count."""
        self.sub_title = self._selection.describe()
        self.query_one("#tallies").border_title = "counts"
        self.query_one("#tallies").focus()
        self.in_thread("counts", self._count, self._take_counts)

    def on_resize(self) -> None:
        """Take as many bins as there are lines."""
        self.call_after_refresh(self._fit)

    def _fit(self) -> None:
        lines = self.query_one("#histogram").size.height - 1  # one for those without a value
        bins = max(_LEAST_BINS, min(lines, _MOST_BINS))
        if bins != self._bins:
            self._bins = bins
            self.watch_column(self.column)
        self._show()

    def watch_column(self, column: str) -> None:
        """Count the values of another column."""
        self.query_one("#histogram").border_title = title_of(column)
        bins = self._bins
        self.in_thread("values", lambda cancelled: self._values(column, bins, cancelled), self._take_values)

    def _count(self, cancelled: Callable[[], bool]) -> tuple[Sequence[tuple[str, Counts, int]], str]:
        """Return the counts by each of some columns, and which periods are stored in part."""
        from orbitdb.catalogue.tallies import marginal, tally

        with self._catalogue.at_one_moment() as still:
            found = tally(still, self._selection, _BY, cancelled)
            partial = ", ".join(str(fill.p) for fill in still.partial(self._selection))
        by = [(name, marginal(found, place)) for place, name in enumerate(_BY)]
        return [(name, counts_by(name, each), each.get(None, 0)) for name, each in by], partial

    def _values(self, column: str, bins: int, cancelled: Callable[[], bool]) -> Spread:
        from orbitdb.catalogue.tallies import histogram, marginal, tally

        if not is_measured(column):
            values = marginal(tally(self._catalogue, self._selection, (column,), cancelled), 0)
            return counts_by(column, values), values.get(None, 0), ""
        found = histogram(self._catalogue, self._selection, column, bins, cancelled)
        if found is None:
            return (), 0, ""
        return counts_in(found), found.without, "bins even in the logarithm" if found.logarithmic else ""

    def _take_counts(self, found: tuple[Sequence[tuple[str, Counts, int]], str]) -> None:
        self._counts, partial = found
        self.query_one("#tallies").border_subtitle = f"p = {partial}: partial" if partial else ""
        self._show()

    def _take_values(self, found: Spread) -> None:
        self._spread = found
        self.query_one("#histogram").border_subtitle = found[2]
        self._show()

    def _show(self) -> None:
        """Write all that is known, to the widths that there are."""
        box = self.query_one("#tallies")
        text, width = Text(), box.scrollable_content_region.width
        for name, counts, without in self._counts:
            text.append(f"{name}\n", "bold")
            text.append("\n".join(lines_of(counts, width, without)) + "\n\n")
        if self._counts:
            box.query_one(Static).update(text)
        box = self.query_one("#histogram")
        if self._spread is not None:
            counts, without, _ = self._spread
            lines = lines_of(counts, box.scrollable_content_region.width, without)
            box.query_one(Static).update(Text("\n".join(lines)))

    def action_column(self) -> None:
        """Choose the column from a list."""

        def take(column: str | None) -> None:
            if column is not None:
                self.column = column

        named = {name: EVERY[name].heading for name in DRAWN}
        self.app.push_screen(ChoiceDialog("histogram of", named, self.column), take)

    def action_next_column(self, step: int) -> None:
        """Take the next column, or the one before."""
        self.column = DRAWN[(DRAWN.index(self.column) + step) % len(DRAWN)]
