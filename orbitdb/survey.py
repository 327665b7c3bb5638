"""Filling a catalogue: enumerate, skip what is known, solve, store, period by period.

Every batch of words is written in one transaction together with the cursor that says how far the
period has come, so that a fill can be stopped at any moment, by Ctrl-C or a kill, and goes on there.
"""

import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Protocol

import numpy as np
import sqlalchemy as sa
from numpy.typing import NDArray

from orbitdb import __version__, symmetry
from orbitdb.enumeration import (
    RULE_NUMBERS,
    admissible_words,
    count_admissible,
    count_primitive,
    primitive_words,
)
from orbitdb.errors import StoreError
from orbitdb.orbits import Orbit, Orbits, Status
from orbitdb.pruning import FAMILY, pruned_word, rule_numbers, rules_broken
from orbitdb.relaxation import relax
from orbitdb.solve import solve, solve_word
from orbitdb.stadium import Stadium
from orbitdb.store import filling
from orbitdb.store.catalogue import Catalogue
from orbitdb.store.filling import DONE, Cursor, Writer
from orbitdb.store.known import KnownClasses
from orbitdb.symmetry import classify
from orbitdb.words import from_strings, pack, to_strings, unpack

_BATCH = 8192
_LAST_FULL_MASK = 64


class Solver(Protocol):
    """A method that turns admissible words of one order into orbits."""

    def __call__(self, words: NDArray[np.uint8], stadium: Stadium) -> Orbits:
        """Return what becomes of words, shape (N, p)."""


METHODS: dict[str, Solver] = {"newton": solve, "relaxation": relax}


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


