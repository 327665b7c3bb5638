"""Verifying a catalogue: everything is computed again from the words alone and compared.

The words must be all there (`orbitdb.verification.completeness`); what is stored of an orbit must agree
with itself (`orbitdb.verification.invariants`) and with new solutions
(`orbitdb.verification.recomputation`).
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, replace
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from orbitdb.billiard.stadium import Stadium
from orbitdb.catalogue.catalogue import Catalogue
from orbitdb.orbits.newton import solve_admissible
from orbitdb.orbits.orbit import EXISTING, Orbits
from orbitdb.store.asking.selection import Selection
from orbitdb.store.reading import audit
from orbitdb.store.reading.audit import Ids, StoredBlock, blocks, choose, load_orbits, whole_rows
from orbitdb.symbols.words import to_strings
from orbitdb.verification.births import check_births, whole_births
from orbitdb.verification.blocks import ClassBlock, Part, Workers, steps_of
from orbitdb.verification.changes import change_blocks
from orbitdb.verification.check import Check, Step, judged, measured
from orbitdb.verification.classes import class_blocks
from orbitdb.verification.completeness import OF_FILE, CountsPart, FilePart
from orbitdb.verification.enclosures import enclosure_parts
from orbitdb.verification.invariants import check_consistency, with_bounds
from orbitdb.verification.levels import level_parts
from orbitdb.verification.lives import prove_lives
from orbitdb.verification.provenance import ProvenancePart, runs_of_here
from orbitdb.verification.recomputation import check_against, check_bits, restart
from orbitdb.verification.sweeps import check_sweeps
from orbitdb.verification.trajectories import trajectory_parts

if TYPE_CHECKING:
    import sqlalchemy as sa

PROMISES = {
    "file": "SQLite finds the file sound",
    "foreign keys": "no reference leads nowhere",
    "schema": "tables and view are those of this version",
    "counts": "the sequences of every period are as many as the transfer matrix says",
    "classes": "every class has the id, the size, the walls, the symmetries and the words of its least word",
    "elements": "every place in a class has the symmetry element that leads to it",
    "rules": "pruned words are least rotations and break just the rules that are stored",
    "fills": "the counts of every filled period are those of its rows",
    "births": "births and deaths take turns, and agree with every fill",
    "changes": "either side of a birth or death is decided again, and so is the bounce that makes it",
    "lives": "between a = 0.02 and 1000 no birth or death is missing, and none too many",
    "undecided": "cells in ln a are small enough to tell that",
    "sweeps": "swept counts are those of the transfer matrix, of fills, of births, and of new solutions",
    "sums": "swept sums are those of new solutions",
    "entropy": "proved bounds on the entropy agree with new ones, and their windows are counted again",
    "levels": "quantum levels are those of a finer grid, within their errors, and none is missing",
    "trajectories": "averages over trajectories agree with exact means and with a new run",
    "provenance": "runs, methods and certificates say of one another what they must",
    "values": "every row has what its status demands",
    "statuses": "a new solution gives the same status",
    "unresolved": "every status is decided",
    "bounds": "a new solution lies within the error bounds",
    "bits": "a new solution on the same machine gives the same bits",
    "walls": "every bounce is on its own wall",
    "margins": "the margin is that of the bounces",
    "reflection": "every bounce obeys the law of reflection",
    "residuals": "the residual is that of the bounces",
    "lengths": "the length is that of the path",
    "lambda": "lambda is that of the monodromy matrices",
    "signature": "the Hessian has the right signature",
    "Hessian": "the Hessian's determinant gives lambda",
    "radii": "certified radii are within the error bounds",
    "restarts": "other starts lead to the same orbit",
    "certificates": "ball arithmetic proves the row",
}
"""What is checked, in the order of the report."""


def report(steps: Iterable[Step]) -> list[Check]:
    """Join what the steps have found, one check a promise, in order."""
    found: dict[str, Check] = {}
    for step in steps:
        for check in step.checks:
            found[check.name] = found[check.name].joined(check) if check.name in found else check
    return [found[name] for name in PROMISES if name in found]


def verify(
    catalogue: Catalogue,
    selections: Sequence[Selection],
    sample: int | None = None,
    restarts: int = 0,
    seed: int = 0,
    missing_births: bool = False,
    workers: Workers | None = None,
) -> Iterator[Step]:
    """Compute a catalogue again and compare.

    Parameters
    ----------
    catalogue : Catalogue
        All is read from it as it is at one moment; by workers, each part as it is at a moment of its own:
        a fill does not change the rows of classes that are there.
    selections : sequence of Selection
        What to check, one for each a. The file is checked as a whole; counts, births, and the words of
        classes and pruned ones are checked of the chosen periods, of all if there is no a; orbits only of
        the chosen classes: a class is chosen if one of its words is.
    sample : int, optional
        Check the orbits of only so many of the chosen classes of every a, drawn at random.
    restarts : int, optional
        Solve every class again from so many random starts.
    seed : int, optional
        Of sample and restarts.
    missing_births : bool, optional
        Prove that no birth or death is missing, too.
    workers : Workers, optional
        Processes that check file, counts and classes; what is found does not depend on them.

    Yields
    ------
    Step
        Behind every block of rows, so that memory is bounded.

    Raises
    ------
    StoreError
        If the database cannot be read.
    """
    rng = np.random.default_rng(seed)
    with catalogue.at_one_moment() as still, still.reading() as connection:
        classes = {s.a: choose(connection, s, sample, rng) for s in selections}
        parts = chain(
            _parts(still, connection, selections, classes, (restarts, seed)),
            change_blocks(connection, still.path, selections, sample, rng),
            trajectory_parts(connection, still.path),
            enclosure_parts(connection, still.path),
            level_parts(connection, still.path),
        )
        yield from steps_of(parts, connection, workers)
        born = whole_births(connection, selections)
        yield Step("births", 0, 1, tuple(check_births(connection, born)))
        if missing_births:
            yield from prove_lives(connection, born)
        yield Step("sweeps", 0, 1, tuple(check_sweeps(still, selections)))


def _parts(
    catalogue: Catalogue,
    connection: "sa.Connection",
    selections: Sequence[Selection],
    chosen: Mapping[float, Ids],
    starts: tuple[int, int],
) -> Iterator[Part]:
    """Yield what can be checked apart, what takes long and cannot be cut first."""
    path = catalogue.path
    yield from (FilePart(path, name) for name in OF_FILE)
    yield CountsPart(path, tuple(selections))
    yield ProvenancePart(path)
    yield from class_blocks(connection, path, selections)
    for a, ids in chosen.items():
        yield from _orbit_blocks(path, a, ids, *starts)


def _orbit_blocks(path: Path, a: float, ids: Ids, restarts: int, seed: int) -> Iterator["OrbitBlock"]:
    """Yield blocks of the classes that are chosen at one a."""
    total = sum(map(len, ids.values()))
    for p, block, before in blocks(ids):
        yield OrbitBlock(path, p, block, before, total, a, restarts, seed)


@dataclass(frozen=True, eq=False)
class OrbitBlock(ClassBlock):
    """Classes of which the orbits at one a are to be checked.

    Attributes
    ----------
    a : float
    restarts, seed : int
        As in `verify`.
    """

    a: float
    restarts: int
    seed: int

    def checked(self, connection: "sa.Connection") -> Step:
        """Return what is found in the rows that a connection reads."""
        stage = f"orbits, p = {self.p} at a = {self.a:g}"
        number = audit.stadium_id(connection, self.a)
        if number is None:
            return Step(stage, self.done, self.total, ())
        stored, stadium = load_orbits(connection, number, self.ids), Stadium(self.a)
        whole = stored.whole(self.p)
        checks = [judged("values", stored.words, ~whole)]
        rows = whole_rows(stored, self.p, whole)
        if rows:
            with np.errstate(all="ignore"):  # what is stored may be any number
                orbits = with_bounds(stored.orbits(rows), stadium)
                checks += _block(orbits, stored, rows, stadium, runs_of_here(connection))
            if self.restarts:
                rng = np.random.default_rng([self.seed, self.before])
                checks.append(restart(orbits.words, stadium, self.restarts, rng))
        at = f"at a = {self.a:g}"
        named = (replace(check, first=check.first and f"{check.first} {at}") for check in checks)
        return Step(stage, self.done, self.total, tuple(named))


def _block(
    stored: Orbits,
    block: StoredBlock,
    rows: Sequence[int],
    stadium: Stadium,
    ours: AbstractSet[int],
) -> Iterator[Check]:
    """Check some rows of a block, of sound words and whole."""
    fresh = solve_admissible(stored.words, stadium)
    yield from check_against(stored, fresh)
    made = zip(block.some("solver", rows), block.some("run", rows), strict=True)
    same = np.array([solver != "relaxation" and run in ours for solver, run in made])
    comparable = np.flatnonzero(same)
    yield check_bits(stored.rows(comparable), fresh.rows(comparable))
    existing = np.flatnonzero(np.isin(stored.status, EXISTING) & np.isfinite(stored.error))
    yield from check_consistency(stored.rows(existing), stadium)
    radii = block.some("radius", rows)
    proofs = [i for i, radius in enumerate(radii) if radius is not None]
    labels = to_strings(stored.words[proofs])
    radius = np.array([radii[i] for i in proofs])
    allowed = np.where(np.isfinite(stored.error[proofs]), stored.error[proofs], 0.0)
    yield measured("radii", labels, radius, allowed)
