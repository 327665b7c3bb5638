"""The symbol plane: the future and the past of each bounce as two numbers.

Number the pieces of the boundary anticlockwise: 0 bottom wall, 1 right semicircle, 2 top wall, 3 left
semicircle. The *letter* of a bounce says how many pieces farther the next bounce is; 0 and 4 stand for the
same semicircle, anticlockwise and clockwise. So the letters of a bounce are in the order in which they occur
as the outgoing path turns anticlockwise:

========== ==== ==== === ==== ====
bounce on  0    1    2   3    4
========== ==== ==== === ==== ====
bottom          R    top L
top             L    0   R
right      up   top  L   0    down
left       down 0    R   top  up
========== ==== ==== === ==== ====

The digits of ``gamma``, in mixed radix, are the ranks of the letters of the bounce and of all later ones. A
bounce on a straight wall reverses the order of all paths that leave it, so a digit is reversed after an odd
number of later wall bounces. ``delta`` is ``gamma`` of the reversed path from the same bounce. From the
second letter on, a letter that the geometric rules exclude (`orbitdb.symbols.pruning`) has no rank.

The order is measured, not proved. In fans of paths, ``gamma`` rises with the angle from the tangent
everywhere, with the arc length on semicircles and against it on walls.

Source: pruning fronts are Hansen's; these letters for the six symbols are not published.
"""

from collections.abc import Iterable
from functools import cache
from itertools import count
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from orbitdb.arrays import Floats, Marks, Words
from orbitdb.symbols.pruning import need_admissible

LETTERS = 27
"""Number of letters of `gamma` and of `delta`; doubles could not hold many more."""

ANTICLOCKWISE, CLOCKWISE = 0, 4
"""The letters of runs: the next bounce is on the same semicircle."""

PIECE = np.array([0, 3, 2, 1, 3, 1], dtype=np.uint8)
"""The piece of the boundary on which each symbol is; semicircles have odd numbers."""

_RUN = np.array([0, CLOCKWISE, 0, ANTICLOCKWISE, ANTICLOCKWISE, CLOCKWISE], dtype=np.uint8)
"""The letter of each symbol in a run; up is clockwise on the left semicircle."""


class _State(NamedTuple):
    """What the letters so far imply about the next one."""

    curved: bool  # whether the bounce is on a semicircle
    excluded: int | None  # the letter that the geometric rules exclude, if one is known
    reversed: bool  # whether the number of later wall bounces is odd

    def digits(self) -> list[int]:
        """Return the digit of each letter; a letter that is excluded has a neighbour's."""
        letters = range(ANTICLOCKWISE, CLOCKWISE + 1) if self.curved else range(1, CLOCKWISE)
        ranked = [letter for letter in letters if letter != self.excluded]
        last = len(ranked) - 1
        ranks = [min(sum(other < letter for other in ranked), last) for letter in range(CLOCKWISE + 1)]
        return [last - rank for rank in ranks] if self.reversed else ranks

    def after(self, letter: int) -> "_State":
        """Return the state at the next bounce.

        A run keeps its sense (rule 5). A leg does not return to the semicircle that it comes from (rules 4
        and 6); in a leg that begins with a straight bounce, that semicircle is not known. Neither table of
        `orbitdb.symbols` serves here, as these letters are relative to the piece on which a bounce is.
        """
        if letter in (ANTICLOCKWISE, CLOCKWISE):
            return _State(True, CLOCKWISE - letter, self.reversed)
        if self.curved != bool(letter % 2):
            return _State(True, None, self.reversed)
        origin = letter if self.curved else self.excluded
        return _State(False, None if origin is None else CLOCKWISE - origin, not self.reversed)


class _Tables(NamedTuple):
    """What each of S states makes of each letter; the first two states are those of a first bounce."""

    digit: Floats  # shape (S, 5)
    radix: Floats  # shape (S,)
    after: NDArray[np.intp]  # the next state, shape (S, 5)


@cache
def _tables() -> _Tables:
    states = [_State(False, None, False), _State(True, None, False)]
    after = []
    for state in states:  # grows while it is read
        following = [state.after(letter) for letter in range(CLOCKWISE + 1)]
        states += [new for new in dict.fromkeys(following) if new not in states]
        after.append([states.index(new) for new in following])
    digit = np.array([state.digits() for state in states], dtype=np.float64)
    return _Tables(digit, digit.max(axis=1) + 1, np.array(after))


def symbol_plane(words: Words) -> Floats:
    """Return gamma and delta of each bounce of periodic orbits.

    Parameters
    ----------
    words : ndarray of int, shape (N, p)
        Admissible words.

    Returns
    -------
    ndarray, shape (N, p, 2)
        gamma, which encodes the future of a bounce, and delta, which encodes its past, in [0, 1]. They are
        the middles of the intervals of all paths with the same `LETTERS` letters.

    Raises
    ------
    WordError
        If the argument is not an array of admissible words.

    Examples
    --------
    >>> from orbitdb.symbols.words import from_strings
    >>> symbol_plane(from_strings(["13"])).round(6).tolist()
    [[[0.5, 0.5], [0.5, 0.5]]]
    """
    need_admissible(words)
    piece, run = PIECE[words], _RUN[words]
    ahead, back = (np.roll(piece, shift, axis=1) for shift in (-1, 1))
    future = _letters(piece, ahead, np.roll(run, -1, axis=1))
    past = _letters(piece, back, CLOCKWISE - run)
    curved = piece % 2 == 1
    gamma = ordinate(curved, (np.roll(future, -n, axis=1) for n in count()))
    delta = ordinate(curved, (np.roll(past, n, axis=1) for n in count()))
    return np.stack([gamma, delta], axis=-1)


def _letters(piece: Words, following: Words, run: Words) -> Words:
    """Return the letters of bounces, given their pieces, the next ones, and the letters of runs."""
    return np.where(piece == following, run, (following - piece) % 4).astype(np.uint8)


def ordinate(curved: Marks, letters: Iterable[Words]) -> Floats:
    """Read the letters of paths as numbers.

    Parameters
    ----------
    curved : ndarray of bool, any shape
        Whether the first bounce is on a semicircle.
    letters : iterable of ndarray of int, each of the same shape
        The letters of the first bounce, of the second one, and so on; `LETTERS` of them are read.

    Returns
    -------
    ndarray, of the same shape
        Numbers in [0, 1]: gamma for letters of the future, delta for letters of the reversed past.
    """
    digit, radix, after = _tables()
    state = curved.astype(np.intp)
    value, width = np.zeros(curved.shape), np.ones(curved.shape)
    for _, letter in zip(range(LETTERS), letters, strict=False):
        width /= radix[state]
        value += digit[state, letter] * width
        state = after[state, letter]
    return value + width / 2
