"""Whether Newton's method in doubles, ball arithmetic and the paper's dynamics agree on every status.

Ball arithmetic proves its statuses, so it is the judge. The relaxation stops at a small force and
compares coordinates with the ends of walls and semicircles: it may be wrong where an orbit comes
nearer to a joint than the force leaves its coordinates uncertain, and must be where it runs through
one, for it has no word for that.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orbitdb.benchmarks.representatives import representatives
from orbitdb.billiard.stadium import Stadium
from orbitdb.orbits.newton import certificates, solve_in_doubles
from orbitdb.orbits.orbit import Orbits, Status
from orbitdb.orbits.relaxation import EPSILON, relax, slowest_rates
from orbitdb.symbols.words import to_strings

MAX_STEPS = 20_000_000
"""Steps after which the relaxation gives a word up; they grow like a^3, and a = 10 takes 3 million."""


@dataclass(frozen=True)
class Disagreement:
    """A word that doubles or the relaxation give another status than ball arithmetic proves.

    Attributes
    ----------
    a : float
    word : str
        The least word of its class.
    doubles, relaxed, proved : str
        The three statuses.
    margin : float
        Proved distance from the nearest joint, in coordinate units.
    error : float
        How far from the orbit the relaxation may have stopped: its force over its slowest rate.
    """

    a: float
    word: str
    doubles: str
    relaxed: str
    proved: str
    margin: float
    error: float

    @property
    def explained(self) -> bool:
        """Whether only the relaxation is wrong, and no better than it can."""
        near = self.proved == Status.BOUNDARY or abs(self.margin) < self.error
        return near and self.doubles in (self.proved, Status.UNRESOLVED)

    def sentence(self) -> str:
        """Return it in words."""
        why = (
            "it runs through a joint"
            if self.proved == Status.BOUNDARY
            else f"margin {self.margin:.1e}, and the force leaves an error of {self.error:.1e}"
        )
        said = f"{self.word} at a = {self.a:g}: {self.proved} by proof, {self.relaxed} by the relaxation"
        doubles = "" if self.doubles in (self.proved, Status.UNRESOLVED) else f", {self.doubles} in doubles"
        return f"{said}{doubles}; {why}{'' if self.explained else ': NOT EXPLAINED'}"


@dataclass(frozen=True)
class Agreement:
    """How three methods agree on the classes of one period.

    Attributes
    ----------
    a : float
    p : int
    classes, orbits, boundary : int
        Admissible classes, and those of them that are proved to be orbits or to run through a joint.
    doubles : int
        Classes that Newton's method in doubles gives the proved status; it leaves the others open.
    relaxation : int
        Classes that the relaxation gives the proved status.
    disagreements, unexplained : int
        Classes that one of the two gives another status, and those of them that are not `explained`.
    unresolved : int
        Classes that the relaxation has not brought to rest.
    steps : int
        Most Runge-Kutta steps that it took for a class.
    """

    a: float
    p: int
    classes: int
    orbits: int
    boundary: int
    doubles: int
    relaxation: int
    disagreements: int
    unexplained: int
    unresolved: int
    steps: int


def agreement(
    p: int, stadium: Stadium, progress: Callable[[int, int], None] | None = None
) -> tuple[Agreement, list[Disagreement]]:
    """Relax all classes of one period and `compare`; `relax` reports the progress."""
    words, _ = representatives(p)
    return compare(relax(words, stadium, max_steps=MAX_STEPS, progress=progress), stadium)


def compare(
    relaxed: Orbits, stadium: Stadium, epsilon: float = EPSILON
) -> tuple[Agreement, list[Disagreement]]:
    """Compare relaxed words of one period with Newton's method in doubles and with ball arithmetic.

    Parameters
    ----------
    relaxed : Orbits
        What `relax` has made of admissible words; of it, words, status, coordinates and steps count.
    stadium : Stadium
    epsilon : float, optional
        The force at which the relaxation has stopped.

    Returns
    -------
    Agreement
    list of Disagreement
        In the order of the words.
    """
    words = relaxed.words
    found = certificates(words, stadium)
    proved = np.array([each.status.value for each in found])
    doubles = solve_in_doubles(words, stadium).status
    settled = relaxed.status != Status.UNRESOLVED
    wrong = (settled & (relaxed.status != proved)) | ((doubles != Status.UNRESOLVED) & (doubles != proved))
    rows = np.flatnonzero(wrong)
    errors = _errors(relaxed.rows(rows), stadium, epsilon)
    differing = [
        Disagreement(
            a=stadium.a,
            word=to_strings(words[row : row + 1])[0],
            doubles=str(doubles[row]),
            relaxed=str(relaxed.status[row]),
            proved=str(proved[row]),
            margin=float(found[row].margin.mid()),
            error=error,
        )
        for row, error in zip(rows.tolist(), errors.tolist(), strict=True)
    ]
    counts = Agreement(
        a=stadium.a,
        p=words.shape[1],
        classes=len(words),
        orbits=int((proved == Status.ORBIT).sum()),
        boundary=int((proved == Status.BOUNDARY).sum()),
        doubles=int((doubles == proved).sum()),
        relaxation=int((relaxed.status == proved).sum()),
        disagreements=len(differing),
        unexplained=sum(not each.explained for each in differing),
        unresolved=int((~settled).sum()),
        steps=int(relaxed.iterations.max(initial=0)),
    )
    return counts, differing


def _errors(relaxed: Orbits, stadium: Stadium, epsilon: float) -> NDArray[np.float64]:
    """Return how far the force may leave words from where they would come to rest, shape (N,)."""
    errors = np.full(len(relaxed), np.inf)
    still = np.isfinite(relaxed.coordinates).all(axis=1)
    if still.any():
        rates = slowest_rates(relaxed.words[still], stadium, relaxed.coordinates[still])
        errors[still] = np.where(rates > 0, epsilon / np.where(rates > 0, rates, 1.0), np.inf)
    return errors
