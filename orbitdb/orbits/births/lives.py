"""The lives of one word: the ranges of a in which it is an orbit."""

from dataclasses import replace

from orbitdb.billiard.stadium import MIN_A, Stadium
from orbitdb.errors import InputError
from orbitdb.orbits import newton
from orbitdb.orbits.births.changes import Life, find_changes
from orbitdb.orbits.orbit import Orbit, pruned_word
from orbitdb.symbols.symmetry import class_of
from orbitdb.symbols.words import from_strings, is_primitive, parse

LONGEST = 200
"""Bounces of a word that is followed in a, at most."""


def existence(word: str) -> list[Life]:
    """Find the ranges of a in which one word is an orbit.

    Parameters
    ----------
    word : str
        Symbols 0..5, in any rotation. A pruned word, the family 02 or a repetition has none.

    Returns
    -------
    list of (float, float or None)
        In order of a. A range may begin at 0, and its end is None if it has none.

    Raises
    ------
    InputError
        If the text is no word, or has more than `LONGEST` bounces.

    Examples
    --------
    >>> existence("013")
    [(0.0, None)]
    """
    symbols = parse(word)
    if len(symbols) > LONGEST:
        raise InputError(
            f"a word of {len(symbols)} bounces is too long to follow over a: give at most {LONGEST}"
        )
    if not is_primitive(symbols) or pruned_word(symbols, MIN_A) is not None:
        return []
    return find_changes(from_strings([class_of(symbols).representative])).lives()[0]


def solve_word(word: str, stadium: Stadium | float, exists: bool = False) -> Orbit:
    """Find what becomes of one primitive word of any order, in any rotation.

    Parameters
    ----------
    word : str
        Symbols 0..5 or run notation; words that are pruned geometrically are not solved.
    stadium : Stadium or float
        The stadium, or its a.
    exists : bool, optional
        Also find the ranges of a in which it is an orbit (`existence`), for `Orbit.exists`; that
        takes a hundred times as long.

    Returns
    -------
    Orbit
        With the coordinates in the order of the word.

    Raises
    ------
    WordError
        If it is no word, or repeats a shorter one.
    StadiumError
        If there is no such stadium.
    InputError
        If you ask for ``exists`` and it has more than `LONGEST` bounces.

    Examples
    --------
    >>> solve_word("013", 1.6, exists=True).exists
    ((0.0, None),)
    """
    found = newton.solve_word(word, stadium)
    return replace(found, exists=tuple(existence(found.code))) if exists else found
