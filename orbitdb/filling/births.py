"""Storing where in a all classes of a period begin and cease to be orbits.

Every block is written in one transaction together with the cursor that says how far the period has
come, as a fill does it (`orbitdb.filling.periods`): it can be stopped at any moment and goes on there.
"""

import time
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from pathlib import Path

from orbitdb.errors import StoreError
from orbitdb.filling.birth_blocks import BLOCK, birth_blocks
from orbitdb.filling.periods import Progress
from orbitdb.filling.workers import HERE, Workers
from orbitdb.store.file.schema import DONE
from orbitdb.store.writing import insertion
from orbitdb.store.writing.changes import (
    BirthCursor,
    add_changes,
    close_births,
    move_births,
    open_births,
    words_with_changes,
)
from orbitdb.store.writing.cursors import OvertakenError
from orbitdb.store.writing.writer import Writer
from orbitdb.symbols.counting import count_admissible
from orbitdb.symbols.enumeration import Span
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
        Behind every block that is safely stored.

    Raises
    ------
    StoreError
        If the database cannot be written.
    WorkError
        If the workers fail, or the changes of a word make no sense.
    """
    periods = sorted(set(periods))
    writer = Writer(path, {"command": "births", "periods": periods}, references=False)
    try:
        while cursors := _open(writer, periods):
            with suppress(OvertakenError):  # by another process that does the same: go on behind it
                yield from _blocks(writer, cursors, workers)
    finally:
        writer.close()


def _open(writer: Writer, periods: Sequence[int]) -> dict[int, BirthCursor]:
    """Return how far the periods are that are not done, by period."""
    with writer.writing() as connection:
        cursors = {p: open_births(connection, p) for p in periods}
    return {p: cursor for p, cursor in cursors.items() if cursor.state != DONE}


def _blocks(writer: Writer, cursors: dict[int, BirthCursor], workers: Workers) -> Iterator[Progress]:
    """Store the blocks behind the cursors, and close every period behind its last one."""
    clock = time.monotonic()
    todo = [(p, cursor.after) for p, cursor in cursors.items()]
    for found in workers.solved(birth_blocks(todo, BLOCK, workers.jobs)):
        before, clock = clock, time.monotonic()
        seconds = (clock - before) / len(found.parts)
        for part in found.parts:
            p = part.span.p
            with writer.writing() as connection:
                numbers = keys(pack(part.words), p).tolist()
                insertion.add_cycles(connection, numbers, part.words, part.stabiliser)
                add_changes(writer, connection, numbers, part.changes, found.arithmetic)
                cursors[p] = move_births(connection, cursors[p], part.span, part.count, seconds)
            if part.span.upto == Span.whole(p).upto:
                _close(writer, p)
            yield Progress(p, cursors[p].words, count_admissible(p))


def _close(writer: Writer, p: int) -> None:
    """Close a period of which all blocks are stored."""
    with writer.writing() as connection:
        found, total = words_with_changes(connection, p), count_admissible(p)
        if found != total:
            raise StoreError(
                f"births of period {p} are of {found} words instead of {total}: {writer.path} is damaged"
            )
        close_births(connection, p)
