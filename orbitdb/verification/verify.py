"""Verify a catalogue: recompute everything from the words alone, and compare.

All words must be there (`orbitdb.verification.completeness`). A stored orbit must be consistent
(`orbitdb.verification.invariants`) and agree with a new solution (`orbitdb.verification.recomputation`).
"""

from collections.abc import Generator, Iterable, Iterator, Sequence
from collections.abc import Set as AbstractSet
from contextlib import suppress
from dataclasses import asdict, dataclass, replace
from functools import partial
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import sqlalchemy as sa

from orbitdb.billiard.stadium import Stadium
from orbitdb.errors import AlteredError
from orbitdb.extras import data_frame
from orbitdb.filling.workers import at_work
from orbitdb.numerals import exact
from orbitdb.orbits.newton import solve_admissible
from orbitdb.orbits.status import EXISTING, Orbits
from orbitdb.plaintext import several
from orbitdb.progress import Tell
from orbitdb.store.asking.selection import Selection
from orbitdb.store.file.database import need_place, place
from orbitdb.store.reading import audit
from orbitdb.store.reading.audit import StoredBlock, load_orbits, sampled_classes, whole_rows
from orbitdb.store.reading.moment import Moment, reading
from orbitdb.symbols.words import to_strings
from orbitdb.verification.births import change_parts, check_births, prove_lives, whole_births
from orbitdb.verification.check import Block, Check, Checked, Part, blocks, checked_apart, judged, measured
from orbitdb.verification.completeness import class_parts, file_parts
from orbitdb.verification.invariants import check_consistency, with_bounds
from orbitdb.verification.levels_and_bounds import record_parts
from orbitdb.verification.provenance import check_provenance, runs_of_here
from orbitdb.verification.recomputation import certify, check_against, check_bits, restart
from orbitdb.verification.sweeps import check_sweeps

if TYPE_CHECKING:
    import pandas

    from orbitdb.filling.workers import Workers


PROMISES = {
    "file": "SQLite finds the file sound",
    "foreign keys": "every reference points to a row",
    "schema": "tables and views are those of this version",
    "counts": "every period has as many words as the transfer matrix says",
    "classes": "id, size, walls, symmetries and words of every class follow from its representative",
    "elements": "every position in a class has the right symmetry element",
    "rules": "pruned words are least rotations and break exactly the stored rules",
    "fills": "the counts of every filled period agree with its rows",
    "births": "births and deaths alternate, and agree with every fill",
    "changes": "new solutions on both sides of a birth or death confirm it, and the bounce that causes it",
    "lives": "between a = 0.02 and 1000, no birth or death is missing or spurious",
    "undecided": "every class is decided before its cells in ln a become too small",
    "sweeps": "swept counts agree with the transfer matrix, fills, births and new solutions",
    "sums": "swept sums agree with new solutions",
    "entropy": "proved bounds on the entropy agree with new ones and with a recount of their windows",
    "levels": "quantum levels agree with those found on a finer grid, in number and within their errors",
    "trajectories": "averages over trajectories agree with exact means and with a new run",
    "provenance": "runs, methods and certificates agree with one another",
    "reading": "the commands can read every value",
    "values": "every row has the values that its status demands",
    "statuses": "a new solution gives the same status",
    "unresolved": "every status is decided",
    "bounds": "a new solution lies within the error bounds",
    "bits": "a new solution with the same arithmetic gives the same bits",
    "walls": "every bounce is on its own wall",
    "margins": "the margin follows from the bounces",
    "reflection": "every bounce obeys the law of reflection",
    "residuals": "the residual follows from the bounces",
    "lengths": "the length follows from the path",
    "lambda": "lambda follows from the monodromy matrices",
    "signature": "the Hessian has the right signature",
    "Hessian": "the Hessian's determinant gives lambda",
    "radii": "certified radii are within the error bounds",
    "restarts": "other starts converge to the same orbit",
    "certificates": "ball arithmetic proves every row",
}
"""The checks, in the order of the report."""


def report(steps: Iterable[Checked]) -> list[Check]:
    """Join the checks of all steps by name, in the order of `PROMISES`."""
    found: dict[str, Check] = {}
    for step in steps:
        for check in step.checks:
            found[check.name] = found[check.name].joined(check) if check.name in found else check
    return [found[name] for name in PROMISES if name in found]


