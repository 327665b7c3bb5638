"""The verification of a whole file: its steps one after another, and what they come to."""

from collections.abc import Generator, Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from orbitdb.errors import AlteredError
from orbitdb.extras import data_frame
from orbitdb.filling.workers import at_work
from orbitdb.plaintext import several
from orbitdb.progress import Tell
from orbitdb.store.asking.selection import Selection
from orbitdb.store.reading.moment import reading
from orbitdb.verification.check import Check, Step
from orbitdb.verification.recomputation import certify
from orbitdb.verification.verify import verify

if TYPE_CHECKING:
    import pandas

_STARTS_A_SECOND = 800_000
"""Random starts from which words are solved; a check of all else takes as long as four."""


@dataclass(frozen=True)
class Verification:
    """What a verification has found.

    Attributes
    ----------
    checks : tuple of Check
        One for each promise that was looked at.

    Examples
    --------
    >>> catalogue.verify(p="2-5")
    <sound: 22 checks>
    """

    checks: tuple[Check, ...]

    @property
    def sound(self) -> bool:
        """Whether no check has failed."""
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
        """Return a data frame, one row a check."""
        return data_frame(map(asdict, self.checks)).rename(columns={"name": "check"})


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
) -> Generator[Step]:
    """Compute a catalogue again and compare, in processes if it is worth it; then prove its rows if asked to.

    The parameters are those of `orbitdb.verification.verify.verify` and
    `orbitdb.verification.recomputation.certify`.
    """
    with reading(path) as moment:
        known = 0
        with suppress(AlteredError):  # it is among what is checked
            fills = ((each, fill) for each in selections for fill in moment.fills(each.a))
            known = sum(fill.words for each, fill in fills if each.includes(fill.p))
        checked = known if sample is None else min(sample, known)
        with at_work((4 + restarts) * checked / _STARTS_A_SECOND, jobs) as workers:
            here = workers if workers.jobs > 1 else None
            yield from verify(moment, selections, sample, restarts, seed, births, here)
    for selection in selections if rigorous else ():
        yield from certify(path, selection, sample, seed, again)


def told(steps: Iterable[Step], tell: Tell) -> Iterator[Step]:
    """Pass steps on, and tell how far they are."""
    for step in steps:
        tell(step.done, step.total if step.total > 1 else 0, step.stage)
        yield step
