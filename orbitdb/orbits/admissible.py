"""Solve batches of admissible words: from directions to orbits with statuses and error bounds.

Doubles decide most words; `orbitdb.orbits.balls` decides the others.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from orbitdb.arrays import Batch, Floats, Indices, Integers, Words
from orbitdb.billiard.legs import Chain, Legs, coordinates, cut, length, margin_distances
from orbitdb.billiard.stability import exponent, forces
from orbitdb.billiard.stadium import Stadium
from orbitdb.orbits.error_bounds import coordinate_error, enclosed_areas, lambda_error, length_error
from orbitdb.orbits.newton import TOLERANCE, newton
from orbitdb.orbits.orbits import Orbits
from orbitdb.orbits.status import DecidedStatuses, Status, decide

if TYPE_CHECKING:
    from orbitdb.orbits.balls import Enclosure


def solve_admissible(
    words: Words, stadium: Stadium, tolerance: float = TOLERANCE, every: bool = True
) -> Orbits:
    """Find the orbits of words known to be admissible, as `solve` does.

    Unless `every` is set, words that are proved not to be orbits only get a status, a margin and a number of
    steps.
    """
    (orbits,) = solve_periods([words], stadium, tolerance, every)
    return orbits


def solve_periods(
    groups: Sequence[Words], stadium: Stadium, tolerance: float = TOLERANCE, every: bool = True
) -> list[Orbits]:
    """Find the orbits of admissible words of several periods, given as an array for each period.

    The other parameters are those of `solve_admissible`.
    """
    solved = _in_doubles(groups, stadium, tolerance, every)
    for words, orbits in zip(groups, solved, strict=True):
        left = np.flatnonzero(orbits.status == Status.UNRESOLVED)
        if len(left):
            orbits.place(left, solve_in_balls(words[left], stadium))
    return solved


def solve_in_balls(words: Words, stadium: Stadium) -> Orbits:
    """Find the orbits of N >= 1 admissible words in ball arithmetic, and round them to doubles."""
    from orbitdb.orbits.balls import as_orbits, enclose  # seldom needed, and takes 30 ms to import

    return as_orbits(words, stadium, [enclose(word, stadium) for word in words])


def solve_in_doubles(
    words: Words, stadium: Stadium, tolerance: float = TOLERANCE, every: bool = True
) -> Orbits:
    """Find the orbits of words as `solve_admissible` does, but leave undecided words unresolved."""
    (orbits,) = _in_doubles([words], stadium, tolerance, every)
    return orbits


def _in_doubles(groups: Sequence[Words], stadium: Stadium, tolerance: float, every: bool) -> list[Orbits]:
    """Solve words of several periods; those with equal numbers of runs together, whatever their periods."""
    solved = [Orbits.empty(words) for words in groups]
    pieces: dict[int, list[tuple[Orbits, Indices, Legs]]] = {}
    for orbits in solved:
        for rows, legs in cut(orbits.words):
            pieces.setdefault(len(legs.k), []).append((orbits, rows, legs))
    for alike in pieces.values():
        chains = _solve_chains(Chain.of([legs for *_, legs in alike]), stadium.a, tolerance, every)
        first = 0
        for orbits, rows, legs in alike:
            last = first + len(rows)
            orbits.place(rows, _orbits_of(orbits.words[rows], legs, stadium, chains.rows(slice(first, last))))
            first = last
    return solved


def certificates(words: Words, stadium: Stadium, precision: int | None = None) -> list["Enclosure"]:
    """Prove the statuses of admissible words, shape (N, p), in ball arithmetic, from the words alone.

    Newton's method in double precision only provides starting points, on which the proof does not rest.
    `precision` is the initial number of bits, by default `orbitdb.orbits.balls.PRECISION`.
    """
    from orbitdb.orbits.balls import PRECISION, enclose_all

    enclosures: dict[int, Enclosure] = {}
    for rows, legs in cut(words):
        start = newton(legs, stadium.a).alpha
        enclosed = enclose_all(legs, stadium, start, precision or PRECISION)
        enclosures.update(zip(rows.tolist(), enclosed, strict=True))
    return [enclosures[row] for row in range(len(words))]


@dataclass(frozen=True, eq=False)
class _SolvedChains(Batch):
    """N solved chains of m legs; see `Orbits` for the numbers, which are NaN for words without an orbit."""

    alpha: Floats  # shape (m, N)
    iterations: Integers
    status: NDArray[np.str_]
    margin: Floats
    length: Floats
    lyapunov: Floats
    error: Floats
    length_error: Floats
    lyapunov_error: Floats


_MEASURES = ("length", "lyapunov", "error", "length_error", "lyapunov_error")


def _solve_chains(legs: Chain, a: float, tolerance: float, every: bool) -> _SolvedChains:
    """Solve N chains, with error bounds, and with a status if doubles can decide it.

    Unless `every` is set, those that are proved not to be orbits are not measured.
    """
    alpha, iterations = newton(legs, a, tolerance)
    decided = decide(legs, a, alpha)
    margin = margin_distances(legs, alpha, decided.slack).min(axis=(0, 1))
    measures = {name: np.full(len(legs), np.nan) for name in _MEASURES}
    left = np.flatnonzero(every | (decided.status != Status.DYNAMICAL))
    if len(left):
        measured = _measured(legs.chain(left), a, alpha.take(left, axis=1), decided.rows(left))
        for name, values in zip(_MEASURES, measured, strict=True):
            measures[name][left] = values
    return _SolvedChains(alpha, iterations, decided.status, margin, **measures)


def _measured(legs: Chain, a: float, alpha: Floats, decided: DecidedStatuses) -> tuple[Floats, ...]:
    """Return the `_MEASURES` of N chains whose directions and statuses are known."""
    slopes, alpha_error = decided.slopes, decided.alpha_error
    lyapunov = exponent(slopes)
    return (
        length(legs, a, alpha),
        lyapunov,
        coordinate_error(legs, a, alpha, alpha_error, decided.slack_error),
        length_error(legs, a, alpha, slopes, alpha_error),
        lambda_error(legs, slopes, alpha_error, lyapunov),
    )


def _orbits_of(words: Words, legs: Legs, stadium: Stadium, chains: _SolvedChains) -> Orbits:
    """Return the orbits of solved words, shape (N, p); those that were measured get their bounces, too."""
    numbers = {name: getattr(chains, name) for name in ("status", "margin", "iterations", *_MEASURES)}
    orbits = replace(Orbits.empty(words), **numbers)
    left = np.flatnonzero(~np.isnan(chains.length))
    if len(left):
        own = orbits.rows(left)
        place = coordinates(legs.rows(left), stadium.a, chains.alpha.take(left, axis=1))
        area, area_error = enclosed_areas(stadium, own.words, place, own.error)
        residual = np.abs(forces(stadium, own.words, place)).max(axis=1)
        bounces = {"coordinates": place, "residual": residual, "area": area, "area_error": area_error}
        orbits.place(left, replace(own, **bounces))
    return orbits
