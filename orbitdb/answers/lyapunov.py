"""Lyapunov averages by period: `Catalogue.lyapunov`, the registry of its methods, and `.statistics`.

To add an average, add an entry to `AVERAGES`; tables, files, the figure and the screen follow.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from orbitdb.answers.complete_periods import (
    CompletePeriods,
    all_orbits,
    if_avoiding,
    read_noted,
    sum_rules_of,
    why_no_lambda,
    why_no_sum_rules,
)
from orbitdb.answers.entropy import enclosure, entropy_of_rows, outside
from orbitdb.answers.results import TRAJECTORIES, UP_TO_CUT, Result
from orbitdb.arrays import Floats
from orbitdb.averages import pseudocycles
from orbitdb.averages.by_period import (
    Lyapunov,
    Weight,
    every_period,
    lyapunov_of_periods,
    none_where_incomplete,
    of_divisors,
    of_pairs,
)
from orbitdb.averages.exact_means import exact_means
from orbitdb.averages.sum_rules import SumRules
from orbitdb.billiard.stadium import Stadium
from orbitdb.columns import Column
from orbitdb.errors import InputError, check_number
from orbitdb.orbits.least_values import least_exponent
from orbitdb.progress import Tell, nobody
from orbitdb.selection import Selection
from orbitdb.store.sqlite import Connection
from orbitdb.store.stored_values import best_reference
from orbitdb.symbols.pruning import count_admissible
from orbitdb.text import format_float, with_error

_LARGEST_CUT = 1000
MOST_FACTORS = 100_000

EXPONENTS = ("lambda_d", "lambda_c")


@dataclass(frozen=True)
class AverageInputs:
    """The chosen orbits of complete periods, and the quantities that several averages share."""

    subset: CompletePeriods
    weight: Weight

    @cached_property
    def sums(self) -> Lyapunov:
        """The averages over fixed points and by the zeta function."""
        return lyapunov_of_periods(self.subset.sums(), self.subset.highest, self.weight)

    @cached_property
    def rules(self) -> SumRules | None:
        """The averages by sum rules, or None if the orbits have none."""
        return sum_rules_of(self.subset)


@dataclass(frozen=True)
class Average:
    """A method that averages lambda per bounce and per unit length.

    Attributes
    ----------
    name : str
        The columns are ``lambda_d_<name>`` and ``lambda_c_<name>``, or, if the name is empty, ``lambda_d``
        and ``lambda_c``.
    brief, label : str
        Short name on the screen, and label in figures.
    needs : callable
        Returns the periods, from 2 on, whose orbits the average of order p needs.
    compute : callable
        Returns the columns, each an array over p = 2, 3, ... up to the highest period, with NaN where there
        is no value. It returns no columns if the average does not exist for the given orbits.
    error : bool
        Whether there are also columns ``lambda_d_<name>_error`` and ``lambda_c_<name>_error``.
    ink : str
        Colour, ``one`` to ``six``.
    marker, line : str
        Symbol that marks points on the screen (empty for a line), and line format in matplotlib.
    """

    name: str
    brief: str
    label: str
    needs: Callable[[int], set[int]]
    compute: Callable[[AverageInputs], Mapping[str, Floats]]
    error: bool = False
    ink: str = "six"
    marker: str = ""
    line: str = "-"

    def of(self, exponent: str) -> str:
        """Return the name of the column with this average of an exponent, lambda_d or lambda_c."""
        return f"{exponent}_{self.name}" if self.name else exponent

    @property
    def columns(self) -> list[str]:
        """The names of the columns that a table always has, even if they have no values."""
        values = [self.of(exponent) for exponent in EXPONENTS]
        return values + [f"{name}_error" for name in values if self.error]


def _of_sums(*names: str) -> Callable[[AverageInputs], Mapping[str, Floats]]:
    return lambda given: {name: getattr(given.sums, name) for name in names}


def _of_rules(given: AverageInputs) -> Mapping[str, Floats]:
    names = [f"{exponent}_sum_rule{end}" for end in ("", "_error") for exponent in EXPONENTS]
    return {} if given.rules is None else {name: getattr(given.rules, name) for name in names}


AVERAGES = [
    Average("", "orbits", "average over fixed points", of_divisors, _of_sums("lambda_d", "lambda_c"),
            ink="one", line="x:"),
    Average("pair", "pairs", "mean of $p - 1$ and $p$", of_pairs, _of_sums("lambda_d_pair", "lambda_c_pair"),
            ink="three", marker="+", line="^-"),
    Average("zeta", "zeta", "zeta function to order $p$", every_period,
            _of_sums("lambda_d_zeta", "lambda_c_zeta", "z0"), ink="two", marker="×", line="s--"),
    Average("sum_rule", "sum rules", "sum rules (band: error)", every_period, _of_rules,
            error=True, ink="four", marker="•", line="o-"),
]  # fmt: skip
"""The averages, in the order of their columns."""

_AVOIDED = (
    "these are averages over the orbits that never contain the pattern. While they include orbits beside the "
    "bouncing balls or long runs along a semicircle, the zeta function does not converge, and ln z0 is no "
    "escape rate"
)
"""What averages over the words without a pattern mean, and what they do not."""

_NEVER_ESCAPE = (
    "these are averages over the orbits that never escape; at p = 11, zeta was up to 3 % above trajectories. "
    "ln z0 is no escape rate: `catalogue.escape(...)` estimates it"
)
"""What averages over the orbits without a bounce in an opening mean, and what they do not."""

OF_AVERAGES = [
    Column(
        name, "number", f"{part}average {exponent}; {average.label.partition(' (')[0].replace('$', '')}", unit
    )
    for average in AVERAGES
    for exponent, unit in zip(EXPONENTS, ("1", "1/radius"), strict=True)
    for ending, part in (("", ""), ("_error", "estimated error of the "))
    if (name := average.of(exponent) + ending) in average.columns
]
"""The columns that every table of averages has."""


def lyapunov(
    connection: Connection,
    chosen: Selection,
    weight: str = "exp",
    cut: float | None = None,
    tell: Tell = nobody,
) -> Result:
    """Return the average Lyapunov exponents by period, or up to a cut in lambda (`Catalogue.lyapunov`)."""
    wanted, notes = _weight(weight), list[str]()
    if reason := why_no_lambda(chosen):
        return Result(chosen, {}, (), (reason,))
    subset = read_noted(connection, chosen, notes, swept=cut is None, lower=cut is None)
    if subset is None:
        return Result(chosen, {}, (), tuple(notes))
    if cut is not None:
        return _up_to(subset, cut, wanted, notes, tell)
    columns, facts = averages(subset, wanted, notes), [subset.selection.describe()]
    reference = best_reference(connection, chosen.a)
    for name in TRAJECTORIES if reference is not None else ():
        columns[f"{name}_trajectory"] = [getattr(reference, name)] * len(columns["p"])
    if all_orbits(subset.selection):  # trajectories and exact means are not about some of the orbits
        a = format_float(chosen.a)
        if reference is None:
            notes.append(f"no trajectory value at a = {a}: `catalogue.simulate(a={a})` computes one")
        else:
            means = (f"lambda_d = {with_error(reference.lambda_d, reference.lambda_d_error)}",
                     f"lambda_c = {with_error(reference.lambda_c, reference.lambda_c_error)}")  # fmt: skip
            facts.append(f"trajectories: {', '.join(means)}")
        facts.append(_without_orbits(chosen.a))
    return Result(subset.selection, columns, tuple(facts), tuple(filter(None, notes)))


def lyapunov_of_rows(subset: CompletePeriods, weight: str = "exp") -> Result:
    """Return the average Lyapunov exponents of orbits that were already read (`Subset.averages`)."""
    notes: list[str] = []
    columns = averages(subset, _weight(weight), notes)
    return Result(subset.selection, columns, (subset.selection.describe(),), tuple(filter(None, notes)))


def _weight(name: str) -> Weight:
    if name not in list(Weight):
        raise InputError(f"weight {name!r}: use {' or '.join(Weight)}")
    return Weight(name)


def averages(subset: CompletePeriods, weight: Weight, notes: list[str]) -> dict[str, list[Any]]:
    """Return the columns of all `AVERAGES` over complete periods; append what is missing to `notes`."""
    given = AverageInputs(subset, weight)
    p = given.sums.p
    columns: dict[str, list[Any]] = {"p": p.tolist()}
    reason = why_no_lambda(subset.selection)
    for average in AVERAGES:
        columns |= {name: [None] * len(p) for name in average.columns}
        if reason:
            continue
        columns |= none_where_incomplete(p, average.compute(given), average.needs, subset.periods)
    avoided = reason or if_avoiding(subset.selection, _NEVER_ESCAPE if subset.selection.opening else _AVOIDED)
    notes += [why_no_sum_rules(subset), *subset.notes(given.sums), avoided]
    return subset.rows_of(columns)


def _without_orbits(a: float) -> str:
    """Return a line with the bounds on the exponents that follow from exact means alone."""
    low, high = exact_means(a).bounds
    scales = (("lambda_d", Stadium(a).legs_per_bounce), ("lambda_c", Stadium(a).legs_per_length))
    ranges = (f"{low * scale:.6f} < {name} < {high * scale:.6f}" for name, scale in scales)
    return f"from exact means alone, without orbits: {', '.join(ranges)}"


def _up_to(subset: CompletePeriods, cut: float, weight: Weight, notes: list[str], tell: Tell) -> Result:
    check_number("cut", cut)
    if not 0 < cut <= _LARGEST_CUT:
        raise InputError(f"cut {cut}: give a lambda above 0 and up to {_LARGEST_CUT}, such as 9")
    rows, a = subset.classes, subset.selection.a
    if weight is Weight.DETERMINANT and (most := pseudocycles.largest_cut(rows, cut, MOST_FACTORS)) < cut:
        raise InputError(f"cut {cut:g} has too many terms with weight det: give {most:g} or less")
    zeta = pseudocycles.lyapunov_by_stability(
        rows, cut, subset.highest, weight, lambda done: tell(done, 1.0, "summing pseudo-cycles")
    )
    if subset.missing:
        notes.append(f"the zeta function lacks p = {subset.why_missing(subset.missing)}")
    else:
        notes.append(f"the zeta function gives no average {zeta.fault}" if zeta.fault else "")
        complete = math.floor(least_exponent(subset.highest, a) * 1000) / 1000
        if cut > complete:
            notes.append(
                f"the orbits are proved complete only up to lambda = {complete:.3f} at a = "
                f"{format_float(a)}: between that and the cut {cut:g}, orbits of period above "
                f"{subset.highest} may be missing, which would change the average"
            )
    values = (zeta.lambda_d, zeta.lambda_c, zeta.mean_path, zeta.z0)
    row = [cut, *(None if subset.missing or value != value else value for value in values)]
    columns = {name: [value] for name, value in zip(UP_TO_CUT, row, strict=True)}
    return Result(subset.selection, columns, (subset.selection.describe(),), tuple(filter(None, notes)))


def statistics(connection: Connection, selection: Selection, weight: str = "exp") -> Result:
    """Return counts, entropies and Lyapunov averages of complete periods (`Catalogue.statistics`)."""
    notes: list[str] = []
    subset = read_noted(connection, selection, notes, swept=True)
    if subset is None:
        return Result(selection, {}, (), tuple(notes))
    periods, classes = subset.shown, subset.classes.p.tolist()
    columns = {
        "N_t": [count_admissible(p) for p in periods],
        "N_c": subset.cycles()[periods].tolist(),
        "classes": [None if p in subset.swept else classes.count(p) for p in periods],
    }
    for result in (entropy_of_rows(subset), lyapunov_of_rows(subset, weight)):
        columns |= {name: list(values) for name, values in result.columns.items()}
        notes += result.notes
    proved = enclosure(connection, selection.a)
    notes.append(outside(periods, columns["h_zeta"], proved.bounds, subset.selection))
    columns |= proved.columns(len(periods))
    return Result(subset.selection, columns, (proved.fact,), tuple(dict.fromkeys(filter(None, notes))))