def fill(path: Path, a: float, periods: Iterable[int], method: str = "newton") -> Iterator[Progress]:
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

    Yields
    ------
    Progress
        Behind every batch that is safely stored.

    Raises
    ------
    StoreError
        If the database cannot be written, or another process fills the same period.
    """
    stadium = Stadium(a)
    periods = list(periods)
    writer = Writer(path, {"command": "fill", "a": a, "periods": periods, "method": method}, __version__)
    try:
        for p in periods:
            yield from _PeriodFill(writer, stadium, p, method).run()
    finally:
        writer.close()


class _PeriodFill:
    """The fill of one period at one a."""

    def __init__(self, writer: Writer, stadium: Stadium, p: int, method: str) -> None:
        self.writer, self.stadium, self.p, self.method = writer, stadium, p, method
        self.total = self.stored = 0
        self.clock = time.monotonic()

    def run(self) -> Iterator[Progress]:
        """Store what is missing, batch by batch."""
        with self.writer.writing() as connection:
            cursor = filling.open_fill(self.writer, connection, self.stadium.a, self.p)
            if cursor.state == DONE:
                return
            known = KnownClasses(connection, cursor)
        self.total = count_admissible(self.p)
        if cursor.sequences_done:
            batches = self._from_store(cursor, known)
        else:
            batches = self._from_scratch(cursor, known)
        for _ in batches:
            yield Progress(self.p, self.stored, self.total)
        with self.writer.writing() as connection:
            filling.close_fill(connection, cursor, self._counts(connection, cursor))

    def _from_scratch(self, cursor: Cursor, known: KnownClasses) -> Iterator[Cursor]:
        """Enumerate words; store them, their classes and the orbits of the classes."""
        after = -1 if cursor.word is None else int(pack(from_strings([cursor.word]))[0])
        for words in admissible_words(self.p, after):
            classes = classify(words)
            codes = pack(words)
            least = classes.representative == codes
            unsolved = least & ~np.isin(codes, known.solved)
            orbits = METHODS[self.method](words[unsolved], self.stadium)
            text = to_strings(words)
            with self.writer.writing() as connection:
                known.refresh(connection)
                known.add(connection, words[least], classes.stabiliser[least])
                cycles = known.numbers(classes.representative)
                rows = list(zip([self.p] * len(text), text, cycles, classes.element.tolist(), strict=True))
                filling.add_sequences(connection, rows)
                self._add_orbits(connection, cursor, known.numbers(codes[unsolved]), orbits)
                cursor = self._advance(connection, cursor, text[-1])
            self.stored += len(text)
            yield cursor

    def _from_store(self, cursor: Cursor, known: KnownClasses) -> Iterator[Cursor]:
        """Solve the classes that a fill at another a has stored."""
        after = 0 if cursor.word is None else int(pack(from_strings([cursor.word]))[0])
        todo = known.codes[(known.codes > after) & ~np.isin(known.codes, known.solved)]
        share = self.total / max(len(todo), 1)
        for start in range(0, len(todo), _BATCH):
            codes = todo[start : start + _BATCH]
            words = unpack(codes, self.p)
            orbits = METHODS[self.method](words, self.stadium)
            with self.writer.writing() as connection:
                self._add_orbits(connection, cursor, known.numbers(codes), orbits)
                cursor = self._advance(connection, cursor, to_strings(words[-1:])[0])
            self.stored = round((start + len(codes)) * share)
            yield cursor

    def _add_orbits(
        self, connection: sa.Connection, cursor: Cursor, cycles: list[int], orbits: Orbits
    ) -> None:
        filling.add_orbits(self.writer, connection, cursor.stadium, cycles, orbits, self.method)

    def _advance(self, connection: sa.Connection, cursor: Cursor, word: str) -> Cursor:
        now = time.monotonic()
        moved = filling.move_cursor(connection, cursor, word, now - self.clock)
        self.clock = now
        return moved

    def _counts(self, connection: sa.Connection, cursor: Cursor) -> dict[str, int]:
        """Return the counts of the finished period, checked against the transfer matrix."""
        found = filling.count_statuses(connection, cursor)
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
            "n_t": self.total,
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
    writer = Writer(path, {"command": "fill --geometric", "periods": list(periods)}, __version__)
    names = [",".join(map(str, rule_numbers(mask))) for mask in range(_LAST_FULL_MASK)]
    try:
        for p in periods:
            done, total = 0, count_primitive(p)
            for words in primitive_words(p):
                masks = rules_broken(words)
                pruned = masks > 0
                rules = [names[mask] for mask in masks[pruned].tolist()]
                text = to_strings(words[pruned])
                rows = [(p, *row) for row in zip(text, rules, strict=True) if row[0] != FAMILY]
                with writer.writing() as connection:
                    filling.add_pruned(connection, rows)
                done += len(words)
                yield Progress(p, done, total)
    finally:
        writer.close()


def fill_word(path: Path, word: str, a: float, method: str = "newton") -> Orbit:
    """Store one primitive word of any order, its symmetry class, and what becomes of it at one a.

    Parameters
    ----------
    path : Path
        A catalogue of the newest schema.
    word : str
        Symbols 0..5, in any rotation.
    a : float
        The stadium.
    method : str, optional
        One of `METHODS`.

    Returns
    -------
    Orbit
        The word in the rotation asked for; the family 02 is not stored.
    """
    writer = Writer(path, {"command": "fill", "a": a, "code": word, "method": method}, __version__)
    try:
        if (pruned := pruned_word(word, a)) is not None:
            return _keep_pruned(writer, pruned)
        family = symmetry.class_of(word)
        orbits = METHODS[method](from_strings([family.representative]), Stadium(a))
        with writer.writing() as connection:
            stadium = writer.stadium_id(connection, a)
            number = filling.add_class(connection, family)
            filling.add_orbits(writer, connection, stadium, [number], orbits, method)
    finally:
        writer.close()
    return find(path, word, a)


def _keep_pruned(writer: Writer, word: Orbit) -> Orbit:
    """Store a geometrically pruned word with the rules it breaks; the family is not stored."""
    if word.status is Status.FAMILY:
        return word
    rules = ",".join(map(str, word.rules))
    with writer.writing() as connection:
        filling.add_pruned(connection, [(word.p, word.representative, rules)])
    return replace(word, stored=True)


def find(path: Path | None, word: str, a: float) -> Orbit:
    """Return what a catalogue says of a primitive word, or solve it if it is not there.

    Parameters
    ----------
    path : Path or None
        A catalogue; None if there is none.
    word : str
        Symbols 0..5, in any rotation.
    a : float
        The stadium.
    """
    stored = None if path is None else Catalogue(path).find(word, a)
    return solve_word(word, Stadium(a)) if stored is None else stored
