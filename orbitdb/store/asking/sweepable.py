"""Subsets that can be swept: those that a solved class decides, and their canonical text.

The text is the key of a stored sweep. The same subset has the same text, however you ask for it;
that of all orbits is empty. The stadium and the periods are keys of their own, not part of it.
"""

from collections.abc import Iterator

from orbitdb.orbits.orbit import Status
from orbitdb.store.asking.parsing import ordered_symmetry, parse_bound, parse_reversal
from orbitdb.store.asking.selection import Selection, SelectionError
from orbitdb.symbols.enumeration import MAX_PERIOD
from orbitdb.symbols.words import parse

SWEPT_MEASURES = ("length", "lyapunov", "lambda_d", "lambda_c", "margin")
"""The measures by which a sweep can choose; births and deaths are stored, and not found with an orbit."""

_OF_ROWS = {"where": "where", "exists": "exists", "not_at": "not-at"}
"""What a sweep cannot choose by, in the words of its error."""

_ALL = float("inf")
_LONGEST = 2 * MAX_PERIOD
"""Symbols of the longest factor that a word of any period has."""


def why_not_swept(selection: Selection) -> str:
    """Tell why the averages over a subset cannot be swept; empty if they can."""
    rows = [told for name, told in _OF_ROWS.items() if getattr(selection, name)]
    rows += [f"range of {name}" for name in selection.ranges if name not in SWEPT_MEASURES]
    if rows:
        return (
            f"a subset by {', '.join(rows)} cannot be swept, as that needs stored rows: choose by reversal, "
            f"symmetry, contains and ranges of {', '.join(SWEPT_MEASURES)}, or fill the periods"
        )
    if selection.statuses not in ((), (Status.ORBIT,)):
        return f"status {', '.join(selection.statuses)} cannot be swept: sums are over orbits alone"
    if (count := len(selection.contains or "")) > _LONGEST:
        return f"contains {count} symbols cannot be swept: no swept word has more than {_LONGEST} in a row"
    return ""


def swept_text(selection: Selection) -> str:
    """Return the canonical text of a subset of orbits, such as ``reversal=self length=:20.0``.

    A `SelectionError` tells why it cannot be swept.
    """
    if why := why_not_swept(selection):
        raise SelectionError(why)
    return " ".join(_parts(selection))


def _parts(selection: Selection) -> Iterator[str]:
    """Yield what a subset is chosen by, in one order and one way to write it."""
    if selection.time_reversal:
        yield f"reversal={parse_reversal(selection.time_reversal)}"
    if selection.symmetry:
        yield f"symmetry={ordered_symmetry(selection.symmetry)}"  # a file may hold sweeps of what is no group
    if selection.contains:
        yield f"contains={parse(selection.contains)}"
    for name in SWEPT_MEASURES:
        low, high = selection.ranges.get(name, (None, None))
        bounds = f"{_written(low, -_ALL)}:{_written(high, _ALL)}"
        if bounds != ":":
            yield f"{name}={bounds}"


def _written(bound: float | None, none: float) -> str:
    """Write a bound in full; nothing where all values are within it."""
    return "" if bound is None or bound == none else repr(float(bound) + 0.0)  # so that -0.0 is 0.0


def selection_of(text: str, a: float) -> Selection:
    """Return the subset at one a that has a canonical text; an `InputError` if none has."""
    given = dict(part.partition("=")[::2] for part in text.split())
    ranges = dict(parse_bound(f"{name}={given[name]}") for name in SWEPT_MEASURES if name in given)
    found = Selection(
        a,
        statuses=(Status.ORBIT,),
        time_reversal=given.get("reversal"),
        symmetry=given.get("symmetry"),
        contains=given.get("contains"),
        ranges=ranges,
    )
    if swept_text(found) != text:
        raise SelectionError(f"{text!r:.60} is the canonical text of no subset")
    return found
