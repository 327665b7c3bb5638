"""Sweeping periods: enumerate, solve and add up, and keep counts and sums alone.

Every block is written in one transaction together with the cursor that says how far the period has come, as
a fill does it (`orbitdb.filling.periods`): a sweep can be stopped at any moment and goes on there.
"""

import time
from collections.abc import Iterable, Iterator
from contextlib import closing
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from orbitdb.averages.swept_sum_rules import EXACT, next_tilts
from orbitdb.billiard.stadium import Stadium
from orbitdb.errors import StoreError
from orbitdb.filling.periods import Progress
from orbitdb.filling.swept_blocks import cut_into_swept_blocks
from orbitdb.filling.workers import HERE, Workers
from orbitdb.store.asking.selection import Selection
from orbitdb.store.asking.sweepable import swept_text
from orbitdb.store.file.schema import DONE
from orbitdb.store.reading.catalogue import Catalogue
from orbitdb.store.reading.sweeps import moments_of
from orbitdb.store.writing.cursors import OvertakenError
from orbitdb.store.writing.sweeps import SweepCursor, add_swept, close_sweep, open_sweep
from orbitdb.store.writing.writer import Writer
from orbitdb.symbols.counting import count_admissible

SMALL = 200_000
"""Words up to which a period is swept here: other processes would begin to work when it is over."""


def sweep_periods(
    path: Path,
    a: float,
    periods: Iterable[int],
    workers: Workers = HERE,
    selection: Selection | None = None,
) -> Iterator[Progress]:
    """Store the counts of all admissible words of some periods at one a, and sums over the orbits.

    Parameters
    ----------
    path : Path
        A catalogue of the newest schema.
    a : float
        The stadium.
    periods : iterable of int
        Periods, 2..`MAX_PERIOD`; those that are swept are passed over.
    workers : Workers, optional
        Where the words are found and solved; what is stored does not depend on it.
    selection : Selection, optional
        Of which orbits the counts and sums are, by default of all; its a and its periods do not count. It is
        kept beside those of other subsets.

    Yields
    ------
    Progress
        Behind every block that is safely stored.

    Raises
    ------
    SelectionError
        If the subset cannot be swept (`orbitdb.store.asking.sweepable.why_not_swept`).
    StoreError
        If the database cannot be written.
    WorkError
        If the workers fail.
    """
    stadium, periods = Stadium(a), list(periods)
    chosen = "" if selection is None else swept_text(selection)
    parameters = {"command": "sweep", "a": a, "periods": periods, **({"selection": chosen} if chosen else {})}
    writer = Writer(path, parameters, references=False)
    try:
        for p in periods:
            yield from _period(writer, stadium, p, chosen, workers)
    finally:
        writer.close()


def _period(writer: Writer, stadium: Stadium, p: int, selection: str, workers: Workers) -> Iterator[Progress]:
    """Sweep what is missing, block by block; go on behind another process that does the same."""
    total = count_admissible(p)
    tilts = {} if selection else _tilts(writer.path, stadium.a, p)  # sum rules are of all orbits
    while True:
        with writer.writing() as connection:
            cursor = open_sweep(writer, connection, stadium.a, p, tilts, selection)
        if cursor.state == DONE:
            return
        try:
            for moved in _blocks(writer, cursor, stadium, workers if total > SMALL else HERE):
                cursor = moved
                yield Progress(p, cursor.words, total)
        except OvertakenError:
            continue
        if cursor.words != total:
            raise StoreError(
                f"the sweep of period {p} has counted {cursor.words} words instead of {total}: {writer.path} "
                "is damaged"
            )
        with writer.writing() as connection:
            close_sweep(writer, connection, cursor)
        return


def _tilts(path: Path, a: float, p: int) -> dict[int, NDArray[np.float64]]:
    """Return the tilts that moments of a period are wanted around: none if lower periods have no moments."""
    if p <= EXACT:
        return {}
    with closing(Catalogue(path)) as catalogue:
        known = moments_of(catalogue.sweeps(a))
    return next_tilts(a, known) if len(known) == p - EXACT - 1 else {}


def _blocks(writer: Writer, cursor: SweepCursor, stadium: Stadium, workers: Workers) -> Iterator[SweepCursor]:
    """Store the blocks behind the cursor; yield where it has come to."""
    clock = time.monotonic()
    blocks = cut_into_swept_blocks(stadium.a, cursor.p, cursor.after, cursor.tilts, cursor.selection)
    for found in workers.solved(blocks):
        with writer.writing() as connection:
            before, clock = clock, time.monotonic()
            spent = clock - before, found.processor
            cursor = add_swept(
                writer,
                connection,
                cursor,
                found.span,
                found.tally,
                found.sums,
                found.moments,
                spent,
                found.arithmetic,
            )
        yield cursor
