"""Storing where in a all classes of a period begin and cease to be orbits.

Every block is written in one transaction together with the cursor that says how far the period has
come, as a fill does it (`orbitdb.filling.periods`): it can be stopped at any moment and goes on there.
"""

import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from orbitdb.arithmetic import arithmetic
from orbitdb.equality import ByValue
from orbitdb.errors import StoreError
from orbitdb.filling.periods import Progress
from orbitdb.filling.workers import HERE, Workers
from orbitdb.orbits.births import Changes, find_changes
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
from orbitdb.symbols.enumeration import Span, admissible_words, spans
from orbitdb.symbols.symmetry import classify
from orbitdb.symbols.words import keys, pack
from orbitdb.version import __version__

BLOCK = 1 << 15
"""Words of a block: a second of work or two."""


@dataclass(frozen=True)
class BirthBlock:
    """Words of one period of which the changes are to be found.

    Attributes
    ----------
    span : Span
        The words.
    """

    span: Span

    def solved(self) -> "SolvedBirths":
        """Find its words, their symmetry classes, and the changes of the classes whose least words it has."""
        none = np.zeros((0, self.span.p), dtype=np.uint8)
        words = np.concatenate([none, *admissible_words(*self.span)])
        classes = classify(words)
        least = classes.representative == pack(words)
        found = find_changes(words[least])
        by = (__version__, arithmetic())
        return SolvedBirths(self.span, len(words), words[least], classes.stabiliser[least], found, *by)


@dataclass(frozen=True, eq=False)
class SolvedBirths(ByValue):
    """What became of a block.

    Attributes
    ----------
    span : Span
        The block's.
    count : int
        How many words it has.
    words : ndarray of uint8, shape (N, p)
        Those of them that are the least of their classes, in order.
    stabiliser : ndarray of uint8, shape (N,)
        Their stabilisers.
    changes : Changes
        Their births and deaths.
    version, arithmetic : str
        Of the orbitdb that solved it, and what computed there (`orbitdb.arithmetic.arithmetic`).
    """

    span: Span
    count: int
    words: NDArray[np.uint8]
    stabiliser: NDArray[np.uint8]
    changes: Changes
    version: str
    arithmetic: str


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
    periods = list(periods)
    writer = Writer(path, {"command": "births", "periods": periods}, references=False)
    try:
        for p in periods:
            yield from _period(writer, p, workers)
    finally:
        writer.close()


def _period(writer: Writer, p: int, workers: Workers) -> Iterator[Progress]:
    """Store what is missing, block by block; go on behind another process that does the same."""
    total = count_admissible(p)
    while True:
        with writer.writing() as connection:
            cursor = open_births(connection, p)
        if cursor.state == DONE:
            return
        try:
            for words in _blocks(writer, cursor, workers if total > BLOCK else HERE):
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


def _blocks(writer: Writer, cursor: BirthCursor, workers: Workers) -> Iterator[int]:
    """Store the blocks behind the cursor; yield how many words are done."""
    clock = time.monotonic()
    for found in workers.solved(BirthBlock(span) for span in spans(cursor.p, BLOCK, cursor.after)):
        numbers = keys(pack(found.words), cursor.p).tolist()
        with writer.writing() as connection:
            insertion.add_cycles(connection, numbers, found.words, found.stabiliser)
            add_changes(writer, connection, numbers, found.changes, found.arithmetic)
            before, clock = clock, time.monotonic()
            cursor = move_births(connection, cursor, found.span, found.count, clock - before)
        yield cursor.words
