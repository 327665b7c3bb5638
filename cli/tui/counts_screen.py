"""Counts of the chosen subset by status, period, symmetry and time reversal, and histograms of columns."""

import math
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from itertools import pairwise
from typing import Any, ClassVar, NamedTuple

import numpy as np
from rich.console import Console, ConsoleOptions, RenderResult
from rich.style import Style
from rich.table import Table
from rich.text import Text
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Horizontal
from textual.reactive import reactive
from textual.widgets import Footer, OptionList
from textual.widgets.option_list import Option

from orbitdb.answers.completeness import partial_periods
from orbitdb.arrays import Floats, Integers
from orbitdb.catalogue import Catalogue
from orbitdb.cli.output import number
from orbitdb.cli.tui.dialogs import ListDialog, NameList
from orbitdb.cli.tui.help import purpose
from orbitdb.cli.tui.panels.filter_bar import equals
from orbitdb.cli.tui.screens import LEAVING, OwnScreen, TopLine, key
from orbitdb.cli.tui.stored import EVERY
from orbitdb.store.connection import Connection
from orbitdb.store.query import select_words
from orbitdb.store.selection import Selection

_BY = ("status", "p", "symmetry", "time_reversal")
_LEAST_BINS, _MOST_BINS = 8, 40
_EIGHTHS = ("", *"▏▎▍▌▋▊▉")

DRAWN = tuple(name for name in EVERY if name not in ("code", "representative", "cycle"))
"""The columns that a histogram can show: all except those that name a word or a class."""

_FINEST = 1e-12
"""Smallest relative width of a bin; edges closer than this would look the same in print."""

_DECADES = 1000.0
"""Bins are logarithmic if the largest value is more than this many times the smallest."""


class Histogram(NamedTuple):
    """Numbers of rows in the bins of a column, and `without` a value; a value on an edge is in the bin above.

    The shapes are (bins + 1,) and (bins,); the edges ascend, evenly in the logarithm if `logarithmic`.
    """

    edges: Floats
    counts: Integers
    without: int
    logarithmic: bool


def tally(connection: Connection, selection: Selection, columns: Sequence[str]) -> dict[str, Counter[Any]]:
    """Count the rows of a subset by the values of each of some columns of the view ``class``."""
    chosen = select_words(connection, selection, columns=columns)
    words = chosen.counts.tolist()
    tallies: dict[str, Counter[Any]] = {name: Counter() for name in columns}
    for name, numbers in tallies.items():
        for value, count in zip(chosen.values[name].tolist(), words, strict=True):
            numbers[None if value != value else value] += count
    return tallies


def histogram(connection: Connection, selection: Selection, column: str, bins: int) -> Histogram | None:
    """Count the rows of a subset in at most `bins` bins of a numeric column.

    The edges are round numbers, or evenly spaced in the logarithm. Return None if no row has a value.
    """
    chosen = select_words(connection, selection, columns=(column,))
    values, rows = chosen.values[column].astype(np.float64), chosen.counts.astype(np.int64)
    present = ~np.isnan(values)
    if not present.any():
        return None
    low, high = float(values[present].min()), float(values[present].max())
    logarithmic = low > 0 and high > _DECADES * low
    edges = np.geomspace(low, high, bins + 1) if logarithmic else _round_edges(low, high, bins)
    # the outer edges are rounded, so a value may lie an ulp outside
    counts, _ = np.histogram(np.clip(values[present], edges[0], edges[-1]), edges, weights=rows[present])
    return Histogram(edges, counts, int(rows[~present].sum()), logarithmic)


def _round_edges(low: float, high: float, bins: int) -> Floats:
    """Return successive multiples of a round number, such as 0.2 or 2.5, from below `low` to above `high`."""
    width = max((high - low) / bins, _FINEST * abs(high))
    decade = 10.0 ** math.floor(math.log10(width)) if low < high else 1.0
    steps = (decade * factor for factor in (1.0, 2.0, 2.5, 5.0, 10.0, 20.0))
    spans = ((step, math.floor(low / step), math.floor(high / step) + 1) for step in steps)
    step, first, last = next(span for span in spans if span[2] - span[1] <= bins)
    # 3 * 0.1 is an ulp above the 0.3 that a user would type
    return np.asarray([float(f"{step * n:.15g}") for n in range(first, last + 1)])


