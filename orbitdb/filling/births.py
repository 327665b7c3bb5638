"""Find and store the births and deaths of all classes of a period."""

from collections.abc import Generator, Iterable, Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import sqlalchemy as sa
from numpy.typing import NDArray

from orbitdb.arithmetic import arithmetic
from orbitdb.arrays import Integers
from orbitdb.filling.fill import cut
from orbitdb.filling.resuming import Cursor, Step, Work, open_cursor, resume, run_steps
from orbitdb.filling.workers import HERE, Task, Workers, at_work
from orbitdb.orbits.births import Changes, find_changes
from orbitdb.progress import Tell, nobody
from orbitdb.store.file.schema import BORN, DIED
from orbitdb.store.file.tables import birth_fill
from orbitdb.store.reading.fills import words_up_to
from orbitdb.store.reading.moment import reading
from orbitdb.store.writing.classes import add_changes, add_classes, number_events
from orbitdb.store.writing.writer import Writer
from orbitdb.symbols.enumeration import Span, all_least_words
from orbitdb.symbols.pruning import count_admissible
from orbitdb.symbols.symmetry import SIZES, joined_words
from orbitdb.symbols.words import keys, unpack

BLOCK = 1 << 17
"""Approximate number of words in a block, which takes a few seconds."""

_WORDS_A_SECOND = 40_000
"""Approximate number of words for which births are found per second."""


def find_births(path: Path, periods: Sequence[int], jobs: int | None = None, tell: Tell = nobody) -> None:
    """Find and store all births and deaths of the given periods (`Catalogue.fill_births`)."""
    totals = {p: count_admissible(p) for p in periods}
    with reading(path) as moment:
        known = sum(each.words for each in moment.birth_fills() if each.p in totals)
    with at_work((sum(totals.values()) - known) / _WORDS_A_SECOND, jobs) as workers:
        run_steps(fill_births(path, periods, workers), "births", totals, tell, known)


def fill_births(path: Path, periods: Iterable[int], workers: Workers = HERE) -> Generator[Step]:
    """Find and store all births and deaths of the given periods; yield a `Step` after every stored block."""
    periods = sorted(set(periods))
    with closing(Writer(path, {"command": "births", "periods": periods}, references=False)) as writer:
        yield from resume(_Births(writer), periods, workers)


@dataclass(frozen=True, eq=False)
class SolvedBirths:
    """The N classes of a span, and their births and deaths.

    Attributes
    ----------
    codes : ndarray of int64, shape (N,)
        The packed representatives, in ascending order.
    changes : Changes
    span, stabiliser, words, arithmetic
        As in `orbitdb.filling.fill.SolvedBlock`.
    """

    span: Span
    codes: Integers
    stabiliser: NDArray[np.uint8]
    words: list[str]
    changes: Changes
    arithmetic: str


def solve_births(span: Span) -> SolvedBirths:
    """Find the classes whose representatives lie in a span, and their births and deaths."""
    codes, stabiliser = all_least_words(span)
    words = joined_words(codes, stabiliser, span.p)
    return SolvedBirths(span, codes, stabiliser, words, find_changes(unpack(codes, span.p)), arithmetic())


class _Births(Work):
    def open(self, connection: sa.Connection, p: int) -> Cursor:
        return open_cursor(connection, birth_fill, p=p)

    def blocks(self, cursor: Cursor, jobs: int) -> Iterator[Task[SolvedBirths]]:
        return (partial(solve_births, span) for span in cut(cursor.p, cursor.after, BLOCK, jobs))

    def store(self, connection: sa.Connection, cursor: Cursor, part: SolvedBirths) -> dict[str, float]:
        numbers = keys(part.codes, cursor.p).tolist()
        add_classes(connection, numbers, unpack(part.codes, cursor.p), part.stabiliser, part.words)
        add_changes(self.writer, connection, numbers, part.changes, part.arithmetic)
        return {"words": int(SIZES[part.stabiliser].sum())}

    def counted(self, connection: sa.Connection, cursor: Cursor) -> tuple[int, dict[str, Any]]:
        return words_up_to(connection, None, cursor.p, "5" * cursor.p), {}

    def closing(self, connection: sa.Connection, cursor: Cursor) -> dict[str, Any]:
        return _counts(number_events(connection, cursor.p))


def _counts(changes: Sequence[Any]) -> dict[str, Any]:
    moving = [row for row in changes if row.a > 0]
    births = [row.a for row in moving if row.kind == BORN]
    return {
        "classes": len({row.cycle for row in changes}),
        "births": len(births),
        "deaths": len({row.cycle for row in moving if row.kind == DIED}),
        "always": len(changes) - len(moving),
        "least": min(births, default=None),
        "largest": max(births, default=None),
    }
