"""Figures of orbits and of chosen subsets, from what the catalogue holds of them."""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import typer
from matplotlib.figure import Figure
from numpy.typing import NDArray

from orbitdb.averages import by_period
from orbitdb.averages.fixed_points import Weight, missing_periods
from orbitdb.averages.period_sums import lyapunov_of_periods
from orbitdb.averages.standing import faults_of, standing
from orbitdb.billiard.stability import birkhoff
from orbitdb.billiard.stadium import Stadium
from orbitdb.cli.averaging import counts_without_rows, note_uncounted, read_classes
from orbitdb.cli.reading import note_gaps, note_nothing
from orbitdb.cli.render import note
from orbitdb.errors import InputError
from orbitdb.orbits.orbit import Orbit
from orbitdb.plots import curves, paths
from orbitdb.plots.style import BLUE, ORANGE, explain, figure, plain
from orbitdb.store.asking.selection import Selection
from orbitdb.store.reading.catalogue import Catalogue
from orbitdb.store.reading.fills import joined_spans
from orbitdb.store.reading.leg_terms import sum_rules_of, why_no_further_sum_rules, why_no_sum_rules
from orbitdb.store.reading.references import best_reference
from orbitdb.store.reading.whole_periods import WholePeriods, why_missing
from orbitdb.symbols.symmetry import REVERSE, images_of
from orbitdb.symbols.words import run_notation

_NOTHING = ": nothing to draw"


def draw_orbit(found: Orbit) -> Figure:
    """Draw the path of an orbit that has coordinates in its stadium."""
    with figure(6.4, _height(found.a, 6.4)) as made:
        ax = made.add_subplot()
        assert found.points is not None
        paths.draw_orbit(ax, Stadium(found.a), found.points)
        ax.set_title(_caption(found))
    return made


def draw_reverse(found: Orbit) -> Figure:
    """Draw an orbit above its time reverse, whose bounces are those of the orbit backwards."""
    reverse = images_of(found.code)[REVERSE]
    same = found.time_reversal == "self"
    kind = "the same orbit: it retraces its path" if same else "another orbit, counted, too"
    with figure(6.4, 2 * _height(found.a, 6.4)) as made:
        above, below = made.subplots(2, 1)
        assert found.points is not None
        paths.draw_orbit(above, Stadium(found.a), found.points)
        above.set_title(f"(a) {_caption(found)}")
        paths.draw_orbit(below, Stadium(found.a), found.points[::-1], BLUE if same else ORANGE)
        below.set_title(f"(b) its time reverse {short(reverse)}: {kind}")
    return made


def _height(a: float, width: float) -> float:
    """Return the height in inches of a stadium drawn this wide, with its title and axis."""
    return max(2.0, (width - 0.8) * 2.7 / (2 * a + 2.7) + 0.9)


def _caption(found: Orbit) -> str:
    numbers = f"$a = {found.a:g}$,  $L = {found.length:.4f}\\,R$,  $\\lambda = {found.lyapunov:.4f}$"
    return f"{short(found.code)},  {numbers}"


def short(code: str) -> str:
    """Return a code for a title: as it is, or in run notation, cut if it is still long."""
    if len(code) <= 30:
        return code
    text = run_notation(code)
    return text if len(text) <= 40 else f"{text[:37]}..."


def _draw_entropy(catalogue: Catalogue, chosen: Selection, _limit: int) -> Figure:
    found, periods = _entropies(catalogue, chosen)
    proved = catalogue.entropy_bounds(chosen.a)
    band = None if proved is None else (proved.lower, proved.upper)
    p, shown = _standing(found, periods)
    with figure(6.4, 4.2) as made:
        ax = made.add_subplot()
        curves.draw_entropy(ax, p, shown["K_0"], shown["h_zeta"], shown["h_zeta_change"], band)
        ax.set_title(plain(_labelled(made, chosen, periods)))
        explain(made, ax)
    return made


