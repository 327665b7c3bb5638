"""Check that Newton's method in double precision, ball arithmetic and the relaxation agree on each status.

Ball arithmetic proves its statuses, so it is the reference. The paper's relaxation stops when the force is
small. Its status can be wrong if an orbit is closer to a joint than the error of the coordinates. It is
always wrong if an orbit runs through a joint, because the relaxation has no status for this case.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from orbitdb.arrays import Floats
from orbitdb.billiard.stadium import Stadium
from orbitdb.numerals import exact
from orbitdb.orbits.newton import certificates, solve_in_doubles
from orbitdb.orbits.relaxation import EPSILON, relax, slowest_rates
from orbitdb.orbits.status import Orbits, Status
from orbitdb.symbols.enumeration import representatives
from orbitdb.symbols.words import to_strings

MAX_STEPS = 20_000_000
"""Steps after which the relaxation gives up. The number needed grows like a^3; it is 3 million at a = 10."""


@dataclass(frozen=True)
class Agreement:
    """Agreement of three methods on the classes of one period."""

    a: float
    p: int
    classes: int  # admissible classes
    orbits: int  # classes proved to be orbits
    boundary: int  # classes proved to run through a joint
    doubles: int  # classes for which Newton's method in double precision gives the proved status
    relaxation: int  # classes for which the relaxation gives the proved status
    # classes for which one of these two methods gives a wrong status
    disagreements: int
    # disagreements that are explained neither by a joint on the orbit nor by the error of the relaxation
    # (the final force divided by the slowest rate, compared with the margin)
    unexplained: int
    unresolved: int  # classes that the relaxation did not bring to rest
    steps: int  # largest number of Runge-Kutta steps for a class


def agreement(
    p: int, stadium: Stadium, progress: Callable[[int, int], None] | None = None
) -> tuple[Agreement, list[str]]:
    """Relax all classes of one period and `compare` the statuses; `progress` is passed on to `relax`."""
    words, _ = representatives(p)
    return compare(relax(words, stadium, max_steps=MAX_STEPS, progress=progress), stadium)


def compare(relaxed: Orbits, stadium: Stadium, epsilon: float = EPSILON) -> tuple[Agreement, list[str]]:
    """Compare relaxed words of one period with Newton's method in double precision and with ball arithmetic.

    The relaxation has stopped at the force `epsilon`. Of its results, only words, statuses, coordinates and
    iterations are used. The returned sentences describe each word to which a method gives a wrong status, in
    the order of the words.
    """
    words = relaxed.words
    found = certificates(words, stadium)
    proved = np.array([each.status.value for each in found])
    margin = np.array([float(each.margin.mid()) for each in found])
    doubles = solve_in_doubles(words, stadium).status
    settled = relaxed.status != Status.UNRESOLVED
    newton_is_wrong = (doubles != Status.UNRESOLVED) & (doubles != proved)
    rows = np.flatnonzero((settled & (relaxed.status != proved)) | newton_is_wrong)
    errors = _errors(relaxed.rows(rows), stadium, epsilon)
    joint = proved[rows] == Status.BOUNDARY
    explained = (joint | (np.abs(margin[rows]) < errors)) & ~newton_is_wrong[rows]
    said = []
    for row, error, clear in zip(rows.tolist(), errors.tolist(), explained.tolist(), strict=True):
        why = f"margin {margin[row]:.1e}, while the final force allows an error of {error:.1e}"
        said.append(
            f"{to_strings(words[row : row + 1])[0]} at a = {exact(stadium.a)}: {proved[row]} by proof, "
            f"{relaxed.status[row]} by the relaxation"
            f"{f', {doubles[row]} in double precision' if newton_is_wrong[row] else ''}; "
            f"{'it runs through a joint' if proved[row] == Status.BOUNDARY else why}"
            f"{'' if clear else ': NOT EXPLAINED'}"
        )
    counts = Agreement(
        a=stadium.a,
        p=words.shape[1],
        classes=len(words),
        orbits=int((proved == Status.ORBIT).sum()),
        boundary=int((proved == Status.BOUNDARY).sum()),
        doubles=int((doubles == proved).sum()),
        relaxation=int((relaxed.status == proved).sum()),
        disagreements=len(rows),
        unexplained=int((~explained).sum()),
        unresolved=int((~settled).sum()),
        steps=int(relaxed.iterations.max(initial=0)),
    )
    return counts, said


def _errors(relaxed: Orbits, stadium: Stadium, epsilon: float) -> Floats:
    """Return how far from rest the final force allows each word to be, shape (N,)."""
    errors = np.full(len(relaxed), np.inf)
    still = np.isfinite(relaxed.coordinates).all(axis=1)
    if still.any():
        rates = slowest_rates(relaxed.words[still], stadium, relaxed.coordinates[still])
        errors[still] = np.where(rates > 0, epsilon / np.where(rates > 0, rates, 1.0), np.inf)
    return errors
