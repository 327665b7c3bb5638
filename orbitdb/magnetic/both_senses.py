"""The words of one period in a magnetic field, each symmetry class followed once.

A class is solved once without a field, and followed to kappa and to -kappa. Its images under even elements
(the identity, xy, xT, yT) have the numbers of the representative at kappa; images under odd elements
(x, y, T, xyT) have those at -kappa.
"""

from dataclasses import dataclass
from typing import Any, NamedTuple, Self

import numpy as np

from orbitdb.arrays import Floats, Indices, Marks, Masks, Words
from orbitdb.billiard.stadium import Stadium
from orbitdb.magnetic.along_kappa import follow_in_field
from orbitdb.magnetic.field_status import FieldNumbers, FieldStatus, measure
from orbitdb.symbols.symmetry import ODD, class_of, classify, encloses_nothing
from orbitdb.symbols.words import MAX_KEYED, from_strings, least_rotations, pack, to_strings, unpack


class _Classes(NamedTuple):
    """The symmetry classes of N words."""

    least: Words  # the representatives, shape (C, p)
    stabiliser: Masks  # shape (C,)
    owner: Indices  # the class of each word, shape (N,)
    odd: Marks  # whether an odd element leads to the word, shape (N,)


def _classes_of(words: Words) -> _Classes:
    p = words.shape[1]
    if p <= MAX_KEYED:
        found = classify(least_rotations(pack(words), p), p)
        codes, first, owner = np.unique(found.representative, return_index=True, return_inverse=True)
        return _Classes(unpack(codes, p), found.stabiliser[first], owner, np.isin(found.element, ODD))
    families = [class_of(word) for word in to_strings(words)]
    stabilisers = {family.representative: family.stabiliser for family in families}
    place = {word: number for number, word in enumerate(stabilisers)}
    owner = np.array([place[family.representative] for family in families])
    odd = np.isin([family.element for family in families], ODD)
    return _Classes(from_strings([*place]), np.array([*stabilisers.values()], np.uint8), owner, odd)


@dataclass(frozen=True)
class BothSenses:
    """N words of one period as paths to follow: each class to kappa and, unless it is the same, to -kappa."""

    least: Words  # the representatives, shape (C, p)
    rows: Indices  # the class of each path, shape (M,)
    sign: Floats  # 1 or -1, by which kappa is multiplied, shape (M,)
    paths: Indices  # the path of each word, and that of its reverse, if kappa is positive, shape (2, N)

    @classmethod
    def of(cls, words: Words) -> Self:
        """Find the classes of words, shape (N, p), in any rotation."""
        least, stabiliser, owner, odd = _classes_of(words)
        both = ~encloses_nothing(stabiliser)  # the others are the same at kappa and -kappa
        forth = np.arange(len(least))
        back = np.where(both, len(least) - 1 + np.cumsum(both), forth)
        paths = np.stack([forth, back])[:, owner]
        sign = np.repeat([1.0, -1.0], [len(least), both.sum()])
        rows = np.concatenate([forth, np.flatnonzero(both)])
        return cls(least, rows, sign, np.where(odd, paths[::-1], paths))

    def follow(self, stadium: Stadium, free: Floats, kappas: Floats) -> dict[float, dict[str, Any]]:
        """Follow the representatives to curvatures; return the numbers of all words at each, as columns.

        They start at `free`, their coordinates without a field, shape (C, p).
        """
        words, coordinates, at = self.least[self.rows], free[self.rows], 0.0
        numbers: dict[float, dict[str, Any]] = {}
        for size in np.unique(np.abs(kappas)).tolist():
            followed = follow_in_field(stadium, words, coordinates, self.sign * at, self.sign * size)
            coordinates, at = followed.coordinates, size
            found = measure(stadium, words, followed, self.sign * size)
            if size == 0:  # words without a fixed point to start from are proved to be no orbits
                found.status[found.status == FieldStatus.UNRESOLVED.value] = FieldStatus.JOINT.value
            own = kappas[np.abs(kappas) == size].tolist()
            numbers |= {kappa: self._numbers(found, kappa) for kappa in own}
        return numbers

    def _numbers(self, found: FieldNumbers, kappa: float) -> dict[str, Any]:
        """Return the numbers of the words at one curvature, given those of the paths."""
        own, reverse = self.paths[::-1] if kappa < 0 else self.paths
        sense = self.sign[own] * (-1.0 if kappa < 0 else 1.0)
        return vars(found.rows(own)) | {
            "splitting": found.action[reverse] - found.action[own],
            "area": found.area[own] * sense + 0.0,  # not -0.0
        }
