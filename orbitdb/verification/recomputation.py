"""Checks of stored orbits against new solutions in doubles, from the usual start and from others."""

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from orbitdb.billiard.legs import Legs, cut, derivatives, direction_limits
from orbitdb.billiard.stadium import Stadium
from orbitdb.orbits.error_bounds import direction_errors
from orbitdb.orbits.newton import newton
from orbitdb.orbits.orbit import EXISTING, NUMBERS, Orbits, Status
from orbitdb.symbols.words import to_strings
from orbitdb.verification.check import Check, judged, measured, shares

Floats = NDArray[np.float64]
Marks = NDArray[np.bool_]

BOUNDED = {"coordinates": "error", "length": "length_error", "lyapunov": "lyapunov_error"}

_SETTLED = 1e-6


def check_against(stored: Orbits, fresh: Orbits) -> Iterator[Check]:
    """Check what is stored of N words against a new solution: statuses, numbers within the bounds.

    Parameters
    ----------
    stored, fresh : Orbits
        The same words; rows that lack what their status demands must not be among them.
    """
    labels = to_strings(stored.words)
    sign = np.where(stored.status == Status.DYNAMICAL.value, -1.0, 1.0)
    wrong_side = (stored.status != Status.BOUNDARY.value) & (sign * stored.margin < 0)
    yield judged("statuses", labels, (stored.status != fresh.status) | wrong_side)
    yield judged("unresolved", labels, stored.status == Status.UNRESOLVED.value)

    both = np.flatnonzero(np.isin(stored.status, EXISTING) & np.isin(fresh.status, EXISTING))
    kept, found = stored.rows(both), fresh.rows(both)
    deviation, allowed = [], []
    for name, bound in BOUNDED.items():
        distance = np.abs(getattr(kept, name) - getattr(found, name))
        deviation.append(distance.max(axis=1) if distance.ndim == 2 else distance)
        allowed.append(getattr(kept, bound) + getattr(found, bound))
    yield _worst("bounds", [labels[row] for row in both], np.stack(deviation), np.stack(allowed))


def _worst(name: str, labels: Sequence[str], deviation: Floats, allowed: Floats) -> Check:
    """Check deviations of shape (k, N), k of each row."""
    worst = shares(deviation, allowed).argmax(axis=0), np.arange(len(labels))
    return measured(name, labels, deviation[worst], allowed[worst])


def check_bits(stored: Orbits, fresh: Orbits) -> Check:
    """Check that a new solution gives the stored numbers to the last bit.

    It does wherever the same version computes with the same `orbitdb.arithmetic.arithmetic`.
    """
    labels = to_strings(stored.words)
    kept = np.isin(fresh.status, EXISTING)
    differs = stored.iterations != fresh.iterations
    for name in NUMBERS:
        value = getattr(fresh, name)
        expected = np.where((kept | (name == "margin")) & np.isfinite(value), value, np.nan)
        differs |= _bits_differ(getattr(stored, name), expected + 0.0)  # SQLite stores -0.0 as 0.0
    places = np.where(kept[:, None], fresh.coordinates, np.nan)
    differs |= _bits_differ(stored.coordinates, places).any(axis=1)
    return judged("bits", labels, differs)


def _bits_differ(x: Floats, y: Floats) -> Marks:
    differ: Marks = x.view(np.int64) != y.view(np.int64)
    return differ & ~(np.isnan(x) & np.isnan(y))


def restart(words: NDArray[np.uint8], stadium: Stadium, times: int, rng: np.random.Generator) -> Check:
    """Solve words again from random directions between their limits, and compare the results.

    Parameters
    ----------
    words : ndarray of uint8, shape (N, p)
        Admissible words.
    stadium : Stadium
    times : int
        Starts for each word.
    rng : Generator

    Returns
    -------
    Check
        Its rows are the restarts that came to rest; two results differ if they are farther apart than
        their error bounds together, the deviation being the largest of a direction (radians).
    """
    found = Check("restarts", 0)
    text = to_strings(words)
    for rows, legs in cut(words):
        labels = [text[row] for row in rows]
        first = newton(legs, stadium.a).alpha
        first_error = _errors(legs, stadium.a, first)
        low, high = direction_limits(legs, stadium.a)
        for _ in range(times):
            again = newton(legs, stadium.a, start=rng.uniform(low, high)).alpha
            error = _errors(legs, stadium.a, again)
            rest = np.flatnonzero(error.max(axis=0) < _SETTLED)
            apart, allowed = np.abs(again - first)[:, rest], (error + first_error)[:, rest]
            found = found.joined(_worst("restarts", [labels[row] for row in rest], apart, allowed))
    return found


def _errors(legs: Legs, a: float, alpha: Floats) -> Floats:
    slopes = derivatives(legs, a, alpha)
    return direction_errors(legs, a, alpha, slopes)
