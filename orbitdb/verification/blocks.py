"""Blocks of classes that are checked apart, by whatever process: what they find depends on nothing else."""

from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import NDArray

from orbitdb.equality import ByValue
from orbitdb.store.reading.catalogue import Catalogue
from orbitdb.verification.check import Step
from orbitdb.version import __version__

if TYPE_CHECKING:
    import sqlalchemy as sa


@dataclass(frozen=True)
class Checked:
    """What a block has found, and which orbitdb looked."""

    step: Step
    version: str


@dataclass(frozen=True, eq=False)
class ClassBlock(ByValue, ABC):
    """Classes of one period that are to be checked.

    Attributes
    ----------
    path : Path
        The catalogue.
    p : int
    ids : ndarray of int64, shape (N,)
        Their numbers.
    before, total : int
        How many classes are checked before these, and how many there are to check.
    """

    path: Path
    p: int
    ids: NDArray[np.int64]
    before: int
    total: int

    @property
    def done(self) -> int:
        """How many classes are checked with these."""
        return self.before + len(self.ids)

    @abstractmethod
    def checked(self, connection: "sa.Connection") -> Step:
        """Return what is found in the rows that a connection reads."""

    def solved(self) -> Checked:
        """Return what is found in the rows as they are now: those of a class stay what they are."""
        with _opened(self.path).reading() as connection:
            return Checked(self.checked(connection), __version__)


@lru_cache(maxsize=1)
def _opened(path: Path) -> Catalogue:
    return Catalogue(path)


class Workers(Protocol):
    """Something that checks blocks, such as `orbitdb.filling.workers.Processes`."""

    def solved(self, blocks: Iterable[ClassBlock]) -> Iterator[Checked]:
        """Yield what blocks have found, in their order."""


def steps_of(
    blocks: Iterable[ClassBlock], connection: "sa.Connection", workers: Workers | None
) -> Iterator[Step]:
    """Yield what blocks find, in their order: by workers, or here, in what one connection reads."""
    if workers is None:
        return (block.checked(connection) for block in blocks)
    return (found.step for found in workers.solved(blocks))
