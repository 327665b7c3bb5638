"""Edge words, and windows: finite edge words with a marked junction, treated as chains of legs.

An edge word has one letter for each edge of a path (`orbitdb.symbols.edges`), without the semicircle. It thus
represents two codes, which are mirror images, and the numbers of words and codes grow at the same rate.

The mark is where a run ends and a leg begins. A junction where a leg ends and a run begins becomes such a
junction if the word is reversed, so, with the mirror, it suffices to start from six windows
(`first_windows`). The directions of the legs that lie entirely inside a window are the unknowns. Beyond the
ends of a window, any continuation is allowed.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orbitdb.arrays import Batch, Floats, Indices, Marks
from orbitdb.symbols.edges import ENDS_LEG, LETTERS, MAY_FOLLOW, TO_BOTTOM, TO_TOP, D, U, X

Letters = NDArray[np.uint8]


def letters_of(text: str) -> Letters:
    """Return the letters of an edge word, shape (L,)."""
    return np.array([LETTERS.index(letter) for letter in text], dtype=np.uint8)


MIRROR = letters_of("DUXbavwBA")
"""The letter of each edge when the stadium is turned upside down."""

REVERSAL = letters_of("DUXABvwab")
"""The letter of each edge when it is traversed in the opposite direction."""

IN_RUN = np.isin(np.arange(9), (U, D))
STARTS_LEG = np.isin(np.arange(9), (X, TO_TOP, TO_BOTTOM))
SIGN = np.array([1, -1, 0, 1, -1, 1, -1, 1, -1], dtype=np.int8)
"""Sign of each letter, which the mirror reverses; 0 for X. For a, b, A, B: +1 top, -1 bottom."""


def geometric_entropy() -> float:
    """Return the growth rate of all edge words, an upper bound on the topological entropy for every a.

    It is ln(1/z) = 1.218756, rounded up, where z^3 + z^2 + 3 z = 1. The entropy approaches it as a increases.
    """
    low, high = 0.2, 0.4
    while (middle := (low + high) / 2) not in (low, high):
        low, high = (middle, high) if middle**3 + middle**2 + 3 * middle < 1 else (low, middle)
    return -math.log(low) + 1e-15


def reverse(words: Letters) -> Letters:
    """Return edge words traversed in the opposite direction; the letters are on the last axis."""
    return REVERSAL[words[..., ::-1]]


_FIRST = ("UX", "Ua", "Da", "Xa", "Aa", "Ba")
UNKNOWN_RUN, PART_OF_RUN, PART_OF_LEG = range(3)
"""What is at an end of a window: an unknown run, part of a run, or part of a leg."""


@dataclass(frozen=True, eq=False)
class Windows:
    """N windows of L edges."""

    letters: Letters  # shape (N, L)
    mark: Indices  # number of letters before the marked junction of each window, shape (N,)

    def __len__(self) -> int:
        return len(self.mark)

    @property
    def edges(self) -> int:
        """The number L of edges of each window."""
        return self.letters.shape[1]

    def rows(self, chosen: Indices | Marks) -> "Windows":
        """Return the chosen windows."""
        return Windows(self.letters[chosen], self.mark[chosen])


def first_windows() -> Windows:
    """Return six two-letter windows that represent every junction, up to mirror images and reversal."""
    letters = np.array([letters_of(text) for text in _FIRST])
    return Windows(letters, np.ones(len(letters), dtype=np.intp))


def extended(windows: Windows, at_left: Marks) -> Windows:
    """Return all extensions of the windows by one letter, at the left or right end as chosen for each."""
    ends = np.where(at_left, windows.letters[:, 0], windows.letters[:, -1])
    fits = np.where(at_left[:, None], MAY_FOLLOW.T[ends], MAY_FOLLOW[ends])
    row, letter = np.nonzero(fits)
    left = at_left[row][:, None]
    old = windows.letters[row]
    new = letter.astype(np.uint8)[:, None]
    letters = np.where(left, np.concatenate([new, old], axis=1), np.concatenate([old, new], axis=1))
    return Windows(letters, windows.mark[row] + at_left[row])


@dataclass(frozen=True, eq=False)
class OpenChains(Batch):
    """N windows as open chains: run 1, leg 1, run 2 ... leg m, run m + 1, and an outer leg at each end.

    Rows are numbered from 0 to m + 1; run i precedes leg i, and there is no run 0. If an end of the window
    cuts a leg, leg 0 or m + 1 is that leg. Otherwise it is the unknown leg beyond the run at that end.
    """

    # Number of bounces and sense (+1 up) of each run, shape (m + 2, N). Of a cut run, only the bounces in the
    # window count. A single bounce has no sense; before the mark, d is then the sign of the next wall.
    k: Floats
    d: Floats
    # Number of walls of each leg, and its first wall (-1 bottom, +1 top, 0 none), shape (m + 2, N). Of a cut
    # leg, only the walls in the window count. s is the sign of the direction at the start of the leg, but for
    # leg 0 at its end.
    n: Floats
    s: Floats
    left: Indices  # what is at the left end, such as `UNKNOWN_RUN`, shape (N,)
    right: Indices  # what is at the right end, shape (N,)
    marked: Indices  # the row of the run before the mark and of the leg after it, shape (N,)

    def __len__(self) -> int:
        return len(self.marked)

    @property
    def sense(self) -> Floats:
        """The sense d of the run before the mark, shape (N,)."""
        return self.at_mark(self.d)

    @property
    def lean(self) -> Floats:
        """c in the condition h + c o > 0 at the mark, shape (N,): d for a leg without walls, otherwise -s."""
        return np.where(self.at_mark(self.n) > 0, -self.at_mark(self.s), self.sense)

    def at_mark(self, rows: Floats) -> Floats:
        """Return the entry in the marked row of each window."""
        return rows[self.marked, np.arange(len(self))]


def open_chains(windows: Windows) -> Iterator[tuple[Indices, OpenChains]]:
    """Cut windows into runs and legs; for each number of unknowns, yield window indices and chains."""
    left, right = _kind_of_end(windows.letters[:, 0]), _kind_of_end(windows.letters[:, -1], backwards=True)
    unknowns = ENDS_LEG[windows.letters].sum(axis=1) - (left == PART_OF_LEG)
    for m in np.unique(unknowns):
        rows = np.flatnonzero(unknowns == m)
        yield rows, _chains(windows.rows(rows), int(m), left[rows], right[rows])


def _kind_of_end(letters: Letters, backwards: bool = False) -> Indices:
    at_run = (ENDS_LEG if backwards else STARTS_LEG)[letters]
    return np.where(IN_RUN[letters], PART_OF_RUN, np.where(at_run, UNKNOWN_RUN, PART_OF_LEG))


def _chains(windows: Windows, m: int, left: Indices, right: Indices) -> OpenChains:
    letters = windows.letters
    count = len(windows)
    word = np.arange(count)[:, None]
    leg = STARTS_LEG[letters].cumsum(axis=1)
    in_run = IN_RUN[letters]
    sign = SIGN[letters].astype(float)
    run = (leg + 1) * count + word
    size = (m + 2) * count

    def tally(places: Indices, weights: Floats) -> Floats:
        sums: Floats = np.bincount(places.ravel(), weights.ravel(), minlength=size).astype(float)
        return sums.reshape(m + 2, count)

    k = 1 + tally(np.where(in_run, run, 0), np.where(in_run, 1.0, 0.0))
    turn = tally(np.where(in_run, run, 0), np.where(in_run, sign, 0.0))
    place = leg * count + word
    n = tally(place, np.where(in_run, 0.0, 1.0))
    n[1 : m + 1] -= 1
    first = STARTS_LEG[letters] | (ENDS_LEG[letters] & (leg == 0))
    s = tally(place, np.where(first, sign, 0.0))
    s[0] *= -1  # the path leaves the last wall of leg 0
    marked = leg[np.arange(count), windows.mark]
    d = np.where(turn < 0, -1.0, 1.0)
    mark = (marked, np.arange(count))
    d[mark] = np.where((k[mark] == 1) & (s[mark] != 0), s[mark], d[mark])  # as the condition expects
    return OpenChains(k, d, n, s, left, right, marked)
