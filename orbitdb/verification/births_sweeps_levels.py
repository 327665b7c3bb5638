"""Check births, sweeps and quantum levels, each against new solutions and against whatever else is stored.

The status at both ends of the bracket around a birth or death is decided again. That none is missing is
proved cell by cell in ln a, by another method than the one that found them.

The words of a swept period are solved again, up to period `SWEPT_ANEW`. Levels are found again on another
grid; their number must be the same, and they must agree within their errors.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, replace
from functools import partial
from itertools import groupby
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from orbitdb.answers.levels import stored_levels
from orbitdb.arrays import Floats, Integers, Marks, Words
from orbitdb.averages.by_period import PeriodSums
from orbitdb.billiard.legs import cut
from orbitdb.billiard.stadium import MAX_A, MIN_A, Stadium
from orbitdb.orbits.births import signs
from orbitdb.orbits.exponents import OrbitClasses, Tally
from orbitdb.orbits.missing_births import KnownChange, Verdict, prove_all
from orbitdb.orbits.newton import newton, solve
from orbitdb.orbits.status import Status
from orbitdb.quantum.levels import ROUNDING, windows
from orbitdb.quantum.weyl import Parity
from orbitdb.store.connection import Connection, Moment
from orbitdb.store.fills import Sweep, read_sweeps
from orbitdb.store.lives import BirthFill, counts_at, read_birth_fills
from orbitdb.store.rows import LISTED, as_list
from orbitdb.store.schema import BORN, DIED, DONE
from orbitdb.store.selection import Selection
from orbitdb.symbols.enumeration import Span, all_least_words
from orbitdb.symbols.pruning import count_admissible
from orbitdb.symbols.symmetry import SIZES
from orbitdb.symbols.words import from_strings, unpack
from orbitdb.text import exact, shortened
from orbitdb.verification.checks import (
    Block,
    Check,
    Checked,
    Part,
    blocks,
    by_period,
    is_chosen,
    judged,
    listed,
    measured,
    sampled,
    single,
)
from orbitdb.verification.classes import fill_rows

SWEPT_ANEW = 11
"""Highest period of a sweep to solve again, which takes half a second."""

_ROUNDING = 1e-12
_REPETITIONS = 20
"""Allowed ratio of the error of a term to that of its orbit, due to the weights of repetitions."""

_GRID = (20, 2)
"""Degree, and divisions of the cells at the joint: a finer grid than that on which levels are found."""

BLOCK = 1000
"""Number of classes to prove at once, which takes a few hundred megabytes."""


def whole_births(connection: Connection, selections: Sequence[Selection] = ()) -> list[BirthFill]:
    """Return the periods with complete births that are chosen at some a, or all without selections."""
    return [
        births for births in read_birth_fills(connection) if births.whole and is_chosen(births.p, selections)
    ]


def check_births(selections: Sequence[Selection], connection: Connection) -> Iterator[Check]:
    """Check complete births of the chosen periods, and the counts that follow from them at every filled a."""
    fills = [fill for fill in fill_rows(connection) if fill["state"] == DONE]
    for births in whole_births(connection, selections):
        rows = change_rows(connection, births.p)
        yield listed("births", len(rows), [*_wrong_changes(rows), *_wrong_counts(connection, births)])
        for fill in fills:
            if fill["p"] == births.p:
                label = f"p = {fill['p']} at a = {exact(fill['a'])}"
                yield single("births", label, _against_fill(connection, fill))


class ChangeRow(NamedTuple):
    """A stored birth or death, with the representative of its class."""

    cycle: int
    number: int
    a: float
    error: float
    kind: str
    word: str


def change_rows(connection: Connection, p: int, ids: Integers | None = None) -> list[ChangeRow]:
    """Return births and deaths of a period, or only those of some classes, by class and number."""
    only = "" if ids is None else f"AND cycle {LISTED}"
    query = f"""SELECT {", ".join(ChangeRow._fields)} FROM change JOIN cycle ON cycle.id = change.cycle
        WHERE p = :p {only} ORDER BY cycle, number"""
    values = {"p": p} if ids is None else {"p": p, "ids": as_list(ids)}
    return [ChangeRow(*row) for row in connection.execute(query, values)]


def _wrong_changes(rows: Sequence[Any]) -> Iterator[str]:
    """Yield the classes whose changes are not numbered by ascending a, or whose kinds do not alternate."""
    for _, changes in groupby(rows, key=lambda row: row.cycle):
        own = list(changes)
        kinds = [DIED if n % 2 else BORN for n in range(len(own))]
        places = [row.a for row in own]
        if (
            [row.number for row in own] != list(range(1, len(own) + 1))
            or [row.kind for row in own] != kinds
            or len(own) % 2 == 0
            or places != sorted(set(places))
            or not all(0 <= row.error <= row.a for row in own)
        ):
            yield shortened(own[0].word)


def _wrong_counts(connection: Connection, fill: BirthFill) -> Iterator[str]:
    """Yield the wrong counts of a period; here SQLite counts, not the code that stored the counts."""
    (values,) = connection.records(_COUNTS, {"p": fill.p, "born": BORN, "died": DIED})
    pairs = [("words", values.pop("words"), count_admissible(fill.p))]
    for name, stored, value in pairs + [(name, getattr(fill, name), value) for name, value in values.items()]:
        if stored != value:
            yield f"p = {fill.p}: {name} is {stored} instead of {value}"


_COUNTS = """\
SELECT sum(iif(number = 1, class_size, 0)) AS words,
       count(DISTINCT cycle) AS classes,
       count(iif(kind = :born AND a > 0, 1, NULL)) AS births,
       count(DISTINCT iif(kind = :died AND a > 0, cycle, NULL)) AS deaths,
       count(iif(a = 0, 1, NULL)) AS always,
       min(iif(kind = :born AND a > 0, a, NULL)) AS least,
       max(iif(kind = :born AND a > 0, a, NULL)) AS largest
