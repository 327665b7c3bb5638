"""Storing births and deaths, and how far the changes of a period are stored, in one transaction."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import sqlalchemy as sa

from orbitdb.orbits.batches import JOINTS
from orbitdb.orbits.births import Changes, events
from orbitdb.store.file.schema import BORN, DIED, DONE, FILLING, birth_fill, change, cycle
from orbitdb.store.writing.cursors import OvertakenError, end_of
from orbitdb.store.writing.insertion import insert
from orbitdb.store.writing.writer import Writer
from orbitdb.symbols.enumeration import Span
from orbitdb.symbols.words import keys_of_period


@dataclass(frozen=True)
class BirthCursor:
    """How far the changes of one period are stored.

    Attributes
    ----------
    p : int
    state : str
        ``filling`` or ``done``.
    word : str or None
        The changes of all words up to this one, in the order of their texts, are stored.
    words : int
        How many words that are.
    """

    p: int
    state: str
    word: str | None
    words: int

    @property
    def after(self) -> int:
        """The packed word behind which the work goes on."""
        return -1 if self.word is None else int(self.word, 8)


def open_births(connection: sa.Connection, p: int) -> BirthCursor:
    """Return how far the changes of a period are stored, which may be nothing."""
    row = connection.execute(sa.select(birth_fill).where(birth_fill.c.p == p)).first()
    return (
        BirthCursor(p, FILLING, None, 0) if row is None else BirthCursor(p, row.state, row.cursor, row.words)
    )


def move_births(
    connection: sa.Connection, cursor: BirthCursor, span: Span, words: int, seconds: float
) -> BirthCursor:
    """Note that the changes of a span behind the cursor are stored, and what that took.

    Raises
    ------
    OvertakenError
        If another process has moved the same cursor.
    """
    fresh = sa.insert(birth_fill).prefix_with("OR IGNORE")
    connection.execute(fresh.values(p=cursor.p, state=FILLING, seconds=0.0, words=0))
    last = end_of(span)
    here = (birth_fill.c.p == cursor.p) & (birth_fill.c.state == FILLING)
    moved = connection.execute(
        sa.update(birth_fill)
        .where(here, birth_fill.c.cursor.is_not_distinct_from(cursor.word))
        .values(cursor=last, words=cursor.words + words, seconds=birth_fill.c.seconds + seconds)
    )
    if moved.rowcount != 1:
        raise OvertakenError
    return replace(cursor, word=last, words=cursor.words + words)


def add_changes(
    writer: Writer,
    connection: sa.Connection,
    numbers: Sequence[int],
    changes: Changes,
    computed: str | None = None,
) -> None:
    """Store the changes of classes by their numbers, with the arithmetic that computed them.

    Those that are always orbits are born at 0.
    """
    always = np.flatnonzero(changes.always)
    run = writer.run_id(connection, computed)
    rows: list[tuple[Any, ...]] = [
        (numbers[i], 1, 0.0, 0.0, BORN, None, None, None, None, run) for i in always.tolist()
    ]
    count = changes.always.astype(int).tolist()
    names = ("word", "a", "error", "born", "bounce", "joint", "slope")
    columns = (getattr(changes, name).tolist() for name in names)
    for word, a, error, born, bounce, joint, slope in zip(*columns, strict=True):
        count[word] += 1
        kind = BORN if born else DIED
        rows.append((numbers[word], count[word], a, error, kind, bounce, JOINTS[joint], None, slope, run))
    if rows:
        insert(connection, "change", list(zip(*rows, strict=True)))


def close_births(connection: sa.Connection, p: int) -> None:
    """Number the events of a period of which all changes are stored, and note the counts."""
    here = change.c.cycle.between(*keys_of_period(p))
    found = connection.execute(
        sa.select(change.c.cycle, change.c.number, change.c.a, change.c.error, change.c.kind).where(here)
    ).all()
    moving = [row for row in found if row.a > 0]
    births = [row.a for row in moving if row.kind == BORN]
    if moving:
        a, error = (np.array([getattr(row, name) for row in moving]) for name in ("a", "error"))
        numbered = zip(events(a, error).tolist(), moving, strict=True)
        connection.exec_driver_sql(
            "UPDATE change SET event = ? WHERE cycle = ? AND number = ?",
            [(event, row.cycle, row.number) for event, row in numbered],
        )
    connection.execute(
        sa.update(birth_fill)
        .where(birth_fill.c.p == p)
        .values(
            state=DONE,
            classes=len({row.cycle for row in found}),
            births=len(births),
            deaths=len({row.cycle for row in moving if row.kind == DIED}),
            always=len(found) - len(moving),
            least=min(births, default=None),
            largest=max(births, default=None),
        )
    )


def words_with_changes(connection: sa.Connection, p: int) -> int:
    """Return how many words the classes with changes of a period have."""
    here = change.c.cycle.between(*keys_of_period(p)), change.c.number == 1
    size = sa.select(sa.func.sum(cycle.c.class_size)).join_from(change, cycle).where(*here)
    return connection.scalar(size) or 0