class Count(NamedTuple):
    """The number of rows for which an SQL condition holds, with a label."""

    label: str
    rows: int
    condition: str


def counts_by(column: str, counts: Mapping[Any, int]) -> list[Count]:
    """Return the count of each value of a column, in the order of the values; rows without one come last."""
    values: list[Any] = sorted(value for value in counts if value is not None)
    valued = [Count(number(column, value), counts[value], equals(column, value)) for value in values]
    return valued + _without(column, counts.get(None, 0))


def counts_in(column: str, histogram: Histogram) -> list[Count]:
    """Return the counts of the bins of a histogram, each labelled with the edges of its bin."""
    digits = 3 if histogram.logarithmic else 15  # linear edges are round numbers with few digits
    edges, bins = histogram.edges.tolist(), []
    for (low, high), count in zip(pairwise(edges), histogram.counts.tolist(), strict=True):
        least, most = f"{column} >= {low!r}", f"{column} < {high!r}"
        inner = [least] * (low != edges[0]) + [most] * (high != edges[-1])  # the outer edges are rounded
        condition = " and ".join(inner) or f"{column} is not null"
        bins.append(Count(f"{low:.{digits}g}–{high:.{digits}g}", count, condition))
    return bins + _without(column, histogram.without)


def _without(column: str, count: int) -> list[Count]:
    return [Count("without", count, equals(column, None))] if count else []


