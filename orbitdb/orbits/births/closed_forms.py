"""Numbers that look like a root of a small quadratic equation: recognised numerically, not proved."""

import math

_RELATIVE = 1e-12
"""What births are known to, at least; larger errors tell too little."""
_MOST = 60
"""Largest leading and middle coefficient; a chance hit among so many is rarer than one in 10^5."""
_SQUARE = 200
"""Largest denominator of a rational square."""


def closed_form(a: float) -> str | None:
    """Return a as a rational number, a square root of one, or a quadratic number; None if it is like none.

    Parameters
    ----------
    a : float
        A positive number, known to 1e-12 of itself.

    Examples
    --------
    >>> closed_form(0.3660254037844386)
    '(sqrt(3) - 1)/2'
    """
    for q in range(1, _SQUARE + 1):
        p = round(a * a * q)
        if p and abs(p / q - a * a) <= 2 * _RELATIVE * a * a:
            return _root(0, 4 * p * q, 2 * q)
    for c2 in range(1, _MOST + 1):
        for c1 in sorted(range(-_MOST, _MOST + 1), key=abs):
            c0 = -round(c2 * a * a + c1 * a)
            size = 2 * c2 * a * a + abs(c1) * a
            if abs(c2 * a * a + c1 * a + c0) <= _RELATIVE * size and abs(c0) <= _MOST * max(1, a * a):
                side = 1 if 2 * c2 * a + c1 > 0 else -1
                return _root(-side * c1, c1 * c1 - 4 * c2 * c0, side * 2 * c2)
    return None


def _root(rational: int, square: int, below: int) -> str:
    """Write (rational + sqrt(square))/below in lowest terms, below of either sign."""
    factor = max(k for k in range(1, math.isqrt(max(square, 1)) + 1) if square % (k * k) == 0)
    square //= factor * factor
    if square == 1:
        rational, factor, square = rational + factor, 0, 0
    sign = 1 if below > 0 else -1
    rational, factor, below = sign * rational, sign * factor, sign * below
    shared = math.gcd(rational, factor, below)
    rational, factor, below = rational // shared, factor // shared, below // shared
    if not factor:
        return f"{rational}" if below == 1 else f"{rational}/{below}"
    surd = f"sqrt({square})" if abs(factor) == 1 else f"{abs(factor)} sqrt({square})"
    if not rational:
        return surd if below == 1 else f"{surd}/{below}"
    above = f"{surd} {'-' if rational < 0 else '+'} {abs(rational)}" if factor > 0 else f"{rational} - {surd}"
    return above if below == 1 else f"({above})/{below}"
