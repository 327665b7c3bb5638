"""Sweeping periods: enumerate, solve and add up, and keep counts and sums alone."""

from collections.abc import Generator, Iterable, Iterator, Mapping
from contextlib import closing
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import sqlalchemy as sa
from numpy.typing import NDArray

from orbitdb.averages.sum_rules import EXACT, next_tilts
from orbitdb.billiard.stadium import Stadium
from orbitdb.catalogue.catalogue import Catalogue
from orbitdb.filling.resuming import Progress, resume
from orbitdb.filling.swept_blocks import SweptBlock, SweptSums
from orbitdb.filling.workers import HERE, Workers
from orbitdb.store.asking.selection import Selection
from orbitdb.store.asking.sweepable import swept_text
from orbitdb.store.reading.sweeps import moments_of
from orbitdb.store.writing.cursors import Cursor
from orbitdb.store.writing.sweeps import add_sums, add_up, open_sweep, tilts_of
from orbitdb.store.writing.writer import Writer
from orbitdb.symbols.counting import count_admissible
from orbitdb.symbols.least_words import class_spans

CLASSES = 1 << 15
"""Of a block, at most: it bounds the memory."""

SMALL = 200_000
"""Words up to which a period is swept here: other processes would begin to work when it is over."""


def sweep_periods(
    path: Path,
    a: float,
    periods: Iterable[int],
    workers: Workers = HERE,
    selection: Selection | None = None,
) -> Generator[Progress]:
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
        As `orbitdb.filling.resuming.resume` does, which says what it raises.

    Raises
    ------
    SelectionError
        If the subset cannot be swept (`orbitdb.store.asking.sweepable.why_not_swept`).
    """
    stadium, periods = Stadium(a), list(periods)
    chosen = "" if selection is None else swept_text(selection)
    parameters = {"command": "sweep", "a": a, "periods": periods, **({"selection": chosen} if chosen else {})}
    with closing(Writer(path, parameters, references=False)) as writer:
        for p in periods:  # one by one: the tilts of each come from those before it
            tilts = {} if chosen else _tilts(path, a, p)  # sum rules are of all orbits
            work = _Sweep(writer, stadium.a, chosen, tilts)
            yield from resume(writer, work, [p], workers if count_admissible(p) > SMALL else HERE)


class _Sweep:
    """A sweep at one a, of all orbits or of a subset."""

    def __init__(
        self, writer: Writer, a: float, selection: str, tilts: Mapping[int, NDArray[np.float64]]
    ) -> None:
        self.writer, self.a, self.selection, self.tilts = writer, a, selection, tilts

    def open(self, connection: sa.Connection, p: int) -> Cursor:
        return open_sweep(self.writer, connection, self.a, p, self.tilts, self.selection)

    def blocks(self, cursor: Cursor, jobs: int) -> Iterator[SweptBlock]:
        """Cut a period as nothing else decides: sums over blocks are the same however they come about."""
        spans, tilts = class_spans(cursor.p, CLASSES, cursor.after), tilts_of(cursor)
        return (SweptBlock(self.a, span, tilts, self.selection) for span in spans)

    def store(self, connection: sa.Connection, cursor: Cursor, part: SweptSums) -> dict[str, float]:
        add_sums(self.writer, connection, cursor, part.sums, part.moments, part.arithmetic)
        return {**asdict(part.tally), "blocks": 1, "processor": part.processor}

    def counted(self, connection: sa.Connection, cursor: Cursor) -> tuple[int, dict[str, Any]]:
        return cursor.words, add_up(self.writer, connection, cursor)


def _tilts(path: Path, a: float, p: int) -> dict[int, NDArray[np.float64]]:
    """Return the tilts that moments of a period are wanted around: none if lower periods have no moments."""
    if p <= EXACT:
        return {}
    with closing(Catalogue(path)) as catalogue:
        known = moments_of(catalogue.sweeps(a))
    return next_tilts(a, known) if len(known) == p - EXACT - 1 else {}