FROM change JOIN cycle ON cycle.id = change.cycle WHERE p = :p"""


def _against_fill(connection: Connection, fill: Mapping[str, Any]) -> Iterator[str]:
    tally = asdict(counts_at(connection, fill["a"], fill["p"]))
    for name, value in {"n_t": tally.pop("words"), **tally}.items():
        if value != fill[name]:
            yield f"{name} is {value} according to births"


def prove_lives(connection: Connection, periods: Iterable[BirthFill]) -> Iterator[Checked]:
    """Prove, block by block, that no birth or death is missing in the given periods.

    Classes that are decided count as rows of the check ``lives``; classes whose cells become too small before
    that, as rows of ``undecided``.
    """
    for births in periods:
        changes = groupby(change_rows(connection, births.p), key=lambda row: str(row.word))
        classes = [(word, _brackets(rows)) for word, rows in changes]
        for start in range(0, len(classes), BLOCK):
            block = classes[start : start + BLOCK]
            words = [word for word, _ in block]
            verdict, _ = prove_all(from_strings(words), [brackets for _, brackets in block])
            unknown = int((verdict == Verdict.UNDECIDED).sum())
            proved = judged("lives", words, verdict == Verdict.WRONG)
            checks = [replace(proved, rows=len(words) - unknown)]
            checks += [Check("undecided", unknown)] * (unknown > 0)
            yield Checked(f"missing births, p = {births.p}", start + len(block), len(classes), tuple(checks))


def _brackets(rows: Iterable[Any]) -> list[KnownChange]:
    return [
        (float(np.log(row.a - row.error)), float(np.log(row.a + row.error)), row.kind == BORN)
        for row in rows
        if row.a > row.error
    ]


def change_parts(
    connection: Connection, selections: Sequence[Selection], sample: int | None, rng: np.random.Generator
) -> Iterator[Part]:
    """Yield parts that check the classes with births in the chosen periods, or a random sample of these."""
    classes = connection.execute("SELECT DISTINCT cycle FROM change").fetchall()
    born = by_period(connection, only=np.array(classes, np.int64))
    chosen = [ids for p, ids in born.items() if is_chosen(p, selections)]
    drawn = sampled(np.concatenate([np.zeros(0, np.int64), *chosen]), sample, rng)
    return (block.part("births", _check_changes) for block in blocks(by_period(connection, only=drawn)))


def _check_changes(block: Block, connection: Connection) -> Iterator[Check]:
    """Check the status on both sides of each birth and death."""
    rows = change_rows(connection, block.p, block.ids)
    words = from_strings([row.word for row in rows])
    wrong = ~np.array([_is_possible(row) for row in rows])
    if not wrong.any():
        wrong = _wrong_sides(words, rows)
    labels = [f"{row.word} at a = {exact(row.a)}" for row in rows]
    yield replace(judged("births", labels, wrong), rows=0)  # counted already


def _is_possible(row: Any) -> bool:
    """Tell whether a birth at a = 0 is exact, and the bracket of any other birth or death is in range."""
    if row.a == 0:
        return (row.error, row.kind, row.number) == (0, BORN, 1)
    return row.a - row.error >= MIN_A and row.error > 0 and row.a + row.error <= MAX_A


def _wrong_sides(words: Words, rows: Sequence[Any]) -> Marks:
    """Tell which changes contradict the statuses just below and above them, or at `MIN_A` for a = 0."""
    a, error = (np.array([getattr(row, name) for row in rows]) for name in ("a", "error"))
    born = np.array([1 if row.kind == BORN else -1 for row in rows])
    low, high = np.where(a == 0, MIN_A, a - error), np.where(a == 0, MIN_A, a + error)
    wrong: Marks = _signs(words, high) != born
    moving = np.flatnonzero(a > 0)
    wrong[moving] |= _signs(words[moving], low[moving]) != -born[moving]
    return wrong


def _signs(words: Words, a: Floats) -> NDArray[np.int8]:
    """Return 1 for each word that is an orbit at its own a, -1 if not, 0 if ball arithmetic cannot decide."""
    sign = np.zeros(len(words), np.int8)
    for here, legs in cut(words):
        sign[here] = signs(words[here], legs, a[here], newton(legs, a[here]).alpha)
    return sign


def check_sweeps(moment: Moment, selections: Sequence[Selection]) -> Iterator[Check]:
    """Check the counts of every chosen whole period that has been swept, and the sums up to `SWEPT_ANEW`."""
    for selection in selections:
        for sweep in read_sweeps(moment, selection.a):
            if sweep.whole and selection.includes(sweep.p):
                label = f"p = {sweep.p} at a = {exact(selection.a)}"
                yield single("sweeps", label, _wrong_tally(moment, sweep, selection.a))
                if sweep.p <= SWEPT_ANEW:
                    yield from _anew(sweep, selection.a, label)


def _wrong_tally(moment: Moment, sweep: Sweep, a: float) -> Iterator[str]:
    """Yield the counts that disagree with the transfer matrix, or with the fill or births of the period."""
    if sweep.tally.words != (total := count_admissible(sweep.p)):
        yield f"{sweep.tally.words} words instead of {total}"
    for fill in fill_rows(moment):
        if (fill["a"], fill["p"], fill["state"]) == (a, sweep.p, DONE):
            yield from _differing(sweep.tally, fill)
    if sweep.p in {births.p for births in read_birth_fills(moment) if births.whole}:
        yield from _differing(sweep.tally, vars(counts_at(moment, a, sweep.p)))


def _differing(tally: Tally, other: Mapping[str, Any]) -> Iterator[str]:
    for name in ("n_c", "classes", "boundary", "unresolved"):
        if (count := getattr(tally, name)) != other[name]:
            yield f"{name} is {count} instead of {other[name]}"


def _anew(sweep: Sweep, a: float, label: str) -> Iterator[Check]:
    """Solve a period as a fill does, and compare its counts and sums with the sweep."""
    tally, sums, off = _solved(sweep.p, a)
    yield replace(single("sweeps", label, _differing(sweep.tally, asdict(tally))), rows=0)
    if sweep.sums is None:
        return
    stored, expected = (np.frombuffer(measures.numbers()) for measures in (sweep.sums, sums))
    if len(stored) != len(expected):
        yield Check("sums", 1, 1, first=label)
        return
    worst = np.max(np.abs(stored - expected) / np.where(expected > 0, expected, 1.0), initial=0.0)
    yield measured("sums", [label], np.array([worst]), np.array([_ROUNDING + _REPETITIONS * off]))


def _solved(p: int, a: float) -> tuple[Tally, PeriodSums, float]:
    """Return the counts and sums of a period, and the largest error of an orbit.

    The error of an orbit is the error of lambda plus the relative error of the length.
    """
    classes = all_least_words(Span.whole(p))
    sizes = SIZES[classes.stabiliser].astype(np.int64)
    solved = solve(unpack(classes.codes, p), Stadium(a))
    is_orbit, boundary, unresolved = (
        solved.status == status for status in (Status.ORBIT, Status.BOUNDARY, Status.UNRESOLVED)
    )
    orbits, of_orbits = solved.rows(is_orbit), sizes[is_orbit]
    counts = (int(sizes[which].sum()) for which in (boundary, unresolved))
    tally = Tally(int(sizes.sum()), int(of_orbits.sum()), len(orbits), *counts)
    walls = np.isin(orbits.words, (0, 2)).sum(axis=1)
    rows = OrbitClasses(np.full(len(orbits), p), of_orbits, orbits.length, orbits.lyapunov, walls)
    off = np.max(orbits.lyapunov_error + orbits.length_error / orbits.length, initial=0.0)
    return tally, PeriodSums.of(rows, p), float(off)


def level_parts(connection: Connection) -> Iterator[Part]:
    """Yield parts that check the quantum levels of each parity at each a."""
    for a, parity in connection.execute("SELECT DISTINCT a, parity FROM level_fill ORDER BY a, parity"):
        yield Part(f"levels {parity} at a = {exact(a)}", partial(_levels, a, parity))


def _levels(a: float, parity: str, connection: Connection) -> Iterator[Check]:
    """Check the numbers of levels in and below each window and, if they are right, each level."""
    for stored in stored_levels(connection, a, Parity(parity)):
        tasks = windows(Stadium(stored.a), stored.parity, stored.low, stored.high)
        anew = [task.solved(*_GRID) for task in tasks]
        k = np.concatenate([window.k for window in anew])
        if (stored.below, len(stored.k)) != (anew[0].below, len(k)):
            yield judged("levels", [f"{parity} {stored.low:g} to {stored.high:g}"], [True])
        else:
            labels = [f"{parity} {each:.6g}" for each in stored.k]
            yield measured("levels", labels, np.abs(stored.k - k), stored.error + ROUNDING * k)
