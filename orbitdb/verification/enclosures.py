"""Stored bounds on the topological entropy: sound, and at odds neither with one another nor with new ones."""

from collections.abc import Iterator, Sequence
from itertools import groupby
from typing import TYPE_CHECKING

from orbitdb.billiard.stadium import Stadium
from orbitdb.store.reading.enclosures import Enclosure, is_sound, rows
from orbitdb.verification.check import Check, shown

if TYPE_CHECKING:
    import sqlalchemy as sa

    from orbitdb.entropy.bounds import EntropyBounds

_EDGES = 7
"""Windows of so many edges take less than a tenth of a second at any a."""


def check_enclosures(connection: "sa.Connection") -> Iterator[Check]:
    """Check that all bounds at one a, with new ones of short windows, have a number in common."""
    for a, group in groupby(rows(connection), key=lambda each: each.a):
        found = list(group)
        wrong = list(_wrong(found))
        first = shown(f"windows of {wrong[0].window} edges at a = {a:g}") if wrong else None
        yield Check("entropy", len(found), len(wrong), first=first)


def _wrong(found: Sequence[Enclosure]) -> Iterator[Enclosure]:
    """Yield the rows that are not sound, or have nothing in common with new bounds or with closer ones."""
    from orbitdb.entropy.bounds import search  # SciPy's sparse matrices load slowly

    sound = [each for each in found if is_sound(each)]
    new = list(search(Stadium(sound[0].a), _EDGES)) if sound else []
    for each in found:
        others: list[Enclosure | EntropyBounds] = [*new, *(one for one in sound if one.width < each.width)]
        if each not in sound or not all(_meet(each, other) for other in others):
            yield each


def _meet(one: Enclosure, other: "Enclosure | EntropyBounds") -> bool:
    return one.lower <= other.upper and other.lower <= one.upper
