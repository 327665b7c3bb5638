"""Where an unfolded orbit bounces, and the slacks: how far inside its wall or semicircle each bounce is.

All arrays with a value for each leg or run have shape (m, N), as in `orbitdb.billiard.legs`.
"""

import numpy as np

from orbitdb.arithmetic import ABOVE, EPSILON
from orbitdb.arrays import Floats
from orbitdb.billiard.legs import Chain, Legs, following, half_turns, preceding
from orbitdb.billiard.stadium import HALF_PI


def end_angles(legs: Chain, alpha: Floats) -> tuple[Floats, Floats]:
    """Return the angles of the first and of the last bounce of each run, each of shape (m, N)."""
    middle = (preceding(legs.parity * alpha) - alpha) / 2
    spread = legs.d * half_turns(legs, alpha) * (legs.k - 1)
    return middle - spread, middle + spread


def slacks(legs: Chain, alpha: Floats) -> Floats:
    """Return how far inside its wall or semicircle each end of a run or leg is (radians), shape (4, m, N).

    For each run, the slacks are pi/2 - |t| of its first and of its last bounce. For each leg, they are
    pi/2 - s t - 2 |alpha| at its start and the same expression at its end with the leg reversed, where t is
    the angle of the adjacent bounce on the semicircle. This is the angle from the joint to the bounce that
    would follow if the semicircle were a full circle. A slack that does not exist is infinite: both slacks of
    a leg without walls, and that of the last bounce of a run with only one. All slacks of an orbit are
    positive; a path through a joint has a slack of zero.
    """
    low, high, later, latest, ahead, back = smooth_slacks(legs, alpha)
    return np.stack([np.minimum(low, high), np.minimum(later, latest), ahead, back])


def smooth_slacks(legs: Chain, alpha: Floats) -> Floats:
    """Return the slacks without absolute values, and so linear in the directions, shape (6, m, N).

    For each run, they are pi/2 - t and pi/2 + t for its first bounce, then for its last. For each leg, they
    are pi/2 - 2 s alpha - s t at its start and the same expression at its end with the leg reversed, with t
    as in `slacks`. All are positive if and only if all `slacks` are. A slack that does not exist is infinite.
    """
    return _six(legs, HALF_PI, alpha, *end_angles(legs, alpha), np.inf)


def slack_changes(legs: Chain, change: Floats) -> Floats:
    """Return the change of the smooth slacks, shape (6, m, N), for a given change of the directions.

    The change of a slack that does not exist is zero.
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
    """Bound the errors of `slacks`, given the errors of the directions, shape (m, N).

    If the two directions beside a run change, the angle at each end of the run changes by 1/2k of one change
    and 1 - 1/2k of the other. The rounding, in units of eps, is as follows: psi is accurate to 5.3, and
    (k - 1)/k of half of it enters the angle at an end; a quotient and a product add 1.6 (k - 1)/k each, and
    two sums 2.4; pi/2 and the sums of a slack add at most 3.5. `allowed` also covers the rounding of the
    bounces between the ends, 4 + 17.4 (k - 1)/k, and of the angles whose heights `coordinates` computes,
    5.1 + 5.8 (k - 1)/k.
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

    The distance from the joint to the first bounce of a leg is 2 cos(pi/4 + s t/2) sin(slack/2) / sin|alpha|,
    with t as in `slacks`.
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

    For an unfolded leg, `rise` and `fall` are the vertical distances of its start and of its end from its
    first wall. They are computed from 2 sin^2(pi/4 - t/2), with t measured towards the wall at that end,
    because the difference 1 - sin t would lose digits.
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
