"""Storing the births and deaths of all classes of a period."""

from collections.abc import Iterable, Iterator, Mapping
from contextlib import closing
from pathlib import Path

import sqlalchemy as sa

from orbitdb.errors import StoreError
from orbitdb.filling.birth_blocks import BLOCK, BirthBlock, SolvedSpan, birth_blocks
from orbitdb.filling.resuming import Progress, resume
from orbitdb.filling.workers import HERE, Workers
from orbitdb.store.file.tables import birth_fill
from orbitdb.store.reading.fills import words_up_to
from orbitdb.store.writing.changes import add_changes, number_events
from orbitdb.store.writing.classes import add_classes
from orbitdb.store.writing.cursors import Cursor, close, open_cursor
from orbitdb.store.writing.writer import Writer
from orbitdb.symbols.counting import count_admissible
from orbitdb.symbols.symmetry import SIZES
from orbitdb.symbols.words import keys, pack


def fill_births(path: Path, periods: Iterable[int], workers: Workers = HERE) -> Iterator[Progress]:
    """Store the births and deaths of all classes of some periods.

    Parameters
    ----------
    path : Path
        A catalogue of the newest schema.
    periods : iterable of int
        Periods, 2..`MAX_PERIOD`; those that are done are passed over.
    workers : Workers, optional
        Where the changes are found; what is stored does not depend on it.

    Yields
    ------
    Progress
        As `orbitdb.filling.resuming.resume` does, which says what it raises.
    """
    periods = sorted(set(periods))
    with closing(Writer(path, {"command": "births", "periods": periods}, references=False)) as writer:
        yield from resume(writer, _Births(writer), periods, workers)


class _Births:
    """The births and deaths of all classes."""

    def __init__(self, writer: Writer) -> None:
        self.writer = writer

    def open(self, connection: sa.Connection, p: int) -> Cursor:
        return open_cursor(connection, birth_fill, p=p)

    def blocks(self, cursors: Mapping[int, Cursor], jobs: int) -> Iterator[BirthBlock]:
        for p, cursor in cursors.items():
            yield from birth_blocks(p, cursor.after, BLOCK, jobs)

    def store(self, connection: sa.Connection, cursor: Cursor, part: SolvedSpan) -> dict[str, float]:
        numbers = keys(pack(part.least), cursor.p).tolist()
        add_classes(connection, numbers, part.least, part.stabiliser, part.words)
        add_changes(self.writer, connection, numbers, part.changes, part.arithmetic)
        return {"words": int(SIZES[part.stabiliser].sum())}

    def close(self, cursor: Cursor) -> None:
        p = cursor.p
        with self.writer.writing() as connection:
            found, total = words_up_to(connection, None, p, "5" * p), count_admissible(p)
            if found != total:
                raise StoreError(
                    f"period {p} has births of {found} words instead of {total}: "
                    f"{self.writer.path} is damaged"
                )
            close(connection, cursor, number_events(connection, p))
