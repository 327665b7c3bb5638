"""Jumping by typing: where the first row is of a period, or of a code that begins so."""

from collections.abc import Callable

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

Span = tuple[int, int]
"""A key, and one above it: what is meant is from the first on, and below the other."""


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
    place = pages.keys.first_within(_of_period(pages, period)) if period else None
    if place is not None:
        return place, f"period {period}"
    if not set(typed) <= set(SYMBOLS):
        return None, f"no period {period}" if period else f"no code {typed}"
    place = _place_of_word(pages, typed)
    if place is None:
        place = pages.keys.first_within(_beginning(pages, typed))
    return place, f"code {typed}" if place is not None else f"no code {typed}"


def _of_period(pages: Pages, period: int) -> list[Span]:
    """Return where the keys of the words of a period are."""
    if period <= MAX_KEYED:
        low, high = keys_of_period(period)
        return [(low, high)]
    return _long(pages, lambda word: len(word) == period)


def _beginning(pages: Pages, code: str) -> list[Span]:
    """Return where the keys of the words are that begin with some symbols: in each period, between two."""
    rests = [BITS * (p - len(code)) for p in range(len(code), MAX_KEYED + 1)]
    spans = [(key(code) << rest, (key(code) + 1) << rest) for rest in rests]
    return spans + _long(pages, lambda word: word.startswith(code))


def _long(pages: Pages, fits: Callable[[str], bool]) -> list[Span]:
    """Return the keys of long words, one by one."""
    keys = [pages.index.key(word) for word in pages.index.long_words if fits(word)]
    return [(number, number + 1) for number in keys if number is not None]


def _place_of_word(pages: Pages, code: str) -> int | None:
    try:
        return pages.position(least_rotation(parse_primitive(code)))
    except WordError:
        return None
