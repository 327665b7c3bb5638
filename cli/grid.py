"""Values of a as they are typed: one, or a grid."""

from orbitdb.errors import InputError
from orbitdb.numerals import real, whole

_MOST = 1000
_DIGITS = 6


def lengths(text: str) -> tuple[float, ...]:
    """Return the half lengths that ``1.6`` or ``0.3:10:40`` stand for.

    A grid is logarithmic: neighbours have one ratio. Its ends are as they are given, what is between
    them is rounded to 6 digits, so that every a can be typed again.

    Raises
    ------
    InputError
        If it is neither, or there is no such stadium.
    """
    from orbitdb.billiard.stadium import Stadium

    parts = text.split(":")
    if len(parts) not in (1, 3):
        raise InputError(f"--a {text!r:.40}: give one a, or a grid FROM:TO:COUNT such as 0.3:10:40")
    try:
        ends = [Stadium(real(part)).a for part in parts[:2]]
        count = whole(parts[2]) if parts[2:] else 1
    except ValueError as error:
        raise InputError(f"--a: {error}") from None
    if len(ends) == 1:
        return (ends[0],)
    low, high = ends
    if not (low < high and 2 <= count <= _MOST):
        raise InputError(f"--a {text:.40}: a grid has 2 to {_MOST} values, from a smaller a to a larger one")
    inner = (low * (high / low) ** (i / (count - 1)) for i in range(1, count - 1))
    found = (low, *(float(f"{a:.{_DIGITS}g}") for a in inner), high)
    if list(found) != sorted(set(found)):
        raise InputError(f"--a {text:.40}: too close for {count} values with {_DIGITS} digits")
    return found
