"""Figures of chosen subsets, and of levels beside them, from what the catalogue holds."""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import typer
from matplotlib.figure import Figure
from numpy.typing import NDArray

from orbitdb.averages.fixed_points import missing_periods
from orbitdb.billiard.stadium import Stadium
from orbitdb.catalogue.catalogue import Catalogue
from orbitdb.catalogue.gaps import joined_spans
from orbitdb.catalogue.results import Result
from orbitdb.catalogue.spectrum import read_classes, read_levels
from orbitdb.cli.figures.orbits import short
from orbitdb.cli.reading import note_gaps, note_nothing
from orbitdb.cli.render import note
from orbitdb.errors import InputError
from orbitdb.orbits.least_values import least_length
from orbitdb.plots import curves, paths
from orbitdb.plots.style import figure
from orbitdb.quantum.amplitudes import orbit_terms, weyl
from orbitdb.quantum.lengths import counted, family_count
from orbitdb.store.asking.selection import Selection

_NOTHING = ": nothing to draw"
_LENGTHS = (1.0, 12.0)
_PLACES = 2000


def draw_entropy(catalogue: Catalogue, chosen: Selection) -> Figure:
    """Draw K_0 and h_zeta by period, with the proved bounds."""
    found = _told(catalogue.entropy(chosen))
    p, shown = _series(found)
    with figure(6.4, 4.2, _described(chosen, found["p"])) as made:
        ax = made.add_subplot()
        curves.draw_entropy(ax, p, shown["K_0"], shown["h_zeta"], (found["h_lower"][0], found["h_upper"][0]))
    return made


def draw_lyapunov(catalogue: Catalogue, chosen: Selection) -> Figure:
    """Draw the exponents per bounce and per length by period, by every method."""
    found = _told(catalogue.lyapunov(chosen))
    p, shown = _series(found)
    with figure(6.4, 6.4, _described(chosen, found["p"])) as made:
        above, below = made.subplots(2, 1, sharex=True)
        labels = r"$\langle \lambda_d \rangle$ (per bounce)", r"$\langle \lambda_c \rangle$ (per length $R$)"
        for ax, name, label in zip((above, below), ("lambda_d", "lambda_c"), labels, strict=True):
            trajectories = f"{name}_trajectory", f"{name}_error_trajectory"
            line = tuple(found[each][0] for each in trajectories) if trajectories[0] in shown else None
            curves.draw_lyapunov(ax, p, shown, name, label, line)
        above.set(xlabel="")
    return made


def _told(found: Result) -> Result:
    """Say what is missing of what is drawn; leave if it is everything."""
    for text in found.notes:
        note(text if len(found) else f"{text}{_NOTHING}")
    if not len(found):
        raise typer.Exit(1)
    return found


def _series(found: Result) -> tuple[NDArray[np.int64], dict[str, NDArray[np.float64]]]:
    """Return all periods from the first to the last, and the averages, NaN where there is none.

    So no line is drawn across a period that is not there.
    """
    here = np.array(found["p"])
    p = np.arange(here[0], here[-1] + 1)
    shown = {}
    for name in found.columns:
        if name not in ("p", "h_proof"):
            shown[name] = np.full(len(p), np.nan)
            shown[name][here - here[0]] = np.array(found[name], dtype=float)
    return p, shown


def _described(chosen: Selection, periods: Sequence[int]) -> str:
    """Say what is shown, of the periods that were named those that are drawn."""
    spans = joined_spans([(p, p) for p in periods])
    return (replace(chosen, periods=tuple(spans)) if chosen.periods else chosen).describe()


def _nothing(catalogue: Catalogue, chosen: Selection) -> typer.Exit:
    """Say that there is nothing to draw; return how the command ends then."""
    note_nothing(catalogue, chosen, more=_NOTHING)
    return typer.Exit(1)


def draw_sheet(catalogue: Catalogue, chosen: Selection, limit: int) -> Figure:
    """Draw one orbit of each class of a period, the first ones if there are more than the limit."""
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
    with figure(
        max(4.0, columns * wide * unit),
        rows * high * unit + 0.6,
        f"Classes of {chosen.describe()}: least word (class size)",
    ) as made:
        ax = made.add_subplot()
        paths.draw_sheet(ax, stadium, drawn, labels, columns)
        made.set_label(chosen.describe())
    return made


def draw_phase_space(catalogue: Catalogue, chosen: Selection) -> Figure:
    """Draw the bounces in phase space, coloured by lambda."""
    stadium = Stadium(chosen.a)
    note_gaps(catalogue, chosen)
    subset = catalogue.select(chosen, coordinates=True)
    if not len(subset):
        raise _nothing(catalogue, chosen)
    periods = ((*subset.of_period(p), subset.lambda_d[subset.p == p]) for p in np.unique(subset.p).tolist())
    with figure(7.2, 4.4, chosen.describe()) as made:
        ax = made.add_subplot()
        dots = paths.draw_phase_space(ax, stadium, *paths.bounces(stadium, periods))
        made.colorbar(dots, ax=ax, label=r"$\lambda_d$ (per bounce)", pad=0.01, extend="both")
    return made


def draw_lengths(catalogue: Catalogue, chosen: Selection) -> Figure:
    """Draw how many orbits are no longer than L, and their density."""
    note_gaps(catalogue, chosen)
    found = catalogue.classes(chosen)
    if not len(found):
        raise _nothing(catalogue, chosen)
    whole = [fill.p for fill in catalogue.fills(chosen.a) if fill.whole and chosen.includes(fill.p)]
    highest = max((p for p in whole if not missing_periods(p, whole)), default=None)
    complete = None if highest is None else least_length(highest, chosen.a)
    with figure(6.4, 6.0, chosen.describe()) as made:
        above, below = made.subplots(2, 1, sharex=True)
        curves.draw_staircase(above, found.length, found.chosen, complete)
        drawn = curves.draw_density(below, found.p, found.length, found.chosen)
        made.colorbar(drawn, ax=below, label="orbits per unit of $L/R$", pad=0.01)
        above.set(xlabel="")
    return made


def draw_length_spectrum(catalogue: Catalogue, chosen: Selection) -> Figure:
    """Draw the length spectrum of the orbits, and that of the levels if there are any."""
    found = catalogue.spectrum(_LENGTHS, points=1000, a=chosen.a)
    for said in found.notes():
        note(said)
    with figure(7.2, 4.8, f"length spectrum at a = {chosen.a:g}, k below {found.k_max:.4g}") as made:
        ax = made.add_subplot()
        curves.draw_spectrum(ax, found, short)
    return made


def draw_levels(catalogue: Catalogue, chosen: Selection) -> Figure:
    """Draw the number of levels, and its fluctuations beside those that the orbits give."""
    known = read_levels(catalogue, chosen.a, None)
    if known is None:
        raise InputError(f"no levels to draw: 'orbitdb levels --k 0:30 --a {chosen.a:g}' finds them")
    k, end = known
    at, stadium = np.linspace(0.5, end, _PLACES), Stadium(chosen.a)
    classes, _, highest = read_classes(catalogue, chosen)
    smooth, family = weyl(stadium, None)(at), family_count(stadium, at, _LENGTHS[1])
    orbits = counted(orbit_terms(classes, _LENGTHS[1]), at)
    note(f"orbits and bouncing balls of lengths up to {_LENGTHS[1]:g}: a partial sum")
    with figure(7.2, 6.0, f"{len(k)} levels at a = {chosen.a:g}, k below {end:.4g}") as made:
        above, below = made.subplots(2, 1, sharex=True)
        curves.draw_level_count(above, below, k, at, smooth, family, orbits, highest)
    return made
