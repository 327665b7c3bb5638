"""Certification: the rows of a catalogue proved in ball arithmetic, and the proofs stored."""

from collections.abc import Generator, Sequence
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from orbitdb import __version__
from orbitdb.billiard.stadium import Stadium
from orbitdb.catalogue.catalogue import Catalogue
from orbitdb.orbits.newton import certificates
from orbitdb.orbits.orbit import EXISTING, NUMBERS, Orbits, Status
from orbitdb.store.asking.selection import Selection
from orbitdb.store.file.tables import certificate
from orbitdb.store.reading.audit import StoredBlock, choose, ids_in, load_orbits, stadium_id, whole_rows
from orbitdb.store.writing.writer import Writer, replace_certificates
from orbitdb.symbols.words import to_strings
from orbitdb.verification.check import Check, Step, blocks, judged, measured
from orbitdb.verification.invariants import rounding_of_places, with_bounds

if TYPE_CHECKING:
    from orbitdb.orbits.balls.enclosure import Enclosure

Marks = NDArray[np.bool_]
Floats = NDArray[np.float64]

_BATCH = 256
_SHARP = 512
"""Bits for rows whose bounds are those of a ball, and no wider than a ball."""


def certify(
    path: Path, selection: Selection, sample: int | None = None, seed: int = 0, again: bool = False
) -> Generator[Step]:
    """Prove the rows of the chosen classes in ball arithmetic and store the certificates.

    Every batch is stored in one transaction; a certification that was stopped goes on where it was.

    Parameters
    ----------
    path : Path
        A catalogue of the newest schema.
    selection : Selection
    sample, seed : int, optional
        As of `verify`.
    again : bool, optional
        Prove those again that have a certificate.

    Yields
    ------
    Step
        Behind every batch that is safely stored.
    """
    catalogue = Catalogue(path)
    with catalogue.reading() as connection:
        chosen = choose(connection, selection, sample, np.random.default_rng(seed))
        number = stadium_id(connection, selection.a)
        if number is None:
            return
        proofs = ids_in(connection, certificate.c.cycle, certificate.c.stadium == number)
    known = proofs[:0] if again else proofs
    todo = {p: np.setdiff1d(those, known) for p, those in chosen.items()}
    with closing(Writer(path, {"command": "verify --rigorous", "a": selection.a})) as writer:
        for block in blocks(todo, _BATCH):
            with catalogue.reading() as connection:
                stored = load_orbits(connection, number, block.ids)
            check, proved = _prove_block(stored, block.p, Stadium(selection.a))
            with writer.writing() as connection:
                ids = block.ids.tolist()
                replace_certificates(writer, connection, number, ids, proved, __version__)
            check = replace(check, first=check.first and f"{check.first} at a = {selection.a:g}")
            yield Step(f"proofs at a = {selection.a:g}, p = {block.p}", block.done, block.total, (check,))


def _prove_block(stored: StoredBlock, p: int, stadium: Stadium) -> tuple[Check, list[tuple[int, float, int]]]:
    """Prove rows of one period; return also the certificates of those that are proved."""
    rows = whole_rows(stored, p, stored.whole(p))
    rest = set(range(len(stored.words))) - set(rows)
    check = judged("certificates", [stored.words[i] for i in sorted(rest)], [True] * len(rest))
    if not rows:
        return check, []
    found, proved, radius, bits = prove(with_bounds(stored.orbits(rows), stadium), stadium)
    entries = zip(rows, radius.tolist(), bits, proved.tolist(), strict=True)
    return found.joined(check), [(stored.columns["cycle"][i], *rest) for i, *rest, ok in entries if ok]


def prove(stored: Orbits, stadium: Stadium) -> tuple[Check, Marks, Floats, Sequence[int]]:
    """Prove stored rows in ball arithmetic.

    A row is proved if its status is the one of the enclosure and, where there is an orbit, every stored
    coordinate, the length, lambda and the margin lie within the row's own bounds of the true values.

    Parameters
    ----------
    stored : Orbits
        N rows that have what their status demands.
    stadium : Stadium

    Returns
    -------
    check : Check
        Its deviation is that of the coordinates, length or lambda with the largest share.
    proved : ndarray of bool, shape (N,)
    radius : ndarray, shape (N,)
        Proven distance of the stored coordinates from the true ones; 0 where none are stored.
    bits : sequence of int
        Precision of each proof.
    """
    labels = to_strings(stored.words)
    enclosed = certificates(stored.words, stadium)
    distances = np.array([_distances(stored, row, ball, stadium) for row, ball in enumerate(enclosed)])
    doubtful = np.flatnonzero(~(distances[:, 1] <= distances[:, 2]))
    sharper = certificates(stored.words[doubtful], stadium, _SHARP) if len(doubtful) else []
    for row, ball in zip(doubtful.tolist(), sharper, strict=True):
        enclosed[row], distances[row] = ball, _distances(stored, row, ball, stadium)
    radius, deviation, allowed = distances.T
    check = measured("certificates", labels, deviation, allowed)
    return check, deviation <= allowed, radius, [ball.precision for ball in enclosed]


def _distances(stored: Orbits, row: int, ball: "Enclosure", stadium: Stadium) -> tuple[float, float, float]:
    """Return how far stored coordinates may be from a ball's, and the worst number and its bound.

    The number of a wrong status is infinite.
    """
    from orbitdb.orbits.balls.enclosure import distance

    if ball.status.value != stored.status[row] or ball.status is Status.UNRESOLVED:
        return 0.0, np.inf, 1.0
    if ball.status.value not in EXISTING:
        return 0.0, 0.0, 1.0
    numbers = {name: float(getattr(stored, name)[row]) for name in NUMBERS}
    places = zip(ball.coordinates, stored.coordinates[row].tolist(), strict=True)
    radius = max(distance(*place) for place in places)
    pairs = (
        (radius, numbers["error"]),
        (distance(ball.length, numbers["length"]), numbers["length_error"]),
        (distance(ball.lyapunov, numbers["lyapunov"]), numbers["lyapunov_error"]),
        (distance(ball.margin, numbers["margin"]), numbers["error"] + rounding_of_places(stadium)),
    )
    return radius, *max(pairs, key=lambda pair: pair[0] / pair[1] if pair[1] > 0 else np.inf)
