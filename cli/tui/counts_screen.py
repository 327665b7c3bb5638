"""Counts of the chosen subset by status, period, symmetry and time reversal, and histograms of columns."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Any, ClassVar

from rich.bar import Bar
from rich.console import Console, ConsoleOptions, Group, RenderableType, RenderResult
from rich.table import Table
from rich.text import Text
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Horizontal
from textual.reactive import reactive
from textual.widgets import Footer, Header, Static

from orbitdb.answers.completeness import partial_fills
from orbitdb.answers.counts import Histogram, histogram, marginal, tally
from orbitdb.cli.render import number
from orbitdb.cli.tui.dialogs import ChoiceDialog
from orbitdb.cli.tui.screens import LEAVING, OwnScreen, ScrollBox, key
from orbitdb.cli.tui.view import EVERY
from orbitdb.columns import IN_CATALOGUE
from orbitdb.store.asking.selection import Selection
from orbitdb.store.reading.moment import Reader

_BY = ("status", "p", "symmetry", "time_reversal")
_MOST_BINS = 40
_LEAST_BINS = 8
_COLUMNS = {column.name: column for column in IN_CATALOGUE}

Counts = Sequence[tuple[str, int]]
"""Pairs of a label and a count."""

DRAWN = tuple(name for name in EVERY if name not in ("code", "representative", "cycle"))
"""The columns that a histogram can show: all except those that name a word or a class."""


def counts_by(column: str, counts: Mapping[Any, int]) -> Counts:
    """Return the count of each value of a column, labelled with that value, in the order of the values."""
    known = sorted(value for value in counts if value is not None)
    return [(number(column, value), counts[value]) for value in known]


def counts_in(histogram: Histogram) -> Counts:
    """Return the counts of the bins of a histogram, each labelled with the edges of its bin."""
    digits = 3 if histogram.logarithmic else 15  # linear edges are round numbers with few digits
    labels = (f"{low:.{digits}g}–{high:.{digits}g}" for low, high in pairwise(histogram.edges.tolist()))
    return list(zip(labels, histogram.counts.tolist(), strict=True))


class CountBar(Bar):
    """A bar drawn in eighths of a cell, so that even a small count is visible."""

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        if self.end:
            self.end = max(self.end, 1.01 * self.size / (8 * options.max_width))
        return super().__rich_console__(console, options)


def bars(counts: Counts, without: int = 0) -> RenderableType:
    """Return one line per count: its label, the number, and a bar; the longest bar fills the width.

    A last line gives the number of rows without a value, if there are any.
    """
    if not counts and not without:
        return "none"
    most = max((count for _, count in counts), default=0)
    table = Table.grid(padding=(0, 1, 0, 0), expand=True)
    table.add_column(justify="right", no_wrap=True)
    table.add_column(justify="right", no_wrap=True)
    table.add_column(ratio=1)
    for label, count in counts:
        table.add_row(label, f"{count:,}", CountBar(most, 0, count))
    if without:
        table.add_row("without", f"{without:,}")
    return table


class CountsScreen(OwnScreen[str | None]):
    """The number of words of each kind in a subset, and a histogram of one column."""

    BINDING_GROUP_TITLE = "Counts"
    BINDINGS: ClassVar[list[BindingType]] = [
        *LEAVING,
        key("d", "dismiss", "back", tooltip="to the orbits"),
        Binding("s", "column", "column", tooltip="of the histogram"),
        Binding("right_square_bracket", "next_column(1)", "next column"),
        key("left_square_bracket", "next_column(-1)", "previous column"),
        Binding("e", "export", "export", tooltip="the histogram as a figure"),
    ]

    column: reactive[str] = reactive("length", init=False, repaint=False)

    def __init__(self, catalogue: Reader, selection: Selection, column: str) -> None:
        super().__init__()
        self._catalogue, self._selection = catalogue, selection
        self.set_reactive(CountsScreen.column, column if column in DRAWN else "length")
        self._bins = 0
        self._drawn: Counts = ()

    def compose(self) -> ComposeResult:
        """Lay out the counts and the histogram."""
        yield Header()
        with Horizontal(id="counts"):
            for name in ("tallies", "histogram"):
                with ScrollBox(id=name):
                    yield Static("counting …")
        yield Footer(show_command_palette=False, compact=True)

    def on_mount(self) -> None:
        """Start counting."""
        self.sub_title = self._selection.describe()
        self.query_one("#tallies").border_title = "counts"
        self.query_one("#tallies").focus()
        self.in_thread("counts", self._count, partial(self._show, "#tallies"))

    def on_resize(self) -> None:
        """Use as many bins as lines fit on the screen."""
        self.call_after_refresh(self._fit)

    def _fit(self) -> None:
        lines = self.query_one("#histogram").size.height - 1  # one line is for rows without a value
        bins = max(_LEAST_BINS, min(lines, _MOST_BINS))
        if bins != self._bins:
            self._bins = bins
            self.watch_column(self.column)

    def watch_column(self, column: str) -> None:
        """Count the values of another column for the histogram."""
        known, bins = _COLUMNS[column], self._bins
        unit = f" ({known.unit})" if known.unit not in ("", "1") else ""
        self.query_one("#histogram").border_title = f"{column}: {known.brief}{unit}"
        self.in_thread("values", lambda cancelled: self._values(column, bins, cancelled), self._take_values)

    def _count(self, cancelled: Callable[[], bool]) -> tuple[RenderableType, str]:
        """Return the counts by each of the columns `_BY`, and a note on partial periods."""
        with self._catalogue.moment() as moment:
            found = tally(moment, self._selection, _BY, cancelled)
            partly = ", ".join(str(fill.p) for fill in partial_fills(moment, self._selection))
        parts: list[RenderableType] = []
        for place, name in enumerate(_BY):
            counts = marginal(found, place)
            parts += [Text(name, "bold"), bars(counts_by(name, counts), counts.get(None, 0)), ""]
        return Group(*parts), f"partial periods: {partly}" if partly else ""

    def _values(self, column: str, bins: int, cancelled: Callable[[], bool]) -> tuple[Counts, int, str]:
        """Return the counts of the values of a column, the number of rows without a value, and a note."""
        with self._catalogue.moment() as moment:
            if _COLUMNS[column].kind != "number":  # integers or texts
                values = marginal(tally(moment, self._selection, (column,), cancelled), 0)
                return counts_by(column, values), values.get(None, 0), ""
            found = histogram(moment, self._selection, column, bins, cancelled)
        if found is None:
            return (), 0, ""
        even = "bins of equal width in the logarithm" if found.logarithmic else ""
        return counts_in(found), found.without, even

    def _take_values(self, found: tuple[Counts, int, str]) -> None:
        self._drawn, without, note = found
        self._show("#histogram", (bars(self._drawn, without), note))

    def _show(self, box: str, found: tuple[RenderableType, str]) -> None:
        drawn, self.query_one(box).border_subtitle = found
        self.query_one(f"{box} Static", Static).update(drawn)

    def action_export(self) -> None:
        """Save the histogram as a figure."""
        from orbitdb.cli.tui.export import ask_for_file, save_figure

        counts, column, title = self._drawn, self.column, self._selection.describe()
        if not counts:
            self.notify("there is nothing to draw")
            return

        def write(path: Path, _: object) -> str:
            return save_figure(path, lambda figures: figures.draw_counts(counts, column, title))

        ask_for_file(self, f"{column}.png", write, f"the histogram of {column}")

    def action_column(self) -> None:
        """Choose the column of the histogram from a list."""
        named = {name: name for name in DRAWN}
        self.ask(ChoiceDialog("histogram of", "", named, self.column), partial(setattr, self, "column"))

    def action_next_column(self, step: int) -> None:
        """Show the histogram of the next or previous column."""
        self.column = DRAWN[(DRAWN.index(self.column) + step) % len(DRAWN)]
