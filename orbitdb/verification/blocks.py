"""Parts of a catalogue that are checked apart, by whatever process: what is found depends on nothing else."""

from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import NDArray

from orbitdb.catalogue.catalogue import Catalogue
from orbitdb.equality import ByValue
from orbitdb.store.asking.selection import Selection
from orbitdb.verification.check import Step
from orbitdb.version import __version__

if TYPE_CHECKING:
    import sqlalchemy as sa


@dataclass(frozen=True)
class Checked:
    """What was found in a part, and which orbitdb looked."""

    step: Step
    version: str


@dataclass(frozen=True, eq=False)
class Part(ByValue, ABC):
    """A part of a catalogue that is to be checked.

    Attributes
    ----------
    path : Path
        The catalogue.
    """

    path: Path

    @abstractmethod
    def checked(self, connection: "sa.Connection") -> Step:
        """Return what is found in what a connection reads."""

    def solved(self) -> Checked:
        """Return what is found in the catalogue as it is now: the rows of a class stay what they are."""
        with _opened(self.path).reading() as connection:
            return Checked(self.checked(connection), __version__)


@dataclass(frozen=True, eq=False)
class ClassBlock(Part, ABC):
    """Classes of one period that are to be checked.

    Attributes
    ----------
    p : int
    ids : ndarray of int64, shape (N,)
        Their numbers.
    before, total : int
        How many classes are checked before these, and how many there are to check.
    """

    p: int
    ids: NDArray[np.int64]
    before: int
    total: int

    @property
    def done(self) -> int:
        """How many classes are checked with these."""
        return self.before + len(self.ids)


@lru_cache(maxsize=1)
def _opened(path: Path) -> Catalogue:
    return Catalogue(path)


def is_chosen(p: int, selections: Sequence[Selection]) -> bool:
    """Tell whether a period is chosen at some a; without any a all are."""
    return not selections or any(each.includes(p) for each in selections)


class Workers(Protocol):
    """Something that checks parts, such as `orbitdb.filling.workers.Processes`."""

    def solved(self, blocks: Iterable[Part]) -> Iterator[Checked]:
        """Yield what was found in parts, in their order."""


def steps_of(parts: Iterable[Part], connection: "sa.Connection", workers: Workers | None) -> Iterator[Step]:
    """Yield what is found in parts, in their order: by workers, or here, in what one connection reads."""
    if workers is None:
        return (part.checked(connection) for part in parts)
    return (found.step for found in workers.solved(parts))
