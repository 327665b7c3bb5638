"""Identify orbits by a trajectory that follows them, or by their length."""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import starmap
from typing import TYPE_CHECKING, Any, ClassVar

from orbitdb.answers.completeness import Coverage, complete_length, describe_fills
from orbitdb.arrays import Floats
from orbitdb.billiard.stadium import Stadium
from orbitdb.display import Record, Rows, data_frame
from orbitdb.errors import InputError, check_int, check_number
from orbitdb.orbits.orbit import Orbit
from orbitdb.orbits.shadowing import shadows
from orbitdb.orbits.status import Status
from orbitdb.selection import Selection
from orbitdb.store.lookup import orbits_of_length
from orbitdb.store.sqlite import Connection
from orbitdb.symbols.words import to_strings
from orbitdb.text import format_float, several
from orbitdb.trajectories.trajectory import BOUNCES, trace_points, trace_start

if TYPE_CHECKING:
    import pandas

NEAR = 1e-2
"""Default tolerance for the distance between a bounce and that of an orbit, in units of the radius."""

SAME_LENGTH = 1e-3
"""Default tolerance for a length, in units of the radius."""

SHOWN = 10
"""Default number of shadowed orbits to report."""

SHADOWED = (
    "code", "p", "status", "first", "last", "bounces", "turns", "distance", "length", "lambda_d", "lyapunov",
    "representative", "class_size", "a", "stored", "sequence", "sequence_first",
)  # fmt: skip
"""The columns of a table of shadowed orbits."""

_LEAST_LENGTH = 4.0
"""Lower bound on the length of every orbit; the word 13, for example, has length 4 (1 + a)."""

_MOST_TOLERANCE = 1.0
_MOST_LENGTH = 1e12
_ALL = 2**63 - 1
"""SQLite's largest integer."""


@dataclass(frozen=True)
class Followed:
    """An orbit, and the stretch of a trajectory that follows it.

    Attributes
    ----------
    orbit : Orbit
        The orbit, rotated so that it begins with the first bounce of the stretch.
    first : int
        Number of this first bounce on the trajectory.
    bounces : int
        Number of successive bounces within the tolerance.
    distance : float
        Smallest distance between a bounce and that of the orbit, in units of the radius.
    """

    orbit: Orbit
    first: int
    bounces: int
    distance: float

    @property
    def last(self) -> int:
        """Number of the last bounce of the stretch."""
        return self.first + self.bounces - 1

    @property
    def turns(self) -> float:
        """Number of times that the stretch goes round the orbit."""
        return self.bounces / self.orbit.p


@dataclass(frozen=True, eq=False, repr=False)
class Trajectory:
    """The symbols of a trajectory, and the periodic orbits that it shadows.

    Attributes
    ----------
    columns : tuple of str
        The columns of `rows`.
    sequence : str
        The symbols of the bounces, in order; this is not a cyclic word.
    first : int
        Number of the first bounce; 1 is the first after the start, or the first point.
    points : ndarray, shape (T, 2)
        Positions of the bounces, from the middle of the stadium, in units of the radius.
    shadowed : tuple of Followed
        The shadowed orbits up to the limit; those that the trajectory goes round most often come first.
    total : int
        Number of all shadowed orbits, including those beyond the limit.
    notes : tuple of str
        How far the trajectory could be followed, and why no orbit was found; one line each.
    """

    columns: ClassVar[tuple[str, ...]] = SHADOWED
    sequence: str
    first: int
    points: Floats
    shadowed: tuple[Followed, ...]
    total: int
    notes: tuple[str, ...] = ()

    def __repr__(self) -> str:
        bounces, orbits = several(len(self.sequence), "bounce"), several(self.total, "orbit")
        return f"<{bounces} from number {self.first} on: {orbits} shadowed, {len(self.shadowed)} listed>"

    def rows(self, names: Sequence[str] = SHADOWED) -> Iterator[tuple[Any, ...]]:
        """Yield the named columns of each shadowed orbit."""
        for stretch in self.shadowed:
            yield tuple(self._value(stretch, name) for name in names)

    def _value(self, stretch: Followed, name: str) -> Any:
        if name == "sequence_first":
            return self.first
        return getattr(next(each for each in (stretch, stretch.orbit, self) if hasattr(each, name)), name)

    def to_pandas(self) -> "pandas.DataFrame":
        """Return the shadowed orbits as a data frame (extra ``pandas``)."""
        return data_frame(self.rows(), SHADOWED)


@dataclass(frozen=True)
class Candidate(Record):
    """A symmetry class of stored orbits that matches a given length after r traversals.

    Attributes
    ----------
    code : str
        The representative of the class.
    p, class_size : int
        Period, and number of cyclic words in the class.
    repetitions : int
        The number r of traversals.
    length, length_error, lyapunov : float
        Values for one traversal; ``length_error`` is None for orbits from the paper's relaxation.
    difference : float
        r times the length, minus the given length.
    """

    code: str
    p: int
    class_size: int
    repetitions: int
    length: float
    length_error: float | None
    lyapunov: float
    difference: float

    @property
    def total(self) -> float:
        """The length of r traversals."""
        return self.repetitions * self.length


