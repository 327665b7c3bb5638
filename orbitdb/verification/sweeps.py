"""Check sweeps against the transfer matrix, fills, births, and new solutions."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, replace
from typing import Any

import numpy as np
import sqlalchemy as sa

from orbitdb.answers.whole_periods import read_classes
from orbitdb.averages.by_period import PeriodSums
from orbitdb.billiard.stadium import Stadium
from orbitdb.errors import StoreError
from orbitdb.numerals import exact
from orbitdb.orbits.classes import OrbitClasses
from orbitdb.orbits.exponents import Tally
from orbitdb.orbits.newton import solve
from orbitdb.orbits.status import Status
from orbitdb.store.asking.selection import Selection
from orbitdb.store.asking.sweepable import chosen_words, within_ranges
from orbitdb.store.file.schema import DONE
from orbitdb.store.file.tables import stadium, sweep, sweep_block
from orbitdb.store.reading import audit
from orbitdb.store.reading.fills import Sweep
from orbitdb.store.reading.lives import counts_at
from orbitdb.store.reading.moment import Moment
from orbitdb.symbols.enumeration import Span, all_least_words
from orbitdb.symbols.pruning import count_admissible
from orbitdb.symbols.symmetry import SIZES
from orbitdb.symbols.words import unpack
from orbitdb.verification.check import Check, measured, single
from orbitdb.verification.completeness import wrong_cursor, wrong_end

SWEPT_ANEW = 11
"""Highest period to solve again, which takes half a second."""

_ROUNDING = 1e-12
_REPETITIONS = 20
"""Allowed ratio of the error of a term to that of its orbit, due to the weights of repetitions."""

_COUNTS = ("n_c", "classes", "boundary", "unresolved")


def check_sweeps(moment: Moment, selections: Sequence[Selection]) -> Iterator[Check]:
    """Check the counts of every chosen period that has been swept, and the sums up to period `SWEPT_ANEW`.

    All swept subsets of such a period are checked, even if only some words were chosen.
    """
    yield from _cursors(moment.connection, {each.a: each for each in selections})
    for selection in selections:
        a = selection.a
        try:
            found = list(_swept(moment, selection))
        except StoreError as error:
            yield Check("sweeps", 1, 1, first=f"at a = {exact(a)}: {error}")
            continue
        for each, subset in found:
            others = _others(moment, each, subset) if each.whole else ()
            yield single("sweeps", _label(each, a), _wrong_counts(each, others))
            if each.whole and each.p <= SWEPT_ANEW:
                yield from _anew(each, subset)


def _cursors(connection: sa.Connection, chosen: Mapping[float, Selection]) -> Iterator[Check]:
    """Check the cursor and the number of blocks of each sweep of a chosen period."""
    blocks = sa.select(sweep_block.c.stadium, sweep_block.c.p, sweep_block.c.selection, sa.func.count())
    kept = {
        tuple(key): count for *key, count in connection.execute(blocks.group_by(*blocks.selected_columns[:3]))
    }
    query = sa.select(sweep, stadium.c.a).join(stadium).where(stadium.c.a.in_(chosen))
    for row in map(dict, connection.execute(query).mappings().all()):
        if not chosen[row["a"]].includes(row["p"]):
            continue
        if row["state"] == DONE:
            wrong = list(wrong_end(row))
        else:
            stored = kept.get((row["stadium"], row["p"], row["selection"]), 0)
            wrong = list(wrong_cursor(sweep, row))
            wrong += [f"{row['blocks']} blocks instead of {stored}"] if row["blocks"] != stored else []
        yield Check(
            "sweeps",
            0,
            len(wrong),
            first=f"p = {row['p']} at a = {exact(row['a'])}: {wrong[0]}" if wrong else None,
        )


def _swept(moment: Moment, selection: Selection) -> Iterator[tuple[Sweep, Selection]]:
    for subset in (Selection(selection.a, statuses=(Status.ORBIT,)), *moment.swept_subsets(selection.a)):
        for each in moment.sweeps(selection.a, subset):
            if selection.includes(each.p):
                yield each, replace(subset, periods=((each.p, each.p),))


def _others(moment: Moment, swept: Sweep, subset: Selection) -> Iterator[Mapping[str, Any]]:
    """Yield the counts of the same period from its fill and, if all orbits are swept, from births."""
    a, p = subset.a, swept.p
    for fill in audit.fill_rows(moment.connection):
        if (fill["a"], fill["p"], fill["state"]) == (a, p, DONE):
            yield _stored(moment, subset) if swept.selection else fill
    if not swept.selection and p in {each.p for each in moment.birth_fills() if each.whole}:
        yield vars(counts_at(moment.connection, a, p))


def _stored(moment: Moment, subset: Selection) -> Mapping[str, Any]:
    """Return the counts of a subset of a filled period; ranges apply only to orbits."""
    rows = read_classes(moment, subset)
    others = {
        status.value: moment.count(replace(subset, statuses=(status,), ranges={}))
        for status in (Status.BOUNDARY, Status.UNRESOLVED)
    }
    return {"n_c": int(rows.words.sum()), "classes": len(rows), **others}


def _wrong_counts(swept: Sweep, others: Iterable[Mapping[str, Any]]) -> Iterator[str]:
    """Yield the counts that disagree with the transfer matrix, or with the fill or births of the period."""
    tally, total = swept.tally, count_admissible(swept.p)
    if tally.words > total or (swept.whole and tally.words != total):
        yield f"{tally.words} words instead of {total}"
    for other in others:
        yield from _differing(tally, other)
    if tally.n_c + tally.boundary + tally.unresolved > tally.words or tally.classes > tally.n_c:
        yield "more words or classes than there can be"


def _differing(tally: Tally, other: Mapping[str, Any]) -> Iterator[str]:
    for name in _COUNTS:
        if (found := getattr(tally, name)) != other[name]:
            yield f"{name} is {found} instead of {other[name]}"


def _anew(swept: Sweep, subset: Selection) -> Iterator[Check]:
    """Solve a period as a fill does, and compare its counts and sums with the sweep."""
    tally, sums, off = _solved(swept.p, subset)
    label = _label(swept, subset.a)
    yield replace(single("sweeps", label, _differing(swept.tally, asdict(tally))), rows=0)
    if swept.sums is None:
        return
    stored, expected = (np.frombuffer(each.numbers()) for each in (swept.sums, sums))
    if len(stored) != len(expected):
        yield Check("sums", 1, 1, first=label)
        return
    worst = np.max(np.abs(stored - expected) / np.where(expected > 0, expected, 1.0), initial=0.0)
    yield measured("sums", [label], np.array([worst]), np.array([_ROUNDING + _REPETITIONS * off]))


def _solved(p: int, subset: Selection) -> tuple[Tally, PeriodSums, float]:
    """Return the counts and sums of a period, and the largest error of an orbit.

    The error of an orbit is the error of lambda plus the relative error of the length.
    """
    classes = all_least_words(Span.whole(p))
    sizes = chosen_words(classes, p, subset)
    found = solve(unpack(classes.codes, p), Stadium(subset.a))
    orbits, boundary, unresolved = (
        (found.status == status) & (sizes > 0)
        for status in (Status.ORBIT, Status.BOUNDARY, Status.UNRESOLVED)
    )
    orbits[orbits] = within_ranges(
        classes.codes[orbits], p, found.length[orbits], found.lyapunov[orbits], subset
    )
    counts = (int(sizes[which].sum()) for which in (boundary, unresolved))
    words = int(SIZES[classes.stabiliser].sum())
    tally = Tally(words, int(sizes[orbits].sum()), int(orbits.sum()), *counts)
    some = found.rows(orbits)
    walls = np.isin(some.words, (0, 2)).sum(axis=1)
    rows = OrbitClasses(np.full(len(some), p), sizes[orbits], some.length, some.lyapunov, walls)
    off = np.max(some.lyapunov_error + some.length_error / some.length, initial=0.0)
    return tally, PeriodSums.of(rows, p), float(off)


def _label(swept: Sweep, a: float) -> str:
    return f"p = {swept.p} at a = {exact(a)}" + (f", {swept.selection}" if swept.selection else "")
