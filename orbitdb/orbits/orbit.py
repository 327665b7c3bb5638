"""Orbits: what is known of a batch of words, as a structure of arrays."""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from enum import StrEnum
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from orbitdb.billiard.stadium import Stadium
from orbitdb.equality import ByValue
from orbitdb.extras import load
from orbitdb.symbols.words import from_strings

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Floats = NDArray[np.float64]

NUMBERS = ("length", "lyapunov", "margin", "residual", "error", "length_error", "lyapunov_error")
"""The columns of `Orbits` that hold one number a word."""


class Status(StrEnum):
    """What became of a word."""

    ORBIT = "orbit"
    GEOMETRIC = "geometric"
    DYNAMICAL = "dynamical"
    BOUNDARY = "boundary"
    FAMILY = "family"
    UNRESOLVED = "unresolved"

    @property
    def sentence(self) -> str:
        """The status in words."""
        return _SENTENCES[self]


_SENTENCES = {
    Status.ORBIT: "an unstable periodic orbit",
    Status.GEOMETRIC: "geometrically pruned: no orbit at any a",
    Status.DYNAMICAL: "dynamically pruned: its fixed point leaves the stadium at this a",
    Status.BOUNDARY: "runs exactly through a joint of wall and semicircle: not counted",
    Status.FAMILY: "the bouncing-ball family: marginal and not isolated, so never counted",
    Status.UNRESOLVED: "not decided",
}


STORED = tuple(status for status in Status if status is not Status.FAMILY)
"""Statuses that rows of a catalogue have."""

EXISTING = (Status.ORBIT.value, Status.BOUNDARY.value)
"""Statuses of words that have coordinates, length and lambda."""


def finite(number: np.float64) -> float | None:
    """Return a number as a plain float, None where it is not finite."""
    return float(number) if np.isfinite(number) else None


@dataclass(frozen=True, eq=False)
class Orbits(ByValue):
    """N words of one order p and the stationary points of their length.

    Attributes
    ----------
    words : ndarray of uint8, shape (N, p)
        Admissible words.
    status : ndarray of str, shape (N,)
        Values of `Status`.
    coordinates : ndarray, shape (N, p)
        x on a straight wall, radians on a semicircle, in the order of the word.
    length, lyapunov : ndarray, shape (N,)
        Total length (units of the radius), and lambda of one traversal.
    margin : ndarray, shape (N,)
        Least distance of a bounce from the end of its wall or semicircle, negative outside.
    residual : ndarray, shape (N,)
        Largest violation of the law of reflection at a bounce, in cosines.
    error, length_error, lyapunov_error : ndarray, shape (N,)
        Bounds on the error of every coordinate, of the length and of lambda.
    iterations : ndarray of int, shape (N,)
        Steps the solver took.
    """

    words: NDArray[np.uint8]
    status: NDArray[np.str_]
    coordinates: Floats
    length: Floats
    lyapunov: Floats
    margin: Floats
    residual: Floats
    error: Floats
    length_error: Floats
    lyapunov_error: Floats
    iterations: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.words)

    @classmethod
    def empty(cls, words: NDArray[np.uint8]) -> "Orbits":
        """Return the words with nothing known of them yet: unresolved, all numbers NaN."""
        n, p = words.shape
        return cls(
            words=words,
            status=np.full(n, Status.UNRESOLVED.value, dtype="U10"),
            coordinates=np.full((n, p), np.nan),
            iterations=np.zeros(n, np.int64),
            **{name: np.full(n, np.nan) for name in NUMBERS},
        )

    def rows(self, chosen: NDArray[np.intp] | NDArray[np.bool_]) -> "Orbits":
        """Return some of the words."""
        return Orbits(**{each.name: getattr(self, each.name)[chosen] for each in fields(self)})

    def place(self, rows: NDArray[np.intp], part: "Orbits") -> None:
        """Write what a part of the batch has become into the given rows."""
        for name in ("status", "coordinates", "iterations", *NUMBERS):
            getattr(self, name)[rows] = getattr(part, name)


