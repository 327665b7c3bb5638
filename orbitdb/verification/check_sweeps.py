"""Check sweeps against fills and births, and up to period `SWEPT_ANEW` against new solutions."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from orbitdb.averages.by_period import PeriodSums
from orbitdb.billiard.stadium import Stadium
from orbitdb.orbits.exponents import OrbitClasses, Tally
from orbitdb.orbits.solve import solve
from orbitdb.orbits.status import Status
from orbitdb.store.lookup import counts_at
from orbitdb.store.periods import Sweep, read_birth_fills, read_sweeps
from orbitdb.store.tables import DONE
from orbitdb.symbols.edges import count_by_edges
from orbitdb.symbols.enumeration import Span, all_least_words
from orbitdb.symbols.symmetry import SIZES
from orbitdb.symbols.words import unpack
from orbitdb.text import format_float
from orbitdb.verification.check_classes import fill_rows
from orbitdb.verification.checks import Check, Scope, differences

SWEPT_ANEW = 11
"""Highest period of a sweep to solve again, which takes half a second."""

_ROUNDING = 1e-12
_REPETITIONS = 20
"""Allowed ratio of the error of a term to that of its orbit, due to the weights of repetitions."""


def check_sweeps(scope: Scope) -> Iterator[Check]:
    """Check the counts of every chosen whole period that has been swept, and the sums up to `SWEPT_ANEW`."""
    with_births = {births.p for births in read_birth_fills(scope.connection) if births.done}
    for selection in scope.selections:
        a = selection.a
        fills = {fill["p"]: fill for fill in fill_rows(scope) if (fill["a"], fill["state"]) == (a, DONE)}
        for sweep in read_sweeps(scope.connection, a):
            if not (sweep.done and selection.includes(sweep.p)):
                continue
            label = f"p = {sweep.p} at a = {format_float(a)}"
            others = [fills[sweep.p]] if sweep.p in fills else []
            if sweep.p in with_births:
                others.append(vars(counts_at(scope.connection, a, sweep.p)))
            if sweep.p <= SWEPT_ANEW:
                tally, sums, off = _solved(sweep.p, a)
                others.append(vars(tally))
                yield _compared(label, sweep.sums, sums, off)
            yield Check.single("sweeps", label, _wrong_tally(sweep, others))


def _wrong_tally(sweep: Sweep, others: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    """Yield the counts that disagree with the transfer matrix, or with other counts of the period."""
    if sweep.tally.words != (total := count_by_edges(sweep.p)):
        yield f"{sweep.tally.words} words instead of {total}"
    for counts in others:
        names = ("n_c", "classes", "boundary", "unresolved")
        yield from differences(vars(sweep.tally), {name: counts[name] for name in names})


def _compared(label: str, sums: PeriodSums | None, expected: PeriodSums, off: float) -> Check:
    """Compare the sums of a sweep with those over new solutions, given the largest error of an orbit."""
    stored, right = (np.frombuffer(b"" if of is None else of.numbers()) for of in (sums, expected))
    if len(stored) != len(right):
        return Check("sums", 1, 1, first=label)
    worst = np.max(np.abs(stored - right) / np.where(right > 0, right, 1.0), initial=0.0)
    return Check.measured("sums", [label], np.array([worst]), np.array([_ROUNDING + _REPETITIONS * off]))


def _solved(p: int, a: float) -> tuple[Tally, PeriodSums, float]:
    """Solve a period as a fill does; return its counts and sums, and the largest error of an orbit.

    The error of an orbit is the error of lambda plus the relative error of the length.
    """
    classes = all_least_words(Span.of_period(p))
    sizes = SIZES[classes.stabiliser].astype(np.int64)
    solved = solve(unpack(classes.codes, p), Stadium(a))
    exists = solved.status == Status.ORBIT
    orbits, of_orbits = solved.rows(exists), sizes[exists]
    others = (int(sizes[solved.status == of].sum()) for of in (Status.BOUNDARY, Status.UNRESOLVED))
    tally = Tally(int(sizes.sum()), int(of_orbits.sum()), len(orbits), *others)
    walls = np.isin(orbits.words, (0, 2)).sum(axis=1)
    rows = OrbitClasses(np.full(len(orbits), p), of_orbits, orbits.length, orbits.lyapunov, walls)
    off = np.max(orbits.lyapunov_error + orbits.length_error / orbits.length, initial=0.0)
    return tally, PeriodSums.of(rows, p), float(off)
