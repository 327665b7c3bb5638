"""The numbers of the statistics screen: from rows of the catalogue to averages by period."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from orbitdb.averages.by_period import Entropy, Lyapunov, entropy
from orbitdb.averages.exact_means import exact_means
from orbitdb.averages.fixed_points import ClassRows, Weight, missing_periods
from orbitdb.averages.leg_sums import LegSums
from orbitdb.averages.period_sums import lyapunov
from orbitdb.averages.standing import faults_of, standing
from orbitdb.averages.sum_rules import SumRules, sum_rules
from orbitdb.catalogue.averaged import enclosure, outside
from orbitdb.catalogue.whole_periods import read_leg_sums, why_missing, why_no_sum_rules
from orbitdb.cli.render import number
from orbitdb.cli.tui.orbit.pictures import Curve
from orbitdb.orbits.orbit import Status
from orbitdb.store.asking.selection import Selection
from orbitdb.trajectories.ensemble import Reference

if TYPE_CHECKING:
    from orbitdb.catalogue.catalogue import Catalogue
    from orbitdb.store.reading.records import Enclosure


@dataclass(frozen=True)
class Statistics:
    """Averages over the orbits of a subset, by period.

    Attributes
    ----------
    selection : Selection
        The orbits that were chosen.
    words, classes, admissible : dict of int to int
        For each filled period the chosen orbits, their classes, and the paper's N_t.
    entropy : Entropy
    lyapunov : Lyapunov
    missing : tuple of int
        Periods that are not there, without which the zeta functions are not whole.
    partial : tuple of int
        Chosen periods that are stored in part, and left out.
    sum_rules : SumRules or None
        None for a part of the orbits, where they have no meaning.
    proved : (Enclosure, str)
        Proved bounds on the entropy of all orbits, and a line that tells of them.
    unborn : tuple of int
        Chosen periods that are left out as the subset depends on their births, and none are stored.
    """

    selection: Selection
    words: dict[int, int]
    classes: dict[int, int]
    admissible: dict[int, int]
    entropy: Entropy
    lyapunov: Lyapunov
    missing: tuple[int, ...]
    partial: tuple[int, ...]
    sum_rules: SumRules | None
    proved: "tuple[Enclosure, str]"
    unborn: tuple[int, ...] = ()


def statistics(
    catalogue: "Catalogue",
    selection: Selection,
    weight: Weight = Weight.EXPONENTIAL,
    cancelled: Callable[[], bool] = lambda: False,
) -> Iterator[Statistics]:
    """Yield the averages over a subset's orbits up to each whole period, as the periods are read.

    All is of one moment; periods that are stored in part are left out.
    """
    if not selection.statuses:
        selection = replace(selection, statuses=(Status.ORBIT,))
    with catalogue.at_one_moment() as still:
        partial = tuple(fill.p for fill in still.partial(selection))
        unborn = tuple(still.without_births(selection))
        fills = [fill for fill in still.fills(selection.a) if fill.whole and selection.includes(fill.p)]
        fills = [fill for fill in fills if fill.p not in unborn]
        proved = enclosure(still, selection.a)
        parts: list[ClassRows] = []
        sums: list[LegSums] = []
        for count, fill in enumerate(fills, 1):
            if cancelled():
                return
            known = fills[:count]
            classes = still.classes(replace(selection, periods=((fill.p, fill.p),)))
            parts.append(classes.rows())
            missing = missing_periods(fill.p, [fill.p for fill in known])
            held = not why_no_sum_rules(selection, missing)
            if held:
                sums.append(read_leg_sums(classes, selection.a))
            rows = _joined(parts)
            if len(rows):
                yield Statistics(
                    selection=selection,
                    words={fill.p: int(part.size.sum()) for fill, part in zip(known, parts, strict=True)},
                    classes={fill.p: len(part) for fill, part in zip(known, parts, strict=True)},
                    admissible={fill.p: fill.n_t or 0 for fill in known},
                    entropy=entropy(rows, fill.p),
                    lyapunov=lyapunov(rows, fill.p, weight),
                    missing=tuple(missing),
                    partial=partial,
                    sum_rules=_sum_rules(rows, sums, fill.p, selection.a) if held else None,
                    proved=proved,
                    unborn=unborn,
                )


def _sum_rules(rows: ClassRows, sums: list[LegSums], highest: int, a: float) -> SumRules:
    return sum_rules(rows, LegSums.joined(sums), highest, exact_means(a))


def _joined(parts: list[ClassRows]) -> ClassRows:
    names = ("period", "size", "length", "lyapunov", "inverse")
    return ClassRows(*(np.concatenate([getattr(part, name) for part in parts]) for name in names))


COLUMNS = (
    "p", "N_t", "N_c", "classes", "N", "K_0", "h_zeta", "lambda_d", "lambda_d_pair", "lambda_d_zeta",
    "lambda_c", "lambda_c_pair", "lambda_c_zeta", "lambda_d_sum_rule", "lambda_d_sum_rule_error",
    "lambda_c_sum_rule", "lambda_c_sum_rule_error",
)  # fmt: skip


def notes_of(found: Statistics) -> list[str]:
    """Return what is to be said of the numbers: what is not there, and what is proved."""
    lost = why_missing([*found.missing, *found.unborn], found.selection, found.partial, found.unborn)
    notes = [f"without p = {lost}" if lost else ""]
    notes += [faults_of(each, found.words) for each in (found.entropy, found.lyapunov)]
    bounds, told = found.proved
    notes += [told, outside(found.entropy.p.tolist(), _shown(found)["h_zeta"], bounds, found.selection)]
    return list(dict.fromkeys(filter(None, notes)))


def _shown(found: Statistics) -> dict[str, list[Any]]:
    """Return the columns of all averages, None for every value that does not stand."""
    shown = standing(found.lyapunov, found.words) | standing(found.entropy, found.words)
    if found.sum_rules is None:
        return {name: [None] * len(found.entropy.p) for name in COLUMNS} | shown
    return standing(found.sum_rules, found.words) | shown


def table_of(found: Statistics) -> list[list[str]]:
    """Return the numbers as text, a list a filled period; empty where one does not stand."""
    shown = _shown(found)
    rows = []
    for p, words in found.words.items():
        counts = {"p": p, "N_t": found.admissible[p], "N_c": words, "classes": found.classes[p]}
        values = {name: counts[name] if name in counts else shown[name][p - 2] for name in COLUMNS}
        rows.append(["" if value is None else number(name, value) for name, value in values.items()])
    return rows


def curves_of(found: Statistics, reference: Reference | None) -> dict[str, list[Curve]]:
    """Return the curves of the entropy, and of the Lyapunov exponents a bounce and a length."""
    p = found.entropy.p.astype(float)
    shown = {name: np.array(values, dtype=float) for name, values in _shown(found).items()}
    curves = {
        "entropy": [
            Curve("one", "K_0", p, shown["K_0"]),
            Curve("two", "zeta", p, shown["h_zeta"], "×"),
        ]
    }
    ends = (found.proved[0].lower, found.proved[0].upper)
    curves["entropy"] += [
        Curve("six", name, p, np.full_like(p, end)) for name, end in zip(("proved", ""), ends, strict=True)
    ]
    for name in ("lambda_d", "lambda_c"):
        curves[name] = [
            Curve("one", "orbits", p, shown[name]),
            Curve("three", "pairs", p, shown[f"{name}_pair"]),
            Curve("two", "zeta", p, shown[f"{name}_zeta"], "×"),
        ]
        if found.sum_rules is not None:
            held, error = (shown[f"{name}_sum_rule{end}"] for end in ("", "_error"))
            band = [Curve("six", "", p, held + sign * error) for sign in (-1, 1)]
            curves[name] = [Curve("four", "sum rules", p, held, "•"), *curves[name], *band]
        if reference is not None:
            level = np.full_like(p, getattr(reference, name))
            curves[name].insert(0, Curve("five", "trajectories", p, level))
    return curves
