"""Edge words: the paths between bounces as letters, one an edge, and the code they belong to.

U, D an edge of a run that goes up, down; X a leg without walls; a, b from a run to the top, to the
bottom wall; w, v from top to bottom, from bottom to top; A, B from the top, from the bottom to a run. The
letters do not say which semicircle is meant: it changes with every leg. So an edge word stands for two
codes, mirror images of each other, and words of p edges and codes of p bounces grow at one rate.
"""

import math

import numpy as np
from numpy.typing import NDArray

Letters = NDArray[np.uint8]

LETTERS = "UDXabwvAB"
U, D, X, TO_TOP, TO_BOTTOM, DOWN_LEG, UP_LEG, FROM_TOP, FROM_BOTTOM = range(len(LETTERS))

WAYS = {
    "U": "UXab", "D": "DXba", "X": "UDXab", "A": "UDXab", "B": "DUXba",
    "a": "wA", "v": "wA", "b": "vB", "w": "vB",
}  # fmt: skip
"""What may follow, so ordered that a letter and its mirror image, X aside, have images in one place."""


def letters_of(text: str) -> Letters:
    """Return the letters of an edge word, shape (L,)."""
    return np.array([LETTERS.index(letter) for letter in text], dtype=np.uint8)


def text_of(letters: Letters) -> str:
    """Return an edge word as text."""
    return "".join(LETTERS[letter] for letter in letters)


MAY_FOLLOW = np.array([[after in WAYS[before] for after in LETTERS] for before in LETTERS])
"""MAY_FOLLOW[x, y]: whether letter y may stand behind letter x; the geometric rules, all of them."""

MIRROR = letters_of("DUXbavwBA")
"""The letter of an edge seen upside down."""

REVERSAL = letters_of("DUXABvwab")
"""The letter of an edge run backwards."""

IN_RUN = np.isin(np.arange(9), (U, D))
STARTS_LEG = np.isin(np.arange(9), (X, TO_TOP, TO_BOTTOM))
ENDS_LEG = np.isin(np.arange(9), (X, FROM_TOP, FROM_BOTTOM))
SIGN = np.array([1, -1, 0, 1, -1, 1, -1, 1, -1], dtype=np.int8)
"""Changes with the mirror; 0 for X. For a, b, A, B it is that of the wall: +1 top, -1 bottom."""


def geometric_entropy() -> float:
    """Return the growth rate of all edge words, an upper bound on the topological entropy for every a.

    ln(1/z), z the root of z^3 + z^2 + 3 z = 1, rounded upward: 1.218756. It is also the limit of the
    entropy as a grows.
    """
    low, high = 0.2, 0.4
    while (middle := (low + high) / 2) not in (low, high):
        low, high = (middle, high) if middle**3 + middle**2 + 3 * middle < 1 else (low, middle)
    return -math.log(low) + 1e-15


def reverse(words: Letters) -> Letters:
    """Return edge words run backwards, the last axis being that of the letters."""
    return REVERSAL[words[..., ::-1]]
