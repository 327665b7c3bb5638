"""Storing the counts and sums of a sweep, and how far it has come, in one transaction."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace

import numpy as np
import sqlalchemy as sa
from numpy.typing import NDArray

from orbitdb.averages.period_sums import PeriodSums
from orbitdb.averages.tilt_moments import TiltMoments, from_bytes, to_bytes
from orbitdb.equality import ByValue
from orbitdb.orbits.tally import Tally
from orbitdb.store.file.schema import DONE, FILLING, SWEPT, run, sweep, sweep_block
from orbitdb.store.writing.cursors import OvertakenError, end_of
from orbitdb.store.writing.writer import Writer
from orbitdb.symbols.enumeration import Span


@dataclass(frozen=True, eq=False)
class SweepCursor(ByValue):
    """How far a sweep of one period at one a has come.

    Attributes
    ----------
    stadium, p : int
    selection : str
        What is swept: all orbits, or a subset by its canonical text (`orbitdb.store.asking.sweepable`).
    state : str
        ``filling`` or ``done``.
    word : str or None
        All classes whose least words are up to this one are counted and added up.
    blocks : int
        In how many blocks that was.
    words : int
        How many words the classes have.
    tilts : mapping of int to ndarray
        Those that moments are added up around (`orbitdb.averages.swept_sum_rules`).
    """

    stadium: int
    p: int
    selection: str
    state: str
    word: str | None
    blocks: int
    words: int
    tilts: Mapping[int, NDArray[np.float64]]

    @property
    def after(self) -> int:
        """The packed word behind which the sweep goes on."""
        return -1 if self.word is None else int(self.word, 8)


def open_sweep(
    writer: Writer,
    connection: sa.Connection,
    a: float,
    p: int,
    tilts: Mapping[int, NDArray[np.float64]],
    selection: str = "",
) -> SweepCursor:
    """Return where the sweep of a period stands, beginning it if need be, with some tilts."""
    number = writer.stadium_id(connection, a)
    here = {"stadium": number, "p": p, "selection": selection}
    none = dict.fromkeys(("blocks", "seconds", "processor", *SWEPT), 0)
    moments = to_bytes({level: TiltMoments.none(mu) for level, mu in tilts.items()})
    fresh = sa.insert(sweep).prefix_with("OR IGNORE").values(**here, state=FILLING, moments=moments, **none)
    connection.execute(fresh)
    names = (sweep.c.state, sweep.c.cursor, sweep.c.blocks, sweep.c.words, sweep.c.moments)
    row = connection.execute(sa.select(*names).filter_by(**here)).one()
    centres = {level: each.centre for level, each in from_bytes(row.moments).items()}
    return SweepCursor(number, p, selection, row.state, row.cursor, row.blocks, row.words, centres)


def add_swept(
    writer: Writer,
    connection: sa.Connection,
    cursor: SweepCursor,
    span: Span,
    tally: Tally,
    sums: PeriodSums,
    moments: Mapping[int, TiltMoments],
    spent: tuple[float, float],
    computed: str,
) -> SweepCursor:
    """Store the counts and sums of the block behind the cursor; return where it has come to.

    Parameters
    ----------
    writer : Writer
    connection : Connection
        Of the writer.
    cursor : SweepCursor
    span : Span
        The block's.
    tally : Tally
    sums : PeriodSums
    moments : mapping of int to TiltMoments
    spent : tuple of float
        Seconds as they passed, and of a processor.
    computed : str
        The arithmetic that has found it.

    Raises
    ------
    OvertakenError
        If another process has moved the same cursor.
    """
    last = end_of(span)
    seconds, processor = spent
    moved = connection.execute(
        sa.update(sweep)
        .where(_of(cursor, sweep), sweep.c.state == FILLING, sweep.c.cursor.is_not_distinct_from(cursor.word))
        .values(
            cursor=last,
            blocks=sweep.c.blocks + 1,
            seconds=sweep.c.seconds + seconds,
            processor=sweep.c.processor + processor,
            **{name: sweep.c[name] + count for name, count in asdict(tally).items()},
        )
    )
    if moved.rowcount != 1:
        raise OvertakenError
    block = sa.insert(sweep_block).values(
        stadium=cursor.stadium,
        p=cursor.p,
        selection=cursor.selection,
        number=cursor.blocks,
        sums=sums.numbers(),
        moments=to_bytes(moments),
        run=writer.run_id(connection, computed),
    )
    connection.execute(block)
    return replace(cursor, word=last, blocks=cursor.blocks + 1, words=cursor.words + tally.words)


def close_sweep(writer: Writer, connection: sa.Connection, cursor: SweepCursor) -> None:
    """Add up the blocks of a period that is swept, and keep the sum instead of them.

    Another process that has swept the same may have done it already.
    """
    if connection.scalar(sa.select(sweep.c.state).where(_of(cursor, sweep))) == DONE:
        return
    here = _of(cursor, sweep_block)
    query = sa.select(sweep_block.c.sums, sweep_block.c.moments).where(here).order_by(sweep_block.c.number)
    blocks = connection.execute(query).all()
    sums = PeriodSums.joined([PeriodSums.from_numbers(cursor.p, each.sums) for each in blocks], cursor.p)
    parts = [from_bytes(each.moments) for each in blocks]
    moments = {level: TiltMoments.joined([part[level] for part in parts]) for level in cursor.tilts}
    computed = sa.func.json_extract(run.c.parameters, "$.arithmetic")
    by = connection.scalars(
        sa.select(computed).distinct().join(sweep_block).where(here).order_by(computed)
    ).all()
    number = writer.run_id(connection, " | ".join(by) or None)
    connection.execute(sa.delete(sweep_block).where(here))
    connection.execute(
        sa.update(sweep)
        .where(_of(cursor, sweep))
        .values(state=DONE, sums=sums.numbers(), moments=to_bytes(moments), run=number)
    )


def _of(cursor: SweepCursor, table: sa.Table) -> sa.ColumnElement[bool]:
    return sa.and_(*(table.c[name] == getattr(cursor, name) for name in ("stadium", "p", "selection")))
