"""The Dirichlet levels of a stadium: the k for which Laplace psi = -k^2 psi, with psi = 0 on the boundary.

The levels are found in windows of k. The error of a level allows for rounding and for the finite degree of
the polynomials, whose effect is extrapolated from the two highest degrees in each cell (`Grid.truncation`).
"""

import math
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from orbitdb.arrays import Floats
from orbitdb.billiard.arithmetic import arithmetic
from orbitdb.billiard.stadium import Stadium, as_stadium
from orbitdb.display import Drawn, Table, data_frame
from orbitdb.errors import InputError, check_number
from orbitdb.quantum.condensation import Interiors, eigenfunctions, one_thread
from orbitdb.quantum.elements import grid, quarter_stadium
from orbitdb.quantum.weyl import Parity, k_range, parities_of, wavenumber, weyl
from orbitdb.text import format_float, several

if TYPE_CHECKING:
    import pandas


LEAST_A, LARGEST_A = 0.05, 20.0
"""Smallest and largest half length for which the error estimates have been tested."""
MOST_LEVELS = 20_000
"""Maximum number of levels, of all parities, below the end of a range. The memory for a window grows in
proportion to this number, to 3 or 4 GB at the limit, and all windows together take hours."""

_IN_WINDOW = 48
"""Approximate number of levels of one parity in a window."""
_GRID = (18, 1)
"""Degree of the polynomials, and number of times the cells at the joint are divided."""
_PHASE = 9.0
"""Maximum value of k times the size of a cell; at 9.5, truncation errors are often far above rounding."""
ROUNDING = 4e-15
"""Relative error allowed for rounding. The largest errors found at half lengths from 0.05 to 20, by comparing
with energies in 80-bit arithmetic, are 1.1e-15 for the lowest levels and 5e-16 for others."""
_ON_END = 1e-10
"""Relative distance from an end of a window within which a level counts as on the end; the levels from
different grids differ by less."""
_BEYOND = 1e-6
"""Relative distance by which a window is extended to find its levels; the levels from different grids differ
by less, so they agree on the number of levels."""


@dataclass(frozen=True, eq=False)
class LevelWindow:
    """Levels of one parity in a window of k.

    Attributes
    ----------
    a : float
        Half length of the stadium.
    parity : Parity
    low, high : float
        The ends of the window, in 1/radius; it contains all levels with low <= k < high.
    below : int
        Number of levels of the same parity below the window.
    k, error : ndarray, shape (N,)
        The levels in ascending order, and estimates of their errors.
    seconds : float
        Processor time for finding the levels.
    arithmetic : str
        The software that computed the levels (`orbitdb.billiard.arithmetic.arithmetic`).
    """

    a: float
    parity: Parity
    low: float
    high: float
    below: int
    k: Floats
    error: Floats
    seconds: float = 0.0
    arithmetic: str = ""

    def without(self, stored: "Iterable[Range]") -> "Iterator[LevelWindow]":
        """Yield the parts of the window that no stored range covers; these ascend."""
        for low, high in ranges_not_stored(stored, self.low, self.high):
            first, last = np.searchsorted(self.k, [low, high]).tolist()
            k, error = self.k[first:last], self.error[first:last]
            yield replace(self, low=low, high=high, below=self.below + first, k=k, error=error)


class Range(Protocol):
    """A range low <= k < high."""

    @property
    def low(self) -> float: ...  # noqa: D102
    @property
    def high(self) -> float: ...  # noqa: D102


def ranges_not_stored(done: Iterable[Range], low: float, high: float) -> Iterator[tuple[float, float]]:
    """Yield the ranges of k between `low` and `high` that no stored range covers; these ascend."""
    for stored in done:
        if low < min(stored.low, high):
            yield low, min(stored.low, high)
        low = max(low, stored.high)
    if low < high:
        yield low, high


