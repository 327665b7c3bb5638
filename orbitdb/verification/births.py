"""Check births and deaths: their order, agreement with fills, brackets and bounces, and that none is missing.

The status at both ends of the bracket around a birth or death is decided again, as in
`orbitdb.orbits.births`. The stored bounce must pass through its joint there, at the stored speed.
That none is missing is proved cell by cell in ln a, by another method than the one that found them.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, replace
from itertools import groupby
from typing import Any

import numpy as np
import sqlalchemy as sa
from numpy.typing import NDArray

from orbitdb.arrays import Floats, Marks, Words
from orbitdb.billiard.legs import Chain, cut, derivatives, direction_limits, slack_errors
from orbitdb.billiard.stadium import MAX_A, MIN_A
from orbitdb.numerals import exact
from orbitdb.orbits.births import JOINTS, events, joints, signs
from orbitdb.orbits.continuation import motion, slacks_and_slopes
from orbitdb.orbits.error_bounds import direction_errors
from orbitdb.orbits.missing_births import KnownChange, Verdict, prove_all
from orbitdb.orbits.newton import newton
from orbitdb.plaintext import shortened
from orbitdb.store.asking.selection import Selection
from orbitdb.store.file.schema import BORN, DIED, DONE
from orbitdb.store.file.tables import birth_fill, change, cycle
from orbitdb.store.reading import audit
from orbitdb.store.reading.lives import BirthFill, birth_fills, counts_at
from orbitdb.store.reading.soundness import sound_words
from orbitdb.symbols.pruning import count_admissible
from orbitdb.symbols.words import from_strings
from orbitdb.verification.check import (
    Block,
    Check,
    Checked,
    Part,
    blocks,
    is_chosen,
    judged,
    listed,
    single,
)

BLOCK = 1000
"""Number of classes to prove at once, which takes a few hundred megabytes."""

_CLOSE = 1e-6
"""Relative tolerance for slopes. They have no error bounds, and no proof depends on them."""


def whole_births(connection: sa.Connection, selections: Sequence[Selection] = ()) -> list[BirthFill]:
    """Return the periods with complete births that are chosen at some a, or all without selections."""
    return [found for found in birth_fills(connection) if found.whole and is_chosen(found.p, selections)]


def check_births(selections: Sequence[Selection], connection: sa.Connection) -> Iterator[Check]:
    """Check complete births of the chosen periods, and the counts that follow from them at every filled a.

    Every period with births needs a row in `birth_fill`.
    """
    fills = [fill for fill in audit.fill_rows(connection) if fill["state"] == DONE]
    known = cycle.c.p.in_(sa.select(birth_fill.c.p))
    unknown = sa.select(cycle.c.p).join_from(change, cycle).where(~known).distinct().order_by(cycle.c.p)
    for p in connection.scalars(unknown).all():
        yield Check("births", 0, 1, first=f"p = {p}: births without a row in birth_fill")
    for found in whole_births(connection, selections):
        rows = audit.change_rows(connection, found.p)
        wrong = [*_wrong_changes(rows), *_wrong_events(rows), *_wrong_counts(connection, found)]
        yield listed("births", len(rows), wrong)
        for fill in fills:
            if fill["p"] == found.p:
                yield single(
                    "births", f"p = {fill['p']} at a = {exact(fill['a'])}", _against(connection, fill)
                )


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


def _wrong_events(rows: Sequence[Any]) -> Iterator[str]:
    """Yield the changes with a wrong event number; changes at the same a share one, and a = 0 has none."""
    moving = [row for row in rows if row.a > 0]
    a, error = (np.array([getattr(row, name) for row in moving]) for name in ("a", "error"))
    for row, event in zip(moving, events(a, error).tolist() if moving else (), strict=True):
        if row.event != event:
            yield f"{shortened(row.word)}: event {row.event} instead of {event}"
    yield from (shortened(row.word) for row in rows if row.a == 0 and row.event is not None)


def _wrong_counts(connection: sa.Connection, found: BirthFill) -> Iterator[str]:
    """Yield the wrong counts of a period; here SQLite counts, not the code that stored the counts."""
    born, died = (sa.and_(change.c.a > 0, change.c.kind == kind) for kind in (BORN, DIED))
    first, count = change.c.number == 1, sa.func.count
    births = sa.case((born, change.c.a))
    counts = {
        "words": sa.func.sum(sa.case((first, cycle.c.class_size), else_=0)),
        "classes": count(sa.distinct(change.c.cycle)),
        "births": count(births),
        "deaths": count(sa.distinct(sa.case((died, change.c.cycle)))),
        "always": count(sa.case((change.c.a == 0, 1))),
        "least": sa.func.min(births),
        "largest": sa.func.max(births),
    }
    query = sa.select(*counts.values()).join_from(change, cycle).where(cycle.c.p == found.p)
    values = dict(zip(counts, connection.execute(query).one(), strict=True))
    pairs = [("words", values.pop("words"), count_admissible(found.p))]
    for name, stored, value in pairs + [
        (name, getattr(found, name), value) for name, value in values.items()
    ]:
        if stored != value:
            yield f"p = {found.p}: {name} is {stored} instead of {value}"


def _against(connection: sa.Connection, fill: Mapping[str, Any]) -> Iterator[str]:
    tally = asdict(counts_at(connection, fill["a"], fill["p"]))
    for name, value in {"n_t": tally.pop("words"), **tally}.items():
        if value != fill[name]:
            yield f"{name} is {value} according to births"


def prove_lives(connection: sa.Connection, periods: Iterable[BirthFill]) -> Iterator[Checked]:
    """Prove, block by block, that no birth or death is missing in the given periods.

    Classes that are decided count as rows of the check ``lives``; classes whose cells become too small before
    that, as rows of ``undecided``.
    """
    for found in periods:
        changes = groupby(audit.change_rows(connection, found.p), key=lambda row: str(row.word))
        every = [(word, _known(rows)) for word, rows in changes]
        classes = [every[i] for i in sound_words([word for word, _ in every], found.p)]
        for start in range(0, len(classes), BLOCK):
            block = classes[start : start + BLOCK]
            words = [word for word, _ in block]
            verdict, _ = prove_all(from_strings(words), [known for _, known in block])
            unknown = int((verdict == Verdict.UNDECIDED).sum())
            proved = judged("lives", words, verdict == Verdict.WRONG)
            checks = [replace(proved, rows=len(words) - unknown)]
            checks += [Check("undecided", unknown)] * (unknown > 0)
            yield Checked(f"missing births, p = {found.p}", start + len(block), len(classes), tuple(checks))


def _known(rows: Iterable[Any]) -> list[KnownChange]:
    moving = [row for row in rows if row.a > row.error]
    return [
        (float(np.log(row.a - row.error)), float(np.log(row.a + row.error)), row.kind == BORN)
        for row in moving
    ]


def change_parts(
    connection: sa.Connection, selections: Sequence[Selection], sample: int | None, rng: np.random.Generator
) -> Iterator[Part]:
    """Yield parts that check the classes with births in the chosen periods, or a random sample of these."""
    born = audit.by_period(connection, audit.ids_in(connection, change.c.cycle))
    chosen = [those for p, those in born.items() if is_chosen(p, selections)]
    drawn = audit.sampled(np.concatenate([np.zeros(0, np.int64), *chosen]), sample, rng)
    return (block.part("births", _check_changes) for block in blocks(audit.by_period(connection, drawn)))


def _check_changes(block: Block, connection: sa.Connection) -> Iterator[Check]:
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
    labels = [f"{row.word} at a = {exact(row.a)}" for row in rows]
    yield judged("changes", labels, [id(row) in wrong for row in rows])


def _is_sound(row: Any) -> bool:
    """Tell whether a row is plausible: it has no error and no bounce at a = 0, and both elsewhere."""
    path = (row.bounce, row.joint, row.slope)
    if row.a == 0:
        return (row.error, row.kind, row.number, *path) == (0, BORN, 1, None, None, None)
    inside = row.a - row.error >= MIN_A and row.error > 0 and row.a + row.error <= MAX_A
    return inside and row.kind in (BORN, DIED) and row.joint in JOINTS and None not in path


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


def _wrong_bounces(words: Words, rows: Sequence[Any]) -> Marks:
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
    """Return the smooth slacks at the maximal lengths, their slopes in ln a, and bounds on their errors."""
    limits = direction_limits(legs, a)
    alpha = newton(legs, a).alpha
    _, drift = motion(legs, a, alpha, limits)
    slopes = derivatives(legs, a, alpha)
    errors = direction_errors(legs, a, alpha, slopes)
    return *slacks_and_slopes(legs, alpha, drift), 2 * slack_errors(legs, errors).max(axis=(0, 1))
