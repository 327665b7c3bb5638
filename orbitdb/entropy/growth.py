"""Bounds on the growth rate of paths in a graph, after Collatz and Wielandt, rounded outward.

For a matrix A >= 0 and any v > 0, the spectral radius lies between the least and the largest (Av)_i / v_i. It
is also the largest of the spectral radii of the strongly connected components. If the steps between
components are left out,

    max over components of min (Av)_i / v_i  <=  spectral radius  <=  max (Av)_i / v_i .

Power iteration provides v, but the bounds hold for any positive v.

Source: Collatz, Math. Z. 48 (1942) 221; Wielandt, Math. Z. 52 (1950) 642.
"""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from orbitdb.arrays import Places

if TYPE_CHECKING:
    from scipy.sparse import csr_array  # slow to import

TOLERANCE = 1e-10
"""Relative width of the enclosure at which the power iteration stops."""

MAX_STEPS = 4000

_ROUNDING = 2.0**-48
"""Bound on the rounding errors of a row of at most 9 steps, of the quotient and of the logarithm.

The sum and the quotient lose 10 half units; the logarithm (below 4) and its printed digits lose 2 units.
"""

_SHIFT = 0.5
"""Added to the diagonal in the power iteration, so that periodic components do not oscillate."""

_LEAST = 1e-280
"""Lower limit on the entries of v, which keeps them positive."""


@dataclass(frozen=True)
class Growth:
    """Bounds on the logarithm of a growth rate; both are -inf if the graph has no cycle."""

    lower: float
    upper: float


def growth(origin: NDArray[np.int32], target: NDArray[np.int32], states: int) -> Growth:
    """Enclose the growth rate of the paths in a graph.

    Parameters
    ----------
    origin, target : ndarray of int32, shape (E,)
        The states that each step connects, with at most 9 steps from each state. Two steps between the same
        states count as two.
    states : int
        Number of states.
    """
    matrix, first = _components(origin, target, states)
    if not len(first):
        return Growth(-math.inf, -math.inf)
    sizes = np.diff(first, append=matrix.shape[0])
    v = np.ones(matrix.shape[0])
    lower, upper = 0.0, math.inf
    for _ in range(MAX_STEPS):
        image = matrix @ v
        ratio = image / v
        lower = max(lower, float(np.minimum.reduceat(ratio, first).max()))
        upper = min(upper, float(ratio.max()))
        if upper - lower <= TOLERANCE * lower:
            break
        image += _SHIFT * v
        v = np.maximum(image / np.repeat(np.maximum.reduceat(image, first), sizes), _LEAST)
    return Growth(
        math.log(lower * (1 - _ROUNDING)) - _ROUNDING, math.log(upper * (1 + _ROUNDING)) + _ROUNDING
    )


def _components(
    origin: NDArray[np.int32], target: NDArray[np.int32], states: int
) -> tuple["csr_array", Places]:
    """Return the matrix of all strongly connected components with a cycle, and the first row of each."""
    from scipy.sparse.csgraph import connected_components

    _, label = connected_components(_matrix(origin, target, states), connection="strong")
    inside = label[origin] == label[target]
    origin, target = origin[inside], target[inside]
    cyclic = np.zeros(states, dtype=np.bool_)
    cyclic[origin] = True  # every state of a component with a cycle has a step inside the component
    kept = np.flatnonzero(cyclic)
    kept = kept[np.argsort(label[kept], kind="stable")]
    place = np.empty(len(label), dtype=np.int32)
    place[kept] = np.arange(len(kept), dtype=np.int32)
    first = np.flatnonzero(np.diff(label[kept], prepend=-1))
    return _matrix(place[origin], place[target], len(kept)), first


def _matrix(origin: NDArray[np.int32], target: NDArray[np.int32], states: int) -> "csr_array":
    from scipy.sparse import csr_array

    return csr_array((np.ones(len(origin)), (origin, target)), shape=(states, states))
