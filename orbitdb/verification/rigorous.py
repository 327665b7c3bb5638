"""Certification: the rows of a catalogue proved in ball arithmetic, and the proofs stored."""

from collections.abc import Generator
from dataclasses import replace
from pathlib import Path

import numpy as np

from orbitdb import __version__
from orbitdb.billiard.stadium import Stadium
from orbitdb.catalogue.catalogue import Catalogue
from orbitdb.store.asking.selection import Selection
from orbitdb.store.file.tables import certificate
from orbitdb.store.reading.audit import StoredBlock, choose, ids_in, load_orbits, stadium_id, whole_rows
from orbitdb.store.writing.records import replace_certificates
from orbitdb.store.writing.writer import Writer
from orbitdb.verification.blocks import blocks
from orbitdb.verification.check import Check, Step, judged
from orbitdb.verification.invariants import with_bounds
from orbitdb.verification.recomputation import prove

_BATCH = 256


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
    writer = Writer(path, {"command": "verify --rigorous", "a": selection.a})
    try:
        for block in blocks(todo, _BATCH):
            with catalogue.reading() as connection:
                stored = load_orbits(connection, number, block.ids)
            check, certificates = _prove_block(stored, block.p, Stadium(selection.a))
            with writer.writing() as connection:
                ids = block.ids.tolist()
                replace_certificates(writer, connection, number, ids, certificates, __version__)
            check = replace(check, first=check.first and f"{check.first} at a = {selection.a:g}")
            yield Step(f"proofs at a = {selection.a:g}, p = {block.p}", block.done, block.total, (check,))
    finally:
        writer.close()


def _prove_block(stored: StoredBlock, p: int, stadium: Stadium) -> tuple[Check, list[tuple[int, float, int]]]:
    """Prove rows of one period; return also the certificates of those that are proved."""
    rows = whole_rows(stored, p, stored.whole(p))
    rest = set(range(len(stored.words))) - set(rows)
    check = judged("certificates", [stored.words[i] for i in sorted(rest)], [True] * len(rest))
    if not rows:
        return check, []
    found, proved, radius, bits = prove(with_bounds(stored.orbits(rows), stadium), stadium)
    entries = zip(rows, radius.tolist(), bits, proved.tolist(), strict=True)
    certificates = [(stored.columns["cycle"][i], size, used) for i, size, used, ok in entries if ok]
    return found.joined(check), certificates
