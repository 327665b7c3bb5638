"""The length spectrum of a catalogue's orbits, and of its levels if it has any."""

from typing import TYPE_CHECKING

import numpy as np

from orbitdb.answers.levels import read_classes, read_levels
from orbitdb.billiard.stadium import Stadium
from orbitdb.errors import InputError
from orbitdb.orbits.least_values import least_length
from orbitdb.quantum.length_spectrum import Spectrum, of_family, of_levels, of_terms, reach
from orbitdb.quantum.trace_formula import Terms, family_terms, orbit_terms
from orbitdb.quantum.weyl import Parity, check_levels, one_parity
from orbitdb.store.moment import Moment
from orbitdb.store.selection import Selection

if TYPE_CHECKING:
    from numpy.typing import ArrayLike


_USUAL_K_MAX = 30.0
_LONGEST, _MOST_POINTS, _MOST_K = 100, 100_000, 1000


def read_spectrum(
    moment: Moment,
    a: float,
    lengths: "ArrayLike",
    points: int,
    k_max: float | None = None,
    levels: "ArrayLike | None" = None,
    parity: Parity | str | None = None,
) -> Spectrum:
    """Return the length spectrum (`Catalogue.spectrum`)."""
    ends = np.asarray(lengths, np.float64)
    if ends.shape != (2,) or not 0 <= ends[0] < ends[1] <= _LONGEST or not 2 <= points <= _MOST_POINTS:
        raise InputError(
            f"lengths {lengths!r:.40}, points {points}: give a range within 0..{_LONGEST}, and 2 to "
            f"{_MOST_POINTS} points"
        )
    if k_max is not None and not 1 <= k_max <= _MOST_K:
        raise InputError(f"k_max {k_max:g}: give 1 to {_MOST_K}")
    stadium, of = Stadium(a), one_parity(parity)
    given = None if levels is None else check_levels(levels, stadium, of)
    classes, codes, highest = read_classes(moment, Selection(stadium.a))
    known = read_levels(moment, stadium.a, of) if given is None else (given, float(given[-1]))
    end = _USUAL_K_MAX if known is None else known[1]
    if k_max is not None and known is not None and k_max > end:
        raise InputError(
            f"the levels end at k = {end:.6g}: give a smaller k_max than {k_max:g}, or more levels"
        )
    end = end if k_max is None else k_max
    x, longest = np.linspace(float(ends[0]), float(ends[1]), points), float(ends[1]) + reach(end)
    terms = orbit_terms(classes, longest, of)
    orbits = of_terms(terms, x, end) + of_family(stadium, x, end, of)
    quantum = None if known is None else of_levels(known[0], x, end, stadium, of)
    complete = least_length(highest, stadium.a) if highest > 1 else 0.0
    if of is not None:
        complete /= 2  # because half orbits contribute
    parts = zip(terms, family_terms(stadium, end, longest, of), strict=True)
    both = Terms._make(map(np.concatenate, parts))
    return Spectrum(stadium.a, of, end, x, orbits, quantum, complete, both, codes)
