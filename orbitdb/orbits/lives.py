"""From where to where in a one word is an orbit."""

from orbitdb.billiard.stadium import MIN_A
from orbitdb.errors import InputError
from orbitdb.orbits.births import Life, find_changes
from orbitdb.orbits.pruned import pruned_word
from orbitdb.symbols.symmetry import class_of
from orbitdb.symbols.words import from_strings, is_primitive, parse

LONGEST = 200
"""Bounces of a word that is followed in a, at most."""


def existence(word: str) -> list[Life]:
    """Find from where to where in a one word is an orbit.

    Parameters
    ----------
    word : str
        Symbols 0..5, in any rotation; a pruned word, the family 02 or a repetition never is one.

    Returns
    -------
    list of (float, float or None)
        By rising a; from 0 where it is an orbit from there on, to None where that has no end.

    Raises
    ------
    InputError
        If the text is no word, or one of more than `LONGEST` bounces.

    Examples
    --------
    >>> existence("013")
    [(0.0, None)]
    """
    symbols = parse(word)
    if len(symbols) > LONGEST:
        raise InputError(f"a word of {len(symbols)} bounces is not followed in a: {LONGEST} are the most")
    if not is_primitive(symbols) or pruned_word(symbols, MIN_A) is not None:
        return []
    return find_changes(from_strings([class_of(symbols).representative])).lives()[0]
