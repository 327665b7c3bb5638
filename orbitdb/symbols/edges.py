"""The nine edges of a path, from one bounce to the next, and which may follow which.

U and D are edges of a run that goes up or down. X is a leg without walls. a and b lead from a run to the top
or bottom wall, A and B from the top or bottom wall to a run, w from top to bottom, and v from bottom to top.
The letters do not name the semicircle, which changes with every leg.

The table expresses all geometric rules at once. It shares nothing with `orbitdb.symbols.pruning`, which
states them one by one for symbols, so `count_by_edges` checks the words that are enumerated by those.
"""

import numpy as np

from orbitdb.symbols.pruning import count_cycles

LETTERS = "UDXabwvAB"
U, D, X, TO_TOP, TO_BOTTOM, DOWN_LEG, UP_LEG, FROM_TOP, FROM_BOTTOM = range(len(LETTERS))

_WAYS = {
    "U": "UXab", "D": "DXba", "X": "UDXab", "A": "UDXab", "B": "DUXba",
    "a": "wA", "v": "wA", "b": "vB", "w": "vB",
}  # fmt: skip
"""The letters that may follow each letter."""

MAY_FOLLOW = np.array([[after in _WAYS[before] for after in LETTERS] for before in LETTERS])
"""MAY_FOLLOW[x, y] tells whether letter y may follow letter x."""

ENDS_LEG = np.isin(np.arange(len(LETTERS)), (X, FROM_TOP, FROM_BOTTOM))
"""Whether an edge ends a leg: it arrives on the other semicircle."""


def count_by_edges(p: int) -> int:
    """Count the primitive cyclic words of any period p that the geometric rules allow: the paper's N_t(p)."""
    return count_cycles(p, _closed_walks)


def _closed_walks(n: int) -> int:
    """Return the trace of the n-th power of the matrix of 18 states: an edge, and the side it comes from.

    Closed walks that stay on one semicircle (two sides, two senses) or between the walls (for even n, two
    beginnings, two sides that were never left) are no words.
    """
    same, other = MAY_FOLLOW * ~ENDS_LEG[:, None], MAY_FOLLOW * ENDS_LEG[:, None]
    power = np.linalg.matrix_power(np.block([[same, other], [other, same]]).astype(object), n)
    return int(np.trace(power)) - (4 if n % 2 else 8)
