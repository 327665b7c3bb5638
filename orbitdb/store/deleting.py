"""Delete what is stored at a value of a, and return its space to the disk."""

from collections.abc import Iterator, Sequence
from contextlib import closing, suppress
from pathlib import Path

import sqlalchemy as sa
from sqlalchemy import Table, select
from sqlalchemy.pool import StaticPool

from orbitdb.errors import StoreError
from orbitdb.store import tables as t
from orbitdb.store.file import open_to_write
from orbitdb.store.journal import checkpoint, remove_journal_of
from orbitdb.store.paths import file_id, journal_ids
from orbitdb.store.periods import Contents, contents, filled_last
from orbitdb.store.sqlite import make_engine, plain_errors
from orbitdb.store.writer import Writer


def delete(
    path: Path, a: float, spans: Sequence[tuple[int, int]] = (), only: Contents | None = None
) -> Contents:
    """Delete what is stored at a given a, return its space to the disk, and return what it was.

    With `spans`, ranges of periods, only orbits, fills and sweeps of these periods are deleted. Classes stay
    as long as an orbit at another a, or births, need them, and geometrically pruned words as long as their
    period is filled at another a. Raises `StoreError`, without deleting anything,
    unless `only` is None or what is stored.
    """
    classes = select(t.cycle.c.id).where(t.in_spans(t.cycle.c.p, spans))
    own: dict[Table, sa.ColumnElement[bool]] = {
        t.certificate: t.certificate.c.cycle.in_(classes),
        t.orbit: t.orbit.c.cycle.in_(classes),
        **{table: t.in_spans(table.c.p, spans) for table in (t.fill, t.sweep_block, t.sweep)},
    }
    # without SQLite's checks of references, which would search all orbits for each deleted class
    with (
        closing(Writer(path, {"command": "delete"}, references=False)) as writer,
        writer.transaction() as connection,
    ):
        stored = contents(connection, a, spans)
        if only is not None and stored != only:
            raise StoreError(f"{path} now has {stored} there, so nothing was deleted: look again")
        if not spans:
            own[t.trajectory] = sa.true()
            for table in (t.entropy_bound, t.open_stadium, t.level_fill, t.level):
                connection.execute(sa.delete(table).where(table.c.a == a))
        for table in (t.pruned, t.pruned_fill):
            connection.execute(sa.delete(table).where(filled_last(table, a, spans)))
        for table, rows in own.items():
            connection.execute(sa.delete(table).where(t.at_a(table, a), rows))
        for statement in _unused():
            connection.execute(statement)
    with suppress(StoreError):  # unless the disk is full or another process writes
        vacuum(path)
    return stored


def vacuum(path: Path) -> None:
    """Return the space of deleted rows to the disk."""
    opened = file_id(path)
    with plain_errors(path), closing(open_to_write(path)) as driver, closing(open_to_write(path)) as other:
        driver.execute("VACUUM")
        journal = journal_ids(path)
        checkpoint(make_engine(lambda: driver, "BEGIN IMMEDIATE", StaticPool), other)
    remove_journal_of(path, opened, journal)


def _unused() -> Iterator[sa.Delete]:
    """Yield statements that delete classes without orbits and births, and stadiums that nothing refers to.

    Births need all classes of their period, also those that are never born. A class of a period that is
    being filled may get its orbits later.
    """
    needed = sa.union(select(t.orbit.c.cycle), select(t.change.c.cycle))
    of_births = t.cycle.c.p.in_(select(t.birth_fill.c.p))
    yield sa.delete(t.cycle).where(~of_births, t.cycle.c.id.not_in(needed))
    tables = (t.orbit, t.fill, t.sweep, t.trajectory)
    yield sa.delete(t.stadium).where(
        t.stadium.c.id.not_in(sa.union(*(select(table.c.stadium) for table in tables)))
    )
