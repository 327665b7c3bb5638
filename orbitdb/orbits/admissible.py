"""Solve batches of admissible words: from directions to orbits with statuses and error bounds.

Doubles decide most words; `orbitdb.orbits.balls` decides the others.
"""

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from orbitdb.arrays import Floats, Integers, Words
from orbitdb.billiard.legs import Legs, coordinates, cut, length, margin_distances
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
    orbits = solve_in_doubles(words, stadium, tolerance, every)
    left = np.flatnonzero(orbits.status == Status.UNRESOLVED)
    if len(left):
        orbits.place(left, solve_in_balls(words[left], stadium))
    return orbits


def solve_in_balls(words: Words, stadium: Stadium) -> Orbits:
    """Find the orbits of N >= 1 admissible words in ball arithmetic, and round them to doubles."""
    from orbitdb.orbits.balls import as_orbits, enclose  # seldom needed, and takes 30 ms to import

    return as_orbits(words, stadium, [enclose(word, stadium) for word in words])


def solve_in_doubles(
    words: Words, stadium: Stadium, tolerance: float = TOLERANCE, every: bool = True
) -> Orbits:
    """Find the orbits of words as `solve_admissible` does, but leave undecided words unresolved."""
    orbits = Orbits.empty(words)
    for rows, legs in cut(words):
        directions = newton(legs, stadium.a, tolerance)
        orbits.place(rows, _orbits_of(words[rows], legs, stadium, directions, every))
    return orbits


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


def _orbits_of(
    words: Words, legs: Legs, stadium: Stadium, directions: tuple[Floats, Integers], every: bool = True
) -> Orbits:
    """Turn solved directions into orbits with error bounds, and with a status if doubles can decide it.

    Parameters
    ----------
    words : ndarray of uint8, shape (N, p)
        Admissible words.
    legs : Legs
        The runs and legs of these words.
    directions : (ndarray, ndarray)
        The directions, as in `decide`, and the number of steps that the solver took.
    every : bool, optional
        If false, words that are proved not to be orbits only get a status, a margin and a number of steps.
    """
    alpha, iterations = directions
    decided = decide(legs, stadium.a, alpha)
    margin = margin_distances(legs, alpha, decided.slack).min(axis=(0, 1))
    orbits = replace(Orbits.empty(words), status=decided.status, margin=margin, iterations=iterations)
    left = np.flatnonzero(every | (decided.status != Status.DYNAMICAL))
    if len(left):
        existing = legs.rows(left), stadium, alpha.take(left, axis=1), decided.rows(left)
        orbits.place(left, _measured(orbits.rows(left), *existing))
    return orbits


def _measured(
    orbits: Orbits, legs: Legs, stadium: Stadium, alpha: Floats, decided: DecidedStatuses
) -> Orbits:
    """Complete orbits whose statuses are known with coordinates, length, lambda and their error bounds."""
    a, slopes, alpha_error = stadium.a, decided.slopes, decided.alpha_error
    place, lyapunov = coordinates(legs, a, alpha), exponent(slopes)
    error = coordinate_error(legs, a, alpha, alpha_error, decided.slack_error)
    area, area_error = enclosed_areas(stadium, orbits.words, place, error)
    return replace(
        orbits,
        coordinates=place,
        length=length(legs, a, alpha),
        lyapunov=lyapunov,
        residual=np.abs(forces(stadium, orbits.words, place)).max(axis=1),
        error=error,
        length_error=length_error(legs, a, alpha, slopes, alpha_error),
        lyapunov_error=lambda_error(legs, slopes, alpha_error, lyapunov),
        area=area,
        area_error=area_error,
    )
