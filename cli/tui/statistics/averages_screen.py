"""The statistics screen: Table 1, entropies and Lyapunov averages of the chosen subset."""

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import replace
from functools import partial
from typing import ClassVar

from rich.table import Table
from textual.app import ComposeResult
from textual.binding import Binding
from textual.containers import Horizontal
from textual.widgets import Footer, Header, Static

from orbitdb.averages.fixed_points import Weight
from orbitdb.billiard.stadium import Stadium
from orbitdb.catalogue.catalogue import Catalogue
from orbitdb.catalogue.results import Result
from orbitdb.cli.tui.orbit.drawing import Plot
from orbitdb.cli.tui.screens import RETURN, Keys, OwnScreen, ScrollBox, bindings
from orbitdb.cli.tui.statistics.averages import COLUMNS, curves_of, statistics, table_of
from orbitdb.errors import InputError
from orbitdb.numerals import with_error
from orbitdb.store.asking.selection import Selection
from orbitdb.trajectories.ensemble import Reference, references

FIRST_BOUNCES = 6_000_000
_FIRST = 11
"""The highest period of which the averages are there at once."""
_TITLES = {"entropy": "topological entropy", "lambda_d": "λ per bounce", "lambda_c": "λ per length"}
_WEIGHTS = {Weight.EXPONENTIAL: "weights e^-λ", Weight.DETERMINANT: "weights 1/|det(1 - M)|"}


class StatisticsScreen(OwnScreen[None]):
    """Averages over the chosen orbits by period, as tables and curves."""

    KEYS: ClassVar[Keys] = {
        "statistics": [
            *RETURN,
            Binding("w", "weight", "weight", tooltip="the other weight"),
            Binding("t", "trajectories", "trajectories", tooltip="follow more trajectories"),
        ]
    }
    BINDINGS = bindings(KEYS)

    def __init__(self, catalogue: Catalogue, selection: Selection) -> None:
        super().__init__()
        self._catalogue, self._selection = catalogue, selection
        self.found: Result | None = None
        self.reference: Reference | None = None
        self._weight = Weight.EXPONENTIAL
        self._kept = ""
        self._bounces = FIRST_BOUNCES

    def compose(self) -> ComposeResult:
        """Lay out the table and the curves."""
        yield Header()
        with ScrollBox(id="numbers-box"):
            yield Static("reading …", id="numbers")
        yield Static("trajectories …", id="reference", markup=False)
        with Horizontal(id="plots"):
            for name in _TITLES:
                yield Plot(id=f"plot-{name}")
        yield Footer(show_command_palette=False, compact=True)

    def on_mount(self) -> None:
        """Begin to compute."""
        self.sub_title = self._selection.describe()
        for name, title in _TITLES.items():
            self.query_one(f"#plot-{name}").border_title = title
        self.query_one("#numbers-box").focus()
        self._compute()
        self._refer()

    def _compute(self) -> None:
        weight = self._weight
        self.in_thread("numbers", lambda _: self._averages(weight), self._take)

    def _averages(self, weight: Weight) -> Iterator[Result]:
        """Average over the first periods, which takes no time, and then over all, if there are more."""
        chosen = self._selection
        spans = chosen.periods or ((2, _FIRST),)
        first = tuple((low, min(high, _FIRST)) for low, high in spans if low <= _FIRST)
        if first and any(
            fill.p > _FIRST and chosen.includes(fill.p) for fill in self._catalogue.fills(chosen.a)
        ):
            with suppress(InputError):  # there may be none of them
                yield statistics(self._catalogue, replace(chosen, periods=first), weight)
        yield statistics(self._catalogue, chosen, weight)

    def _take(self, found: Result) -> None:
        self.found = found
        self._show()

    def _refer(self, anew: bool = False) -> None:
        found = partial(self._references, self._bounces, anew)
        self.in_thread("trajectories", lambda _: found(), lambda each: self.take_reference(*each))

    def _references(self, bounces: int, anew: bool) -> Iterator[tuple[Reference, float, bool]]:
        """Yield the stored reference if there is one; else, or to have another, follow trajectories."""
        stored = None if anew else self._catalogue.reference(self._selection.a)
        if stored is not None:
            yield stored, 1.0, True
            return
        seed = bounces // FIRST_BOUNCES  # others each time
        for done, reference in references(Stadium(self._selection.a), bounces, seed):
            yield reference, done, False

    def take_reference(self, new: Reference, done: float, stored: bool) -> None:
        """Show the better value; until one is whole, of which a share is done, the one so far."""
        old = self.reference
        source = "stored" if stored else f"{new.bounces:.2g} bounces followed here"
        if done < 1 and self._kept:
            followed = f"following more: {done:.0%}"
        elif self._kept and old is not None and old.lambda_d_error <= new.lambda_d_error:
            followed = f"{source}, not as good: {_described(new)}"
        else:
            self._kept, followed = (source, "") if done >= 1 else ("", f"{done:.0%}")
            self.reference = old = new
        assert old is not None
        parts = (f"trajectories: {_described(old)}", self._kept, followed)
        self.query_one("#reference", Static).update("; ".join(filter(None, parts)))
        self._show()

    def failed(self, reason: str) -> None:
        """Say what went wrong where the numbers would be, too."""
        super().failed(reason)
        self.found = None
        self.query_one("#numbers", Static).update(reason)

    def _show(self) -> None:
        """Show the numbers and the curves."""
        if self.found is None:
            return
        self.query_one("#numbers-box").border_title = _WEIGHTS[self._weight]
        self.query_one("#numbers", Static).update(_as_table(self.found))
        for name, curves in curves_of(self.found, self.reference).items():
            self.query_one(f"#plot-{name}", Plot).curves = curves

    def action_weight(self) -> None:
        """Take the other weight."""
        self._weight = next(weight for weight in Weight if weight is not self._weight)
        self._compute()

    def action_trajectories(self) -> None:
        """Follow other trajectories, four times as many as the last time; the better value is kept."""
        self._bounces *= 4
        self._refer(anew=True)


def _described(one: Reference) -> str:
    values = (("λ_d", one.lambda_d, one.lambda_d_error), ("λ_c", one.lambda_c, one.lambda_c_error))
    return ", ".join(f"{name} {with_error(value, error, '±')}" for name, value, error in values)


def _as_table(found: Result) -> Table:
    table = Table(box=None, padding=(0, 1, 0, 0), pad_edge=False, header_style="bold")
    for name in COLUMNS:
        heading = "±" if name.endswith("_error") else name.replace("lambda", "λ")
        table.add_column(heading, justify="right", no_wrap=True)
    for row in table_of(found):
        table.add_row(*row)
    table.caption = "; ".join((*found.facts, *found.notes))
    return table
