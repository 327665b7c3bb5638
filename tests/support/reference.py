"""An independent computation of orbits, from plane geometry, with mpmath.

No code of orbitdb is used here. An orbit is a stationary point of the total length in the paper's p
coordinates. Newton's method with the full p x p Hessian finds it from a double-precision solution. Lambda
comes from the product of p flights and p reflections.
"""

from dataclasses import dataclass

import mpmath as mp
from mpmath import mpf

DIGITS = 50


@dataclass(frozen=True)
class Reference:
    """One orbit to `DIGITS` digits: coordinates, length, trace of the monodromy matrix, lambda."""

    coordinates: list[mpf]
    length: mpf
    trace: mpf
    lyapunov: mpf


Vector = tuple[mpf, mpf]
Placed = tuple[Vector, Vector, Vector]
"""A point, and its first and second derivatives."""


def point(symbol: int, x: mpf, a: mpf) -> Placed:
    """Return the position of a bounce and its first two derivatives in the coordinate."""
    if symbol in (0, 2):
        return (x, mpf(symbol - 1)), (mpf(1), mpf(0)), (mpf(0), mpf(0))
    outward = -1 if symbol in (1, 4) else 1
    sin, cos = mp.sin(x), mp.cos(x)
    return (outward * (a + cos), sin), (-outward * sin, cos), (-outward * cos, -sin)


def _dot(u: tuple[mpf, mpf], v: tuple[mpf, mpf]) -> mpf:
    return u[0] * v[0] + u[1] * v[1]


def _link(start: Placed, end: Placed) -> tuple[mpf, mpf, mpf, mpf, mpf, mpf]:
    """Return the length of a link and its derivatives d1, d2, d11, d22, d12 with respect to its two ends."""
    (p, dp, ddp), (q, dq, ddq) = start, end
    step = (q[0] - p[0], q[1] - p[1])
    size = mp.sqrt(_dot(step, step))
    u = (step[0] / size, step[1] / size)
    along_p, along_q = _dot(u, dp), _dot(u, dq)
    return (
        size,
        -along_p,
        along_q,
        (_dot(dp, dp) - along_p**2) / size - _dot(u, ddp),
        (_dot(dq, dq) - along_q**2) / size + _dot(u, ddq),
        -(_dot(dp, dq) - along_p * along_q) / size,
    )


def length_derivatives(word: str, a: mpf, coordinates: list[mpf]) -> tuple[mpf, mp.matrix, mp.matrix]:
    """Return length, gradient (p, 1) and Hessian (p, p) of a closed path."""
    p = len(word)
    bounces = [point(int(s), x, a) for s, x in zip(word, coordinates, strict=True)]
    total, gradient, matrix = mpf(0), mp.zeros(p, 1), mp.zeros(p, p)
    for i in range(p):
        j = (i + 1) % p
        size, d1, d2, d11, d22, d12 = _link(bounces[i], bounces[j])
        total += size
        gradient[i] += d1
        gradient[j] += d2
        matrix[i, i] += d11
        matrix[j, j] += d22
        matrix[i, j] += d12
        matrix[j, i] += d12
    return total, gradient, matrix


def monodromy_trace(word: str, a: mpf, coordinates: list[mpf]) -> mpf:
    """Return the trace of the product of flights and reflections in (displacement, angle)."""
    p = len(word)
    bounces = [point(int(s), x, a) for s, x in zip(word, coordinates, strict=True)]
    product = mp.eye(2)
    for i in range(p):
        (here, tangent, _), (there, _, _) = bounces[i], bounces[(i + 1) % p]
        step = (there[0] - here[0], there[1] - here[1])
        flight = mp.sqrt(_dot(step, step))
        normal = (-tangent[1], tangent[0])
        incidence = abs(_dot(normal, step)) / flight
        kick = mpf(0) if word[i] in "02" else 2 / incidence
        product = mp.matrix([[1, flight], [0, 1]]) * mp.matrix([[-1, 0], [kick, -1]]) * product
    return product[0, 0] + product[1, 1]


def stationary(word: str, a: mpf, coordinates: list[float]) -> list[mpf]:
    """Return nearby coordinates where the length is stationary, by Newton's method."""
    x = [mpf(value) for value in coordinates]
    for _ in range(12):
        _, gradient, matrix = length_derivatives(word, a, x)
        step = mp.lu_solve(matrix, gradient)
        x = [value - change for value, change in zip(x, step, strict=True)]
        if max(abs(change) for change in step) < mpf(10) ** -(DIGITS // 2 + 5):
            return x
    raise ArithmeticError(f"Newton's method does not converge for {word} at a = {a}")


def refine(word: str, a: float, coordinates: list[float]) -> Reference:
    """Find the orbit near a double-precision solution, to `DIGITS` digits.

    Parameters
    ----------
    word : str
    a : float
        Half length; the double counts as exact.
    coordinates : list of float
        Starting point of Newton's method, in the order of the word.

    Raises
    ------
    ArithmeticError
        If Newton's method does not converge from there.
    """
    with mp.workdps(DIGITS + 15):
        half_length = mpf(a)
        x = stationary(word, half_length, coordinates)
        total, _, _ = length_derivatives(word, half_length, x)
        trace = monodromy_trace(word, half_length, x)
        half = abs(trace) / 2
        return Reference(x, total, trace, mp.log(half + mp.sqrt(half**2 - 1)))


def relative(value: float, exact: mpf) -> float:
    """Return the relative error of a double."""
    return float(abs((mpf(value) - exact) / exact))


def joint_coordinate(joint: str, symbol: str) -> tuple[mpf, mpf]:
    """Return the coordinate of a joint on the wall of a symbol, as c0 + c1 a."""
    if symbol in "02":
        return mpf(0), mpf(1 if "right" in joint else -1)
    return (mp.pi / 2 if "top" in joint else -mp.pi / 2), mpf(0)


def birth_error(word: str, bounce: int, joint: str, a: float, start: list[float]) -> mpf:
    """Return the error of a birth, compared with its 50-digit value; bounces are counted from 1.

    The orbit is followed from a double-precision solution, and the secant method finds the birth.
    """
    with mp.workdps(DIGITS + 15):
        c0, c1 = joint_coordinate(joint, word[bounce - 1])

        def distance(at: mpf) -> mpf:
            return stationary(word, at, start)[bounce - 1] - c0 - c1 * at

        exact = mp.findroot(distance, (mpf(a), mpf(a) * (1 + mpf(10) ** -9)), tol=mpf(10) ** -90)
        return abs(mpf(a) - exact)
