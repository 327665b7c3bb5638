"""Storing the births and deaths of all classes of a period."""

from collections.abc import Generator, Iterable, Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

import sqlalchemy as sa

from orbitdb.filling.blocks import BirthBlock, SolvedBirths, block_size
from orbitdb.filling.resuming import Progress, resume
from orbitdb.filling.workers import HERE, Workers
from orbitdb.store.file.tables import birth_fill
from orbitdb.store.reading.fills import words_up_to
from orbitdb.store.reading.lives import counts_when_done
from orbitdb.store.writing.changes import add_changes, number_events
from orbitdb.store.writing.classes import add_classes
from orbitdb.store.writing.cursors import Cursor, open_cursor
from orbitdb.store.writing.writer import Writer
from orbitdb.symbols.least_words import class_spans
from orbitdb.symbols.symmetry import SIZES
from orbitdb.symbols.words import keys, pack

BLOCK = 1 << 18
"""Words of a block, about: some seconds of work."""

_WORDS_A_CLASS = 8
_SMALLEST = 2
"""Where several processes work, a period is cut into blocks down to this part of a full one."""


def fill_births(path: Path, periods: Iterable[int], workers: Workers = HERE) -> Generator[Progress]:
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

    def blocks(self, cursor: Cursor, jobs: int) -> Iterator[BirthBlock]:
        size = block_size(BLOCK, cursor.p, jobs, _SMALLEST) // _WORDS_A_CLASS
        return map(BirthBlock, class_spans(cursor.p, max(size, 1), cursor.after))

    def store(self, connection: sa.Connection, cursor: Cursor, part: SolvedBirths) -> dict[str, float]:
        numbers = keys(pack(part.least), cursor.p).tolist()
        add_classes(connection, numbers, part.least, part.stabiliser, part.words)
        add_changes(self.writer, connection, numbers, part.changes, part.arithmetic)
        return {"words": int(SIZES[part.stabiliser].sum())}

    def counted(self, connection: sa.Connection, cursor: Cursor) -> tuple[int, dict[str, Any]]:
        words = words_up_to(connection, None, cursor.p, "5" * cursor.p)
        return words, counts_when_done(number_events(connection, cursor.p))
