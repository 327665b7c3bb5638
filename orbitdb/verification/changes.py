"""Births and deaths against new decisions: what a class is on either side of each, and which bounce does it.

That a class changes inside its bracket is decided again, at both ends, as in
`orbitdb.orbits.births.brackets`. The bounce that is said to come through a joint must do so there, at
the speed that is stored.
"""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import sqlalchemy as sa
from numpy.typing import NDArray

from orbitdb.billiard.bounces import slack_errors
from orbitdb.billiard.legs import Chain, cut, derivatives, direction_limits
from orbitdb.billiard.stadium import MAX_A, MIN_A
from orbitdb.orbits.births.brackets import Signs, signs
from orbitdb.orbits.births.changes import JOINTS, joints
from orbitdb.orbits.births.continuation import motion, slacks_and_slopes
from orbitdb.orbits.newton import newton
from orbitdb.orbits.status import direction_errors
from orbitdb.store.asking.selection import Selection
from orbitdb.store.file.schema import BORN, DIED
from orbitdb.store.file.tables import change, cycle
from orbitdb.store.reading.audit import by_period, ids_in, sampled
from orbitdb.store.reading.soundness import sound_words
from orbitdb.symbols.words import MAX_KEYED, from_strings
from orbitdb.verification.blocks import Block, Part, blocks, is_chosen
from orbitdb.verification.check import Check, judged

Floats = NDArray[np.float64]
Marks = NDArray[np.bool_]
Words = NDArray[np.uint8]

_CLOSE = 1e-6
"""Relative, of slopes: no proof rests on them, and they are computed without bounds."""


def change_parts(
    connection: sa.Connection, selections: Sequence[Selection], sample: int | None, rng: np.random.Generator
) -> Iterator[Part]:
    """Yield blocks of the classes with births of the chosen periods, or of so many drawn at random."""
    born = by_period(connection, ids_in(connection, change.c.cycle))
    chosen = [those for p, those in born.items() if 2 <= p <= MAX_KEYED and is_chosen(p, selections)]
    drawn = sampled(np.concatenate([np.zeros(0, np.int64), *chosen]), sample, rng)
    return (block.part("births", _check_changes) for block in blocks(by_period(connection, drawn)))


def _check_changes(block: Block, connection: sa.Connection) -> Iterator[Check]:
    """Decide the births and deaths of classes of one period again."""
    query = sa.select(change, cycle.c.word).join_from(change, cycle)
    here = change.c.cycle.between(int(block.ids[0]), int(block.ids[-1]))
    found = connection.execute(query.where(here).order_by(change.c.cycle, change.c.number)).all()
    p, wanted = block.p, set(block.ids.tolist())
    rows = [row for row in found if row.cycle in wanted]
    words = sorted({row.word for row in rows})
    sound = {words[i] for i in sound_words(words, p)}
    known = [row for row in rows if row.word in sound and _is_sound(row)]
    wrong = {id(row) for row in rows} - {id(row) for row in known}
    if known:
        those = from_strings([row.word for row in known])
        failed = _wrong_sides(those, known) | _wrong_bounces(those, known)
        wrong |= {id(known[i]) for i in np.flatnonzero(failed)}
    labels = [f"{row.word} at a = {row.a:g}" for row in rows]
    yield judged("changes", labels, [id(row) in wrong for row in rows])


def _is_sound(row: Any) -> bool:
    """Tell whether a row could be a change: one at a = 0 has neither error nor bounce, any other has both."""
    path = (row.bounce, row.joint, row.slope)
    if row.a == 0:
        return (row.error, row.kind, row.number, *path) == (0, BORN, 1, None, None, None)
    inside = row.a - row.error >= MIN_A and row.error > 0 and row.a + row.error <= MAX_A
    return inside and row.kind in (BORN, DIED) and row.joint in JOINTS and None not in path


def _wrong_sides(words: Words, rows: Sequence[Any]) -> Marks:
    """Tell which changes are none: what a class is just below and above, and at the least a before all."""
    a, error = (np.array([getattr(row, name) for row in rows]) for name in ("a", "error"))
    born = np.array([1 if row.kind == BORN else -1 for row in rows])
    low, high = np.where(a == 0, MIN_A, a - error), np.where(a == 0, MIN_A, a + error)
    wrong: Marks = _signs(words, high) != born
    moving = np.flatnonzero(a > 0)
    wrong[moving] |= _signs(words[moving], low[moving]) != -born[moving]
    return wrong


def _signs(words: Words, a: Floats) -> Signs:
    """Tell which words are orbits, each at its own a: 1, -1, or 0 where balls do not decide it either."""
    sign = np.zeros(len(words), np.int8)
    for here, legs in cut(words):
        sign[here] = signs(words[here], legs, a[here], newton(legs, a[here]).alpha)
    return sign


def _wrong_bounces(words: Words, rows: Sequence[Any]) -> Marks:
    """Tell which changes are not those of the bounce, the joint and the slope that are stored."""
    wrong = np.array([row.a > 0 for row in rows])
    moving, later = np.flatnonzero(wrong), [row for row in rows if row.a > 0]
    a, error, slope, bounce = (
        np.array([getattr(row, name) for row in later]) for name in ("a", "error", "slope", "bounce")
    )
    joint = np.array([JOINTS.index(row.joint) for row in later], dtype=np.int64)
    for here, legs in cut(words[moving]):
        slack, slopes, off = _slacks(legs, a[here])
        at_joint = np.abs(slack) <= 2 * np.abs(slopes) * (error / a)[here] + off
        like = np.abs(slopes - slope[here]) <= _CLOSE * np.abs(slope[here])
        which, row = np.nonzero(at_joint & like)
        mine = here[row]
        found = joints(words[moving][mine], which)
        same = (found[0] == bounce[mine]) & (found[1] == joint[mine])
        wrong[moving[mine[same]]] = False
    return wrong


def _slacks(legs: Chain, a: Floats) -> tuple[Floats, Floats, Floats]:
    """Return the smooth slacks at the maxima, their slopes in ln a, and a bound on the slacks' errors."""
    limits = direction_limits(legs, a)
    alpha = newton(legs, a).alpha
    _, drift = motion(legs, a, alpha, limits)
    slopes = derivatives(legs, a, alpha)
    errors = direction_errors(legs, a, alpha, slopes)
    return *slacks_and_slopes(legs, alpha, drift), 2 * slack_errors(legs, errors).max(axis=(0, 1))