@dataclass(frozen=True)
class LevelTask:
    """The task of finding all levels of one parity with low <= k < high; any process can solve it."""

    a: float
    parity: Parity
    low: float
    high: float

    def solved(self, order: int = _GRID[0], layers: int = _GRID[1]) -> LevelWindow:
        """Find the levels of the window on a grid.

        A level at an end of the window belongs to the window above that end, whichever way it was rounded.
        The grid has polynomials of degree `order`; the cells at the joint are divided `layers` times.
        """
        began = time.process_time()
        low, high = self.low * (1 - _BEYOND), self.high * (1 + _BEYOND)
        with one_thread():
            elements = self.elements(order, layers)
            below, values, functions = eigenfunctions(elements, self.fixed, low**2, high**2)
            truncation = elements.grid.truncation(functions)
        k = np.sqrt(values)
        error = truncation / (2 * k) + ROUNDING * k
        first, last = np.searchsorted(k, np.array([self.low, self.high]) * (1 - _ON_END))
        k, error = k[first:last], error[first:last]
        stored = np.maximum(k, self.low)
        error += stored - k
        seconds = time.process_time() - began
        return LevelWindow(
            self.a, self.parity, self.low, self.high, below + int(first), stored, error, seconds, arithmetic()
        )

    def elements(self, order: int = _GRID[0], layers: int = _GRID[1]) -> Interiors:
        """Return the elements for the window, by default those of the grid on which `solved` works."""
        steps = math.ceil(self.high / (2 * _PHASE))  # per half height; windows with equal steps share cells
        return _elements(self.a, 1 / (2 * steps), order, layers)

    def fixed(self, points: Floats) -> NDArray[np.bool_]:
        """Return whether the functions must be 0 at each point, shape (..., 2).

        They must be 0 on the outer edge, and on an axis under whose reflection they are odd.
        """
        x, y = points[..., 0], points[..., 1]
        beyond = np.maximum(x - self.a, 0.0)
        odd_x, odd_y = (sign < 0 for sign in self.parity.signs)
        edge = beyond**2 + y**2 > 1 - 1e-8
        return edge | (odd_x & (x < 1e-8)) | (odd_y & (y < 1e-8))


@lru_cache(maxsize=1)
def _elements(a: float, size: float, order: int, layers: int) -> Interiors:
    """Return the elements, which all parities and often consecutive windows share."""
    return Interiors(grid(quarter_stadium(a, size, layers), order))


def level_tasks(stadium: Stadium, parity: Parity, low: float, high: float) -> Iterator[LevelTask]:
    """Divide a range of k into windows; yield the task of each window.

    Raises
    ------
    InputError
        If the half length or the range is outside the tested limits.
    """
    for end in (low, high):
        check_number("k", end)
    if not LEAST_A <= stadium.a <= LARGEST_A:
        raise InputError(
            f"levels cannot be computed at a = {format_float(stadium.a)}: "
            f"give a half length from {LEAST_A:g} to {LARGEST_A:g}"
        )
    if not 0 <= low < high < math.inf:
        raise InputError(f"k from {low:g} to {high:g} is not a range: give a range such as 0:30")
    whole, smooth = weyl(stadium, None), weyl(stadium, parity)
    if whole(high) > MOST_LEVELS:
        most = math.floor(wavenumber(whole, MOST_LEVELS))
        raise InputError(
            f"too many levels up to k = {high:g} at a = {format_float(stadium.a)}: give k up to {most}"
        )
    while low < high:
        end = wavenumber(smooth, max(smooth(low), 0.0) + _IN_WINDOW)
        if smooth(high) - smooth(end) < _IN_WINDOW / 4:
            end = high
        yield LevelTask(stadium.a, parity, low, end)
        low = end


def in_order(tasks: Iterable[LevelTask]) -> list[LevelTask]:
    """Sort tasks so that windows of different parities can share their elements."""
    return sorted(tasks, key=lambda task: task.high)


