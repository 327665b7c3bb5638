"""Births to 50 digits, from plane geometry alone: the a at which a bounce stands on a joint."""

import mpmath as mp
from mpmath import mpf
from reference import DIGITS, length_derivatives

from orbitdb.billiard.stadium import Stadium
from orbitdb.orbits.newton import solve
from orbitdb.symbols.words import from_strings


def joint_coordinate(joint: str, symbol: str) -> tuple[mpf, mpf]:
    """Return the coordinate of a joint on the wall of a symbol, as c0 + c1 a."""
    if symbol in "02":
        return mpf(0), mpf(1 if "right" in joint else -1)
    return (mp.pi / 2 if "top" in joint else -mp.pi / 2), mpf(0)


def birth_error(word: str, bounce: int, joint: str, a: float) -> mpf:
    """Return how far a birth is from the one to 50 digits, bounces counted from 1.

    The orbit is followed by Newton's method in all p coordinates, the birth found by the secant method.
    """
    start = solve(from_strings([word]), Stadium(a * (1 + 1e-9))).coordinates[0].tolist()
    with mp.workdps(DIGITS + 15):
        c0, c1 = joint_coordinate(joint, word[bounce - 1])

        def distance(at: mpf) -> mpf:
            x = [mpf(value) for value in start]
            for _ in range(12):
                _, gradient, matrix = length_derivatives(word, at, x)
                step = mp.lu_solve(matrix, gradient)
                x = [value - change for value, change in zip(x, step, strict=True)]
                if max(abs(change) for change in step) < mpf(10) ** -(DIGITS // 2 + 5):
                    break
            return x[bounce - 1] - c0 - c1 * at

        exact = mp.findroot(distance, (mpf(a), mpf(a) * (1 + mpf(10) ** -9)), tol=mpf(10) ** -90)
        return abs(mpf(a) - exact)
