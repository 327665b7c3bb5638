"""Whether any birth or death is missing: cell by cell in ln a, by another way than that which found them."""

from collections.abc import Iterable, Iterator
from itertools import groupby
from typing import TYPE_CHECKING, Any

import numpy as np

from orbitdb.orbits.births.completeness import KnownChange, Verdict, prove_all
from orbitdb.store.file.schema import BORN
from orbitdb.store.reading import audit
from orbitdb.store.reading.lives import BirthFill
from orbitdb.symbols.words import from_strings
from orbitdb.verification.check import Check, Step, shown

if TYPE_CHECKING:
    import sqlalchemy as sa

_BLOCK = 1000
"""Classes that are proved at once: some hundred megabytes."""


def prove_lives(connection: "sa.Connection", periods: Iterable[BirthFill]) -> Iterator[Step]:
    """Prove of periods of which all births are stored that none is missing; yield block by block.

    The checks count the classes that are proved as rows of ``lives``, and those of which the proof tells
    nothing, as cells become too small, as rows of ``undecided``.
    """
    for found in periods:
        classes = [(word, list(rows)) for word, rows in groupby(audit.changes(connection, found.p), _word)]
        for start in range(0, len(classes), _BLOCK):
            block = classes[start : start + _BLOCK]
            words = from_strings([word for word, _ in block])
            verdict, _ = prove_all(words, [_known(rows) for _, rows in block])
            checks = tuple(_checks([word for word, _ in block], verdict))
            yield Step(f"births missing, p = {found.p}", start + len(block), len(classes), checks)


def _checks(words: list[str], verdict: "np.ndarray[Any, np.dtype[np.int8]]") -> Iterator[Check]:
    wrong, unknown = np.flatnonzero(verdict == Verdict.WRONG), int((verdict == Verdict.UNDECIDED).sum())
    first = shown(words[wrong[0]]) if len(wrong) else None
    yield Check("lives", len(words) - unknown, len(wrong), first=first)
    if unknown:
        yield Check("undecided", unknown)


def _word(row: Any) -> str:
    return str(row.word)


def _known(rows: list[Any]) -> list[KnownChange]:
    """Return the changes of a class above a = 0 as brackets in ln a."""
    moving = [row for row in rows if row.a > row.error]
    return [
        (float(np.log(row.a - row.error)), float(np.log(row.a + row.error)), row.kind == BORN)
        for row in moving
    ]
