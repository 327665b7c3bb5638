"""Lists of levels beside the orbits: what a list lacks, its statistics, and length spectra."""

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from orbitdb.answers.results import Result
from orbitdb.answers.stadium_levels import (
    classes_for_levels,
    levels_from_zero,
    levels_to_gap,
    orbits_for,
    read_orbits,
)
from orbitdb.arrays import Floats
from orbitdb.billiard.stadium import Stadium
from orbitdb.display import columns_of
from orbitdb.errors import InputError, as_floats, check_int, check_number
from orbitdb.orbits.exponents import OrbitClasses
from orbitdb.orbits.least_values import least_length
from orbitdb.quantum.bouncing_balls import family_terms
from orbitdb.quantum.judging import FITS
from orbitdb.quantum.length_spectrum import Spectrum, of_family, of_levels, of_terms, reach
from orbitdb.quantum.level_statistics import Statistics, expected, statistics
from orbitdb.quantum.missing_levels import Assessment, assess, without_twins
from orbitdb.quantum.radius_fit import widest
from orbitdb.quantum.trace_formula import Terms, orbit_terms
from orbitdb.quantum.weyl import Parity, as_levels, check_levels, one_parity, weyl
from orbitdb.store.lookup import WITH_ORBITS, a_values
from orbitdb.store.selection import Selection
from orbitdb.store.sqlite import Connection
from orbitdb.text import format_float, several

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

_USUAL_K_MAX = 30.0
_LONGEST, _MOST_POINTS, _LARGEST_K_MAX = 100, 100_000, 1000

_SHOWN = 3
"""Maximum number of gaps with missing levels to name in one line."""

_LOWEST = 3
"""If this many of the lowest levels are missing, the list may be a window."""
_CLEARLY, _TRIED = 0.8, 100
"""Hints need a misfit smaller than the largest that fits by this factor, and this many levels."""
_FITTED = 5000
"""Number of the last level beyond which no other radius is tried: too many scales fit one after another."""
_MOST_NOISE, _MUCH_NOISE = 0.5, 0.1
"""Largest scatter of levels, in mean spacings, and the scatter from which on a wrong radius may be missed."""
_LARGEST_ERROR = 0.005
"""Largest relative error of a radius."""


def read_spectrum(
    connection: Connection,
    a: float,
    lengths: "ArrayLike",
    points: int,
    k_max: float | None = None,
    levels: "ArrayLike | None" = None,
    parity: Parity | str | None = None,
) -> Spectrum:
    """Return the length spectrum (`Catalogue.spectrum`)."""
    x = _lengths(lengths, check_int("points", points, 0))
    check_number("k_max", k_max or 0)
    if k_max is not None and not 1 <= k_max <= _LARGEST_K_MAX:
        raise InputError(f"k_max {k_max:g}: give 1 to {_LARGEST_K_MAX}")
    stadium, of = Stadium(a), one_parity(parity)
    given = None if levels is None else check_levels(levels, stadium, of)
    classes, highest = read_orbits(connection, Selection(stadium.a))
    codes = classes.representative
    assert codes is not None
    compared = levels_to_gap(connection, stadium.a, of) if given is None else (given, float(given[-1]))
    end = _USUAL_K_MAX if compared is None else compared[1]
    if k_max is not None and compared is not None and k_max > end:
        raise InputError(
            f"the levels end at k = {end:.6g}: give a smaller k_max than {k_max:g}, or more levels"
        )
    end = end if k_max is None else k_max
    longest = float(x[-1]) + reach(end)
    terms = orbit_terms(classes, longest, of)
    orbits = of_terms(terms, x, end) + of_family(stadium, x, end, of)
    quantum = None if compared is None else of_levels(compared[0], x, end, stadium, of)
    complete = least_length(highest, stadium.a) if highest > 1 else 0.0
    if of is not None:
        complete /= 2  # because half orbits contribute
    parts = zip(terms, family_terms(stadium, end, longest, of), strict=True)
    both = Terms._make(map(np.concatenate, parts))
    judged = () if given is None else tuple(notes_on_missing_levels(connection, stadium.a, given, of))
    return Spectrum(stadium.a, of, end, x, orbits, quantum, complete, both, codes, judged)


def _lengths(lengths: "ArrayLike", points: int) -> Floats:
    """Return evenly spaced lengths, given their range; raise `InputError` if it is no valid range."""
    ends = as_floats(lengths, f"lengths {lengths!r:.40}: give a range such as (1, 12)")
    if ends.shape != (2,) or not 0 <= ends[0] < ends[1] <= _LONGEST or not 2 <= points <= _MOST_POINTS:
        raise InputError(
            f"lengths {lengths!r:.40}, points {points}: give a range within 0..{_LONGEST}, and 2 to "
            f"{_MOST_POINTS} points"
        )
    return np.linspace(float(ends[0]), float(ends[1]), points)