class Candidates(Rows[Candidate]):
    """The stored orbits with a given length, the closest matches first.

    Attributes
    ----------
    notes : tuple of str
        What is not filled, and the nearest orbit if none has this length; one line each.
    among : str
        The periods that were searched; '' if nothing is stored.
    complete : bool
        Whether it is proved that the file lacks no orbit of such a length.
    """

    notes: tuple[str, ...] = ()
    among: str = ""
    complete: bool = False

    def describe(self, more: str = "") -> str:
        """Return a line with the number of orbits, followed by `more`, and of what was searched."""
        count = several(len(self), "candidate") if self else "no candidates"
        beyond = (
            "complete, by proof" if self.complete else "orbits of longer periods may have this length, too"
        )
        return f"{count} among {self.among}, one per symmetry class{more}; {beyond}" if self.among else ""


def identify_trajectory(
    stadium: Stadium,
    find: Callable[[str], Orbit],
    start: Sequence[float] | None = None,
    points: Any = None,
    tolerance: float | None = None,
    bounces: int | None = None,
    limit: int | None = None,
) -> Trajectory:
    """Find the orbits that a trajectory shadows, from its symbols (`Catalogue.identify`)."""
    if (start is None) == (points is None):
        raise InputError("give one of start, points and length")
    near = _measure("tolerance", NEAR if tolerance is None else tolerance, _MOST_TOLERANCE)
    most = _count(SHOWN if limit is None else limit)
    if start is not None:
        each_way = None if bounces is None else check_int("bounces", bounces, 0)
        path = trace_start(stadium, start, near, each_way)
    elif bounces is not None:
        raise InputError("give a number of bounces with a start, not with points")
    else:
        path = trace_points(stadium, points, near)
    orbits = shadows(stadium, path.symbols, path.points, near, whole=start is None)
    shadowed = tuple(
        Followed(find(orbit.word), path.first + orbit.first, orbit.bounces, orbit.distance)
        for orbit in orbits[:most]
    )
    sequence = to_strings(path.symbols[None])[0] if len(path) else ""
    ends = "" if start is None else _followed(path.first, len(path), bounces)
    turns = "" if start is None else _turned(start[2])
    notes = tuple(filter(None, (turns, ends, "" if orbits else _unshadowed(sequence))))
    return Trajectory(sequence, path.first, path.points, shadowed, len(orbits), notes)


def _followed(first: int, count: int, asked: int | None) -> str:
    """Return a note if a trajectory could not be followed for the requested number of bounces, or ''."""
    last, wanted = first + count - 1, asked or BOUNCES
    if last >= wanted and first <= 1 - wanted:
        return ""
    return f"followed from bounce {first} to {last}; double precision does not determine the rest"


def _turned(angle: float) -> str:
    """Return a note if an angle may be in degrees, or ''."""
    if abs(angle) <= 2 * math.pi:
        return ""
    degrees = f"{angle:g} degrees are {math.radians(angle):.6g}"
    return f"the angle {angle:g} is beyond 2 pi: angles are in radians; {degrees}"


def _unshadowed(sequence: str) -> str:
    """Return a note about a trajectory that shadows no orbit."""
    if sequence and set(sequence) <= {"0", "2"}:
        return "no orbit: the trajectory bounces between the straight walls, like the bouncing-ball family 02"
    return "no orbit is shadowed for two bounces or more; a larger tolerance finds orbits farther away"


def read_candidates(
    connection: Connection, a: float, length: float, tolerance: float | None, limit: int | None = None
) -> Candidates:
    """Return the stored orbits with a given length, and what was searched (`Catalogue.identify`)."""
    found = Candidates(identify_length(connection, a, length, tolerance, limit))
    coverage = Coverage(connection, Selection(a, statuses=(Status.ORBIT,)))
    fills, notes = coverage.fills, coverage.gaps()
    for orbit in () if found else identify_length(connection, a, length, 1.0, 1):
        times = f"{orbit.repetitions} x {orbit.code}" if orbit.repetitions > 1 else orbit.code
        enough = float(f"{1.05 * abs(orbit.difference):.2g}")
        notes.append(
            f"the nearest orbit is {times} of length {orbit.total:.7f}: `tolerance={enough:g}` finds it"
        )
    found.notes = tuple(notes)
    farthest = length + (SAME_LENGTH if tolerance is None else tolerance)
    found.complete = farthest < (complete_length(fills, Selection(a)) or 0)
    if fills or found:  # otherwise, a note says that nothing was searched
        found.among = describe_fills(fills, a) if fills else f"single words at a = {format_float(a)}"
    return found


def identify_length(
    connection: Connection, a: float, length: float, tolerance: float | None, limit: int | None = None
) -> Rows[Candidate]:
    """Find the stored orbits that have a given length after one or more traversals (`Catalogue.identify`).

    The error bounds of stored lengths are added to the tolerance, so that no orbit is lost to rounding. The
    tolerance is at most a quarter of the smallest length, so the number of traversals is unique.
    """
    wanted = _measure("length", length, _MOST_LENGTH)
    within = _measure(
        "tolerance", SAME_LENGTH if tolerance is None else tolerance, _MOST_TOLERANCE, zero=True
    )
    most = _ALL if limit is None else _count(limit)
    found = orbits_of_length(connection, a, wanted, within + 4 * math.ulp(wanted), _LEAST_LENGTH, most)
    return Rows(starmap(Candidate, found))


def _measure(name: str, value: float, most: float, zero: bool = False) -> float:
    check_number(name, value)
    if not (0 < value <= most or (zero and value == 0)):
        least = "0" if zero else "0 (excluded)"
        raise InputError(f"{name} {value!s:.40}: give a number from {least} to {most:g}")
    return float(value)


def _count(limit: int) -> int:
    return min(check_int("limit", limit, 0), _ALL)
