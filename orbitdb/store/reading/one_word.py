"""One word of any order, asked for: from a catalogue, or solved on the spot.

No more is loaded than it takes: a stored orbit needs no solver, and no word needs SQLAlchemy.
"""

from dataclasses import replace
from pathlib import Path

from orbitdb.orbits.orbit import Orbit
from orbitdb.store.file.database import asking
from orbitdb.store.reading.lookup import find_word, partners
from orbitdb.store.reading.stadiums import a_stored, meant
from orbitdb.symbols.words import MAX_KEYED


def a_meant(path: Path) -> float:
    """Return the a that is meant where none is named: the only one of a catalogue, else 1.6.

    Raises
    ------
    InputError
        If there are several, and 1.6 is none of them.
    """
    with asking(path) as connection:
        return meant(a_stored(connection))


def find_or_solve(path: Path | None, word: str, a: float) -> Orbit:
    """Return what a catalogue says of a primitive word, or solve it if it is not there.

    Parameters
    ----------
    path : Path or None
        A catalogue; None if there is none.
    word : str
        Symbols 0..5, in any rotation.
    a : float
        The stadium.
    """
    stored = None
    if path is not None:
        with asking(path) as connection:
            stored = find_word(connection, word, a)
    if stored is not None:
        return stored
    from orbitdb.orbits.newton import solve_word

    return solve_word(word, a)


def with_existence(orbit: Orbit) -> Orbit:
    """Return a word with from where to where in a it is an orbit, found on the spot if need be.

    It stays unknown for words that are too long (`orbitdb.orbits.births.lives.LONGEST`).
    """
    if orbit.exists is not None:
        return orbit
    from orbitdb.orbits.births.lives import LONGEST, existence

    return orbit if orbit.p > LONGEST else replace(orbit, exists=tuple(existence(orbit.code)))


def born_with(path: Path | None, orbit: Orbit) -> list[tuple[float, list[str]]]:
    """Return the births of a word, each with the least words that are one path with it there, if stored."""
    if path is None or orbit.p > MAX_KEYED or not orbit.exists:
        return []
    with asking(path) as connection:
        return partners(connection, orbit.representative)
