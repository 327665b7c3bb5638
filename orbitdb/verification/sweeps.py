"""What sweeps have counted and added up, against the transfer matrix, fills, births, and new solutions."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import numpy as np

from orbitdb.averages.fixed_points import ClassRows
from orbitdb.averages.period_sums import PeriodSums
from orbitdb.billiard.stadium import Stadium
from orbitdb.errors import StoreError
from orbitdb.orbits.newton import solve
from orbitdb.orbits.orbit import Status
from orbitdb.orbits.tally import Tally
from orbitdb.store.asking.selection import Selection
from orbitdb.store.file.schema import DONE
from orbitdb.store.reading import audit
from orbitdb.store.reading.lives import birth_fills, counts_at
from orbitdb.store.reading.sweeps import Sweep, sweeps
from orbitdb.symbols.counting import count_admissible
from orbitdb.symbols.enumeration import Span
from orbitdb.symbols.least_words import least_words
from orbitdb.symbols.symmetry import SIZES
from orbitdb.symbols.words import unpack
from orbitdb.verification.check import Check, measured

if TYPE_CHECKING:
    import sqlalchemy as sa

SWEPT_ANEW = 11
"""The highest period that is solved anew, in half a second."""

_ROUNDING = 1e-12
_REPETITIONS = 20
"""How much more than an orbit's numbers its terms may be off: their weights are e^-lambda of repetitions."""

_COUNTS = ("n_c", "classes", "boundary", "unresolved")


def check_sweeps(connection: "sa.Connection", selections: Sequence[Selection]) -> Iterator[Check]:
    """Check the counts of every chosen period that is swept, and the sums of those up to `SWEPT_ANEW`."""
    fills = {(fill["a"], fill["p"]): fill for fill in audit.fills(connection) if fill["state"] == DONE}
    born = {each.p for each in birth_fills(connection) if each.whole}
    for selection in selections:
        a = selection.a
        try:
            found = [each for each in sweeps(connection, a) if selection.includes(each.p)]
        except StoreError as error:
            yield Check("sweeps", 1, 1, first=f"at a = {a:g}: {error}")
            continue
        for each in found:
            others: list[Mapping[str, Any]] = [fills[a, each.p]] if (a, each.p) in fills else []
            if each.p in born and each.whole:
                others.append(vars(counts_at(connection, a, each.p)))
            yield _counted(each, a, others)
            if each.whole and each.p <= SWEPT_ANEW:
                yield from _anew(each, a)


def _counted(swept: Sweep, a: float, others: Sequence[Mapping[str, Any]]) -> Check:
    """Compare the counts of a period with the transfer matrix, and with those of its fill and its births."""
    tally, total = swept.tally, count_admissible(swept.p)
    wrong = [text for other in others if swept.whole for text in _differing(tally, other)]
    if tally.words > total or (swept.whole and tally.words != total):
        wrong.insert(0, f"{tally.words} sequences instead of {total}")
    if tally.n_c + tally.boundary + tally.unresolved > tally.words or tally.classes > tally.n_c:
        wrong.append("more words have a status than there are")
    return Check("sweeps", 1, int(bool(wrong)), first=f"{_label(swept, a)}: {wrong[0]}" if wrong else None)


def _differing(tally: Tally, other: Mapping[str, Any]) -> Iterator[str]:
    for name in _COUNTS:
        if (found := getattr(tally, name)) != other[name]:
            yield f"{name} is {found} instead of {other[name]}"


def _anew(swept: Sweep, a: float) -> Iterator[Check]:
    """Solve a period as a fill does, and compare its counts and sums with those of the sweep."""
    tally, sums, off = _solved(swept.p, a)
    label = _label(swept, a)
    wrong = list(_differing(swept.tally, asdict(tally)))
    yield Check("sweeps", 0, int(bool(wrong)), first=f"{label}: {wrong[0]}" if wrong else None)
    if swept.sums is None:
        return
    mine, other = (
        (*each.ranges.least, *each.ranges.greatest, *each.sums.flat) for each in (swept.sums, sums)
    )
    if len(mine) != len(other):
        yield Check("sums", 1, 1, first=label)
        return
    stored, expected = np.array(mine), np.array(other)
    worst = np.max(np.abs(stored - expected) / np.where(expected > 0, expected, 1.0), initial=0.0)
    yield measured("sums", [label], np.array([worst]), np.array([_ROUNDING + _REPETITIONS * off]))


def _solved(p: int, a: float) -> tuple[Tally, PeriodSums, float]:
    """Return the counts and the sums of a period, and by how much its lengths and lambdas may be off."""
    parts = list(least_words(Span.whole(p)))
    words = np.concatenate([unpack(part.codes, p) for part in parts])
    sizes = SIZES[np.concatenate([part.stabiliser for part in parts])]
    found = solve(words, Stadium(a))
    orbits, boundary, unresolved = (
        found.status == status for status in (Status.ORBIT, Status.BOUNDARY, Status.UNRESOLVED)
    )
    counts = (int(sizes[which].sum()) for which in (boundary, unresolved))
    tally = Tally(int(sizes.sum()), int(sizes[orbits].sum()), int(orbits.sum()), *counts)
    some = found.rows(orbits)
    walls = np.isin(some.words, (0, 2)).sum(axis=1)
    rows = ClassRows(np.full(len(some), p), sizes[orbits], some.length, some.lyapunov, walls % 2 == 1)
    off = np.max(some.lyapunov_error + some.length_error / some.length, initial=0.0)
    return tally, PeriodSums.of(rows, p), float(off)


def _label(swept: Sweep, a: float) -> str:
    return f"p = {swept.p} at a = {a:g}"
