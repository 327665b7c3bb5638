"""Numbers as people write them; what Python reads beyond that, such as ``1_6`` for 16, is none."""

import re
from fractions import Fraction

_REAL = re.compile(r"[+-]?(?:(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?|inf|nan)")
_WHOLE = re.compile(r"[+-]?[0-9]{1,40}(?:\.[0-9]{0,40})?(?:[eE]\+?[0-9]{1,2})?")


def real(text: str) -> float:
    """Read a number such as ``1.6`` or ``1e-6``.

    Raises
    ------
    ValueError
        If it is none.
    """
    if not _REAL.fullmatch(text.strip()):
        raise ValueError(f"{_shown(text)} is not a number")
    return float(text)


def whole(text: str) -> int:
    """Read a whole number such as ``20000``, ``1e6`` or ``2.5e7``.

    Raises
    ------
    ValueError
        If it is none, or has more than a hundred digits.
    """
    if not _WHOLE.fullmatch(text.strip()) or (value := Fraction(text.strip())).denominator > 1:
        raise ValueError(f"{_shown(text)} is not a whole number")
    return value.numerator


def exact(a: float) -> str:
    """Write a so that it is the same number when it is read again."""
    return f"{a:g}" if float(f"{a:g}") == a else repr(a)


def _shown(text: str) -> str:
    return repr(text if len(text) <= 40 else f"{text[:40]}...")
