"""Verify a catalogue: recompute everything from the words alone, and compare.

All words must be there (`check_classes`). A stored orbit must be consistent and agree with a new solution
(`check_orbits`), and so must births, sweeps and levels (`check_births`, `check_sweeps`, `check_levels`).
"""

from collections import Counter
from collections.abc import Generator, Iterable, Iterator, Sequence
from contextlib import closing
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from orbitdb.billiard.stadium import Stadium
from orbitdb.display import data_frame
from orbitdb.filling.workers import HERE, Workers, at_work
from orbitdb.orbits.status import EXISTING
from orbitdb.progress import Tell, nobody
from orbitdb.selection import Selection
from orbitdb.store.file import reading
from orbitdb.store.paths import check_same_file, file_id
from orbitdb.store.sqlite import Connection, path_of
from orbitdb.text import format_float, several
from orbitdb.verification.check_births import births, check_births, lives
from orbitdb.verification.check_classes import classes, counts, integrity, references
from orbitdb.verification.check_escapes import escapes
from orbitdb.verification.check_levels import levels
from orbitdb.verification.check_orbits import certify, check_against, check_consistency, restart, with_bounds
from orbitdb.verification.check_sweeps import SWEPT_ANEW, check_sweeps
from orbitdb.verification.check_values import values
from orbitdb.verification.checks import (
    Block,
    Check,
    Checked,
    Part,
    Scope,
    blocks,
    checked_apart,
    parts_of,
    stored_orbits,
)

if TYPE_CHECKING:
    import pandas


PROMISES = {
    "file": "SQLite finds the file sound, every reference points to a row, and every value can be read",
    "values": "every value is possible by itself and within its row",
    "counts": "a period has as many words as the transfer matrix says, and a fill the counts of its rows",
    "classes": "all columns of a class follow from its representative, and broken rules from the pruned word",
    "statuses": "a new solution gives the same status",
    "bounds": "a new solution lies within the error bounds",
    "walls": "every bounce is on its own wall, as far from the ends as the margin says",
    "reflection": "every bounce obeys the law of reflection",
    "lengths": "the length and the enclosed area follow from the path",
    "lambda": "lambda follows from the monodromy matrices",
    "Hessian": "the Hessian has the right signature, and its determinant gives lambda",
    "births": "births and deaths alternate, agree with every fill, and are confirmed by new solutions",
    "lives": "between a = 0.02 and 1000, no birth or death is missing or spurious",
    "undecided": "every class is decided before its cells in ln a become too small",
    "sweeps": "swept counts agree with the transfer matrix, fills, births and new solutions",
    "sums": "swept sums agree with new solutions",
    "escapes": "survival in open stadiums agrees with new trajectories, and rates with a coarser matrix",
    "levels": "quantum levels agree with those found on a finer grid, in number and within their errors",
    "restarts": "other starts converge to the same orbit",
    "certificates": "ball arithmetic proves every row",
}
"""The checks, in the order of the report."""


def verify(
    connection: Connection,
    selections: Sequence[Selection],
    sample: int | None = None,
    restarts: int = 0,
    seed: int = 0,
    missing_births: bool = False,
    jobs: int | None = 1,
    workers: Workers | None = None,
) -> Generator[Checked]:
    """Recompute a catalogue, compare, and yield the results block by block.

    Parameters
    ----------
    connection : Connection
        The snapshot to check. Workers read each part in a later one, which is safe because a fill never
        changes the rows of existing classes.
    selections : sequence of Selection
        What to check, one for each a. The file itself is always checked. Counts, births and the words of
        classes are checked in the chosen periods, or in all periods if there are no selections; orbits are
        checked only in classes with chosen words, and levels only if all words are chosen.
    sample : int, optional
        Check the orbits of only this many of the chosen classes at each a, drawn at random.
    restarts : int, optional
        Solve every checked class again from this many random starts.
    seed : int, optional
        Seed for the sample and the restarts.
    missing_births : bool, optional
        Also prove that no birth or death is missing.
    jobs, workers : optional
        Processes that check, as in `at_work`; the result does not depend on them.

    Yields
    ------
    Checked
        After every block of rows, so that memory is bounded.
    """
    asked = tuple(selections), sample, restarts, seed
    scope = Scope(connection, *asked)
    checks = (*CHECKS, lives) if missing_births else CHECKS
    parts = (part for check in checks for part in parts_of(check, scope))
    with at_work(_seconds(scope), jobs, workers) as at_hand:
        if at_hand is HERE:
            yield from (part.checked(scope) for part in parts)
        else:
            yield from at_hand.solved(
                partial(checked_apart, path_of(connection), part, *asked) for part in parts
            )


def _seconds(scope: Scope) -> float:
    """Estimate how long it takes to check the orbits."""
    stored = scope.scalar("SELECT count(*) FROM orbit")
    each = stored if scope.sample is None else min(stored, scope.sample * len(scope.selections))
    return float((4 + scope.restarts) * each / _CLASSES_A_SECOND)


