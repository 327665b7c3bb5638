"""Storing the sums of a sweep, block by block, and their totals at the end."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import sqlalchemy as sa
from numpy.typing import NDArray

from orbitdb.averages.fixed_points import PeriodSums
from orbitdb.averages.tilt_moments import TiltMoments, from_bytes, to_bytes
from orbitdb.store.file.tables import run, sweep, sweep_block
from orbitdb.store.writing.cursors import Cursor, open_cursor
from orbitdb.store.writing.writer import Writer


def open_sweep(
    writer: Writer,
    connection: sa.Connection,
    a: float,
    p: int,
    tilts: Mapping[int, NDArray[np.float64]],
    selection: str,
) -> Cursor:
    """Return how far the sweep of a period has come, which begins with some tilts."""
    moments = to_bytes({level: TiltMoments.none(mu) for level, mu in tilts.items()})
    stadium = writer.stadium_id(connection, a)
    return open_cursor(connection, sweep, stadium=stadium, p=p, selection=selection, moments=moments)


def tilts_of(cursor: Cursor) -> dict[int, NDArray[np.float64]]:
    """Return the tilts that moments are added up around (`orbitdb.averages.sum_rules`), by level."""
    return {level: each.centre for level, each in from_bytes(cursor.row["moments"]).items()}


def add_sums(
    writer: Writer,
    connection: sa.Connection,
    cursor: Cursor,
    sums: PeriodSums,
    moments: Mapping[int, TiltMoments],
    computed: str,
) -> None:
    """Store the sums of the block behind the cursor, with the arithmetic that has found them."""
    block = sa.insert(sweep_block).values(
        **{name: cursor.row[name] for name in ("stadium", "p", "selection")},
        number=cursor.row["blocks"],
        sums=sums.numbers(),
        moments=to_bytes(moments),
        run=writer.run_id(connection, computed),
    )
    connection.execute(block)


def add_up(writer: Writer, connection: sa.Connection, cursor: Cursor) -> dict[str, Any]:
    """Add up the blocks of a period that is swept, drop them, and return the sums as columns of its row."""
    here = cursor.rows(sweep_block)
    query = sa.select(sweep_block.c.sums, sweep_block.c.moments).where(here).order_by(sweep_block.c.number)
    blocks = connection.execute(query).all()
    sums = PeriodSums.joined([PeriodSums.from_numbers(cursor.p, each.sums) for each in blocks], cursor.p)
    parts = [from_bytes(each.moments) for each in blocks]
    moments = {level: TiltMoments.joined([part[level] for part in parts]) for level in tilts_of(cursor)}
    computed = sa.func.json_extract(run.c.parameters, "$.arithmetic")
    by = connection.scalars(
        sa.select(computed).distinct().join(sweep_block).where(here).order_by(computed)
    ).all()
    connection.execute(sa.delete(sweep_block).where(here))
    number = writer.run_id(connection, " | ".join(by) or None)
    return {"sums": sums.numbers(), "moments": to_bytes(moments), "run": number}
