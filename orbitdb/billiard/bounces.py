"""The bounces of an unfolded orbit, and their slacks: how far they are inside their walls.

All arrays of legs and runs have shape (m, N), as in `orbitdb.billiard.legs`.
"""

import numpy as np

from orbitdb.arithmetic import ABOVE, EPSILON
from orbitdb.arrays import Floats
from orbitdb.billiard.legs import Chain, Legs, following, half_turns, preceding
from orbitdb.billiard.stadium import HALF_PI


def end_angles(legs: Chain, alpha: Floats) -> tuple[Floats, Floats]:
    """Return the angles of the first and the last bounce of each run, shape (m, N) each."""
    middle = (preceding(legs.parity * alpha) - alpha) / 2
    spread = legs.d * half_turns(legs, alpha) * (legs.k - 1)
    return middle - spread, middle + spread


def slacks(legs: Chain, alpha: Floats) -> Floats:
    """Return how far each end of a run or leg is inside its wall or semicircle, radians, shape (4, m, N).

    For each run, pi/2 - |t| of its first and last bounce; for each leg, pi/2 - s t - 2 |alpha| at its start
    and, seen backwards, at its end: with t the last bounce on the semicircle, the angle from the joint to the
    bounce that would follow if the semicircle went on. Infinite for a leg without walls and the last bounce
    of a run of one. All are positive for an orbit; an orbit through a joint has a zero.
    """
    low, high, later, latest, ahead, back = smooth_slacks(legs, alpha)
    return np.stack([np.minimum(low, high), np.minimum(later, latest), ahead, back])


def smooth_slacks(legs: Chain, alpha: Floats) -> Floats:
    """Return the slacks without absolute values, shape (6, m, N): linear in the directions.

    For each run pi/2 - t and pi/2 + t of its first bounce, then of its last; for each leg
    pi/2 - 2 s alpha - s t at its start and, seen backwards, at its end, with t as in `slacks`. All are
    positive if all slacks are. Infinite for a leg without walls, and for the second copy of a single bounce.
    """
    return _six(legs, HALF_PI, alpha, *end_angles(legs, alpha), np.inf)


def slack_changes(legs: Chain, change: Floats) -> Floats:
    """Return the change of the smooth slacks, shape (6, m, N), for a change of the directions.

    Zero for a slack that does not exist.
    """
    arriving = preceding(legs.parity * change)
    middle = (arriving - change) / 2
    spread = -(arriving + change) * (legs.k - 1) / (2 * legs.k)
    return _six(legs, 0.0, change, middle - spread, middle + spread, 0.0)


def _six(legs: Chain, base: float, alpha: Floats, first: Floats, last: Floats, none: float) -> Floats:
    several, walled = legs.k > 1, legs.n > 0
    steep = base - 2 * legs.s * alpha
    return np.stack([
        base - first,
        base + first,
        np.where(several, base - last, none),
        np.where(several, base + last, none),
        np.where(walled, steep - legs.s * last, none),
        np.where(walled, steep + legs.s * legs.parity * following(first), none),
    ])  # fmt: skip


def slack_errors(legs: Chain, alpha_error: Floats) -> Floats:
    """Bound the errors of `slacks`, given those of the directions, shape (m, N).

    An end of a run moves by 1/2k of one neighbour's change and 1 - 1/2k of the other's. The rounding,
    in units of eps: psi is accurate to 5.3, (k - 1)/k of half of it is in an end, with 1.6 (k - 1)/k for each
    of a quotient and a product, and 2.4 for two sums; pi/2 and the sums of a slack add at most 3.5. With
    `allowed` there is room for the bounces between the ends, 4 + 17.4 (k - 1)/k, and for the angles that
    `coordinates` takes the heights of, 5.1 + 5.8 (k - 1)/k.
    """
    incoming = preceding(alpha_error)
    near, far = 1 / (2 * legs.k), 1 - 1 / (2 * legs.k)
    allowed = EPSILON * (26 - 18 / legs.k)
    first = far * incoming + near * alpha_error + allowed
    last = near * incoming + far * alpha_error + allowed
    tilt = 2 * alpha_error
    return ABOVE * np.stack([first, last, last + tilt, following(first) + tilt])


def margin_distances(legs: Chain, alpha: Floats, slack: Floats) -> Floats:
    """Return the slacks in coordinate units, shape (4, m, N): radians on a semicircle, x on a wall.

    The first bounce of a leg lies 2 cos(pi/4 + s t/2) sin(slack/2) / sin|alpha| from the joint.
    """
    first, last = end_angles(legs, alpha)
    ahead = -legs.s * legs.parity * following(first)
    walled = legs.n > 0
    rise = np.where(walled, np.abs(np.sin(alpha)), 1.0)
    margin = slack.copy()
    for end, t in zip(margin[2:], (legs.s * last, ahead), strict=True):
        width = 2 * np.cos(HALF_PI / 2 + t / 2) / rise
        end[...] = np.where(walled, width * np.sin(np.where(walled, end, 0.0) / 2), np.inf)
    return margin


def coordinates(legs: Legs, a: float, alpha: Floats) -> Floats:
    """Return the coordinates of all bounces in the order of the words, shape (N, p).

    A leg with walls starts and ends at the distances rise and fall from the first and the last of
    them, 2 sin^2(pi/4 - t/2) with t towards that wall: no difference of nearly equal heights.
    """
    m, n_words = legs.k.shape
    first, last = end_angles(legs, alpha)
    ahead = following(first)
    rise = 2 * np.sin(HALF_PI / 2 - legs.s * last / 2) ** 2
    fall = 2 * np.sin(HALF_PI / 2 + legs.s * legs.parity * ahead / 2) ** 2 + 2 * (legs.n - 1)
    near, far = a + np.cos(last), a + np.cos(ahead)
    side = (1.0 - 2.0 * (np.arange(m)[:, None] % 2)) / np.where(legs.n > 0, rise + fall, 1.0)
    table = np.concatenate([first, side * (rise * far - fall * near)])
    steps = np.concatenate([2 * legs.d * half_turns(legs, alpha), side * 2 * (near + far)])
    run, place, straight = legs.bounces
    entry = (run + m * straight) * n_words + np.arange(n_words)
    found: Floats = (table.ravel()[entry] + place * steps.ravel()[entry]).T
    return np.ascontiguousarray(found)