def orbits(scope: Scope) -> Iterator[Part]:
    """Check the rows of the chosen classes, or of a random sample of them, at every a."""
    rng = np.random.default_rng(scope.seed)
    for selection in scope.selections:
        for block in blocks(scope.classes(selection, rng)):
            yield block.part(f"orbits at a = {format_float(selection.a)}", partial(_orbits, selection.a))


def _orbits(a: float, block: Block, scope: Scope) -> Iterator[Check]:
    """Check the rows of a block at a given a."""
    ids, stored = stored_orbits(scope, a, block)
    block.check_complete(ids)
    stadium = Stadium(a)
    with np.errstate(all="ignore"):  # stored numbers can be anything
        stored = with_bounds(stored, stadium)
        checks = list(check_against(stored, stadium))
        existing = np.flatnonzero(np.isin(stored.status, EXISTING) & np.isfinite(stored.error))
        checks += check_consistency(stored.rows(existing), stadium)
    if scope.restarts:
        rng = np.random.default_rng([scope.seed, block.done - len(block.ids)])
        checks.append(restart(stored.words, stadium, scope.restarts, rng))
    yield from (check.at(f"at a = {format_float(a)}") for check in checks)


CHECKS = (
    Part("file", integrity), Part("references", references), Part("values", values), Part("counts", counts),
    classes, orbits, Part("births", check_births), births, escapes, levels, Part("sweeps", check_sweeps),
)  # fmt: skip
"""What is checked, in order: parts of the catalogue, and functions that yield the parts that they check."""


def verifiable(connection: Connection) -> list[float]:
    """Return the values of a, in order, at which anything is stored that can be verified."""
    return [
        a
        for (a,) in connection.exec_driver_sql(
            "SELECT a FROM stadium UNION SELECT a FROM level_fill UNION SELECT a FROM open_stadium ORDER BY a"
        )
        if isinstance(a, float)  # the check of all values finds those that are damaged
    ]


_CLASSES_A_SECOND = 100_000
"""Number of classes solved per second from a random start; all other checks take as long as four starts."""


@dataclass(frozen=True)
class Verification:
    """The result of a verification.

    Attributes
    ----------
    checks : tuple of Check
        The result for each of `PROMISES` that was checked.
    notes : tuple of str
        What is missing, or could not be decided, one line each.

    Examples
    --------
    >>> catalogue.verify(p="2-5")
    <sound: 11 checks>
    """

    checks: tuple[Check, ...]
    notes: tuple[str, ...] = ()

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
        first = "; ".join(f"{check.name}: {check.first}" for check in self.failed)
        return f"<{len(self.failed)} of {several(len(self.checks), 'check')} failed: {first}>"

    def to_pandas(self) -> "pandas.DataFrame":
        """Return a data frame, one row per check."""
        return data_frame(map(asdict, self.checks)).rename(columns={"name": "check"})


def report(steps: Iterable[Checked], tell: Tell = nobody) -> list[Check]:
    """Join the checks of all steps by name, in the order of `PROMISES`, and report the progress."""
    joined: dict[str, Check] = {}
    for step in steps:
        tell(step.done, step.total if step.total > 1 else 0, step.stage)
        for check in step.checks:
            joined[check.name] = joined[check.name].joined(check) if check.name in joined else check
    return [joined[name] for name in PROMISES if name in joined]


def verified(
    path: Path,
    selections: Sequence[Selection],
    sample: int | None = None,
    restarts: int = 0,
    seed: int = 0,
    births: bool = False,
    prove: bool = False,
    jobs: int | None = None,
    tell: Tell = nobody,
) -> Verification:
    """Verify a catalogue, in several processes if it is large; if `prove`, also prove its rows.

    The other parameters are those of `verify` and `orbitdb.verification.check_orbits.certify`.
    """

    def steps() -> Generator[Checked]:
        opened = file_id(path)
        with reading(path) as connection:
            yield from verify(connection, selections, sample, restarts, seed, births, jobs)
        for selection in selections if prove else ():
            check_same_file(path, opened, _REPLACED)
            yield from certify(path, selection, sample, seed)
        check_same_file(path, opened, _REPLACED)

    with closing(steps()) as going:  # ends its processes if it is interrupted
        checks = tuple(report(going, tell))
    return Verification(checks, tuple(_limits(checks, restarts)))


def _limits(checks: Sequence[Check], restarts: int) -> Iterator[str]:
    """Yield what the checks could not decide, one line each."""
    rows = Counter({check.name: check.rows for check in checks})
    if (unsettled := restarts * rows["statuses"] - rows["restarts"]) > 0:
        yield f"{unsettled} restarts did not converge and prove nothing"
    if lives := rows["lives"] + rows["undecided"]:
        proved = sum(check.rows - check.failures for check in checks if check.name == "lives")
        yield f"{proved} of {lives} classes have all births and deaths between a = 0.02 and 1000"
    if anew := rows["sweeps"] - rows["sums"]:
        what = "the sums of a swept period were" if anew == 1 else f"the sums of {anew} swept periods were"
        yield f"{what} not recomputed: only sums of whole periods up to {SWEPT_ANEW} are"


_REPLACED = "checked it: run the command again to check the file that is there now"
