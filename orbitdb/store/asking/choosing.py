"""Selections applied to classes that are enumerated and solved but not stored.

The choice is the same as that of `orbitdb.store.asking.conditions` from stored rows.
"""

import numpy as np
from numpy.typing import NDArray

from orbitdb.billiard.stadium import Stadium
from orbitdb.orbits.newton import solve_admissible
from orbitdb.store.asking.selection import Selection
from orbitdb.symbols.least_words import LeastWords
from orbitdb.symbols.patterns import words_containing
from orbitdb.symbols.symmetry import SIZES, label, time_reversal
from orbitdb.symbols.words import unpack

Floats = NDArray[np.float64]

_NEAR = 1e-9
"""Share of a measure within which a bound must be for its last digits to matter."""


def chosen_words(classes: LeastWords, p: int, selection: Selection) -> NDArray[np.int64]:
    """Count the words of each class that fulfil the conditions on words: reversal, symmetry, contains.

    The subset is one that can be swept (`orbitdb.store.asking.sweepable`).
    """
    wanted = (selection.time_reversal, time_reversal), (selection.symmetry, label)
    fits = np.array([
        bool(size) and all(not name or name == of(mask) for name, of in wanted)
        for mask, size in enumerate(SIZES)
    ])  # fmt: skip
    if selection.contains:
        sizes = words_containing(classes.codes, classes.stabiliser, p, selection.contains)
    else:
        sizes = SIZES[classes.stabiliser]
    return np.where(fits[classes.stabiliser], sizes, 0)


def within_ranges(
    codes: NDArray[np.int64], p: int, length: Floats, lyapunov: Floats, selection: Selection
) -> NDArray[np.bool_]:
    """Tell which orbits, N packed words of order p with length and lambda, are within the ranges of a subset.

    Where a bound is so near that the last digits decide, and for margins, the orbit is solved as a fill
    does it: the number that is compared is the one that would be stored.
    """
    chosen = np.ones(len(codes), dtype=np.bool_)
    if not selection.ranges:
        return chosen
    measures = _measures(length, lyapunov, np.full(len(codes), np.nan), p)
    near = np.full(len(codes), "margin" in selection.ranges)
    for name, bounds in selection.ranges.items():
        for bound in bounds:
            if bound is not None:
                near |= np.abs(measures[name] - bound) <= _NEAR * measures[name]
    if near.any():
        solved = solve_admissible(unpack(codes[near], p), Stadium(selection.a))
        for name, values in _measures(solved.length, solved.lyapunov, solved.margin, p).items():
            measures[name][near] = values
    for name, (low, high) in selection.ranges.items():
        chosen &= True if low is None else measures[name] >= low
        chosen &= True if high is None else measures[name] <= high
    return chosen


def _measures(length: Floats, lyapunov: Floats, margin: Floats, p: int) -> dict[str, Floats]:
    """Return what orbits of one period can be chosen by, by name, in arrays of their own."""
    return {
        "length": length.copy(),
        "lyapunov": lyapunov.copy(),
        "lambda_d": lyapunov / p,
        "lambda_c": lyapunov / length,
        "margin": margin.copy(),
    }
