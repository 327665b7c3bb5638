"""Stored bounds on the topological entropy: sound, at odds with no others, and their windows recounted."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import sqlalchemy as sa

from orbitdb.billiard.stadium import Stadium
from orbitdb.store.file.schema import BALLS
from orbitdb.store.file.tables import entropy_bound
from orbitdb.store.reading.records import Enclosure, bounds_stored, is_sound
from orbitdb.verification.blocks import Part
from orbitdb.verification.check import Check, Step, shown
from orbitdb.verification.provenance import runs_of_here

if TYPE_CHECKING:
    from orbitdb.entropy.bounds import EntropyBounds

RECOUNTED = 3000
"""Windows that are decided again at any a, in some tenths of a second."""

_COUNTED = ("windows", "undecided", "lower", "upper")


def enclosure_parts(connection: sa.Connection, path: Path) -> Iterator["EnclosurePart"]:
    """Yield one part for each a at which there are bounds."""
    values = connection.scalars(sa.select(entropy_bound.c.a).distinct().order_by(entropy_bound.c.a))
    return (EnclosurePart(path, a) for a in values)


@dataclass(frozen=True, eq=False)
class EnclosurePart(Part):
    """The bounds at one a."""

    a: float

    def checked(self, connection: sa.Connection) -> Step:
        """Return what is found in the rows that a connection reads."""
        found, ours = bounds_stored(connection, a=self.a), _made_here(connection, self.a)
        wrong = list(_wrong(found, ours))
        first = shown(f"windows of {wrong[0].window} edges at a = {self.a:g}") if wrong else None
        return Step("entropy", 0, 1, (Check("entropy", len(found), len(wrong), first=first),))


def _made_here(connection: sa.Connection, a: float) -> set[tuple[str, int]]:
    """Return proof and edges of the bounds at one a that this version has found with this arithmetic."""
    table = entropy_bound.c
    query = sa.select(table.proof, table.edges).where(table.a == a, table.run.in_(runs_of_here(connection)))
    return {(proof, edges) for proof, edges in connection.execute(query)}


def _wrong(found: Sequence[Enclosure], ours: set[tuple[str, int]]) -> Iterator[Enclosure]:
    """Yield the rows that are not sound, have nothing in common with new bounds or closer ones, or differ."""
    sound = [each for each in found if is_sound(each)]
    new = _new_bounds(sound) if sound else {}
    for each in found:
        others: list[Enclosure | EntropyBounds] = [*new.values(), *(x for x in sound if x.width < each.width)]
        agrees = each in sound and all(_meet(each, other) for other in others)
        counted = new.get(each.window) if (each.proof, each.window) in ours else None
        if not agrees or (counted is not None and not _is_recounted(each, counted)):
            yield each


def _new_bounds(found: Sequence[Enclosure]) -> "Mapping[int, EntropyBounds]":
    """Return new bounds by length of windows, up to the longest stored or `RECOUNTED` windows."""
    from orbitdb.entropy.bounds import levels  # SciPy's sparse matrices load slowly

    new = {}
    for level in levels(Stadium(found[0].a)):
        new[level.window] = level
        if level.window >= max(each.window for each in found) or level.windows > RECOUNTED:
            break
    return new


def _meet(one: Enclosure, other: "Enclosure | EntropyBounds") -> bool:
    return one.lower <= other.upper and other.lower <= one.upper


def _is_recounted(one: Enclosure, new: "EntropyBounds") -> bool:
    """Tell whether a row is what is counted again; balls may leave open what doubles decide, no more."""
    if all(getattr(one, name) == getattr(new, name) for name in _COUNTED):
        return True
    wider = one.lower <= new.lower and new.upper <= one.upper
    return one.proof == BALLS and wider and one.windows >= new.windows and one.undecided >= new.undecided
