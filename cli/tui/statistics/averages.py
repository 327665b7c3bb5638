"""The numbers of the statistics screen: those of the commands, as a table and as curves over the period."""

import numpy as np

from orbitdb.averages.fixed_points import Weight
from orbitdb.catalogue.averaged import enclosure, entropy_of_rows, lyapunov_of_rows, outside, read
from orbitdb.catalogue.catalogue import Catalogue
from orbitdb.catalogue.results import PROVED, Result
from orbitdb.cli.render import number
from orbitdb.cli.tui.orbit.pictures import Curve
from orbitdb.errors import InputError
from orbitdb.store.asking.selection import Selection
from orbitdb.symbols.counting import count_admissible
from orbitdb.trajectories.ensemble import Reference

COLUMNS = (
    "p", "N_t", "N_c", "classes", "N", "K_0", "h_zeta", "lambda_d", "lambda_d_pair", "lambda_d_zeta",
    "lambda_c", "lambda_c_pair", "lambda_c_zeta", "lambda_d_sum_rule", "lambda_d_sum_rule_error",
    "lambda_c_sum_rule", "lambda_c_sum_rule_error",
)  # fmt: skip


def statistics(catalogue: Catalogue, selection: Selection, weight: Weight = Weight.EXPONENTIAL) -> Result:
    """Return counts, entropies and Lyapunov averages of a subset's orbits by whole period.

    Raises
    ------
    InputError
        If there is no such orbit; it says why.
    """
    notes: list[str] = []
    with catalogue.at_one_moment() as still:
        subset = read(still, selection, notes, swept=True)
        proved, line = enclosure(still, selection.a)
    if subset is None:
        raise InputError("; ".join(notes))
    periods, classes = subset.periods, subset.classes.p.tolist()
    columns = {
        "N_t": [count_admissible(p) for p in periods],
        "N_c": subset.cycles()[periods].tolist(),
        "classes": [None if p in subset.swept else classes.count(p) for p in periods],
    }
    for found in (entropy_of_rows(subset), lyapunov_of_rows(subset, weight)):
        columns |= {name: list(values) for name, values in found.columns.items()}
        notes += found.notes
    notes.append(outside(periods, columns["h_zeta"], proved, subset.selection))
    bounds = zip(PROVED, (proved.lower, proved.upper, proved.proof), strict=True)
    columns |= {name: [value] * len(periods) for name, value in bounds}
    return Result(subset.selection, columns, (line,), tuple(dict.fromkeys(filter(None, notes))))


def table_of(found: Result) -> list[list[str]]:
    """Return the numbers as text, a list a period; empty where one does not stand."""
    return [[number(name, value) for name, value in zip(COLUMNS, row, strict=True)]
            for row in found.rows(COLUMNS)]  # fmt: skip


def curves_of(found: Result, reference: Reference | None) -> dict[str, list[Curve]]:
    """Return the curves of the entropy, and of the Lyapunov exponents per bounce and per length."""
    shown = {
        name: np.array(values, dtype=float) for name, values in found.columns.items() if name != PROVED[2]
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
    for name in ("lambda_d", "lambda_c"):
        held, error = shown[f"{name}_sum_rule"], shown[f"{name}_sum_rule_error"]
        curves[name] = [
            Curve("four", "sum rules", p, held, "•"),
            Curve("one", "orbits", p, shown[name]),
            Curve("three", "pairs", p, shown[f"{name}_pair"]),
            Curve("two", "zeta", p, shown[f"{name}_zeta"], "×"),
            *(Curve("six", "", p, held + sign * error) for sign in (-1, 1)),
        ]
        if reference is not None:
            level = np.full_like(p, getattr(reference, name))
            curves[name].insert(0, Curve("five", "trajectories", p, level))
    return curves
