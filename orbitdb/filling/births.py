"""Storing where in a all classes of a period begin and cease to be orbits.

Every block is written in one transaction together with the cursor that says how far the period has
come, as a fill does it (`orbitdb.filling.periods`): it can be stopped at any moment and goes on there.
"""

import time
from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np

from orbitdb.errors import StoreError
from orbitdb.filling.periods import Progress
from orbitdb.orbits.births import find_changes
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
from orbitdb.symbols.enumeration import admissible_words, spans
from orbitdb.symbols.symmetry import classify
from orbitdb.symbols.words import keys, pack

BLOCK = 1 << 16
"""Words of a block: some seconds of work."""


def fill_births(path: Path, periods: Iterable[int]) -> Iterator[Progress]:
    """Store the births and deaths of all classes of some periods.

    Parameters
    ----------
    path : Path
        A catalogue of the newest schema.
    periods : iterable of int
        Periods, 2..`MAX_PERIOD`; those that are done are passed over.

    Yields
    ------
    Progress
        Behind every block that is safely stored.

    Raises
    ------
    StoreError
        If the database cannot be written.
    """
    periods = list(periods)
    writer = Writer(path, {"command": "births", "periods": periods}, references=False)
    try:
        for p in periods:
            yield from _period(writer, p)
    finally:
        writer.close()


def _period(writer: Writer, p: int) -> Iterator[Progress]:
    """Store what is missing, block by block; go on behind another process that does the same."""
    total = count_admissible(p)
    while True:
        with writer.writing() as connection:
            cursor = open_births(connection, p)
        if cursor.state == DONE:
            return
        try:
            for words in _blocks(writer, cursor):
                yield Progress(p, words, total)
        except OvertakenError:
            continue
        with writer.writing() as connection:
            found = words_with_changes(connection, p)
            if found != total:
                raise StoreError(
                    f"births of period {p} are of {found} words instead of {total}: {writer.path} is damaged"
                )
            close_births(connection, p)
        return


def _blocks(writer: Writer, cursor: BirthCursor) -> Iterator[int]:
    """Store the blocks behind the cursor; yield how many words are done."""
    clock = time.monotonic()
    for span in spans(cursor.p, BLOCK, cursor.after):
        none = np.zeros((0, cursor.p), dtype=np.uint8)
        words = np.concatenate([none, *admissible_words(*span)])
        classes = classify(words)
        chosen = classes.representative == pack(words)
        least = words[chosen]
        numbers = keys(pack(least), cursor.p).tolist()
        changes = find_changes(least)
        with writer.writing() as connection:
            insertion.add_cycles(connection, numbers, least, classes.stabiliser[chosen])
            add_changes(writer, connection, numbers, changes)
            before, clock = clock, time.monotonic()
            cursor = move_births(connection, cursor, span, len(words), clock - before)
        yield cursor.words