@dataclass(frozen=True, eq=False, repr=False)
class Levels(Table, Drawn):
    """All levels of the given parities in a range of k; `plot` draws their staircase and Weyl's law.

    It also draws their ``spacings``, or with ``rigidity`` Delta_3.

    Attributes
    ----------
    a : float
        Half length of the stadium.
    low, high : float
        The ends of the range, in 1/radius; it contains all levels with low <= k < high.
    k, error : ndarray, shape (N,)
        The levels in ascending order, and estimates of their errors.
    parity : ndarray of str, shape (N,)
        Parity of each level, such as ``oe`` for odd in x and even in y.
    parities : tuple of Parity
        The parities whose levels are included.
    basis : str
        For levels from orbits, the orbits that were used; empty for levels from spectral elements.
    notes : tuple of str
        For each parity of levels from spectral elements, how they compare with Weyl's law.

    Examples
    --------
    >>> print(levels(1.6, 3))
    <4 levels from k = 0 to 3 at a = 1.6>
    """

    a: float
    low: float
    high: float
    k: Floats
    error: Floats
    parity: NDArray[np.str_]
    parities: tuple[Parity, ...] = tuple(Parity)
    basis: str = ""
    notes: tuple[str, ...] = ()

    @classmethod
    def joined(
        cls, a: float, low: float, high: float, parts: Mapping[Parity, Iterable[LevelWindow]]
    ) -> "Levels":
        """Return the levels in a range, given for each parity the windows that cover the range."""
        rows = sorted(
            (k, error, str(parity))
            for parity, solved in parts.items()
            for part in solved
            for k, error in zip(part.k.tolist(), part.error.tolist(), strict=True)
            if low <= k < high
        )
        k, error, parity = zip(*rows, strict=True) if rows else ((), (), ())
        return cls(a, low, high, np.array(k, float), np.array(error, float), np.array(parity, "U2"),
                   tuple(parts))  # fmt: skip

    def __len__(self) -> int:
        return len(self.k)

    def __str__(self) -> str:
        of = "" if len(self.parities) == len(Parity) else f" {', '.join(self.parities)}"
        levels = several(len(self), "level")
        return f"<{levels}{of} from k = {self.low:g} to {self.high:g} at a = {format_float(self.a)}>"

    def to_pandas(self) -> "pandas.DataFrame":
        """Return a data frame with the columns ``k``, ``error`` and ``parity``."""
        return data_frame(self._columns_shown())

    def _columns_shown(self) -> dict[str, Any]:
        return {"k": self.k, "error": self.error, "parity": self.parity}

    _FIGURES = ("staircase", "spacings", "rigidity")

    def _drawing(self, name: str) -> tuple[Sequence[Any], str]:
        parts = {parity: self.k[self.parity == parity] for parity in self.parities}
        return (self,) if name == "staircase" else (self.a, parts), str(self).strip("<>")


def levels(
    stadium: Stadium | float,
    k: float | tuple[float, float],
    parity: Sequence[Parity | str] | str | None = None,
) -> Levels:
    """Return all levels of a stadium with low <= k < high.

    Parameters
    ----------
    stadium : Stadium or float
        The stadium or its half length, from `LEAST_A` to `LARGEST_A`.
    k : (float, float) or float
        The range of k, in 1/radius. As in Python's `range`, a single number is the upper end.
    parity : str or sequence of str, optional
        Any of ``ee``, ``eo``, ``oe`` and ``oo``, for even or odd in x and then in y; by default all four.

    Raises
    ------
    InputError
        If the half length or the range is outside the tested limits.
    """
    at, (low, high) = as_stadium(stadium), k_range(k)
    solved: dict[Parity, list[LevelWindow]] = {one: [] for one in parities_of(parity)}
    for task in in_order(task for one in solved for task in level_tasks(at, one, low, high)):
        solved[task.parity].append(task.solved())
    return Levels.joined(at.a, low, high, solved)
