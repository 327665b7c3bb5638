"""The bounces of orbits one by one, as rows: where each is, and how the path leaves it."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from orbitdb.billiard.stability import birkhoff
from orbitdb.billiard.stadium import Stadium
from orbitdb.columns import OF_BOUNCES
from orbitdb.symbols.words import from_strings

BOUNCE_COLUMNS = tuple(each.name for each in OF_BOUNCES)

BounceRow = tuple[int, int, float, float, float, float, float]


def bounce_rows(
    stadium: Stadium, words: Sequence[str], coordinates: Sequence[NDArray[np.float64] | None]
) -> list[list[BounceRow]]:
    """Return the bounces of some orbits, for each a list of rows with the columns `BOUNCE_COLUMNS`.

    Parameters
    ----------
    stadium : Stadium
    words : sequence of str
    coordinates : sequence of ndarray, shape (p,), or None
        Those of each word; one that has none has no rows.
    """
    found: list[list[BounceRow]] = [[] for _ in words]
    periods: dict[int, list[int]] = {}
    for place, (word, known) in enumerate(zip(words, coordinates, strict=True)):
        if known is not None:
            periods.setdefault(len(word), []).append(place)
    for p, places in periods.items():
        symbols = from_strings([words[place] for place in places])
        here = np.array([coordinates[place] for place in places])
        x, y = np.moveaxis(stadium.points(symbols, here), -1, 0)
        columns = (symbols, here, x, y, *birkhoff(stadium, symbols, here))
        numbers = range(1, p + 1)
        for place, *rows in zip(places, *(column.tolist() for column in columns), strict=True):
            found[place] = list(zip(numbers, *rows, strict=True))
    return found
