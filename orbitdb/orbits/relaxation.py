"""The paper's artificial dynamics, which relaxes all p coordinates together; a check on Newton's method.

Every bounce of a word is an atom on its own extended wall or full circle. Its velocity is its violation of
the law of reflection, which up to sign is the derivative of the total length in its coordinate
(`orbitdb.billiard.stability.forces`). An atom on a straight wall moves towards the smaller angle and shortens
the path; an atom on a semicircle moves towards the larger angle and lengthens it. When all atoms are at rest,
all bounces obey the law of reflection.

Source: Biham and Kvale, eq. (2) and section II, with C = 1, h = 0.1 and fourth-order Runge-Kutta steps.
"""

from dataclasses import replace

import numpy as np

from orbitdb.arrays import Floats, Words
from orbitdb.billiard.legs import cut
from orbitdb.billiard.stability import Links, bounce_matrices, forces
from orbitdb.billiard.stadium import HALF_PI, STRAIGHT, Stadium
from orbitdb.orbits.error_bounds import enclosed_areas
from orbitdb.orbits.orbits import Orbits
from orbitdb.orbits.status import Status

EPSILON = 1e-7
"""Force at which the dynamics stops, as in the paper."""

STEP = 0.1
MAX_STEPS = 200_000


def relax(
    words: Words,
    stadium: Stadium,
    epsilon: float = EPSILON,
    max_steps: int = MAX_STEPS,
    start: Floats | None = None,
) -> Orbits:
    """Find the orbits of admissible words by the paper's artificial dynamics.

    Parameters
    ----------
    words : ndarray of uint8, shape (N, p)
        Admissible primitive words of the same period, in any rotation.
    epsilon : float, optional
        The dynamics of a word stops when all its forces, which are differences of two cosines, are smaller
        than this.
    max_steps : int, optional
        Number of Runge-Kutta steps after which a word is left unresolved.
    start : ndarray, shape (N, p), optional
        Coordinates to start from; `starting_points` by default.

    Returns
    -------
    Orbits
        The statuses come from comparing the coordinates with the ends of walls and semicircles, without
        proof. The method has no error bounds, so these are NaN.
    """
    orbits = Orbits.empty(words)
    symbols = np.ascontiguousarray(words.T)
    x = np.ascontiguousarray((starting_points(words, stadium) if start is None else start).T)
    active = np.arange(len(words))
    for step in range(max_steps + 1):
        velocity = _velocity(stadium, symbols, x)
        done = np.abs(velocity).max(axis=0) < epsilon
        if done.any():
            orbits.place(active[done], _at_rest(symbols[:, done].T, stadium, x[:, done].T, step))
            going = np.flatnonzero(~done)
            active, velocity = active[going], velocity.take(going, axis=1)
            symbols, x = symbols.take(going, axis=1), x.take(going, axis=1)
        if not len(active):
            break
        second = _velocity(stadium, symbols, x + STEP / 2 * velocity)  # a fourth-order Runge-Kutta step
        third = _velocity(stadium, symbols, x + STEP / 2 * second)
        fourth = _velocity(stadium, symbols, x + STEP * third)
        x = x + STEP / 6 * (velocity + 2 * (second + third) + fourth)
    orbits.iterations[active] = max_steps
    return orbits


def starting_points(words: Words, stadium: Stadium) -> Floats:
    """Return coordinates to start from, shape (N, p), with every atom on its own wall or semicircle.

    The atoms of a run are spread over the semicircle in the sense of the run. This selects the right one of
    the two stationary points that a word has if 4 and 5 are not distinguished from 1 and 3. The atoms of a
    leg are spread over the walls from the side where the leg starts to the side where it ends.
    """
    start = np.empty(words.shape)
    for rows, legs in cut(words):
        run, place, straight = legs.bounces
        own = (run, np.arange(len(legs)))
        count = np.where(straight, legs.n[own], legs.k[own])
        spread = (2 * place + 1 - count) / (count + 1)
        ahead = 1.0 - 2.0 * (run % 2)
        start[rows] = (spread * np.where(straight, stadium.a * ahead, HALF_PI * legs.d[own])).T
    return start


def _velocity(stadium: Stadium, symbols: Words, x: Floats) -> Floats:
    """Return dx/dt, shape (p, N), which decreases the length on walls and increases it on semicircles."""
    slope = forces(stadium, symbols.T, x.T).T
    return np.where(STRAIGHT[symbols], -slope, slope)


def _at_rest(words: Words, stadium: Stadium, x: Floats, step: int) -> Orbits:
    """Return the orbits of words at rest, given their coordinates, shape (N, p), without error bounds."""
    links = Links.of(stadium, words, x)
    margin = (np.where(STRAIGHT[words], stadium.a, HALF_PI) - np.abs(x)).min(axis=1)
    unknown = np.full(len(words), np.nan)
    return replace(
        Orbits.empty(words),
        status=np.where(margin > 0, Status.ORBIT.value, Status.DYNAMICAL.value),
        coordinates=x,
        length=links.after.sum(axis=1),
        lyapunov=_exponent(bounce_matrices(stadium, words, x)),
        margin=margin,
        residual=np.abs(links.cos_in - links.cos_out).max(axis=1),
        area=enclosed_areas(stadium, words, x, unknown)[0],
        iterations=np.full(len(words), step),
    )


def _exponent(matrices: Floats) -> Floats:
    """Return ln of the largest modulus of an eigenvalue of each product of matrices, shape (N, p, 2, 2).

    The product is rescaled at every bounce, so words of any length stay in range.
    """
    n, p = matrices.shape[:2]
    product = np.broadcast_to(np.eye(2), (n, 2, 2))
    log_size = np.zeros(n)
    for bounce in range(p):
        product = matrices[:, bounce] @ product
        size = np.abs(product).max(axis=(1, 2))
        product = product / size[:, None, None]
        log_size += np.log(size)
    half_trace = np.abs(np.trace(product, axis1=1, axis2=2)) / 2
    unit = np.exp(-log_size)  # its square is the determinant of the product
    root = np.sqrt(np.maximum((half_trace - unit) * (half_trace + unit), 0.0))
    return np.log(half_trace + root) + log_size
