"""The statistics screen: counts as in Table 1, entropies and Lyapunov averages of a subset, with curves."""

from dataclasses import replace
from functools import partial
from typing import ClassVar

import numpy as np
from rich.table import Table
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Container
from textual.widgets import Static

from orbitdb.answers.lyapunov import AVERAGES, EXPONENTS
from orbitdb.answers.results import PROVED, Result
from orbitdb.averages.by_period import Weight
from orbitdb.billiard.stadium import Stadium
from orbitdb.catalogue import Catalogue
from orbitdb.cli.output import number
from orbitdb.cli.tui.help import KeysLine, purpose
from orbitdb.cli.tui.panels.canvas import Curve, Plot
from orbitdb.cli.tui.screens import LEAVING, OwnScreen, ScrollBox, TopLine, in_shell
from orbitdb.errors import InputError
from orbitdb.orbits.status import Status
from orbitdb.period_ranges import written_periods
from orbitdb.selection import Selection
from orbitdb.text import concise, with_error
from orbitdb.trajectories.ensemble import Reference, references

FIRST_BOUNCES = 6_000_000
FIRST = 11
"""Averages up to this period are shown unasked, because they take little time."""
_NO_TRAJECTORIES = "no trajectories are stored: press t to follow some, for a few seconds"
_TITLES = {
    "entropy": "topological entropy",
    "lambda_d": "lambda_d, per bounce",
    "lambda_c": "lambda_c, per unit length",
}
_WEIGHTS = {Weight.EXPONENTIAL: "weights e^-lambda", Weight.DETERMINANT: "weights 1/|det(1 - M)|"}


def columns() -> tuple[str, ...]:
    """Return the columns of the table; averages with an error come before those without."""
    pairs = [(average, exponent) for exponent in EXPONENTS for average in AVERAGES]
    first = [average.of(exponent) for average, exponent in pairs if average.error]
    others = [average.of(exponent) for average, exponent in pairs if not average.error]
    return ("p", "N_t", "N_c", "classes", "N", "K_0", "h_zeta", *first, *others)


def curves_of(result: Result, reference: Reference | None) -> dict[str, list[Curve]]:
    """Return the curves of the entropy, and of the Lyapunov exponents per bounce and per unit length."""
    shown = {
        name: np.array(values, dtype=float) for name, values in result.columns.items() if name != PROVED[2]
    }
    p = shown["p"]
    curves = {
        "entropy": [
            Curve("one", "K_0", p, shown["K_0"]),
            Curve("two", "zeta", p, shown["h_zeta"], "×"),
            Curve("six", "proved", p, shown["h_lower"]),
            Curve("six", "", p, shown["h_upper"]),
        ]
    }
    for name in EXPONENTS:
        curves[name] = [
            Curve(average.ink, average.brief, p, shown[average.of(name)], average.marker)
            for average in sorted(AVERAGES, key=lambda average: not average.error)
        ]
        for average in AVERAGES:
            if average.error:
                value, error = shown[average.of(name)], shown[f"{average.of(name)}_error"]
                curves[name].append(Curve("six", f"error of {average.brief}", p, value - error))
                curves[name].append(Curve("six", "", p, value + error))
        if reference is not None:
            level = np.full_like(p, getattr(reference, name))
            curves[name].insert(0, Curve("five", "trajectories", p, level))
    return curves


