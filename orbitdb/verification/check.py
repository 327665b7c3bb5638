"""Results of checks over many rows, and parts of a catalogue, each of which any process can check."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np
import sqlalchemy as sa

from orbitdb.arrays import Floats, Integers, Marks
from orbitdb.errors import AlteredError, InputError
from orbitdb.plaintext import shortened
from orbitdb.store.asking.selection import Selection
from orbitdb.store.reading.audit import Ids
from orbitdb.store.reading.moment import reading

_CLASSES = 4096
_NUMBERS = 1 << 20
"""Maximum number of entries in all p x p matrices of a block."""


@dataclass(frozen=True)
class Check:
    """Result of one check over a number of rows.

    Attributes
    ----------
    name : str
        One of `orbitdb.verification.verify.PROMISES`.
    rows, failures : int
        Number of rows checked, and number of failures.
    worst, share : float or None
        The deviation that is largest relative to what its row allows, and that ratio; above 1, the row fails.
    first : str or None
        The first failure.
    """

    name: str
    rows: int
    failures: int = 0
    worst: float | None = None
    share: float | None = None
    first: str | None = None

    def joined(self, other: "Check") -> "Check":
        """Join this result with that of the same check over other rows."""
        larger = max((self, other), key=lambda part: -1.0 if part.share is None else part.share)
        return replace(
            larger,
            rows=self.rows + other.rows,
            failures=self.failures + other.failures,
            first=self.first or other.first,
        )


@dataclass(frozen=True)
class Checked:
    """Result of one step of a verification.

    Attributes
    ----------
    stage : str
        The current stage.
    done, total : int
        Progress of the stage, in classes.
    checks : tuple of Check
        Results for the rows of this step; the report joins the results of all steps by name.
    """

    stage: str
    done: int
    total: int
    checks: tuple[Check, ...]


def judged(name: str, labels: Sequence[str], wrong: Marks | Sequence[bool]) -> Check:
    """Return the check of N labelled rows, given which of them are wrong."""
    marks = np.asarray(wrong)
    first = shortened(labels[int(marks.argmax())]) if marks.any() else None
    return Check(name, len(marks), int(marks.sum()), first=first)


def listed(name: str, rows: int, wrong: Sequence[str]) -> Check:
    """Return the check of a number of rows, given the labels of the wrong ones."""
    return Check(name, rows, len(wrong), first=wrong[0] if wrong else None)


def single(name: str, label: str, wrong: Iterable[str]) -> Check:
    """Return the check of one row, given its label and its faults."""
    first = next(iter(wrong), None)
    return Check(name, 1, int(first is not None), first=None if first is None else f"{label}: {first}")


def shares(deviation: Floats, allowed: Floats) -> Floats:
    """Return deviations divided by the allowed ones; 0 where there is no deviation, infinity for NaN."""
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        share = np.where(deviation == 0, 0.0, deviation / allowed)
    return np.where(np.isnan(share), np.inf, share)


def measured(name: str, labels: Sequence[str], deviation: Floats, allowed: Floats) -> Check:
    """Return the check of N labelled rows, given their deviations and the allowed ones; NaN fails."""
    share = shares(deviation, allowed)
    found = judged(name, labels, share > 1)
    if not len(share):
        return found
    worst = int(share.argmax())
    return replace(found, worst=float(deviation[worst]), share=float(share[worst]))


@dataclass(frozen=True)
class Part:
    """A part of a catalogue to check.

    Attributes
    ----------
    stage : str
    find : callable
        Function that checks the part, given a connection.
    done, total : int
        As in `Checked`.
    """

    stage: str
    find: Callable[[sa.Connection], Iterable[Check]]
    done: int = 0
    total: int = 1

    def checked(self, connection: sa.Connection) -> Checked:
        """Check the part, but stop at the first unreadable value."""
        found: list[Check] = []
        try:
            found.extend(self.find(connection))
        except (AlteredError, InputError) as error:
            what = error.what if isinstance(error, AlteredError) else error
            found.append(Check("reading", 1, 1, first=f"{self.stage}: {what}"))
        return Checked(self.stage, self.done, self.total, tuple(found))


def checked_apart(path: Path, part: Part) -> Checked:
    """Check a part in the file as it is now, which is safe because the rows of a class never change."""
    with reading(path) as moment:
        return part.checked(moment.connection)


@dataclass(frozen=True, eq=False)
class Block:
    """Classes or pruned words of one period that are checked together.

    Attributes
    ----------
    p : int
    ids : ndarray of int64, shape (N,)
    done, total : int
        Number of classes or words that are checked after this block, and number of all to check.
    """

    p: int
    ids: Integers
    done: int
    total: int

    def part(self, stage: str, find: Callable[["Block", sa.Connection], Iterable[Check]]) -> Part:
        """Return the block as a part that `find` checks."""
        return Part(f"{stage}, p = {self.p}", partial(find, self), self.done, self.total)


def blocks(ids: Ids, size: int = _CLASSES) -> Iterator[Block]:
    """Cut classes into blocks of at most `size`; blocks of long words, with large Hessians, are smaller."""
    done, total = 0, sum(map(len, ids.values()))
    for p, those in ids.items():
        step = max(1, min(size, _NUMBERS // p**2))
        for start in range(0, len(those), step):
            block = those[start : start + step]
            done += len(block)
            yield Block(p, block, done, total)


def is_chosen(p: int, selections: Sequence[Selection]) -> bool:
    """Tell whether a period is chosen at some a; if there are no selections, all periods are."""
    return not selections or any(each.includes(p) for each in selections)
