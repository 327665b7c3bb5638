"""One word of any order: asked for, or solved and stored."""

from contextlib import closing
from dataclasses import replace
from pathlib import Path

from orbitdb.billiard.stadium import Stadium
from orbitdb.filling.blocks import METHODS
from orbitdb.orbits.lives import LONGEST, existence
from orbitdb.orbits.newton import solve_word
from orbitdb.orbits.orbit import Orbit, Status
from orbitdb.orbits.pruned import pruned_word
from orbitdb.store.reading.catalogue import Catalogue
from orbitdb.store.reading.lives import partners
from orbitdb.store.writing import insertion
from orbitdb.store.writing.writer import Writer
from orbitdb.symbols import symmetry
from orbitdb.symbols.words import MAX_KEYED, from_strings


def fill_word(path: Path, word: str, a: float, method: str = "newton") -> Orbit:
    """Store one primitive word of any order, its symmetry class, and what becomes of it at one a.

    Parameters
    ----------
    path : Path
        A catalogue of the newest schema.
    word : str
        Symbols 0..5, in any rotation.
    a : float
        The stadium.
    method : str, optional
        One of `METHODS`.

    Returns
    -------
    Orbit
        The word in the rotation asked for; the family 02 is not stored.
    """
    writer = Writer(path, {"command": "fill", "a": a, "code": word, "method": method})
    try:
        if (pruned := pruned_word(word, a)) is not None:
            return _keep_pruned(writer, pruned)
        family = symmetry.class_of(word)
        orbits = METHODS[method].solve(from_strings([family.representative]), Stadium(a))
        with writer.writing() as connection:
            stadium = writer.stadium_id(connection, a)
            number = insertion.add_class(connection, family)
            insertion.add_orbits(writer, connection, stadium, [number], orbits, method)
    finally:
        writer.close()
    return find_or_solve(path, word, a)


def _keep_pruned(writer: Writer, word: Orbit) -> Orbit:
    """Store a geometrically pruned word with the rules it breaks; the family is not stored."""
    if word.status is Status.FAMILY:
        return word
    rules = ",".join(map(str, word.rules))
    with writer.writing() as connection:
        insertion.add_pruned(connection, word.p, [word.representative], [rules])
    return replace(word, stored=True)


def with_existence(orbit: Orbit) -> Orbit:
    """Return a word with from where to where in a it is an orbit, found on the spot if need be.

    It stays unknown for words that are too long (`orbitdb.orbits.lives.LONGEST`).
    """
    if orbit.exists is not None or orbit.p > LONGEST:
        return orbit
    return replace(orbit, exists=tuple(existence(orbit.code)))


def born_with(path: Path | None, orbit: Orbit) -> list[tuple[float, list[str]]]:
    """Return the births of a word, each with the least words that are one path with it there, if stored."""
    if path is None or orbit.p > MAX_KEYED or not orbit.exists:
        return []
    with closing(Catalogue(path)) as catalogue, catalogue.reading() as connection:
        return partners(connection, orbit.representative)


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
        with closing(Catalogue(path)) as catalogue:
            stored = catalogue.find(word, a)
    return solve_word(word, Stadium(a)) if stored is None else stored
