"""Find the orbits of words, and the ranges of a in which a word is an orbit."""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Any, overload

import numpy as np

from orbitdb.arrays import Words
from orbitdb.billiard.stadium import MIN_A, Stadium, as_stadium
from orbitdb.errors import InputError
from orbitdb.orbits.admissible import solve_admissible, solve_periods
from orbitdb.orbits.newton import TOLERANCE
from orbitdb.orbits.orbit import Orbit, pruned_word, pruned_words
from orbitdb.orbits.orbits import NUMBERS, Orbits, finite
from orbitdb.orbits.status import EXISTING, Status
from orbitdb.symbols.pruning import need_admissible
from orbitdb.symbols.symmetry import SymmetryClass, class_of, class_size, label, time_reversal
from orbitdb.symbols.words import from_strings, is_primitive, parse, parse_primitive, read_words


@overload
def solve(words: Words, stadium: Stadium | float, tolerance: float | None = None) -> Orbits: ...


@overload
def solve(words: str | Iterable[str], stadium: Stadium | float, *, errors: str = "raise") -> list[Orbit]: ...


def solve(
    words: Words | str | Iterable[str],
    stadium: Stadium | float,
    tolerance: float | None = None,
    *,
    errors: str = "raise",
) -> Orbits | list[Orbit]:
    """Find the orbits of many words.

    Parameters
    ----------
    words : iterable of str, or ndarray of uint8, shape (N, p)
        Primitive words of any periods as texts, or admissible words of one period as an array
        (`orbitdb.symbols.words.from_strings`).
    stadium : Stadium or float
        The stadium, or its half length.
    tolerance : float, optional
        For an array: error of the leg directions at which Newton's method stops (radians).
    errors : str, optional
        For texts: ``skip`` to leave out those that are not primitive words; by default they raise.

    Returns
    -------
    list of Orbit, or Orbits
        An `Orbit` for each text, as from `solve_word`; for an array, `Orbits`, as arrays. Each word has a
        status, found in ball arithmetic if doubles cannot decide it.

    Raises
    ------
    WordError
        If texts are not primitive words, which are named by their places, or if a word of the array is not
        admissible.
    StadiumError
        If the half length is not valid.

    Examples
    --------
    >>> [orbit.p for orbit in solve(["13", "013"], 1.6)]
    [2, 3]
    """
    if isinstance(words, np.ndarray):
        need_admissible(words)
        return solve_admissible(words, as_stadium(stadium), TOLERANCE if tolerance is None else tolerance)
    if tolerance is not None:
        raise InputError("tolerance is for words given as an array: leave it out")
    texts = [words] if isinstance(words, str) or not isinstance(words, Iterable) else words
    return solve_words(read_words(texts, errors), as_stadium(stadium))


def solve_words(words: Sequence[str], stadium: Stadium) -> list[Orbit]:
    """Solve primitive words of any periods, in any rotation (`solve`)."""
    found = pruned_words(words, stadium.a)
    periods: dict[int, list[str]] = {}
    for word in dict.fromkeys(words):
        if word not in found:
            periods.setdefault(len(word), []).append(word)
    groups = [*periods.values()]
    solved = solve_periods([from_strings(group) for group in groups], stadium)
    for group, orbits in zip(groups, solved, strict=True):
        classes = [class_of(word) for word in group]
        stabilisers = np.array([family.stabiliser for family in classes], np.uint8)
        orbits = orbits.with_symmetries(stabilisers)
        for row, (word, family) in enumerate(zip(group, classes, strict=True)):
            found[word] = _orbit_of(orbits, row, word, family, stadium.a)
    return [found[word] for word in words]


def _orbit_of(orbits: Orbits, row: int, word: str, family: SymmetryClass, a: float) -> Orbit:
    """Return one of some solved words."""
    numbers: dict[str, Any] = {name: finite(getattr(orbits, name)[row]) for name in NUMBERS}
    status = Status(str(orbits.status[row]))
    is_orbit = status in EXISTING
    return Orbit(
        code=word,
        representative=family.representative,
        a=a,
        status=status,
        time_reversal=time_reversal(family.stabiliser),
        symmetry=label(family.stabiliser),
        class_size=class_size(family.stabiliser),
        coordinates=orbits.coordinates[row] if is_orbit else None,
        solver="newton",
        **(numbers if is_orbit else {"margin": numbers["margin"]}),
    )


def solve_word(code: str, stadium: Stadium | float, exists: bool = False) -> Orbit:
    """Solve one primitive word of any period, in any rotation.

    Parameters
    ----------
    code : str
        Symbols 0..5 or run notation. Words that are geometrically pruned are not solved.
    stadium : Stadium or float
        The stadium, or its half length.
    exists : bool, optional
        Also find the ranges of a in which the word is an orbit (`existence`) and store them in
        `Orbit.exists`; this takes a hundred times as long.

    Returns
    -------
    Orbit
        The orbit, with its coordinates in the order of the word.

    Raises
    ------
    WordError
        If the text is not a word, or is a repetition of a shorter word.
    StadiumError
        If the half length is not valid.
    InputError
        If ``exists`` is set and the word has more than `LONGEST` bounces.

    Examples
    --------
    >>> solve_word("013", 1.6, exists=True).exists
    ((0.0, None),)
    """
    symbols = parse_primitive(code)
    (orbit,) = solve_words([symbols], as_stadium(stadium))
    return replace(orbit, exists=tuple(existence(symbols))) if exists else orbit


LONGEST = 200
"""Largest number of bounces of a word that is followed as a varies."""


def existence(code: str) -> "list[tuple[float, float | None]]":
    """Find the ranges of a in which a word is an orbit.

    Parameters
    ----------
    code : str
        Symbols 0..5, in any rotation. Pruned words, the family 02 and repetitions have no ranges.

    Returns
    -------
    list of (float, float or None)
        The ranges in ascending order. A range may begin at 0; its end is None if it extends to infinity.

    Raises
    ------
    InputError
        If the text is not a word, or has more than `LONGEST` bounces.

    Examples
    --------
    >>> existence("013")
    [(0.0, None)]
    """
    symbols = parse(code)
    if len(symbols) > LONGEST:
        raise InputError(
            f"a word of {len(symbols)} bounces is too long to follow as a varies: give at most {LONGEST}"
        )
    if not is_primitive(symbols) or pruned_word(symbols, MIN_A) is not None:
        return []
    from orbitdb.orbits.births import find_changes  # seldom needed

    return find_changes(from_strings([class_of(symbols).representative])).lives()[0]


def with_existence(orbit: Orbit) -> Orbit:
    """Return an orbit with the ranges of a in which it exists, after computing them if necessary.

    The ranges stay unknown for words longer than `LONGEST`.
    """
    if orbit.exists is not None or orbit.p > LONGEST:
        return orbit
    return replace(orbit, exists=tuple(existence(orbit.code)))
