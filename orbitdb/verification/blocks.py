"""Parts of a catalogue that are checked apart, by whatever process: what is found depends on nothing else."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
import sqlalchemy as sa
from numpy.typing import NDArray

from orbitdb.catalogue.catalogue import Catalogue
from orbitdb.errors import AlteredError, InputError
from orbitdb.store.asking.selection import Selection
from orbitdb.store.reading.audit import Ids
from orbitdb.verification.check import Check, Step

_CLASSES = 4096
_NUMBERS = 1 << 20
"""Of all p x p matrices of a block."""


@dataclass(frozen=True)
class Part:
    """A part of a catalogue that is to be checked.

    Attributes
    ----------
    stage : str
        What it belongs to.
    find : callable
        Checks what a connection reads.
    done, total : int
        As of a `Step`.
    """

    stage: str
    find: Callable[[sa.Connection], Iterable[Check]]
    done: int = 0
    total: int = 1

    def checked(self, connection: sa.Connection) -> Step:
        """Return what is found in what a connection reads, up to the first value that nobody can read."""
        found: list[Check] = []
        try:
            found.extend(self.find(connection))
        except (AlteredError, InputError) as error:
            what = error.what if isinstance(error, AlteredError) else error
            found.append(Check("reading", 1, 1, first=f"{self.stage}: {what}"))
        return Step(self.stage, self.done, self.total, tuple(found))


def checked_apart(path: Path, part: Part) -> Step:
    """Return what is found in the file as it is now: the rows of a class stay what they are."""
    with closing(Catalogue(path)) as catalogue, catalogue.reading() as connection:
        return part.checked(connection)


@dataclass(frozen=True, eq=False)
class Block:
    """Classes of one period, or pruned words, that are checked together.

    Attributes
    ----------
    p : int
    ids : ndarray of int64, shape (N,)
        Their numbers.
    done, total : int
        How many are checked with these, and how many there are to check.
    """

    p: int
    ids: NDArray[np.int64]
    done: int
    total: int

    def part(self, stage: str, find: Callable[["Block", sa.Connection], Iterable[Check]]) -> Part:
        """Return them as a part that is checked by a function."""
        return Part(f"{stage}, p = {self.p}", partial(find, self), self.done, self.total)


def blocks(ids: Ids, size: int = _CLASSES) -> Iterator[Block]:
    """Cut classes into blocks of at most so many, and of fewer long words, whose Hessians fill the memory."""
    done, total = 0, sum(map(len, ids.values()))
    for p, those in ids.items():
        step = max(1, min(size, _NUMBERS // p**2))
        for start in range(0, len(those), step):
            block = those[start : start + step]
            done += len(block)
            yield Block(p, block, done, total)


def is_chosen(p: int, selections: Sequence[Selection]) -> bool:
    """Tell whether a period is chosen at some a; without any a all are."""
    return not selections or any(each.includes(p) for each in selections)
