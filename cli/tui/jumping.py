"""Jumping by typing: where the first row is of a period, or of a code that begins so."""

import numpy as np
from numpy.typing import NDArray

from orbitdb.cli.tui.source import Pages
from orbitdb.symbols.words import (
    BITS,
    MAX_KEYED,
    SYMBOLS,
    WordError,
    key,
    keys_of_period,
    least_rotation,
    parse_primitive,
)

Found = tuple[int | None, str]
"""The number of a row, or None, and what is in it."""


def place_of(pages: Pages, typed: str) -> Found:
    """Return where what was typed leads to, and say what that is.

    A number of one or two digits is a period, if the rows have it. Everything else is a code: a word in
    any rotation, or else how the code of a row begins.

    Parameters
    ----------
    pages : Pages
        The rows in their order; the first that fits is meant.
    typed : str
        Digits.
    """
    period = int(typed) if len(typed) <= 2 and typed[0] != "0" else 0
    place = _first(_of_period(pages, period)) if period else None
    if place is not None:
        return place, f"period {period}"
    if not set(typed) <= set(SYMBOLS):
        return None, f"no period {period}" if period else f"no code {typed}"
    place = _place_of_word(pages, typed)
    if place is None:
        place = _first(_beginning(pages, typed))
    return place, f"code {typed}" if place is not None else f"no code {typed}"


def _first(fits: NDArray[np.bool_]) -> int | None:
    places = np.flatnonzero(fits)
    return int(places[0]) if len(places) else None


def _of_period(pages: Pages, period: int) -> NDArray[np.bool_]:
    if period <= MAX_KEYED:
        low, high = keys_of_period(period)
        return (low <= pages.keys) & (pages.keys <= high)
    fits = [word for word in pages.index.long_words if len(word) == period]
    return _are_long(pages, fits)


def _beginning(pages: Pages, code: str) -> NDArray[np.bool_]:
    """Tell which words begin with some symbols: those of each period stand between two keys."""
    fits = _are_long(pages, [word for word in pages.index.long_words if word.startswith(code)])
    for p in range(len(code), MAX_KEYED + 1):
        rest = BITS * (p - len(code))
        low = key(code) << rest
        fits |= (low <= pages.keys) & (pages.keys < low + (1 << rest))
    return fits


def _are_long(pages: Pages, words: list[str]) -> NDArray[np.bool_]:
    fits = np.zeros(len(pages.keys), dtype=np.bool_)
    for word in words:
        place = pages.index.position(pages.keys, word)
        if place is not None:
            fits[place] = True
    return fits


def _place_of_word(pages: Pages, code: str) -> int | None:
    try:
        return pages.position(least_rotation(parse_primitive(code)))
    except WordError:
        return None
