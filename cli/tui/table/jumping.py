"""Jumping by typing: where the first row is of a period, or of a code that begins so."""

from collections.abc import Callable

from orbitdb.cli.tui.table.source import Pages
from orbitdb.store.asking.confinement import never
from orbitdb.symbols.words import SYMBOLS, WordError, least_rotation, parse_primitive

Found = tuple[int | None, str]
"""The number of a row, or None, and what is in it."""


def place_of(pages: Pages, typed: str, cancelled: Callable[[], bool] = never) -> Found:
    """Return where what was typed leads to, and say what that is.

    A number of one or two digits is a period, if the rows have it. Everything else is a code: a word in
    any rotation, or else how the code of a row begins.

    Parameters
    ----------
    pages : Pages
        The rows in their order; the first that fits is meant.
    typed : str
        Digits.
    cancelled : callable, optional
        Asked now and then whether nobody waits any more.

    Raises
    ------
    CancelledError
        If nobody does.
    """
    from orbitdb.store.reading.finding import first_beginning, first_of_period

    period = int(typed) if len(typed) <= 2 and typed[0] != "0" else 0
    place = first_of_period(pages.catalogue, pages.chosen, period) if period else None
    if place is not None:
        return place, f"period {period}"
    if not set(typed) <= set(SYMBOLS):
        return None, f"no period {period}" if period else f"no code {typed}"
    place = _place_of_word(pages, typed)
    if place is None:
        place = first_beginning(pages.catalogue, pages.chosen, typed, cancelled)
    return place, f"code {typed}" if place is not None else f"no code {typed}"


def _place_of_word(pages: Pages, code: str) -> int | None:
    try:
        return pages.position(least_rotation(parse_primitive(code)))
    except WordError:
        return None
