"""Filling a catalogue: enumerate, skip what is known, solve, store, period by period.

Every batch of words is written in one transaction together with the cursor that says how far the
period has come, so that a fill can be stopped at any moment, by Ctrl-C or a kill, and goes on there.
"""

import time
from collections.abc import Iterable, Iterator
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

import sqlalchemy as sa

from orbitdb.billiard.stadium import Stadium
from orbitdb.errors import StoreError
from orbitdb.filling.blocks import METHODS, Block, SolvedBlock, cut_into_blocks
from orbitdb.filling.workers import HERE, Workers
from orbitdb.orbits.orbit import Status
from orbitdb.store.file.schema import DONE
from orbitdb.store.reading.catalogue import Catalogue
from orbitdb.store.writing import insertion
from orbitdb.store.writing.cursors import (
    Cursor,
    OvertakenError,
    Spent,
    close_fill,
    count_statuses,
    count_words,
    move_cursor,
    next_classes,
    open_fill,
)
from orbitdb.store.writing.writer import Writer
from orbitdb.symbols import symmetry
from orbitdb.symbols.automaton import RULE_NUMBERS
from orbitdb.symbols.counting import count_admissible, count_primitive
from orbitdb.symbols.enumeration import Span, primitive_words
from orbitdb.symbols.pruning import FAMILY, rule_numbers, rules_broken
from orbitdb.symbols.words import key, keys, pack, to_strings, unpack

_LAST_FULL_MASK = 64


@dataclass(frozen=True)
class Progress:
    """How far a fill has come.

    Attributes
    ----------
    p : int
        The period at work.
    words : int
        Words of this period that are stored.
    total : int
        Words of this period there are.
    """

    p: int
    words: int
    total: int


def fill_periods(
    path: Path, a: float, periods: Iterable[int], method: str = "newton", workers: Workers = HERE
) -> Iterator[Progress]:
    """Store all admissible words of some periods and what becomes of them at one a.

    Parameters
    ----------
    path : Path
        A catalogue of the newest schema.
    a : float
        The stadium.
    periods : iterable of int
        Periods, 2..`MAX_PERIOD`; those that are done are passed over.
    method : str, optional
        One of `METHODS`.
    workers : Workers, optional
        Where the words are found and solved; what is stored does not depend on it.

    Yields
    ------
    Progress
        Behind every block that is safely stored.

    Raises
    ------
    StoreError
        If the database cannot be written.
    WorkError
        If the workers fail.
    """
    stadium = Stadium(a)
    periods = list(periods)
    parameters = {"command": "fill", "a": a, "periods": periods, "method": method}
    with (
        closing(Writer(path, parameters, references=False)) as writer,
        closing(Catalogue(path)) as catalogue,
    ):
        for p in periods:
            yield from _PeriodFill(writer, catalogue, stadium, p, method, workers).run()