def verify(
    moment: Moment,
    selections: Sequence[Selection],
    sample: int | None = None,
    restarts: int = 0,
    seed: int = 0,
    missing_births: bool = False,
    workers: "Workers | None" = None,
) -> Generator[Checked]:
    """Recompute a catalogue, compare, and yield the results block by block.

    Parameters
    ----------
    moment : Moment
        The moment at which to check. Workers read each part at a later moment, which is safe because a fill
        never changes the rows of existing classes.
    selections : sequence of Selection
        What to check, one for each a. The file itself is always checked. Counts, births and the words of
        classes are checked in the chosen periods, or in all periods if there are no selections; orbits are
        checked only in classes with chosen words.
    sample : int, optional
        Check the orbits of only this many of the chosen classes at each a, drawn at random.
    restarts : int, optional
        Solve every checked class again from this many random starts.
    seed : int, optional
        Seed for the sample and the restarts.
    missing_births : bool, optional
        Also prove that no birth or death is missing.
    workers : Workers, optional
        Processes that check all parts but births and sweeps; the result does not depend on them.

    Yields
    ------
    Checked
        After every block of rows, so that memory is bounded.
    """
    rng = np.random.default_rng(seed)
    connection = moment.connection
    classes = {s.a: sampled_classes(connection, s, sample, rng) for s in selections}
    parts = chain(
        file_parts(selections),
        [Part("provenance", check_provenance)],
        class_parts(connection, selections),
        (
            block.part(f"orbits at a = {exact(a)}", partial(_orbits, a, restarts, seed))
            for a, ids in classes.items()
            for block in blocks(ids)
        ),
        change_parts(connection, selections, sample, rng),
        record_parts(connection),
    )
    if workers is None:
        yield from (part.checked(connection) for part in parts)
    else:
        yield from workers.solved(partial(checked_apart, moment.path, part) for part in parts)
    yield Part("births", partial(check_births, selections)).checked(connection)
    if missing_births:
        yield from prove_lives(connection, whole_births(connection, selections))
    yield Part("sweeps", lambda _: check_sweeps(moment, selections)).checked(connection)


def _orbits(a: float, restarts: int, seed: int, block: Block, connection: sa.Connection) -> Iterator[Check]:
    number = audit.stadium_id(connection, a)
    if number is None:
        return
    stored, stadium = load_orbits(connection, number, block.ids), Stadium(a)
    whole = stored.whole(block.p)
    checks = [judged("values", stored.words, ~whole)]
    rows = whole_rows(stored, block.p, whole)
    if rows:
        with np.errstate(all="ignore"):  # stored numbers can be anything
            orbits = with_bounds(stored.orbits(rows), stadium)
            checks += _block(orbits, stored, rows, stadium, runs_of_here(connection))
        if restarts:
            rng = np.random.default_rng([seed, block.done - len(block.ids)])
            checks.append(restart(orbits.words, stadium, restarts, rng))
    for check in checks:
        yield replace(check, first=check.first and f"{check.first} at a = {exact(a)}")


def _block(
    stored: Orbits,
    block: StoredBlock,
    rows: Sequence[int],
    stadium: Stadium,
    ours: AbstractSet[int],
) -> Iterator[Check]:
    """Check the rows of a block that have sound words and all values."""
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


_STARTS_A_SECOND = 800_000
"""Number of words solved per second from a random start; all other checks take as long as four starts."""


@dataclass(frozen=True)
class Verification:
    """The result of a verification.

    Attributes
    ----------
    checks : tuple of Check
        The result for each of `PROMISES` that was checked.

    Examples
    --------
    >>> catalogue.verify(p="2-5")
    <sound: 22 checks>
    """

    checks: tuple[Check, ...]

    @property
    def sound(self) -> bool:
        """Whether every check passed."""
        return not self.failed

    @property
    def failed(self) -> tuple[Check, ...]:
        """The checks that have failed."""
        return tuple(check for check in self.checks if check.failures)

    def __repr__(self) -> str:
        if self.sound:
            return f"<sound: {several(len(self.checks), 'check')}>"
        told = "; ".join(f"{check.name}: {check.first}" for check in self.failed)
        return f"<{len(self.failed)} of {several(len(self.checks), 'check')} failed: {told}>"

    def to_pandas(self) -> "pandas.DataFrame":
        """Return a data frame, one row per check."""
        return data_frame(map(asdict, self.checks)).rename(columns={"name": "check"})


_TOLD = "checked it: give the same command again to check the file you mean"


def verification_steps(
    path: Path,
    selections: Sequence[Selection],
    sample: int | None = None,
    restarts: int = 0,
    seed: int = 0,
    births: bool = False,
    rigorous: bool = False,
    again: bool = False,
    jobs: int | None = None,
) -> Generator[Checked]:
    """Verify a catalogue, in several processes if it is large; if `rigorous`, also prove its rows.

    The other parameters are those of `verify` and `orbitdb.verification.recomputation.certify`.
    """
    was = place(path)
    with reading(path) as moment:
        known = 0
        with suppress(AlteredError):  # the verification itself reports it
            fills = ((each, fill) for each in selections for fill in moment.fills(each.a))
            known = sum(fill.words for each, fill in fills if each.includes(fill.p))
        checked = known if sample is None else min(sample, known)
        with at_work((4 + restarts) * checked / _STARTS_A_SECOND, jobs) as workers:
            here = workers if workers.jobs > 1 else None
            yield from verify(moment, selections, sample, restarts, seed, births, here)
    for selection in selections if rigorous else ():
        need_place(path, was, _TOLD)
        yield from certify(path, selection, sample, seed, again)
    need_place(path, was, _TOLD)


def told(steps: Iterable[Checked], tell: Tell) -> Iterator[Checked]:
    """Yield the given steps, and report their progress."""
    for step in steps:
        tell(step.done, step.total if step.total > 1 else 0, step.stage)
        yield step
