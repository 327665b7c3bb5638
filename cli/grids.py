"""The numbers that one --a or --kappa stands for: a single one, or a grid of values."""

import math
from collections.abc import Callable, Sequence
from itertools import chain
from typing import TypeAlias

from orbitdb.errors import InputError
from orbitdb.text import format_float, parse_int, real


class GivenValues(tuple[float, ...]):
    """The numbers that one option stands for; an --a without numbers stands for every stored a."""

    __slots__ = ()

    def __str__(self) -> str:
        return ", ".join(map(format_float, self))


Asked: TypeAlias = Sequence[GivenValues] | float | None
"""The values of all --a, or of one; None if it is not given."""

ALL = "all"
_MOST_VALUES = 1000
_DIGITS = 6


def half_length(text: str) -> float:
    """Parse a half length; raise `InputError` if no stadium has it."""
    from orbitdb.billiard.stadium import Stadium

    try:
        return Stadium(real(text)).a
    except ValueError as error:
        raise InputError(str(error)) from None


def half_lengths(text: str) -> GivenValues:
    """Parse half lengths such as ``1.6`` or the logarithmic grid ``0.3:10:40``."""
    return _grid(text, "a", "0.3:10:40", half_length, lambda low, high, part: low * (high / low) ** part)


def curvatures(text: str) -> GivenValues:
    """Parse curvatures such as ``0.05`` or the evenly spaced grid ``0:0.3:31``."""
    return _grid(text, "kappa", "0:0.3:31", real, lambda low, high, part: low + (high - low) * part)


def _grid(
    text: str,
    name: str,
    example: str,
    read: Callable[[str], float],
    between: Callable[[float, float, float], float],
) -> GivenValues:
    """Parse one number, or a grid FROM:TO:COUNT.

    `between` returns the number at a part of the way from one end of the grid to the other. The ends are
    exact; the numbers in between are rounded to 6 digits, so that the user can type each of them.
    """
    parts = text.split(":")
    if "," in text:
        raise ValueError(
            f"{text!r:.40}: repeat --{name} for several values, or give a grid such as {example}"
        )
    if len(parts) == 1:
        return GivenValues([read(text)])
    if len(parts) != 3:
        raise ValueError(f"{text!r:.40}: give one value, or a grid FROM:TO:COUNT such as {example}")
    low, high, count = read(parts[0]), read(parts[1]), parse_int(parts[2])
    if not (low < high < math.inf and 2 <= count <= _MOST_VALUES):
        raise ValueError(
            f"{text:.40}: a grid has 2 to {_MOST_VALUES} values, from a smaller {name} to a larger one"
        )
    inner = (between(low, high, i / (count - 1)) for i in range(1, count - 1))
    values = (low, *(float(f"{value:.{_DIGITS}g}") for value in inner), high)
    if list(values) != sorted(set(values)):
        raise ValueError(f"{text:.40}: the ends are too close for {count} values with {_DIGITS} digits")
    return GivenValues(values)


def many_a(asked: Sequence[GivenValues] | None) -> bool:
    """Tell whether --a may stand for several values, so that each row must show its a."""
    return asked is not None and [len(values) for values in asked] != [1]


def named(asked: Asked) -> tuple[float, ...] | None:
    """Return the values given with --a, without duplicates; None for ``all``, or if --a is not given."""
    if isinstance(asked, float):
        return (asked,)
    if asked and len(asked) > 1 and not all(asked):
        raise InputError(f"--a {ALL} already means every stored a: leave out the others, or list each a")
    return tuple(dict.fromkeys(chain.from_iterable(asked or ()))) or None
