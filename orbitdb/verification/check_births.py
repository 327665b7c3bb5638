"""Check births and deaths against new solutions, and against every fill.

The status at both ends of the bracket around a birth or death is decided again. That none is missing is
proved cell by cell in ln a, by another method than the one that found them.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import groupby
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from orbitdb.arrays import Floats, Integers, Marks, Words
from orbitdb.billiard.legs import cut
from orbitdb.billiard.stadium import MAX_A, MIN_A
from orbitdb.orbits.births import JOINTS, events, find_changes, signs
from orbitdb.orbits.missing_births import Completeness, KnownChange, prove_all
from orbitdb.orbits.newton import newton
from orbitdb.store.lookup import counts_at
from orbitdb.store.periods import BirthFill, count_births, read_birth_fills
from orbitdb.store.tables import BORN, DIED, DONE
from orbitdb.symbols.edges import count_by_edges
from orbitdb.symbols.words import from_strings
from orbitdb.text import format_float, shortened
from orbitdb.verification.check_classes import fill_rows
from orbitdb.verification.checks import LISTED, Block, Check, Part, Scope, blocks, differences

_SLOPES = 1e-6
"""Relative difference of slopes: they are taken at values of a that differ by the error of a change."""

_BORN = "(SELECT * FROM cycle WHERE id IN (SELECT cycle FROM change))"
"""The classes with births."""

BLOCK = 1000
"""Number of classes to prove at once, which takes a few hundred megabytes."""


def whole_births(scope: Scope) -> list[BirthFill]:
    """Return the periods with complete births that are chosen at some a, or all without selections."""
    stored = read_birth_fills(scope.connection)
    return [births for births in stored if births.done and scope.chooses(births.p)]


def check_births(scope: Scope) -> Iterator[Check]:
    """Check complete births of the chosen periods, and the counts that follow from them at every filled a."""
    fills = [fill for fill in fill_rows(scope) if fill["state"] == DONE]
    for births in whole_births(scope):
        rows = change_rows(scope, births.p)
        found = [*_wrong_changes(rows), *_wrong_birth_counts(scope, births), *_wrong_events(rows)]
        yield Check.listed("births", len(rows), found)
        for fill in fills:
            if fill["p"] == births.p:
                tally = vars(counts_at(scope.connection, fill["a"], fill["p"]))
                counts = {"n_t": tally["words"], **tally, "words": fill["words"]}
                wrong = {name: count for name, count in counts.items() if count != fill[name]}
                faults = (f"{name} is {count} according to births" for name, count in wrong.items())
                yield Check.single("births", f"p = {fill['p']} at a = {format_float(fill['a'])}", faults)


class ChangeRow(NamedTuple):
    """A stored birth or death, with the representative of its class."""

    number: int
    a: float
    error: float
    kind: str
    bounce: int | None
    joint: str | None
    event: int | None
    slope: float | None
    word: str


def change_rows(scope: Scope, p: int, ids: Integers | None = None) -> list[ChangeRow]:
    """Return births and deaths of a period, or only those of some classes, by class and number."""
    only = "" if ids is None else f"AND cycle {LISTED}"
    query = f"""SELECT {", ".join(ChangeRow._fields)} FROM change JOIN cycle ON cycle.id = change.cycle
        WHERE p = :p {only} ORDER BY cycle, number"""
    return [ChangeRow(*row) for row in scope.query(query, p=p, ids=ids)]


def _wrong_changes(rows: Sequence[Any]) -> Iterator[str]:
    """Yield the classes whose changes are not numbered by ascending a, or whose kinds do not alternate."""
    for word, of_class in groupby(rows, key=lambda row: str(row.word)):
        changes = list(of_class)
        numbered = [(n, BORN if n % 2 else DIED) for n in range(1, len(changes) + 1)]
        places = [row.a for row in changes]
        if (
            [(row.number, row.kind) for row in changes] != numbered
            or len(changes) % 2 == 0
            or places != sorted(set(places))
            or not all(0 <= row.error <= row.a for row in changes)
        ):
            yield shortened(word)


def _wrong_events(rows: Sequence[ChangeRow]) -> Iterator[str]:
    """Yield the changes of a complete period whose events are not numbered by ascending a."""
    moving = [row for row in rows if row.a > 0]
    right = events(*(np.array([getattr(row, name) for row in moving]) for name in ("a", "error")))
    for row, event in zip(moving, right.tolist(), strict=True):
        if row.event != event:
            yield f"{shortened(row.word)}: event {row.event} instead of {event}"
    yield from (f"{shortened(row.word)}: an event at a = 0" for row in rows if row.a == 0 and row.event)


def _wrong_birth_counts(scope: Scope, fill: BirthFill) -> Iterator[str]:
    counts = count_births(scope.connection, fill.p)
    stored, expected = {"words": counts["words"]}, {"words": count_by_edges(fill.p)}
    for fault in differences(vars(fill) | stored, counts | expected):
        yield f"p = {fill.p}: {fault}"


def births(scope: Scope) -> Iterator[Part]:
    """Check the status on both sides of each birth and death in the chosen periods, or of a sample."""
    rng = np.random.default_rng([scope.seed, 1])
    for block in blocks(scope.sampled(scope.ids(_BORN), rng)):
        yield block.part("births", _check_changes)


def _check_changes(block: Block, scope: Scope) -> Iterator[Check]:
    """Check the status on both sides of each birth and death, and where the paths touch the joints."""
    rows = change_rows(scope, block.p, block.ids)
    a, error = (np.array([getattr(row, name) for row in rows]) for name in ("a", "error"))
    number, born = np.array([(row.number, 1 if row.kind == BORN else -1) for row in rows]).T
    always = (a == 0) & (error == 0) & (born > 0) & (number == 1)
    in_range = (a > 0) & (error > 0) & (a - error >= MIN_A) & (a + error <= MAX_A)
    wrong = ~(always | in_range)
    if not wrong.any():
        wrong = _wrong_sides(from_strings([row.word for row in rows]), a, error, born)
        wrong |= _wrong_joints(rows)
    labels = [f"{row.word} at a = {format_float(row.a)}" for row in rows]
    yield replace(Check.judged("births", labels, wrong), rows=0)  # counted already


def _wrong_sides(words: Words, a: Floats, error: Floats, born: Integers) -> Marks:
    """Tell which changes contradict the statuses just below and above them, or at `MIN_A` for a = 0."""
    wrong: Marks = _signs(words, np.where(a == 0, MIN_A, a + error)) != born
    moving = np.flatnonzero(a > 0)
    wrong[moving] |= _signs(words[moving], (a - error)[moving]) != -born[moving]
    return wrong


def _wrong_joints(rows: Sequence[ChangeRow]) -> Marks:
    """Tell which changes have another bounce, joint or slope than a new search for births finds."""
    words = list(dict.fromkeys(row.word for row in rows))
    found = find_changes(from_strings(words))
    names = ("word", "bounce", "joint", "slope")
    anew: dict[str, list[tuple[int, str, float]]] = {word: [] for word in words}
    for word, bounce, joint, slope in zip(*(getattr(found, each).tolist() for each in names), strict=True):
        anew[words[word]].append((bounce, JOINTS[joint], slope))
    wrong = np.zeros(len(rows), bool)
    for place, row in enumerate(rows):
        if row.a > 0:
            bounce, joint, slope = anew[row.word].pop(0) if anew[row.word] else (None, None, math.nan)
            same = (row.bounce, row.joint) == (bounce, joint)
            wrong[place] = not (same and math.isclose(row.slope or 0.0, slope, rel_tol=_SLOPES))
    return wrong


def _signs(words: Words, a: Floats) -> NDArray[np.int8]:
    """Return 1 for each word that is an orbit at its own a, -1 if not, 0 if ball arithmetic cannot decide."""
    sign = np.zeros(len(words), np.int8)
    for rows, legs in cut(words):
        sign[rows] = signs(words[rows], legs, a[rows], newton(legs, a[rows]).alpha)
    return sign


def lives(scope: Scope, size: int = BLOCK) -> Iterator[Part]:
    """Prove that no birth or death is missing in the chosen periods with complete births, block by block."""
    born = scope.ids(_BORN)
    for fill in whole_births(scope):
        for block in blocks({fill.p: born[fill.p]} if fill.p in born else {}, size):
            yield block.part("missing births", _prove_lives)


def _prove_lives(block: Block, scope: Scope) -> Iterator[Check]:
    """Prove that no birth or death is missing in a block.

    Classes that are decided count as rows of the check ``lives``; classes whose cells become too small before
    that, as rows of ``undecided``.
    """
    brackets: dict[str, list[KnownChange]] = {}
    for row in change_rows(scope, block.p, block.ids):
        changes = brackets.setdefault(row.word, [])
        if row.a > row.error:
            low, high = np.log([row.a - row.error, row.a + row.error]).tolist()
            changes.append((low, high, row.kind == BORN))
    proved = prove_all(from_strings(list(brackets)), list(brackets.values()))
    undecided = int((proved == Completeness.UNDECIDED).sum())
    judgement = Check.judged("lives", list(brackets), proved == Completeness.WRONG)
    yield replace(judgement, rows=len(brackets) - undecided)
    if undecided:
        yield Check("undecided", undecided)
