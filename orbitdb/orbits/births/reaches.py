"""The worst of curvatures and forces all over a cell, and what it bounds (`orbitdb.orbits.births.cells`).

With x = ln a the maximum moves as A alpha' = -2 a sin(alpha), A = -H, and

    A alpha'' = -2 a sin(alpha) - 4 a cos(alpha) alpha' - dD/dalpha alpha'^2 -+ ...,

where the dots stand for cos(h) (alpha_in' + alpha')^2 / 4 k^2 of the two runs beside a leg. The absolute
values of a solution of A u = b are no larger than v max(|b_i| / q_i), for any v > 0 with

    q_i = D_i v_i + w_i (v_i - v_{i-1}) + w_{i+1} (v_i - v_{i+1}) > 0,

D and w the curvatures of leg and run: look at the row of the largest |u_i| / v_i. With D, w and b at their
worst over the cell this bounds alpha' and alpha'' all over it. The bound on alpha' holds where directions are
pressed against limits, too: the maximum on a box is still that of the largest row. The directions stay in the
range over which the worst was taken, by the bound itself and continuity. v may be any, so rounding in it does
not matter.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from orbitdb.billiard.legs import Chain, following, half_turns, preceding
from orbitdb.billiard.stadium import HALF_PI

Floats = NDArray[np.float64]

ROUNDING = 1e-10
WIDER = 1 + 1e-9


class Reach(NamedTuple):
    """What may be said of all points of a cell, shape (m, N) each."""

    beyond: Floats  # least D
    stiff: Floats  # most w
    soft: Floats  # least w
    lean: Floats  # most of |dD/dalpha|
    pull: Floats  # of 2 a |sin alpha|
    drag: Floats  # of 2 a cos alpha
    bend: Floats  # and of |dw/d(alpha_in + alpha_out)|


def reach_of(legs: Chain, a: Floats, r: Floats, alpha: Floats, room: Floats) -> Reach:
    """Bound curvatures and forces where directions are within some distance, and x within r."""
    low, high = a * np.exp(-r) / WIDER, a * np.exp(r) * WIDER
    size = np.abs(alpha)
    least, most = np.maximum(size - room, 0.0), np.minimum(size + room, HALF_PI)
    lift = np.abs(legs.lift)
    half, spread = half_turns(legs, alpha), (preceding(room) + room) / (2 * legs.k)
    under, over = np.maximum(half - spread, 0.0), np.minimum(half + spread, np.pi / legs.k)
    sines = np.sin(under), np.sin(over)
    stiff = np.where((under < HALF_PI) & (over > HALF_PI), 1.0, np.maximum(*sines))
    bend = np.maximum(np.abs(np.cos(under)), np.abs(np.cos(over))) / (4 * legs.k**2)
    pull, drag = 2 * high * np.sin(most), 2 * high * np.cos(least)
    return Reach(
        beyond=(2 * low * np.cos(most) + lift * np.sin(least)) / WIDER,
        stiff=stiff * WIDER / (2 * legs.k),
        soft=np.minimum(*sines) / WIDER / (2 * legs.k),
        lean=np.maximum(lift * np.cos(least), pull) * WIDER,
        pull=pull * WIDER,
        drag=drag * WIDER,
        bend=bend * WIDER,
    )


def firmness(reach: Reach, v: Floats) -> Floats:
    """Return the least q of the module's docstring, a little less for rounding."""
    behind, ahead = v - preceding(v), v - following(v)
    stiff, soft = reach.stiff, reach.soft
    held = reach.beyond * v
    held = held + np.where(behind > 0, soft, stiff) * behind
    held = held + np.where(ahead > 0, following(soft), following(stiff)) * ahead
    total: Floats = held - ROUNDING * (reach.beyond + stiff + following(stiff)) * v
    return total


def displaced(reach: Reach, drift: Floats, off: Floats) -> Floats:
    """Bound what an error of the directions changes in the equations of the drift."""
    kicks = reach.bend * (preceding(off) + off) * (preceding(drift) + drift)
    return reach.drag * off + reach.lean * off * drift + kicks + following(kicks)


def forcing(reach: Reach, speed: Floats) -> Floats:
    """Bound the right side of the equations of the second derivative, given that of the first."""
    kicks = reach.bend * (preceding(speed) + speed) ** 2
    found: Floats = reach.pull + 2 * reach.drag * speed + reach.lean * speed**2 + kicks + following(kicks)
    return found
