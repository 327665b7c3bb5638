"""Read parts of a selection from text: periods, statuses, bounds and the like.

An unreadable text raises `SelectionError`, which says how to write it.
"""

import re
from collections.abc import Iterable, Sequence
from difflib import get_close_matches

from orbitdb.billiard.stadium import Stadium
from orbitdb.numerals import real, whole
from orbitdb.orbits.status import STORED, Status
from orbitdb.store.asking.periods import LEAST_PERIOD
from orbitdb.store.asking.selection import MEASURES, REVERSALS, Bounds, SelectionError
from orbitdb.symbols.symmetry import NAMES, label, smallest_group

_PERIODS = re.compile(r"([0-9]{1,9})(?:-([0-9]{1,9}))?")
_MOST_RANGES = 100
_RANGE = re.compile(r"([^:]*):([^:]*)")
_INTEGER = re.compile(r"\s*[+-]?[0-9]+\s*")
_LARGEST_INTEGER = 2**63


def parse_periods(text: str) -> tuple[tuple[int, int], ...]:
    """Read ranges of periods such as ``11``, ``2-8`` or ``2,3,5-7``."""
    ranges = []
    for part in text.split(","):
        found = _PERIODS.fullmatch(part.strip())
        if found is None:
            raise SelectionError(f"periods {text!r}: write them as 11, 2-8 or 2,3,5-7")
        low, high = int(found[1]), int(found[2] or found[1])
        if low > high:
            remedy = f"write {high}-{low}" if high >= LEAST_PERIOD else f"the least period is {LEAST_PERIOD}"
            raise SelectionError(f"periods {part.strip()!r} run backwards: {remedy}")
        ranges.append((low, high))
    if len(ranges) > _MOST_RANGES:
        raise SelectionError(f"periods: {len(ranges)} ranges, more than {_MOST_RANGES}; join some, as in 2-8")
    return tuple(ranges)


def periods_up_to(text: str, first: int = LEAST_PERIOD) -> tuple[tuple[int, int], ...]:
    """Read the periods to fill: a single number means all up to it; otherwise as `parse_periods`."""
    if "-" in text[1:] or "," in text:
        return parse_periods(text)
    try:
        return ((first, whole(text)),)
    except ValueError:
        raise SelectionError(f"periods {text!r:.40}: write them as 11, 2-8 or 2,3,5-7") from None


def parse_bound(text: str) -> tuple[str, Bounds]:
    """Read bounds on a measure such as ``length=3:10``, ``margin=:1e-4`` or ``lambda_c=0.4:``."""
    name, _, span = text.partition("=")
    if name.strip() not in MEASURES:
        raise SelectionError(f"range {text!r}: name one of {', '.join(MEASURES)}, as in length=3:10")
    found = _RANGE.fullmatch(span.strip())
    try:
        if found is None or not (found[1].strip() or found[2].strip()):
            raise ValueError(text)
        low, high = (real(part) if part.strip() else None for part in found.groups())
        if low != low or high != high:
            raise ValueError(text)
    except ValueError:
        raise SelectionError(f"range {text!r}: write it as {name}=3:10, {name}=3: or {name}=:10") from None
    if low is not None and high is not None and low > high:
        raise SelectionError(f"range {text!r} runs backwards: write {name.strip()}={high:g}:{low:g}")
    return name.strip(), (low, high)


def parse_bounds(texts: Iterable[str]) -> dict[str, Bounds]:
    """Read bounds on measures; several on one measure apply together."""
    found: dict[str, Bounds] = {}
    for text in texts:
        name, bounds = parse_bound(text)
        low, high = zip(found.get(name, (None, None)), bounds, strict=True)
        found[name] = (
            max((bound for bound in low if bound is not None), default=None),
            min((bound for bound in high if bound is not None), default=None),
        )
    return found


def parse_parameter(text: str) -> tuple[str, str | int | float]:
    """Read a value for a name in ``where``, such as ``cut=0.5`` or ``kind=self``."""
    name, sign, value = text.partition("=")
    if not sign or not name.isidentifier():
        raise SelectionError(f"-P {text!r}: write it as name=value")
    try:
        number = real(value)
        return name, int(value) if _INTEGER.fullmatch(value) and abs(number) < _LARGEST_INTEGER else number
    except ValueError:
        return name, value


def parse_reversal(text: str) -> str:
    """Read ``self`` or ``pair``."""
    if text not in REVERSALS:
        raise SelectionError(f"reversal {text!r}: use self or pair")
    return text


def parse_symmetry(text: str) -> str:
    """Read a symmetry label such as ``x,T,xT``, its elements in any order, or ``1`` for none."""
    named = ordered_symmetry(text)
    if named == "1":
        return named
    group = label(smallest_group(map(NAMES.index, named.split(","))))
    if group != named:
        raise SelectionError(
            f"symmetry {text!r} is no group, and none of a word: the smallest that holds it is {group}"
        )
    return group


def ordered_symmetry(text: str) -> str:
    """Write the elements of a symmetry label in order, whether or not they form a group."""
    names = {part.strip() for part in text.split(",")}
    if names != {"1"} and not names <= set(NAMES[1:]):
        raise SelectionError(f"symmetry {text!r}: use 1, or some of {', '.join(NAMES[1:])} with commas")
    return "1" if names == {"1"} else ",".join(name for name in NAMES if name in names)


def parse_statuses(text: str) -> tuple[Status, ...]:
    """Read statuses separated by commas; ``all`` means every status."""
    if text.strip() == "all":
        return STORED
    try:
        found = tuple(dict.fromkeys(Status(part.strip()) for part in text.split(",")))
    except ValueError:
        known = ", ".join(STORED)
        raise SelectionError(f"status {text!r}: use {known}, some of them with commas, or all") from None
    if Status.FAMILY in found:
        raise SelectionError(
            f"status {text!r}: the bouncing-ball family is never stored: 'orbitdb query 02' tells of it"
        )
    return found


def parse_exists(values: float | Iterable[float]) -> tuple[float, ...]:
    """Read one or several values of a at which words exist or do not."""
    each = values if isinstance(values, Iterable) else (values,)
    return tuple(dict.fromkeys(Stadium(a).a for a in each))


def parse_names(text: str, known: Sequence[str]) -> tuple[str, ...]:
    """Read known names of columns, separated by commas."""
    names = tuple(name.strip() for name in text.split(","))
    for name in names:
        if name not in known:
            raise unknown_column(name, known)
    if twice := [name for place, name in enumerate(names) if name in names[:place]]:
        raise SelectionError(f"column {twice[0]!r} is named twice")
    return names


def unknown_column(name: str, known: Sequence[str]) -> SelectionError:
    """Return the error for an unknown column."""
    columns = ", ".join(dict.fromkeys(known))
    return SelectionError(f"column {name!r}: {guess(name, known)}the columns are {columns}")


def guess(name: str, known: Iterable[str]) -> str:
    """Suggest the known name closest to a wrong one; empty if none is similar."""
    return "".join(f"did you mean {meant}? " for meant in get_close_matches(name, list(known), 1))
