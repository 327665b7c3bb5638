"""The words to follow into a magnetic field: given ones, whole periods, or those that criteria choose."""

from collections.abc import Iterable, Sequence
from functools import partial
from typing import NamedTuple

import numpy as np

from orbitdb.answers.completeness import Coverage
from orbitdb.arrays import Indices, Words
from orbitdb.errors import InputError, SelectionError, as_texts
from orbitdb.orbits.orbit import pruned_word
from orbitdb.orbits.status import Status
from orbitdb.period_ranges import check_periods
from orbitdb.selection import Selection
from orbitdb.store.select import Words as Chosen
from orbitdb.store.select import count, rows_of
from orbitdb.store.sqlite import Connection
from orbitdb.symbols.enumeration import Span, all_least_words
from orbitdb.symbols.pruning import count_admissible
from orbitdb.symbols.symmetry import SIZES, packed_members
from orbitdb.symbols.words import from_strings, parse_primitive, read_words, unpack
from orbitdb.text import shortened

LONGEST = 1000
"""Largest number of bounces of a word that is followed into a field."""

MOST = 2_000_000
"""Largest number of entries of a result."""


class PickedWords(NamedTuple):
    """Words to follow into a field."""

    selection: Selection
    batches: list[
        tuple[Indices, Words]
    ]  # for each period, the places of the entries, and words, shape (N, p)
    periods: tuple[int, ...]  # those whose words are all here
    notes: list[str]


def named_words(words: str | Iterable[str], a: float) -> PickedWords:
    """Return given words; raise `InputError` if one of them cannot be followed from kappa = 0."""
    codes = read_words(as_texts("words", words), read=partial(followable, a=a))
    return PickedWords(Selection(a), _by_period(codes), (), [])


def followable(word: str, a: float) -> str:
    """Return the symbols of a word; raise `InputError` if it has no fixed point without a field."""
    symbols = parse_primitive(word)
    if (pruned := pruned_word(symbols, a)) is not None:
        raise InputError(f"{shortened(symbols)} cannot be followed into a field: {pruned.status.sentence}")
    if len(symbols) > LONGEST:
        raise InputError(
            f"a word of {len(symbols)} bounces is too long to follow into a field: give at most {LONGEST}"
        )
    return symbols


_PRUNED = "status geometric: geometrically pruned words cannot be followed into a field"


def _by_period(codes: Sequence[str]) -> list[tuple[Indices, Words]]:
    orders = np.array([len(code) for code in codes])
    groups = [np.flatnonzero(orders == p) for p in np.unique(orders)]
    return [(rows, from_strings([codes[row] for row in rows.tolist()])) for rows in groups]


def chosen_words(connection: Connection, chosen: Selection) -> PickedWords:
    """Return the words of chosen periods, of all filled ones by default, or those that criteria choose.

    Words chosen by periods alone need not be stored.
    """
    given = chosen
    if Status.GEOMETRIC in given.statuses:
        chosen = given.preferring(())
    if Status.GEOMETRIC in chosen.statuses:
        raise SelectionError(_PRUNED)
    coverage = Coverage(connection, chosen)
    if chosen != Selection(chosen.a, chosen.periods):
        codes = [code for (code,) in rows_of(connection, Chosen(chosen), ("code",))]
        if not codes and chosen != given and count(connection, given):  # all of them are pruned
            raise SelectionError(_PRUNED)
        notes = [*coverage.gaps(), "" if codes else coverage.nothing()]
        return PickedWords(chosen, _by_period(codes), (), [*filter(None, notes)])
    periods = check_periods(chosen.periods) if chosen.periods else coverage.filled
    return whole_periods(chosen, periods)._replace(notes=[] if periods else coverage.gaps())


def whole_periods(chosen: Selection, periods: Sequence[int]) -> PickedWords:
    """Return all words of the given periods that the geometric rules allow.

    Raises
    ------
    InputError
        If there are too many.
    """
    total = sum(map(count_admissible, periods))
    if total > MOST:
        raise InputError(f"these periods have {total} words, more than {MOST}: choose fewer periods")
    batches, start = [], 0
    for p in periods:
        classes = all_least_words(Span.of_period(p))
        every = ((1 << SIZES[classes.stabiliser]) - 1).astype(np.uint8)
        codes = np.concatenate([*packed_members(classes.codes, p, every, classes.stabiliser)])
        batches.append((np.arange(start, start := start + len(codes)), unpack(codes, p)))
    return PickedWords(chosen, batches, tuple(periods), [])
