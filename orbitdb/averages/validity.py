"""Which averages by period stand: those that no missing period and no spurious zero spoils.

The command, the figures and the statistics screen show these alone.
"""

from collections.abc import Iterable
from dataclasses import fields
from typing import Any

import numpy as np

from orbitdb.averages.by_period import Entropy, Lyapunov
from orbitdb.averages.fixed_points import divisors, missing_periods
from orbitdb.averages.sum_rules import SumRules

_FIXED_POINTS = {"N", "K_0", "lambda_d", "lambda_c"}
_PAIRS = {"lambda_d_pair", "lambda_c_pair"}


def standing(found: Entropy | Lyapunov | SumRules, filled: Iterable[int]) -> dict[str, list[Any]]:
    """Return the columns of averages by period, None for every value that does not stand.

    A sum over the fixed points of order p needs all divisors of p, a mean of neighbouring periods those
    of both, a zeta function or sum rules every period up to p.

    Parameters
    ----------
    found : Entropy, Lyapunov or SumRules
    filled : iterable of int
        The periods whose orbits are all among those averaged over, as far as they were chosen.

    Returns
    -------
    dict of str to list
        One list a field that is an array, with a number or None for each p.
    """
    have = set(filled)
    columns = {}
    for field in fields(found):
        values = getattr(found, field.name)
        if isinstance(values, np.ndarray) and field.name != "p":
            columns[field.name] = [
                value if value == value and have >= _needs(field.name, p) else None
                for p, value in zip(found.p.tolist(), values.tolist(), strict=True)
            ]
    return {"p": found.p.tolist(), **columns}


def _needs(name: str, p: int) -> set[int]:
    """Return the periods that an average of order p is over."""
    if name in _FIXED_POINTS | _PAIRS:
        orders = (p - 1, p) if name in _PAIRS else (p,)
        return {d for order in orders for d in divisors(order) if d > 1}
    return set(range(2, p + 1))


def faults_of(found: Entropy | Lyapunov, filled: Iterable[int]) -> str:
    """Return one line that says at which periods, all lower ones being there, the zeta function has no
    zero that can be used, and why; empty if there is none."""
    have = set(filled)
    periods: dict[str, list[int]] = {}
    for p, fault in zip(found.p.tolist(), found.faults, strict=True):
        if fault and p in have and not missing_periods(p, have):
            periods.setdefault(fault, []).append(p)
    said = "; ".join(f"at p = {', '.join(map(str, orders))} {fault}" for fault, orders in periods.items())
    return said and f"the zeta function gives no average {said}"
