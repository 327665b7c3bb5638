"""A single word: its orbit in a stadium, and its lives, that is, the ranges of a in which it is an orbit."""

from dataclasses import replace
from typing import Any

from orbitdb.billiard.stadium import MIN_A, Stadium, as_stadium
from orbitdb.errors import InputError
from orbitdb.orbits.batch import NUMBERS, finite
from orbitdb.orbits.births.changes import Stretch, find_changes
from orbitdb.orbits.newton import solve_admissible
from orbitdb.orbits.orbit import Orbit, pruned_word
from orbitdb.orbits.status import Status
from orbitdb.symbols.symmetry import class_of, class_size, label, time_reversal
from orbitdb.symbols.words import from_strings, is_primitive, parse, parse_primitive

LONGEST = 200
"""Largest number of bounces of a word that is followed as a varies."""


def existence(word: str) -> list[Stretch]:
    """Find the ranges of a in which a word is an orbit.

    Parameters
    ----------
    word : str
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
    symbols = parse(word)
    if len(symbols) > LONGEST:
        raise InputError(
            f"a word of {len(symbols)} bounces is too long to follow as a varies: give at most {LONGEST}"
        )
    if not is_primitive(symbols) or pruned_word(symbols, MIN_A) is not None:
        return []
    return find_changes(from_strings([class_of(symbols).representative])).lives()[0]


def solve_word(word: str, stadium: Stadium | float, exists: bool = False) -> Orbit:
    """Solve one primitive word of any period, in any rotation.

    Parameters
    ----------
    word : str
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
    word, stadium = parse_primitive(word), as_stadium(stadium)
    lives = tuple(existence(word)) if exists else None
    if (pruned := pruned_word(word, stadium.a)) is not None:
        return replace(pruned, exists=lives)
    family = class_of(word)
    found = solve_admissible(from_strings([word]), stadium)
    numbers: dict[str, Any] = {name: finite(getattr(found, name)[0]) for name in NUMBERS}
    status = Status(str(found.status[0]))
    there = status in (Status.ORBIT, Status.BOUNDARY)
    return Orbit(
        code=word,
        representative=family.representative,
        a=stadium.a,
        status=status,
        time_reversal=time_reversal(family.stabiliser),
        symmetry=label(family.stabiliser),
        class_size=class_size(family.stabiliser),
        coordinates=found.coordinates[0] if there else None,
        solver="newton",
        exists=lives,
        **(numbers if there else {"margin": numbers["margin"]}),
    )
