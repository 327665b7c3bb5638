"""One word of any order, solved and stored."""

from contextlib import closing
from dataclasses import replace
from pathlib import Path

from orbitdb.billiard.stadium import Stadium
from orbitdb.filling.blocks import METHODS
from orbitdb.orbits.orbit import Orbit, Status, pruned_word
from orbitdb.store.reading.lookup import find_or_solve
from orbitdb.store.writing import classes
from orbitdb.store.writing.writer import Writer
from orbitdb.symbols import symmetry
from orbitdb.symbols.words import from_strings


def fill_word(path: Path, word: str, a: float, method: str = "newton") -> Orbit:
    """Store one primitive word of any order, its symmetry class, and what becomes of it at one a.

    Return the word in the rotation asked for; the family 02 is not stored.
    """
    parameters = {"command": "fill", "a": a, "code": word, "method": method}
    with closing(Writer(path, parameters)) as writer:
        if (pruned := pruned_word(word, a)) is not None:
            if pruned.status is Status.FAMILY:
                return pruned
            rules = ",".join(map(str, pruned.rules))
            with writer.writing() as connection:
                classes.add_pruned(connection, pruned.p, [pruned.representative], [rules])
            return replace(pruned, stored=True)
        family = symmetry.class_of(word)
        orbits = METHODS[method].solve(from_strings([family.representative]), Stadium(a))
        with writer.writing() as connection:
            stadium = writer.stadium_id(connection, a)
            number = classes.add_class(connection, family)
            classes.add_orbits(writer, connection, stadium, [number], orbits, method)
    return find_or_solve(path, word, a)
