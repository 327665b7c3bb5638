"""Subsets that can be swept, because a solved class is enough to decide about its words.

The key of a stored sweep is its stadium, its period, and the canonical text of its subset. This text does not
depend on how you wrote the subset; for all orbits, it is empty. A sweep chooses the same classes as
`orbitdb.store.asking.conditions` chooses from stored rows.
"""

from collections.abc import Iterator

import numpy as np

from orbitdb.arrays import Floats, Integers, Marks
from orbitdb.billiard.stadium import Stadium
from orbitdb.orbits.status import Status
from orbitdb.store.asking.criteria import ordered_symmetry, parse_bound, parse_reversal
from orbitdb.store.asking.selection import Selection, SelectionError
from orbitdb.symbols.enumeration import MAX_PERIOD, LeastWords
from orbitdb.symbols.patterns import words_containing
from orbitdb.symbols.symmetry import SIZES, label, time_reversal
from orbitdb.symbols.words import parse, unpack

SWEPT_MEASURES = ("length", "lyapunov", "lambda_d", "lambda_c", "margin")
"""The measures by which a sweep can choose; births and deaths are not among the results of the solver."""

_OF_ROWS = {"where": "where", "exists": "exists", "not_at": "not-at"}
"""Criteria that a sweep cannot use, and their names in the error message."""

_ALL = float("inf")
_LONGEST = 2 * MAX_PERIOD
"""Largest number of symbols to search for: twice around the longest word."""

_NEAR = 1e-9
"""Relative distance from a bound within which the last digits of a measure decide."""


def why_not_swept(selection: Selection) -> str:
    """Return the reason why a subset cannot be swept; empty if it can be."""
    rows = [told for name, told in _OF_ROWS.items() if getattr(selection, name)]
    rows += [f"range of {name}" for name in selection.ranges if name not in SWEPT_MEASURES]
    if rows:
        return (
            f"a subset by {', '.join(rows)} needs stored rows and cannot be swept: choose by reversal, "
            f"symmetry, contains and ranges of {', '.join(SWEPT_MEASURES)}, or fill the periods"
        )
    if selection.statuses not in ((), (Status.ORBIT,)):
        return f"status {', '.join(selection.statuses)} cannot be swept: a sweep sums over orbits only"
    if (count := len(selection.contains or "")) > _LONGEST:
        return f"contains has {count} symbols and cannot be swept: a sweep tries at most {_LONGEST} in a row"
    return ""


def swept_text(selection: Selection) -> str:
    """Return the canonical text of a subset of orbits, such as ``reversal=self length=:20.0``.

    Raises `SelectionError` if it cannot be swept.
    """
    if why := why_not_swept(selection):
        raise SelectionError(why)
    return " ".join(_parts(selection))


def _parts(selection: Selection) -> Iterator[str]:
    """Yield the criteria in a fixed order and notation."""
    if selection.time_reversal:
        yield f"reversal={parse_reversal(selection.time_reversal)}"
    if selection.symmetry:
        yield f"symmetry={ordered_symmetry(selection.symmetry)}"  # some files have unordered labels
    if selection.contains:
        yield f"contains={parse(selection.contains)}"
    for name in SWEPT_MEASURES:
        low, high = selection.ranges.get(name, (None, None))
        bounds = f"{_written(low, -_ALL)}:{_written(high, _ALL)}"
        if bounds != ":":
            yield f"{name}={bounds}"


def _written(bound: float | None, none: float) -> str:
    """Format a bound with all its digits; empty if every value satisfies it."""
    return "" if bound is None or bound == none else repr(float(bound) + 0.0)  # turns -0.0 into 0.0


def selection_of(text: str, a: float) -> Selection:
    """Return the subset with a canonical text, at a given a; raise `InputError` if there is none."""
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
        raise SelectionError(f"{text!r:.60} is not the canonical text of a subset")
    return found


def chosen_words(classes: LeastWords, p: int, selection: Selection) -> Integers:
    """Count the words of each class that satisfy the conditions on reversal, symmetry and `contains`."""
    wanted = (selection.time_reversal, time_reversal), (selection.symmetry, label)
    fits = np.array([
        bool(size) and all(not name or name == of(mask) for name, of in wanted)
        for mask, size in enumerate(SIZES)
    ])  # fmt: skip
    if selection.contains:
        sizes = words_containing(classes.codes, classes.stabiliser, p, selection.contains)
    else:
        sizes = SIZES[classes.stabiliser]
    return np.where(fits[classes.stabiliser], sizes, 0)


def within_ranges(codes: Integers, p: int, length: Floats, lyapunov: Floats, selection: Selection) -> Marks:
    """Tell which of N orbits, given as packed words of period p, are in the ranges of a subset; shape (N,).

    If the last digits decide, or if margins matter, the orbit is solved as in a fill, so that the number
    compared is the one that a fill would store.
    """
    chosen = np.ones(len(codes), dtype=np.bool_)
    if not selection.ranges:
        return chosen
    measures = _measures(length, lyapunov, np.full(len(codes), np.nan), p)
    near = np.full(len(codes), "margin" in selection.ranges)
    for name, bounds in selection.ranges.items():
        for bound in bounds:
            if bound is not None:
                near |= np.abs(measures[name] - bound) <= _NEAR * measures[name]
    if near.any():
        from orbitdb.orbits.newton import solve_admissible

        solved = solve_admissible(unpack(codes[near], p), Stadium(selection.a))
        for name, values in _measures(solved.length, solved.lyapunov, solved.margin, p).items():
            measures[name][near] = values
    for name, (low, high) in selection.ranges.items():
        chosen &= True if low is None else measures[name] >= low
        chosen &= True if high is None else measures[name] <= high
    return chosen


def _measures(length: Floats, lyapunov: Floats, margin: Floats, p: int) -> dict[str, Floats]:
    columns = length.copy(), lyapunov.copy(), lyapunov / p, lyapunov / length, margin.copy()
    return dict(zip(SWEPT_MEASURES, columns, strict=True))
