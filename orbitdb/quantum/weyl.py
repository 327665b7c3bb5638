"""Parities of waves, Weyl's law, and whether a list of levels agrees with it.

Weyl's law is the smooth number of levels below k, of all parities or of one.

The levels of one parity are those of a quarter of the stadium. Its outer walls are Dirichlet edges; each of
its axes is a Dirichlet or a Neumann edge, depending on the parity. To the number of levels below k, a
Dirichlet edge contributes -length k / (4 pi), a Neumann edge +length k / (4 pi), the curvature of the arc
1/24, and a right angle 1/16 if its edges are of the same kind or -1/16 if they are not.

Source: H. P. Baltes and E. R. Hilf, Spectra of Finite Systems (1976).
"""

import math
from collections.abc import Iterable, Sequence
from enum import StrEnum
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.polynomial import Polynomial

from orbitdb.arrays import Floats
from orbitdb.billiard.stadium import Stadium, as_stadium
from orbitdb.errors import InputError, as_floats, check_number
from orbitdb.text import format_float, several

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

_LEAST_LEVELS = 10
_TOO_MANY, _TOO_FEW, _FEW = 0.2, 0.5, 4
"""Allowed differences from Weyl's law, above and below: fractions of the number that it predicts, plus a few
levels. Half of the levels may be missing."""


class Parity(StrEnum):
    """Parity of a wave: even or odd under x -> -x (first letter) and under y -> -y (second letter)."""

    EE = "ee"
    EO = "eo"
    OE = "oe"
    OO = "oo"

    @property
    def signs(self) -> tuple[int, int]:
        """Signs by which x -> -x and y -> -y multiply the wave: +1 if it is even, -1 if it is odd."""
        return 1 if self.value[0] == "e" else -1, 1 if self.value[1] == "e" else -1


def parities_of(names: "Parity | str | Iterable[Parity | str] | None" = None) -> list[Parity]:
    """Return parities without repetitions, from a name, several separated by commas, or a sequence.

    None and ``all`` stand for all four.

    Raises
    ------
    InputError
        If you give none, or one that is not ``ee``, ``eo``, ``oe`` or ``oo``.
    """
    if names is None or (isinstance(names, str) and names.strip() == "all"):
        return list(Parity)
    try:
        given = names.split(",") if isinstance(names, str) else list(names)
        parities = list(dict.fromkeys(Parity(name.strip()) for name in given))
    except (ValueError, AttributeError, TypeError):
        raise InputError(f"parity {names!s:.40}: use ee, eo, oe or oo") from None
    if not parities:
        raise InputError("no parity: use ee, eo, oe or oo")
    return parities


Wavenumbers: TypeAlias = "float | tuple[float, float | None] | Sequence[float]"
"""A range of wavenumbers: its ends, or one number (`k_ends`)."""


def k_ends(k: Any) -> tuple[float, float | None]:
    """Return the ends of a range of wavenumbers, given as a pair or by its upper end alone.

    The upper end of a pair may be None. Raises `InputError` if they are not a range from 0 or above.
    """
    given = k.tolist() if hasattr(k, "tolist") else k
    pair = isinstance(given, Sequence) and not isinstance(given, str) and len(given) == 2
    low, high = given if pair else (0.0, given)
    for end in (low, *([] if pair and high is None else [high])):
        check_number("k", end)
    if not pair and not 0 < high < math.inf:
        raise InputError(f"k = {high:g}: give a number above 0")
    if not 0 <= low < (math.inf if high is None else high) or (high is not None and math.isinf(high)):
        raise InputError(f"k from {low:g} to {high:g} is not a range: give the lower end first")
    return float(low), None if high is None else float(high)


def k_range(k: Any) -> tuple[float, float]:
    """Return the ends of a range of wavenumbers (`k_ends`); raise `InputError` without an upper end."""
    low, high = k_ends(k)
    if high is None:
        raise InputError(f"k from {low:g} on: give the upper end, too")
    return low, high


def one_parity(name: "Parity | str | None") -> Parity | None:
    """Return the parity with a name, or None for None; raise `InputError` for several or another name."""
    if name is None or name == "all":
        return None
    first, *others = parities_of(name)
    if others:
        raise InputError(f"parity {name}: give one parity, or none for the levels of all parities")
    return first


def weyl(stadium: Stadium, parity: Parity | None) -> Polynomial:
    """Return Weyl's law, the smooth number of levels below k (in 1/radius), as a polynomial in k.

    It counts the levels of the given parity, or all levels if the parity is None.
    """
    if parity is None:
        return Polynomial([1 / 6, -stadium.perimeter / (4 * math.pi), stadium.area / (4 * math.pi)])
    x, y = parity.signs
    edge = stadium.perimeter / 4 - x - y * (stadium.a + 1)
    corners = (x * y - x - y) / 16
    return Polynomial([1 / 24 + corners, -edge / (4 * math.pi), stadium.area / (16 * math.pi)])


