"""One word of a catalogue, by its code."""

from dataclasses import replace

import numpy as np
import sqlalchemy as sa

from orbitdb.orbits.orbit import NUMBERS, Orbit, Status
from orbitdb.orbits.pruned import pruned_word
from orbitdb.store.file.schema import cycle, orbit, sequence, stadium
from orbitdb.store.reading.lives import lives_of
from orbitdb.store.reading.soundness import is_whole, unsound
from orbitdb.symbols import symmetry


def find_word(connection: sa.Connection, word: str, a: float) -> Orbit | None:
    """Return what is stored of a primitive word at one a, in the rotation asked for (`Catalogue.find`)."""
    if (pruned := pruned_word(word, a)) is not None:
        return _find_pruned(connection, pruned)
    family = symmetry.class_of(word)
    query = (
        sa.select(cycle, orbit)
        .join(orbit, orbit.c.cycle == cycle.c.id)
        .join(stadium, stadium.c.id == orbit.c.stadium)
        .where(cycle.c.p == len(word), cycle.c.word == family.representative, stadium.c.a == a)
    )
    row = connection.execute(query).mappings().first()
    if row is None:
        return None
    if not is_whole({str(name): row[name] for name in row}, len(word)):
        raise unsound("a row without what its status demands, of", family.representative)
    coordinates = None
    if row["coordinates"] is not None:
        places = np.frombuffer(row["coordinates"], dtype="<f8")[None, :]
        least = [family.representative]
        coordinates = symmetry.image_coordinates([word], least, family.element, places)[0]
    return Orbit(
        code=word,
        representative=family.representative,
        a=a,
        status=Status(row["status"]),
        time_reversal=row["time_reversal"],
        symmetry=row["symmetry"],
        class_size=row["class_size"],
        coordinates=coordinates,
        solver=row["solver"],
        stored=True,
        exists=lives_of(connection, family.representative),
        **{name: row[name] for name in NUMBERS},
    )


def _find_pruned(connection: sa.Connection, pruned: Orbit) -> Orbit | None:
    key = (sequence.c.p == pruned.p, sequence.c.word == pruned.representative)
    known = connection.scalar(sa.select(sequence.c.p).where(*key))
    return None if known is None else replace(pruned, stored=True)