def _entropies(catalogue: Catalogue, chosen: Selection) -> tuple[by_period.Entropy, Sequence[int]]:
    """Return the entropies that ``orbitdb entropy`` tells, and of which periods; say what is missing."""
    counted = counts_without_rows(catalogue, chosen)
    if counted is None:
        note_uncounted(catalogue, chosen)
        subset = _read(catalogue, chosen)
        return by_period.entropy_of_counts(subset.cycles()), subset.periods
    note_gaps(catalogue, chosen, left_out=True, counted=counted)
    if missing := missing_periods(max(counted.chosen), counted.chosen):
        _note_missing(why_missing(missing, chosen))
    return by_period.entropy_of_counts(counted.cycles()), counted.chosen


def _draw_lyapunov(catalogue: Catalogue, chosen: Selection, _limit: int) -> Figure:
    subset = _read(catalogue, chosen)
    if subset.swept:
        found = lyapunov_of_periods(subset.sums(), subset.highest, Weight.EXPONENTIAL)
    else:
        found = by_period.lyapunov(subset.classes.rows(), subset.highest)
    known = best_reference(catalogue, chosen.a)
    if known is None:
        note(f"no trajectories at a = {chosen.a:g} to compare with: run 'orbitdb simulate --a {chosen.a:g}'")
    lines = (
        (None, None)
        if known is None
        else (
            curves.Line(known.lambda_d, known.lambda_d_error),
            curves.Line(known.lambda_c, known.lambda_c_error),
        )
    )
    p, shown = _standing(found, subset.periods)
    discrete, continuous = (
        curves.LyapunovRows(shown[name], shown[f"{name}_pair"], shown[f"{name}_zeta"], line)
        for name, line in zip(("lambda_d", "lambda_c"), lines, strict=True)
    )
    if why := why_no_sum_rules(subset.selection, subset.missing) or why_no_further_sum_rules(subset):
        note(why)
    if (held := sum_rules_of(subset)) is not None:
        here = held.p >= p[0]
        discrete = replace(
            discrete,
            sum_rule=held.lambda_d_sum_rule[here],
            sum_rule_error=held.lambda_d_sum_rule_error[here],
        )
        continuous = replace(
            continuous,
            sum_rule=held.lambda_c_sum_rule[here],
            sum_rule_error=held.lambda_c_sum_rule_error[here],
        )
    with figure(6.4, 6.4) as made:
        above, below = made.subplots(2, 1, sharex=True)
        curves.draw_lyapunov(above, p, discrete, r"\lambda_d", "per bounce")
        curves.draw_lyapunov(below, p, continuous, r"\lambda_c", "per length $R$")
        above.set(xlabel="", title=plain(_labelled(made, chosen, subset.periods)))
        explain(made, above)
    return made


def _labelled(made: Figure, chosen: Selection, periods: Sequence[int]) -> str:
    """Label a figure with what it shows, of the periods that were named those that are drawn; return it."""
    spans = joined_spans([(p, p) for p in periods])
    shown = replace(chosen, periods=tuple(spans)) if chosen.periods else chosen
    made.set_label(shown.describe())
    return shown.describe()


def _standing(
    found: by_period.Entropy | by_period.Lyapunov, periods: Sequence[int]
) -> tuple[NDArray[np.int64], dict[str, NDArray[np.float64]]]:
    """Return the periods from the first whole one on and the averages that stand; say why others do not.

    NaN where there is none, so that no line is drawn across a period that is not there.
    """
    if fault := faults_of(found, periods):
        note(fault)
    here = found.p >= periods[0]
    columns = standing(found, periods)
    return found.p[here], {name: np.array(column, dtype=float)[here] for name, column in columns.items()}


