"""The bounces of orbits as rows of a table: one row per bounce."""

from collections.abc import Iterator, Sequence
from itertools import groupby, islice
from typing import Any

import numpy as np

from orbitdb.billiard.stability import birkhoff
from orbitdb.billiard.stadium import Stadium
from orbitdb.columns import OF_BOUNCES, Row
from orbitdb.symbols.plane import symbol_plane
from orbitdb.symbols.words import from_strings

BOUNCE_COLUMNS = tuple(column.name for column in OF_BOUNCES)
_BLOCK = 4_000
"""Words whose bounces are computed together."""

BounceRow = tuple[int, int, float, float, float, float, float, float, float]


def bounce_rows(a: float, words: Sequence[str], coordinates: Sequence[Any]) -> list[list[BounceRow]]:
    """Return the bounces of each word as a list of rows with the columns `BOUNCE_COLUMNS`.

    The list of a word whose coordinates are None is empty.
    """
    stadium = Stadium(a)
    bounces: list[list[BounceRow]] = [[] for _ in words]
    periods: dict[int, list[int]] = {}
    for place, (word, of_word) in enumerate(zip(words, coordinates, strict=True)):
        if of_word is not None:
            periods.setdefault(len(word), []).append(place)
    for p, places in periods.items():
        symbols = from_strings([words[place] for place in places])
        of_words = np.array([coordinates[place] for place in places])
        x, y = np.moveaxis(stadium.points(symbols, of_words), -1, 0)
        plane = np.moveaxis(symbol_plane(symbols), -1, 0)
        columns = (symbols, of_words, x, y, *birkhoff(stadium, symbols, of_words), *plane)
        numbers = range(1, p + 1)
        for place, *rows in zip(places, *(column.tolist() for column in columns), strict=True):
            bounces[place] = list(zip(numbers, *rows, strict=True))
    return bounces


def bounce_by_bounce(rows: Iterator[Row]) -> Iterator[Row]:
    """Yield a row per bounce for rows that end with a, code and coordinates (None without an orbit)."""
    while block := list(islice(rows, _BLOCK)):
        for a, group in groupby(block, key=lambda row: row[-3]):
            of_words = list(group)
            words, coordinates = ([row[place] for row in of_words] for place in (-2, -1))
            for row, bounces in zip(of_words, bounce_rows(a, words, coordinates), strict=True):
                yield from ((*row[:-3], *bounce) for bounce in bounces)
