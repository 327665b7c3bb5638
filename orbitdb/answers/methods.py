"""The registry of Lyapunov averages: what each needs, how it is computed, and how it is shown.

`Catalogue.lyapunov`, its tables and files, the figure and the screen follow `AVERAGES`: a further average is
one entry.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property

from orbitdb.answers.whole_periods import WholePeriods, sum_rules_of
from orbitdb.arrays import Floats
from orbitdb.averages.by_period import Lyapunov, lyapunov_of_periods
from orbitdb.averages.fixed_points import Weight, every_period, of_divisors, of_pairs
from orbitdb.averages.sum_rules import SumRules

EXPONENTS = ("lambda_d", "lambda_c")


@dataclass(frozen=True)
class Given:
    """The chosen orbits of whole periods, and what several averages share.

    Attributes
    ----------
    subset : WholePeriods
    weight : Weight
    """

    subset: WholePeriods
    weight: Weight

    @cached_property
    def sums(self) -> Lyapunov:
        """The averages over fixed points and those of the zeta function."""
        return lyapunov_of_periods(self.subset.sums(), self.subset.highest, self.weight)

    @cached_property
    def rules(self) -> SumRules | None:
        """The averages by sum rules, None if the orbits have none."""
        return sum_rules_of(self.subset)


@dataclass(frozen=True)
class Average:
    """An average of lambda per bounce and per length.

    Attributes
    ----------
    name : str
        Its columns are ``lambda_d_<name>`` and ``lambda_c_<name>``; without a name, ``lambda_d`` and
        ``lambda_c``.
    brief, label : str
        Its name on the screen and in a figure.
    needs : callable
        Returns the periods, from 2 on, whose orbits the average of order p needs.
    compute : callable
        Returns its columns, each an array over p = 2, 3, .. to the highest period, NaN where there is no
        value; no columns if it does not exist for these orbits.
    error : bool
        Whether there are also columns ``lambda_d_<name>_error`` and ``lambda_c_<name>_error``.
    ink : str
        Its colour, ``one`` to ``six``.
    marker, line : str
        How its points look on the screen (empty for a line), and its format in matplotlib.
    """

    name: str
    brief: str
    label: str
    needs: Callable[[int], set[int]]
    compute: Callable[[Given], Mapping[str, Floats]]
    error: bool = False
    ink: str = "six"
    marker: str = ""
    line: str = "-"

    def of(self, exponent: str) -> str:
        """Return the name of its column of lambda_d or lambda_c."""
        return f"{exponent}_{self.name}" if self.name else exponent

    @property
    def columns(self) -> list[str]:
        """The columns that it always has, with or without values."""
        values = [self.of(exponent) for exponent in EXPONENTS]
        return values + [f"{name}_error" for name in values if self.error]


def _of_sums(*names: str) -> Callable[[Given], Mapping[str, Floats]]:
    return lambda given: {name: getattr(given.sums, name) for name in names}


def _of_rules(given: Given) -> Mapping[str, Floats]:
    names = [f"{exponent}_sum_rule{end}" for end in ("", "_error") for exponent in EXPONENTS]
    return {} if given.rules is None else {name: getattr(given.rules, name) for name in names}


AVERAGES = [
    Average("", "orbits", "average over fixed points", of_divisors, _of_sums("lambda_d", "lambda_c"),
            ink="one", line="x:"),
    Average("pair", "pairs", "mean of $p - 1$ and $p$", of_pairs, _of_sums("lambda_d_pair", "lambda_c_pair"),
            ink="three", line="^-"),
    Average("zeta", "zeta", "zeta function to order $p$", every_period,
            _of_sums("lambda_d_zeta", "lambda_c_zeta", "z0"), ink="two", marker="×", line="s--"),
    Average("sum_rule", "sum rules", "sum rules (band: error)", every_period, _of_rules,
            error=True, ink="four", marker="•", line="o-"),
]  # fmt: skip
"""The averages, in the order of their columns."""
