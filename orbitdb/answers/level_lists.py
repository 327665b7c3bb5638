"""Lists of levels beside the orbits: what a list lacks, its statistics, and length spectra."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from orbitdb.answers.results import Result
from orbitdb.answers.stadium_levels import (
    classes_for_levels,
    levels_in_catalogue,
    levels_to_gap,
    orbits_for,
    read_orbits,
)
from orbitdb.arrays import Floats
from orbitdb.billiard.stadium import Stadium
from orbitdb.display import columns_of
from orbitdb.errors import InputError, as_floats, check_int, check_number
from orbitdb.orbits.least_values import least_exponent, least_length
from orbitdb.quantum.bouncing_balls import family_terms
from orbitdb.quantum.comparison import Comparison
from orbitdb.quantum.judging import FITS, judge
from orbitdb.quantum.length_spectrum import Spectrum, of_family, of_levels, of_terms, reach
from orbitdb.quantum.level_statistics import Statistics, expected, statistics
from orbitdb.quantum.levels_from_orbits import Staircase
from orbitdb.quantum.missing_levels import Assessment, assess, compare, without_twins
from orbitdb.quantum.radius_fit import likely_grid_step, likely_scales, widest, without_grid
from orbitdb.quantum.trace_formula import Terms, largest_amplitude, orbit_terms
from orbitdb.quantum.weyl import Parity, as_levels, check_levels, k_ends, one_parity, parities_of, weyl
from orbitdb.selection import Selection
from orbitdb.store.lookup import WITH_ORBITS, a_values
from orbitdb.store.sqlite import Connection
from orbitdb.text import format_float, several

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

_USUAL_END = 30.0
_LONGEST, _MOST_POINTS, _LEAST_K_MAX, _LARGEST_K_MAX = 100, 100_000, 1, 2000

_SHOWN = 3
"""Maximum number of other parities, radii and a that fit to name."""

_LOWEST = 3
"""If this many of the lowest levels are missing, the list may be a window."""
_CLEARLY, _TRIED = 0.8, 100
"""Hints need a misfit smaller than the largest that fits by this factor; number of levels that are tried."""
_RESOLUTIONS = 6
"""The same in units of the number of levels that a list must have."""
_FITTED = 5000
"""Number of the last level beyond which no other radius is tried: too many scales fit one after another."""
_MOST_NOISE, _MUCH_NOISE = 0.5, 0.1
"""Largest scatter of levels, in mean spacings, and the scatter from which on a wrong radius may be missed."""
_MANY_MISSING, _MANY_NEAR = 0.15, 0.2
"""Share of missing levels above which a list may not belong to the stadium; in a crowded list, the number
missing or too many within the resolution of the orbits."""
_LARGEST_ERROR = 0.005
"""Largest relative error of a radius."""


def read_spectrum(
    connection: Connection,
    a: float,
    lengths: "ArrayLike | None" = None,
    resolution: int = 500,
    k: Any = None,
    levels: "ArrayLike | None" = None,
    window: bool = False,
    parity: Parity | str | None = None,
) -> Spectrum:
    """Return the length spectrum (`Catalogue.spectrum`)."""
    stadium, of = Stadium(a), one_parity(parity)
    x = _lengths(usual_lengths(a) if lengths is None else lengths, check_int("resolution", resolution, 0))
    given = None if levels is None else check_levels(levels, stadium, of, window)
    if given is None:
        compared = levels_to_gap(connection, stadium.a, of)
        within = (0.0, _USUAL_END if compared is None else compared[1])
    else:
        compared, within = (given, float(given[-1])), (float(given[0]) if window else 0.0, float(given[-1]))
    ends = _range_of_k(k, within, compared is not None, window)
    classes, highest = read_orbits(connection, Selection(stadium.a))
    codes = classes.representative
    assert codes is not None
    longest = float(x[-1]) + reach(*ends)
    terms = orbit_terms(classes, longest, of)
    orbits = of_terms(terms, x, *ends) + of_family(stadium, x, *ends, of)
    complete = least_length(highest, stadium.a) if highest > 1 else 0.0
    parts = zip(terms, family_terms(stadium, ends, longest, of), strict=True)
    return Spectrum(
        a=stadium.a,
        parity=of,
        k_min=ends[0],
        k_max=ends[1],
        length=x,
        orbits=orbits,
        quantum=None if compared is None else of_levels(compared[0], x, *ends, stadium, of),
        complete_length=complete if of is None else complete / 2,  # because half orbits contribute
        terms=Terms._make(map(np.concatenate, parts)),
        codes=codes,
        missing=largest_amplitude(least_exponent(highest, stadium.a), float(x[-1]), of),
    )


def usual_lengths(a: float) -> tuple[float, float]:
    """Return the range of lengths that a spectrum has by default: up to the orbit 13, of length 4 (1 + a)."""
    return 1.0, float(min(math.ceil(4 * (1 + a)) + 1, _LONGEST))


def _range_of_k(k: Any, within: tuple[float, float], levelled: bool, window: bool) -> tuple[float, float]:
    """Return the range of k of a spectrum, which levels limit; a single number is its upper end."""
    if k is None:
        return within
    low, end = k_ends(k)
    high = within[1] if end is None else end
    if not _LEAST_K_MAX <= high <= _LARGEST_K_MAX:
        raise InputError(f"k {k!r:.40}: give a range that ends between {_LEAST_K_MAX} and {_LARGEST_K_MAX}")
    if low and not window:
        raise InputError(f"k from {low:g}: only a list that is a window can begin above 0 (`window=True`)")
    low = low if low else within[0]
    if levelled and not within[0] <= low < high <= within[1]:
        raise InputError(
            f"the levels have k from {within[0]:.6g} to {within[1]:.6g}: give a range of k within these, or "
            "more levels"
        )
    return low, high


def _lengths(lengths: "ArrayLike", count: int) -> Floats:
    """Return evenly spaced lengths, given their range; raise `InputError` if it is no valid range."""
    ends = as_floats(lengths, f"lengths {lengths!r:.40}: give a range such as (1, 12)")
    if ends.shape != (2,) or not 0 <= ends[0] < ends[1] <= _LONGEST or not 2 <= count <= _MOST_POINTS:
        raise InputError(
            f"lengths {lengths!r:.40}, resolution {count}: give a range within 0..{_LONGEST}, and 2 to "
            f"{_MOST_POINTS} points"
        )
    return np.linspace(float(ends[0]), float(ends[1]), count)


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
    stadium, of = Stadium(a), one_parity(parity)
    if k is None and (window or fit_radius):
        raise InputError("a window, or a list whose radius is to be fitted, needs its levels: give them")
    _check_errors(noise, radius_error)
    given = as_levels(levels_in_catalogue(connection, stadium.a, of).k if k is None else k)
    once, twins = without_twins(given, stadium, of)
    levels = check_levels(once, stadium, of, window, least=1)
    classes, period = classes_for_levels(connection, stadium.a)
    orbits = orbits_for(stadium, classes, of, levels, window, widest(radius_error), period)
    assessment = assess(levels, orbits, stadium, of, window, fit_radius, radius_error, noise)
    notes = [_on_twins(twins, len(levels))] if twins else []
    if assessment.fits and not assessment.at_limit:
        notes += _doubts(assessment, noise)
    else:
        notes += hints(connection, assessment, orbits, once)
    return replace(assessment, notes=tuple(notes))


def _doubts(assessment: Assessment, noise: float) -> list[str]:
    """Return what may be wrong with a list that fits."""
    notes = []
    if noise >= _MUCH_NOISE:
        notes.append(
            f"with a scatter of {noise:g} mean spacings, a wrong radius or parity may not be noticed"
        )
    lowest = int(assessment.number[assessment.number > 0][:1].sum()) - 1
    if not assessment.window and lowest >= _LOWEST:
        notes.append(
            f"the {lowest} lowest levels are missing: if the list is meant to begin higher up, "
            "`catalogue.assess(k, window=True)` tells where"
        )
    crowded = assessment.crowded and not assessment.short
    near = assessment.resolved / 2 * abs(assessment.net) / max(assessment.total, 1)
    many = near > _MANY_NEAR if crowded else (assessment.missing_share or 0.0) > _MANY_MISSING
    if assessment.window and many:
        which = "missing" if assessment.net > 0 else "too many"
        notes.append(f"with this many levels {which}, a list from another stadium might fit as well")
    if assessment.window and crowded:
        notes.append(
            f"so high up, a radius that is wrong by 0.05 % can pass unnoticed, and shifts the numbers by "
            f"{assessment.first / 1000:.0f}"
        )
    return notes


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
    """Return a note on levels that a list has twice."""
    if pairs == levels:
        return "the list has every level twice: each pair counts as one level"
    return f"the list has {pairs} of {several(levels, 'level')} twice: each pair counts as one level"


def hints(connection: Connection, found: Assessment, orbits: Staircase, k: Floats) -> list[str]:
    """Return what may explain a list that does not fit: a radius, finite differences, a parity or a stored a.

    A few scales are tried, with a part of the list.
    """
    part = k[: max(_TRIED, _RESOLUTIONS * found.resolved)]
    stadium, of, window = Stadium(found.a), found.parity, found.window
    if found.at_limit:
        said = ["the fit of the radius failed: the radius is off by more than half a per cent"]
    elif found.crowded or weyl(stadium, of)(k[-1]) > _FITTED:
        return [
            "so high up, too many radii fit to find the right one: check the radius, the parity and a, and "
            "whether levels are missing and others spurious"
        ]
    elif found.scale == 1:
        said = _other_scales(compare(part, orbits, stadium, of, window))
    else:
        said = []
    for a, parity in _others(connection, stadium, of):
        if len(said) < _SHOWN and _fits_elsewhere(connection, a, parity, part, window):
            said.append(
                f"they fit the parity {parity}" if a == stadium.a else f"they fit a = {format_float(a)}"
            )
    return said


def _other_scales(compared: Comparison) -> list[str]:
    """Return the hint that a list fits without the error of finite differences, or with another radius."""
    h = None if compared.window else likely_grid_step(compared)
    if h is not None and judge(compared.moved(without_grid(compared.k, h))).misfit < _CLEARLY * FITS:
        return [
            f"finite differences with h = {h:.2g}? They make levels too low by k^3 h^2 / 32; without this "
            "error, the list fits"
        ]
    if any(judge(compared.scaled(s)).misfit < _CLEARLY * FITS for s in likely_scales(compared).tolist()):
        return ["they fit with another radius: `catalogue.assess(k, fit_radius=True)` finds it"]
    return []


def _others(
    connection: Connection, stadium: Stadium, of: Parity | None
) -> Iterator[tuple[float, Parity | None]]:
    """Yield the other parities of the stadium, and the other stored a."""
    for parity in Parity if of is not None else ():
        if parity != of:
            yield stadium.a, parity
    for a in a_values(connection, WITH_ORBITS):
        if a != stadium.a:
            yield a, of


def _fits_elsewhere(connection: Connection, a: float, parity: Parity | None, k: Floats, window: bool) -> bool:
    """Return whether a list clearly fits another stadium or parity, without many missing levels."""
    stadium = Stadium(a)
    try:
        check_levels(k, stadium, parity, window, least=1)
        classes, period = classes_for_levels(connection, a)
    except InputError:
        return False
    orbits = orbits_for(stadium, classes, parity, k, window, period=period)
    judged = judge(compare(k, orbits, stadium, parity, window))
    return judged.misfit < _CLEARLY * FITS and judged.rates.missing < _MANY_MISSING


def assessed(
    connection: Connection, a: float, k: Floats, parity: Parity | None, window: bool
) -> Assessment | None:
    """Return the assessment of a list, None if orbits cannot tell."""
    try:
        return assess_levels(connection, a, k, parity, window=window)
    except InputError:
        return None


def lacking(found: Assessment | None) -> list[str]:
    """Return the notes on a list for a result that uses it; [] if it lacks nothing or orbits cannot tell."""
    return [] if found is None else found.lacking()


def levels_by_parity(
    connection: Connection,
    a: float,
    levels: "Mapping[Parity, ArrayLike] | ArrayLike | None" = None,
    parity: Parity | str | None = None,
    window: bool = False,
) -> dict[Parity, Floats]:
    """Return the given levels of each parity, or those of one parity; by default the stored ones."""
    if levels is None:
        return {of: levels_in_catalogue(connection, a, of).k for of in parities_of(parity)}
    if not isinstance(levels, Mapping):
        if (only := one_parity(parity)) is None:
            raise InputError("levels: give the levels of each parity, such as {'oo': k}, or name one parity")
        levels = {only: levels}
    given = {of: k for name, k in levels.items() for of in parities_of(name)}
    return {of: check_levels(k, Stadium(a), of, window) for of, k in given.items()}


def level_statistics(
    connection: Connection, a: float, levels: Mapping[Parity, Floats], window: bool = False
) -> Result:
    """Return the statistics of the levels of each parity (`Catalogue.level_statistics`)."""
    rows, notes = [], []
    for parity, k in levels.items():
        found = assessed(connection, a, k, parity, window)
        missing = found.missing_share if found is not None else None
        rows += [statistics(k, Stadium(a), parity, balls, missing) for balls in (False, True)]
        where = f"k from {k[0]:.6g} to {k[-1]:.6g}" if window else f"k below {k[-1]:.4g}"
        notes.append(f"{parity}: {len(k)} levels at a = {format_float(a)}, {where}")
        notes += [*lacking(found), *_on_correction(found)]
    columns = columns_of(Statistics._fields, [*rows, *expected()])
    return Result(Selection(a), columns, (), tuple(notes))


def _on_correction(found: Assessment | None) -> list[str]:
    """Return a line that says whether the statistics allow for missing levels."""
    if found is None:
        return [
            "without orbits, it is not known how many levels are missing: the statistics do not allow for it"
        ]
    if found.missing_share is None:
        return ["how many levels are missing is not known: the statistics do not allow for it"]
    if not found.missing_share:
        return []
    return [f"Delta_3 and the number variance allow for {100 * found.missing_share:.1f} % missing levels"]