def _read(catalogue: Catalogue, chosen: Selection) -> WholePeriods:
    """Return the chosen orbits of whole periods for averages; say which periods are missing."""
    subset = read_classes(catalogue, chosen, swept=True, nothing=_NOTHING)
    if subset is None:
        raise typer.Exit(1)
    if subset.missing:
        _note_missing(subset.why_missing())
    return subset


def _note_missing(periods: str) -> None:
    note(f"averages lack the orbits of p = {periods}")


def _nothing(catalogue: Catalogue, chosen: Selection) -> typer.Exit:
    """Say that there is nothing to draw; return how the command ends then."""
    note_nothing(catalogue, chosen, _NOTHING)
    return typer.Exit(1)


def _draw_sheet(catalogue: Catalogue, chosen: Selection, limit: int) -> Figure:
    if not chosen.periods:
        raise InputError("name a period for the sheet, such as --p 5")
    note_gaps(catalogue, chosen)
    words = sorted(set(catalogue.select(chosen).representative.tolist()), key=lambda word: (len(word), word))
    orbits = [found for word in words[:limit] if (found := catalogue.find(word, chosen.a)) is not None]
    drawn = [found.points for found in orbits if found.points is not None]
    if not drawn:
        raise _nothing(catalogue, chosen)
    if len(words) > limit:
        note(f"{limit} of {len(words)} classes are drawn; --limit {len(words)} draws all")
    stadium = Stadium(chosen.a)
    wide, high = paths.cell_size(stadium)
    columns = max(1, math.ceil(math.sqrt(0.8 * len(drawn) * high / wide)))
    rows = math.ceil(len(drawn) / columns)
    labels = [f"{short(found.code)} ({found.class_size})" for found in orbits if found.points is not None]
    unit = 0.26
    with figure(max(4.0, columns * wide * unit), rows * high * unit + 0.6) as made:
        ax = made.add_subplot()
        paths.draw_sheet(ax, stadium, drawn, labels, columns)
        ax.set_title(f"Classes of {plain(chosen.describe())}: least word (class size)")
    return made


def _draw_birkhoff(catalogue: Catalogue, chosen: Selection, _limit: int) -> Figure:
    stadium = Stadium(chosen.a)
    note_gaps(catalogue, chosen)
    subset = catalogue.select(chosen, coordinates=True)
    if not len(subset):
        raise _nothing(catalogue, chosen)
    place, sine, colour = [], [], []
    for p in np.unique(subset.p).tolist():
        along, sines = birkhoff(stadium, *subset.of_period(p))
        place.append(along.ravel())
        sine.append(sines.ravel())
        colour.append(np.repeat(subset.lambda_d[subset.p == p], p))
    with figure(7.2, 4.4) as made:
        ax = made.add_subplot()
        dots = curves.draw_birkhoff(ax, stadium, *map(np.concatenate, (place, sine, colour)))
        made.colorbar(dots, ax=ax, label=r"$\lambda_d$ (per bounce)", pad=0.01, extend="both")
        made.suptitle(plain(chosen.describe()), fontsize=10)
    return made


def _draw_lengths(catalogue: Catalogue, chosen: Selection, _limit: int) -> Figure:
    note_gaps(catalogue, chosen)
    found = catalogue.classes(chosen)
    if not len(found):
        raise _nothing(catalogue, chosen)
    with figure(6.4, 6.0) as made:
        above, below = made.subplots(2, 1, sharex=True)
        curves.draw_staircase(above, found.length, found.chosen)
        curves.draw_density(below, found.p, found.length, found.chosen)
        above.set(xlabel="", title=plain(chosen.describe()))
    return made


OF_SUBSETS: dict[str, Callable[[Catalogue, Selection, int], Figure]] = {
    "entropy": _draw_entropy,
    "lyapunov": _draw_lyapunov,
    "sheet": _draw_sheet,
    "birkhoff": _draw_birkhoff,
    "lengths": _draw_lengths,
}
"""How each figure of a subset is drawn, with at most so many orbits on a sheet."""