class StatisticsScreen(OwnScreen[str | None]):
    """Averages over the chosen orbits by period, as a table and as curves."""

    BINDINGS: ClassVar[list[BindingType]] = [
        *LEAVING,
        *purpose(
            "other",
            Binding("w", "weight", "weight", tooltip="switch the weight: exp or det"),
            Binding("e", "export", "save", tooltip="save the curves as a figure"),
            Binding("m", "more", "more", tooltip="show more periods, which takes longer"),
            Binding("t", "trajectories", "trajectories", tooltip="follow more trajectories to compare"),
        ),
    ]

    def __init__(self, catalogue: Catalogue, selection: Selection) -> None:
        super().__init__()
        self._catalogue, self._selection = catalogue, selection
        self.result: Result | None = None
        self.reference: Reference | None = None
        self._weight = Weight.EXPONENTIAL
        self._everything, self._rest = False, ""
        self._bounces = FIRST_BOUNCES

    def compose(self) -> ComposeResult:
        yield TopLine()
        with ScrollBox(id="statistics"):
            yield Static("reading …", id="numbers")
            yield Static(id="notes", markup=False)
            yield Static(_NO_TRAJECTORIES, id="reference")
            with Container(id="plots"):
                for name in _TITLES:
                    yield Plot(id=f"plot-{name}")
        yield KeysLine()

    def on_mount(self) -> None:
        """Show what takes no time: the first periods, and stored trajectories."""
        self.sub_title = self._selection.describe()
        for name, title in _TITLES.items():
            self.query_one(f"#plot-{name}").border_title = title
        self.query_one("#statistics").focus()
        self._compute()
        stored = partial(self._catalogue.reference, a=self._selection.a)
        self.in_thread("trajectories", lambda _: stored(), self._show_stored)

    def _compute(self) -> None:
        weight, everything = self._weight, self._everything
        self.in_thread("numbers", lambda _: self.averages(weight, everything), self._take)

    def averages(self, weight: Weight, everything: bool = False) -> tuple[Result | None, str]:
        """Return the averages over the first periods, which are fast, or over all; and a note on the rest."""
        chosen = self._selection.preferring((Status.ORBIT,))
        fills = self._catalogue.fills(a=chosen.a)
        later = [fill.p for fill in fills if fill.p > FIRST and chosen.includes(fill.p)]
        if everything or not later:
            every = self._catalogue.statistics(chosen, weight=weight)
            if not len(every):
                raise InputError("; ".join(every.notes))
            return every, ""
        spans = chosen.periods or ((2, FIRST),)
        first = tuple((low, min(high, FIRST)) for low, high in spans if low <= FIRST)
        found = self._catalogue.statistics(replace(chosen, periods=first), weight=weight) if first else None
        return found if found is not None and len(found) else None, f"{written_periods(later)}: press m"

    def _take(self, averages: tuple[Result | None, str]) -> None:
        self.result, self._rest = averages
        self._show()

    def _show_stored(self, reference: Reference | None) -> None:
        if reference is not None:
            self.take_reference(1.0, reference, True)

    def action_trajectories(self) -> None:
        """Follow new trajectories, four times as many each time."""
        bounces, self._bounces = self._bounces, 4 * self._bounces
        seed = bounces // FIRST_BOUNCES  # different trajectories each time
        follow = partial(references, Stadium(self._selection.a), bounces, seed)
        self.in_thread("trajectories", lambda _: follow(), lambda step: self.take_reference(*step))

    def take_reference(self, done: float, reference: Reference, stored: bool = False) -> None:
        """Show averages over trajectories: stored or new ones, or those so far; draw the most accurate."""
        if self.reference is None or reference.lambda_d_error <= self.reference.lambda_d_error:
            self.reference = reference
        source = "stored" if stored else f"{reference.bounces:.2g} bounces, computed now"
        text = f"trajectories: {_described(reference)}; {source if done >= 1 else f'{done:.0%}'}"
        self.query_one("#reference", Static).update(text)
        self._show()

    def failed(self, reason: str) -> None:
        super().failed(reason)
        self.result = None
        self._show(reason)

    def _show(self, failure: str = "") -> None:
        box, notes = self.query_one("#statistics"), [failure or self._rest]
        box.border_title = _WEIGHTS[self._weight]
        self.query_one("#plots").display = self.result is not None
        self.query_one("#numbers", Static).update("" if self.result is None else _as_table(self.result))
        if self.result is not None:
            notes += [*self.result.facts, *self.result.notes]
            for name, curves in curves_of(self.result, self.reference).items():
                self.query_one(f"#plot-{name}", Plot).curves = curves
        self.query_one("#notes", Static).update(in_shell("; ".join(filter(None, notes))))

    def action_export(self) -> None:
        from orbitdb.cli.tui.export import ask_for_file, save_figure

        if self.result is None:
            return
        shown = (self.result, self.reference, self._selection.describe())
        draw = partial(save_figure, "screen.statistics", shown)
        ask_for_file(self, "statistics.png", "the three plots, one below another", draw)

    def action_weight(self) -> None:
        self._weight = next(weight for weight in Weight if weight is not self._weight)
        self._compute()

    def action_more(self) -> None:
        self._everything = True
        self._compute()


def _described(one: Reference) -> str:
    values = (("lambda_d", one.lambda_d, one.lambda_d_error), ("lambda_c", one.lambda_c, one.lambda_c_error))
    return ", ".join(f"{name} {with_error(value, error, '±')}" for name, value, error in values)


def _as_table(result: Result) -> Table:
    table = Table(box=None, padding=(0, 2, 0, 0), pad_edge=False, header_style="bold")
    names = columns()
    short = {
        average.of(exponent): f"λ{exponent.removeprefix('lambda')}\n{average.brief}"
        for exponent in EXPONENTS
        for average in AVERAGES
    }
    for name in names:
        table.add_column(short.get(name, f"\n{name}"), justify="right", no_wrap=True)
    errors = [result.columns.get(f"{name}_error") for name in names]
    for place, row in enumerate(result.rows(names)):
        cells = zip(names, row, errors, strict=True)
        table.add_row(*(concise(x, error[place]) if error else number(name, x) for name, x, error in cells))
    return table