def weyl_number(k: "ArrayLike", a: float | Stadium, parity: Parity | str | None = None) -> float | Floats:
    """Return Weyl's law, the smooth number of levels below k.

    Parameters
    ----------
    k : array_like
        Wavenumbers in 1/radius, one or an array of any shape.
    a : float or Stadium
        Half length of the straight walls, in units of the radius.
    parity : str, optional
        ``ee``, ``eo``, ``oe`` or ``oo``; the levels of all parities if it is not given.

    Returns
    -------
    float or ndarray
        The number for each k, in the shape of `k`; it is not an integer, and near k = 0 it can be negative.

    Raises
    ------
    InputError
        If a k is negative or not finite, or `a` or the parity is invalid.

    Notes
    -----
    Source: H. P. Baltes and E. R. Hilf, Spectra of Finite Systems (1976).

    Examples
    --------
    >>> round(weyl_number(10, 1.6), 3)
    66.003
    """
    values = as_floats(k, "k: give one number, or an array of numbers")
    if (wrong := values[~((values >= 0) & (values < np.inf))]).size:
        raise InputError(f"k = {wrong.flat[0]:g}: give a finite k of 0 or above, in 1/radius")
    number = weyl(as_stadium(a), one_parity(parity))(values)
    return number if np.ndim(number) else float(number)


def wavenumber(smooth: Polynomial, number: float) -> float:
    """Return the k at which the smooth number of levels reaches `number`.

    If the smooth number is larger at every k, return the k >= 0 at which it has its minimum.
    """
    constant, linear, quadratic = smooth.coef.tolist()
    root = linear**2 - 4 * quadratic * (constant - number)
    return max(0.0, (math.sqrt(max(root, 0.0)) - linear) / (2 * quadratic))


def check_levels(
    levels: "ArrayLike",
    stadium: Stadium,
    parity: Parity | None,
    window: bool = False,
    least: int = _LEAST_LEVELS,
) -> Floats:
    """Return levels in ascending order; refuse a list that cannot be all levels of a stadium of radius 1.

    Raises
    ------
    InputError
        If there are fewer than `least` levels, one is not positive and finite, or their number is far from
        Weyl's law. A window is compared with the number of levels that Weyl's law expects between its ends.
    """
    k = as_levels(levels)
    if len(k) < least:
        raise InputError(f"the list has only {several(len(k), 'level')}: give {least} or more")
    low = float(k[0]) if window else 0.0
    if not _plausible(len(k), low, k[-1], stadium, parity):
        of = " of all parities" if parity is None else f" of parity {parity}"
        smooth = weyl(stadium, parity)
        expected = max(0.0, float(smooth(k[-1])) - (float(smooth(low)) if window else 0.0))
        between = f"from k = {low:g} to {k[-1]:g}" if window else f"up to k = {k[-1]:g}"
        raise InputError(
            f"{len(k)} levels {between}, but Weyl's law expects {expected:.0f}{of} at a = "
            f"{format_float(stadium.a)}: {_remedy(k, window, stadium, parity)}"
        )
    return k


def as_levels(levels: "ArrayLike") -> Floats:
    """Return levels in ascending order; raise `InputError` unless they are finite numbers above 0."""
    k = as_floats(levels, "the levels must be numbers: give one row of numbers")
    if k.ndim != 1:
        raise InputError(f"the levels have shape {k.shape}: give one row of numbers")
    k = np.sort(k)
    if (wrong := k[~((k > 0) & (k < np.inf))]).size:
        raise InputError(f"{wrong[0]:g} is not a level: give finite k above 0, in 1/radius")
    return k


def _plausible(count: int, low: float, high: float, stadium: Stadium, parity: Parity | None) -> bool:
    """Return whether a number of levels between two k is near Weyl's law; from 0, all of them count."""
    smooth = weyl(stadium, parity)
    expected = float(smooth(high)) - (float(smooth(low)) if low else 0.0)
    return (1 - _TOO_FEW) * expected - _FEW <= count <= (1 + _TOO_MANY) * expected + _FEW


def _remedy(k: Floats, window: bool, stadium: Stadium, parity: Parity | None) -> str:
    """Return a message that says what may be wrong with a list that has too many or too few levels."""
    low, high = float(k[0]) if window else 0.0, float(k[-1])
    if _plausible(len(k), math.sqrt(low), math.sqrt(high), stadium, parity):
        return "they look like energies: take their square roots (`energies=True` for a file)"
    if _plausible(len(k), low**2, high**2, stadium, parity):
        return "they look like wavenumbers, not energies: take no square roots (leave out `energies=True`)"
    if parity is not None and _plausible(len(k), low, high, stadium, None):
        return "they look like the levels of all parities: leave out the parity"
    if parity is None and any(_plausible(len(k), low, high, stadium, one) for one in Parity):
        return "they look like the levels of one parity: name it, such as `parity='oo'`"
    if not window and _plausible(len(k), float(k[0]), high, stadium, parity):
        return (
            "they look like a window, a list that begins above the lowest level: "
            "`catalogue.assess(k, window=True)` tells where it begins"
        )
    return "check the parity, a and the unit: k is in 1/radius, and frequencies need --frequency and --radius"