class _PeriodFill:
    """The fill of one period at one a."""

    def __init__(
        self, writer: Writer, catalogue: Catalogue, stadium: Stadium, p: int, method: str, workers: Workers
    ) -> None:
        self.writer, self.catalogue = writer, catalogue
        self.stadium, self.p, self.method = stadium, p, method
        self.total = count_admissible(p)
        self.workers = workers if self.total > METHODS[method].words else HERE
        self.clock = time.monotonic()

    def run(self) -> Iterator[Progress]:
        """Store what is missing, block by block; go on behind another process that does the same."""
        while True:
            with self.writer.writing() as connection:
                cursor = open_fill(self.writer, connection, self.stadium.a, self.p)
            if cursor.state == DONE:
                return
            try:
                for moved in self._blocks(cursor):
                    cursor = moved
                    yield Progress(self.p, cursor.words, self.total)
            except OvertakenError:
                continue
            with self.catalogue.reading() as connection:
                counts = self._counts(connection, cursor)  # it takes long: others may write meanwhile
            with self.writer.writing() as connection:
                close_fill(connection, cursor, counts)
            return

    def _blocks(self, cursor: Cursor) -> Iterator[Cursor]:
        """Store the blocks behind the cursor; yield where it has come to."""
        known = cursor.sequences_done
        blocks = (
            self._known_classes(cursor)
            if known
            else cut_into_blocks(self.stadium.a, self.method, self.p, cursor.after, self.workers.jobs)
        )
        for found in self.workers.solved(blocks):
            begun = time.thread_time()
            with self.writer.writing() as connection:
                if not known:
                    self._add_words(connection, found)
                cycles = keys(pack(found.orbits.words), self.p).tolist()
                insertion.add_orbits(
                    self.writer,
                    connection,
                    cursor.stadium,
                    cycles,
                    found.orbits,
                    self.method,
                    found.arithmetic,
                )
                words = count_words(connection, found.span) if known else len(found.words)
                cursor = move_cursor(connection, cursor, found.span, words, self._spent(found, begun))
            yield cursor

    def _add_words(self, connection: sa.Connection, found: SolvedBlock) -> None:
        """Store the words of a block and the classes whose least words are among them.

        The classes of the other words come with smaller words, in blocks that are stored before.
        """
        p, least = self.p, found.orbits.words
        insertion.add_cycles(connection, keys(pack(least), p).tolist(), least, found.stabiliser)
        classes = keys(found.classes.representative, p).tolist()
        insertion.add_sequences(
            connection, p, to_strings(unpack(found.words, p)), classes, found.classes.element.tolist()
        )

    def _known_classes(self, cursor: Cursor) -> Iterator[Block]:
        """Yield blocks of the classes that a fill at another a has stored."""
        after = cursor.after
        count = METHODS[self.method].words // len(symmetry.ELEMENTS)
        while True:
            with self.catalogue.reading() as connection:
                codes = next_classes(connection, self.p, after, count)
            if not len(codes):
                return
            span = Span(self.p, after, int(codes[-1]))
            yield Block(self.stadium.a, self.method, span, codes)
            after = span.upto

    def _spent(self, found: SolvedBlock, begun: float) -> Spent:
        """Return the time that a block took: on its way, and since its storing was begun."""
        before, self.clock = self.clock, time.monotonic()
        return Spent(self.clock - before, found.enumerating, found.solving, time.thread_time() - begun)

    def _counts(self, connection: sa.Connection, cursor: Cursor) -> dict[str, int]:
        """Return the counts of the finished period, checked against the transfer matrix."""
        found = count_statuses(connection, cursor)
        words = sum(count for count, _ in found.values())
        if words != self.total:
            raise StoreError(
                f"period {self.p} holds {words} words instead of {self.total}: {self.writer.path} is damaged"
            )
        primitive = count_primitive(self.p)
        rules = {
            f"rule_{number}": primitive - count_admissible(self.p, frozenset([number]))
            for number in sorted(RULE_NUMBERS)
        }
        n_c, classes = found.get(Status.ORBIT, (0, 0))
        boundary, unresolved = (found.get(s, (0, 0))[0] for s in (Status.BOUNDARY, Status.UNRESOLVED))
        return rules | {
            "primitive": primitive,
            "words": words,
            "n_t": words,
            "n_c": n_c,
            "classes": classes,
            "boundary": boundary,
            "unresolved": unresolved,
        }


def fill_geometric(path: Path, periods: Iterable[int]) -> Iterator[Progress]:
    """Store the geometrically pruned primitive words of some periods, with the rules they break.

    Yields
    ------
    Progress
        Behind every batch; all primitive words of the period are counted.
    """
    writer = Writer(path, {"command": "fill --geometric", "periods": list(periods)})
    names = [",".join(map(str, rule_numbers(mask))) for mask in range(_LAST_FULL_MASK)]
    try:
        for p in periods:
            done, total = 0, count_primitive(p)
            for words in primitive_words(p):
                masks = rules_broken(words)
                pruned = masks > 0
                if p == len(FAMILY):
                    pruned &= keys(pack(words), p) != key(FAMILY)
                rules = [names[mask] for mask in masks[pruned].tolist()]
                with writer.writing() as connection:
                    insertion.add_pruned(connection, p, to_strings(words[pruned]), rules)
                done += len(words)
                yield Progress(p, done, total)
    finally:
        writer.close()