def assess_levels(
    connection: Connection,
    a: float,
    k: "ArrayLike | None" = None,
    parity: Parity | str | None = None,
    fit_radius: bool = False,
    window: bool = False,
    radius_error: float | None = None,
    noise: float = 0.0,
) -> Assessment:
    """Compare a list of levels with the stored orbits (`Catalogue.assess`).

    Raises
    ------
    InputError
        If the numbers cannot be levels of the stadium, or if too few orbits are stored.
    """
    stadium = Stadium(a)
    of = one_parity(parity)
    if k is None and (window or fit_radius):
        raise InputError("a window, or a list whose radius is to be fitted, needs its levels: give them")
    _check_errors(noise, radius_error)
    if k is None:
        k = levels_from_zero(connection, stadium.a, of).k
    once, twins = without_twins(as_levels(k), stadium, of)
    levels = check_levels(once, stadium, of, window)
    classes, period = classes_for_levels(connection, stadium.a)
    orbits = orbits_for(stadium, classes, of, levels, window, widest(radius_error), period)
    assessment = assess(levels, orbits, stadium, of, window, fit_radius, radius_error, noise)
    notes = [_on_twins(twins, len(levels))] if twins else []
    if noise >= _MUCH_NOISE:
        notes.append(
            f"with a scatter of {noise:g} mean spacings, a wrong radius or parity may not be noticed"
        )
    if not assessment.fits or assessment.at_limit:
        hints = _hints(connection, assessment, classes, levels)
        return replace(assessment, notes=(*notes, *hints))
    lowest = int(assessment.number[assessment.number > 0][0]) - 1
    if not window and lowest >= _LOWEST:
        notes.append(
            f"the {lowest} lowest levels are missing: if the list is meant to begin higher up, "
            "'orbitdb assess FILE --window' (in Python window=True) tells where"
        )
    return replace(assessment, notes=tuple(notes))


def _check_errors(noise: float, radius_error: float | None) -> None:
    """Raise `InputError` unless the scatter of the levels and the error of the radius are small enough."""
    check_number("noise", noise)
    if not 0 <= noise <= _MOST_NOISE:
        raise InputError(
            f"noise {noise:g}: give the scatter of the levels in mean spacings, 0 to {_MOST_NOISE:g}"
        )
    check_number("radius_error", radius_error or 0)
    if radius_error is not None and not 0 < radius_error <= _LARGEST_ERROR:
        raise InputError(
            f"the relative error of the radius (--radius, in Python radius_error) is {radius_error:g}: "
            f"give up to {_LARGEST_ERROR:g}"
        )


def _on_twins(pairs: int, levels: int) -> str:
    """Return a note on levels that stand twice in a list."""
    if pairs == levels:
        return "every level stands twice in the list: each pair counts as one level"
    return f"{pairs} of {several(levels, 'level')} stand twice in the list: each pair counts as one level"


def _hints(connection: Connection, assessment: Assessment, classes: OrbitClasses, k: Floats) -> list[str]:
    """Return hints for a list that does not fit: a radius, a parity or a stored a with which it fits."""
    stadium, of, window = Stadium(assessment.a), assessment.parity, assessment.window
    k = k[:_TRIED]

    def better(stadium: Stadium, classes: OrbitClasses, parity: Parity | None, fit: bool = False) -> bool:
        try:
            check_levels(k, stadium, parity, window)
        except InputError:
            return False
        orbits = orbits_for(stadium, classes, parity, k, window)
        other = assess(k, orbits, stadium, parity, window, fit)
        return other.misfit < _CLEARLY * FITS and not other.at_limit

    hints = []
    if assessment.at_limit:
        hints.append("the fit of the radius failed: the radius is off by more than half a per cent")
    elif assessment.scale == 1 and weyl(stadium, of)(k[-1]) <= _FITTED and better(stadium, classes, of, True):
        hints.append(
            "they fit with another radius: 'orbitdb assess FILE --fit-radius' (in Python fit_radius=True) "
            "finds it"
        )
    hints += [
        f"they fit the parity {other}"
        for other in (Parity if of is not None else ())
        if other != of and better(stadium, classes, other)
    ]
    for a in a_values(connection, WITH_ORBITS):
        if a != stadium.a and len(hints) < _SHOWN:
            try:
                there, _ = classes_for_levels(connection, a)
            except InputError:
                continue
            if better(Stadium(a), there, of):
                hints.append(f"they fit a = {format_float(a)}")
    return hints


def notes_on_missing_levels(connection: Connection, a: float, k: Floats, parity: Parity | None) -> list[str]:
    """Return a line on the levels that a list lacks, and notes; [] if it lacks none or orbits cannot tell."""
    try:
        assessment = assess_levels(connection, a, k, parity)
    except InputError:
        return []
    if assessment.fits and not assessment.gaps:
        return []
    if not assessment.fits:
        return [assessment.verdict(), *assessment.notes]
    places = ", ".join(gap.place() for gap in assessment.gaps[:_SHOWN])
    more = f" and {len(assessment.gaps) - _SHOWN} more" if len(assessment.gaps) > _SHOWN else ""
    return [f"{assessment.verdict()}: {places}{more}; 'orbitdb assess FILE' lists them", *assessment.notes]


def level_statistics(connection: Connection, a: float, levels: Mapping[Parity, Floats]) -> Result:
    """Return the statistics of the levels of each parity (`Catalogue.level_statistics`)."""
    rows, notes = [], []
    for parity, k in levels.items():
        rows += [statistics(k, Stadium(a), parity, balls) for balls in (False, True)]
        notes.append(f"{parity}: {len(k)} levels at a = {format_float(a)}, k below {k[-1]:.4g}")
        notes += notes_on_missing_levels(connection, a, k, parity)
    columns = columns_of(Statistics._fields, [*rows, *expected()])
    return Result(Selection(a), columns, (), tuple(notes))