@dataclass(frozen=True, eq=False)
class Orbit(ByValue):
    """One word at one a, and what became of it.

    Attributes
    ----------
    code : str
        The word in the rotation that was asked for.
    representative : str
        The least word of its symmetry class; for a pruned word, its own least rotation.
    a : float
        The stadium.
    status : Status
        What became of the word; the numbers are None where it has none.
    rules : tuple of int
        The geometric rules it breaks.
    time_reversal : str or None
        ``self`` or ``pair``.
    symmetry : str or None
        The elements that map the cyclic word to itself, ``1`` if none does.
    class_size : int or None
        Number of cyclic words in the symmetry class.
    length, lyapunov, margin, residual, error, length_error, lyapunov_error : float or None
        As in `Orbits`.
    coordinates : ndarray, shape (p,), or None
        In the order of ``code``; they cannot be written to, so that an orbit may be a key.
    solver : str or None
        ``newton``, or ``relaxation`` for the paper's method; None for a word that is not solved.
    stored : bool
        Whether it comes from a catalogue or was solved on the spot.
    exists : tuple of (float, float or None), or None
        From where to where in a it is an orbit, if the catalogue it comes from has the births of its
        period, or `orbitdb.solve_word` was asked for it.
    """

    code: str
    representative: str
    a: float
    status: Status
    rules: tuple[int, ...] = ()
    time_reversal: str | None = None
    symmetry: str | None = None
    class_size: int | None = None
    length: float | None = None
    lyapunov: float | None = None
    margin: float | None = None
    residual: float | None = None
    error: float | None = None
    length_error: float | None = None
    lyapunov_error: float | None = None
    coordinates: Floats | None = None
    solver: str | None = None
    stored: bool = False
    exists: tuple[tuple[float, float | None], ...] | None = None

    def __post_init__(self) -> None:
        if self.coordinates is not None:
            locked = self.coordinates.view()
            locked.flags.writeable = False
            object.__setattr__(self, "coordinates", locked)

    def __setstate__(self, state: Mapping[str, Any]) -> None:
        self.__dict__.update(state)
        self.__post_init__()  # an array is loaded as one that can be written to

    @property
    def p(self) -> int:
        """The period: the number of bounces."""
        return len(self.code)

    @property
    def lambda_d(self) -> float | None:
        """Lambda per bounce."""
        return None if self.lyapunov is None else self.lyapunov / self.p

    @property
    def lambda_c(self) -> float | None:
        """Lambda per unit of length."""
        return None if self.lyapunov is None or self.length is None else self.lyapunov / self.length

    @property
    def points(self) -> Floats | None:
        """The bounces in Cartesian coordinates, shape (p, 2), None where it has no coordinates."""
        if self.coordinates is None:
            return None
        return Stadium(self.a).points(from_strings([self.code])[0], self.coordinates)

    def _repr_svg_(self) -> str | None:
        """Draw the orbit in its stadium, for notebooks; None where there is nothing that could be seen."""
        from orbitdb.orbits import svg

        if self.points is None or self.p > svg.MOST_BOUNCES:
            return None
        return svg.orbit_svg(Stadium(self.a), self.points, f"The orbit {self.code} at a = {self.a:g}")

    def plot(self, ax: "Axes | None" = None) -> "Axes":
        """Draw the orbit in its stadium with matplotlib, as in the paper's Fig. 1.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Where to draw; by default in a new figure.

        Returns
        -------
        matplotlib.axes.Axes

        Raises
        ------
        ValueError
            If it has no coordinates.
        ModuleNotFoundError
            If matplotlib is not installed (extra ``plot``).
        """
        points = self.points
        if points is None:
            raise ValueError(f"{self.code:.40} at a = {self.a:g} cannot be drawn: {self.status.sentence}")
        axes = load("orbitdb.plots.axes", "plot()", "plot")
        return axes.orbit_axes(self.code, Stadium(self.a), points, ax)
