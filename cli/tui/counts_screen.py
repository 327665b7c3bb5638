"""Counts of the chosen subset by status, period, symmetry and time reversal, and histograms of columns."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from itertools import pairwise
from typing import ClassVar, NamedTuple

from rich.console import Console, ConsoleOptions, RenderResult
from rich.style import Style
from rich.table import Table
from rich.text import Text
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Horizontal
from textual.reactive import reactive
from textual.widgets import OptionList
from textual.widgets.option_list import Option

from orbitdb.answers.histogram import COUNTABLE, MEASURED, Histogram
from orbitdb.answers.results import Result
from orbitdb.catalogue import Catalogue
from orbitdb.cli.output import number
from orbitdb.cli.tui.dialogs import ListDialog, NameList
from orbitdb.cli.tui.help import KeysLine, purpose
from orbitdb.cli.tui.panels.filter_bar import equals
from orbitdb.cli.tui.screens import LEAVING, OwnScreen, TopLine, key
from orbitdb.cli.tui.stored import SHOWABLE
from orbitdb.criteria import OF_STATUS
from orbitdb.orbits.status import STORED
from orbitdb.selection import Selection

_BY = ("status", "p", "symmetry", "time_reversal")
_LEAST_BINS, _MOST_BINS = 8, 40
_EIGHTHS = ("", *"▏▎▍▌▋▊▉")

DRAWN = tuple(name for name in SHOWABLE if name in COUNTABLE)
"""The columns that a histogram can show, in the order of the table."""


def _unit(column: str) -> str:
    """Return the unit of a column in brackets, to follow its name; empty if it has none."""
    unit = SHOWABLE[column].unit
    return f" ({unit})" if unit not in ("", "1") else ""


class Count(NamedTuple):
    """The number of rows for which an SQL condition holds, with a label."""

    label: str
    rows: int
    condition: str


def counts_by(column: str, counted: Result) -> list[Count]:
    """Return the count of each value of a column, in the order of the values; rows without one come last."""
    return [
        Count("without" if value is None else number(column, value), words, equals(column, value))
        for value, words in counted.rows((column, "words"))
    ]


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
        Binding("enter", "select", "filter", tooltip="filter by this line", key_display="enter"),
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
            key("d", "dismiss", "return to the orbits"),
            Binding("s", "column", "column", tooltip="choose the column of the histogram"),
            Binding("right_square_bracket", "next_column(1)", "next column"),
            key("left_square_bracket", "next_column(-1)", "previous column"),
            Binding("e", "export", "save", tooltip="save the histogram as a figure"),
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
        yield KeysLine()

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
        bins = self._bins
        self.query_one("#histogram").border_title = f"{column}: {SHOWABLE[column].brief}{_unit(column)}"
        self.in_thread("values", lambda cancelled: self._values(column, bins, cancelled), self._show_values)

    def _count(self, cancelled: Callable[[], bool]) -> tuple[dict[str, list[Count]], str]:
        """Return the counts by each of the columns `_BY`, and a note on partial periods."""
        chosen = self._selection
        with self._catalogue.snapshot(cancelled) as then:
            tallies = {name: self._by(then, name) for name in _BY}
            fills = then.fills(a=chosen.a)
        partly = ", ".join(str(fill.p) for fill in fills if chosen.includes(fill.p) and not fill.done)
        groups = {self._title(name): counts_by(name, counted) for name, counted in tallies.items()}
        return groups, f"partial periods: {partly}" if partly else ""

    def _by(self, then: Catalogue, column: str) -> Result:
        return then.count(self._counted(column), by=[column])

    def _counted(self, column: str) -> Selection:
        """Return the words to count by a column: for the status, those of every status, as `count` does.

        If other statuses than the usual ones were chosen, only these are counted.
        """
        return self._selection.preferring(STORED) if column in OF_STATUS else self._selection

    def _title(self, column: str) -> str:
        return column if self._counted(column) == self._selection else f"{column}, of all words"

    def _show_tallies(self, tallies: tuple[dict[str, list[Count]], str]) -> None:
        groups, note = tallies
        box = self.query_one("#tallies", CountsList)
        box.show(groups)
        box.border_title = note or "counts"

    def _values(self, column: str, bins: int, cancelled: Callable[[], bool]) -> tuple[list[Count], str]:
        """Return the counts of the values of a column, or of ranges of its values, and a note."""
        with self._catalogue.snapshot(cancelled) as then:
            if column not in MEASURED:  # integers or texts
                return counts_by(column, self._by(then, column)), ""
            binned = then.histogram(column, self._selection, bins=bins)
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
        draw = partial(save_figure, "screen.counts", (counts, f"{column}{_unit(column)}", title))
        ask_for_file(self, f"{column}.png", f"the histogram of {column}", draw)

    def action_column(self) -> None:
        named = {name: name for name in DRAWN}
        self.ask(ListDialog("histogram of", "", named, self.column), partial(setattr, self, "column"))

    def action_next_column(self, step: int) -> None:
        self.column = DRAWN[(DRAWN.index(self.column) + step) % len(DRAWN)]