class CountBar(NamedTuple):
    """A bar drawn in eighths of a cell; even a small count is visible."""

    share: float
    style: Style | str

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        eighths = max(round(8 * options.max_width * self.share), 1 if self.share else 0)
        yield Text("█" * (eighths // 8) + _EIGHTHS[eighths % 8], self.style)


def lines_of(counts: Sequence[Count], style: Style | str = "") -> Iterator[Table]:
    """Yield one line per count: its label, the number, and a bar; the longest bar fills the width."""
    labels, numbers = (max((len(text) for text in texts), default=0) for texts in (
        [count.label for count in counts], [f"{count.rows:,}" for count in counts]
    ))  # fmt: skip
    most = max((count.rows for count in counts if count.label != "without"), default=0) or 1
    for label, count, _ in counts:
        line = Table.grid(padding=(0, 1, 0, 0), expand=True)
        line.add_column(justify="right", no_wrap=True, width=labels)
        line.add_column(justify="right", no_wrap=True, width=numbers)
        line.add_column(ratio=1)
        line.add_row(label, f"{count:,}", "" if label == "without" else CountBar(count / most, style))
        yield line


class CountsList(NameList):
    """Counts in groups, each with a title, unless it is empty; enter or a click chooses a count."""

    COMPONENT_CLASSES: ClassVar[set[str]] = {"counts--bar"}
    BINDINGS: ClassVar[list[BindingType]] = purpose(
        "choose rows",
        Binding("enter", "select", "filter", tooltip="by the line under the cursor", key_display="enter"),
    )

    def show(self, groups: Mapping[str, Sequence[Count]]) -> None:
        self.clear_options()
        style = self.get_component_rich_style("counts--bar", partial=True)
        for title, counts in groups.items():
            lines = zip(lines_of(counts, style), counts, strict=True)
            options = [Option(line, f"{title}:{count.condition}") for line, count in lines]
            options = options or [Option("none", disabled=True)]
            if title:
                options = [Option(Text(title, "bold"), disabled=True), *options, Option("", disabled=True)]
            self.add_options(options)
        self.action_first()


class CountsScreen(OwnScreen[str | None]):
    """The number of words of each kind in a subset, and a histogram of one column.

    It closes with the SQL condition of the count that was chosen, if any.
    """

    BINDINGS: ClassVar[list[BindingType]] = [
        *LEAVING,
        *purpose(
            "other",
            key("d", "dismiss", "back", tooltip="to the orbits"),
            Binding("s", "column", "column", tooltip="of the histogram"),
            Binding("right_square_bracket", "next_column(1)", "next column"),
            key("left_square_bracket", "next_column(-1)", "previous column"),
            Binding("e", "export", "save", tooltip="the histogram as a figure"),
        ),
    ]

    column: reactive[str] = reactive("length", init=False, repaint=False)

    def __init__(self, catalogue: Catalogue, selection: Selection, column: str) -> None:
        super().__init__()
        self._catalogue, self._selection = catalogue, selection
        self.set_reactive(CountsScreen.column, column if column in DRAWN else "length")
        self._bins = 0
        self._drawn: Sequence[Count] = ()

    def compose(self) -> ComposeResult:
        yield TopLine()
        with Horizontal(id="counts"):
            yield CountsList(id="tallies")
            yield CountsList(id="histogram")
        yield Footer(show_command_palette=False, compact=True)

    def on_mount(self) -> None:
        self.sub_title = self._selection.describe()
        self.query_one("#tallies").focus().border_title = "counting …"
        self.in_thread("counts", self._count, self._show_tallies)

    def on_resize(self) -> None:
        self.call_after_refresh(self._fit)

    def _fit(self) -> None:
        """Use as many bins as there are lines."""
        lines = self.query_one("#histogram").size.height - 1  # one line is for rows without a value
        bins = max(_LEAST_BINS, min(lines, _MOST_BINS))
        if bins != self._bins:
            self._bins = bins
            self.watch_column(self.column)

    def watch_column(self, column: str) -> None:
        entry, bins = EVERY[column], self._bins
        unit = f" ({entry.unit})" if entry.unit not in ("", "1") else ""
        self.query_one("#histogram").border_title = f"{column}: {entry.brief}{unit}"
        self.in_thread("values", lambda cancelled: self._values(column, bins, cancelled), self._show_values)

    def _count(self, cancelled: Callable[[], bool]) -> tuple[dict[str, list[Count]], str]:
        """Return the counts by each of the columns `_BY`, and a note on partial periods."""
        with self._catalogue.snapshot(cancelled) as connection:
            tallies = tally(connection, self._selection, _BY)
            partly = ", ".join(map(str, partial_periods(connection, self._selection)))
        groups = {name: counts_by(name, counts) for name, counts in tallies.items()}
        return groups, f"partial periods: {partly}" if partly else ""

    def _show_tallies(self, tallies: tuple[dict[str, list[Count]], str]) -> None:
        groups, note = tallies
        box = self.query_one("#tallies", CountsList)
        box.show(groups)
        box.border_title = note or "counts"

    def _values(self, column: str, bins: int, cancelled: Callable[[], bool]) -> tuple[list[Count], str]:
        """Return the counts of the values of a column, or of ranges of its values, and a note."""
        with self._catalogue.snapshot(cancelled) as connection:
            if EVERY[column].kind != "number":  # integers or texts
                return counts_by(column, tally(connection, self._selection, (column,))[column]), ""
            binned = histogram(connection, self._selection, column, bins)
        if binned is None:
            return [], ""
        even = "bins of equal width in the logarithm" if binned.logarithmic else ""
        return counts_in(column, binned), even

    def _show_values(self, values: tuple[list[Count], str]) -> None:
        self._drawn, note = values
        self.query_one("#histogram", CountsList).show({"": self._drawn})
        self.query_one("#histogram").border_subtitle = note

    def on_option_list_option_selected(self, message: OptionList.OptionSelected) -> None:
        self.dismiss((message.option_id or "").partition(":")[2] or None)

    def action_export(self) -> None:
        from orbitdb.cli.tui.export import ask_for_file, save_figure

        counts = [(label, count) for label, count, _ in self._drawn if label != "without"]
        column, title = self.column, self._selection.describe()
        if not counts:
            self.notify("there is nothing to draw")
            return
        draw = partial(save_figure, "screen.counts", (counts, column, title))
        ask_for_file(self, f"{column}.png", f"the histogram of {column}", draw)

    def action_column(self) -> None:
        named = {name: name for name in DRAWN}
        self.ask(ListDialog("histogram of", "", named, self.column), partial(setattr, self, "column"))

    def action_next_column(self, step: int) -> None:
        self.column = DRAWN[(DRAWN.index(self.column) + step) % len(DRAWN)]
