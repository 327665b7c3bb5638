"""Words in a magnetic field: `Catalogue.field`."""

import math
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from orbitdb.answers.field_words import MOST, PickedWords, followable, whole_periods
from orbitdb.answers.results import Result
from orbitdb.arrays import Floats, Integers, Marks, Texts, Words
from orbitdb.averages.by_period import of_divisors
from orbitdb.billiard.stadium import ANTICLOCKWISE, Stadium
from orbitdb.display import MOST_SHOWN, Drawn, Table, columns_of, data_frame
from orbitdb.errors import InputError, as_floats
from orbitdb.magnetic.action import ArcPaths
from orbitdb.magnetic.along_kappa import follow_in_field
from orbitdb.magnetic.both_senses import BothSenses
from orbitdb.magnetic.field_status import IN_FIELD, FieldStatus, measure
from orbitdb.orbits.admissible import solve_in_doubles
from orbitdb.progress import Tell, nobody
from orbitdb.selection import Selection
from orbitdb.symbols.plane import symbol_plane
from orbitdb.symbols.words import from_strings, to_strings
from orbitdb.text import format_float, several

if TYPE_CHECKING:
    import pandas

FIELD_COLUMNS = (
    "code", "p", "a", "kappa", "status", "action", "length", "area", "lyapunov", "trace", "splitting",
    "residual",
)  # fmt: skip
"""The columns of the entries, which are also their JSON keys."""

_CHECKED_A, _CHECKED = 1.6, ((0.1, 8), (0.2, 6))
"""Half length, and the largest curvatures and highest periods up to which random searches found no further
words."""

_NAMED = 4
"""Number of curvatures to name in a title."""


@dataclass(frozen=True, eq=False, repr=False)
class FieldOrbits(Table, Drawn):
    """Words in a magnetic field, as arrays with one entry per word and curvature.

    The numbers are computed in doubles, without error bounds; they are NaN for words that are not orbits.
    `plot` draws the actions against the curvature.

    Attributes
    ----------
    columns : tuple of str
        The columns of the entries, which are also their JSON keys.
    selection : Selection
        What was chosen.
    code, status : ndarray of str, shape (N,)
        The words, and values of `orbitdb.magnetic.field_status.FieldStatus`.
    p : ndarray of int, shape (N,)
        Periods.
    kappa : ndarray, shape (N,)
        Curvatures of the path, 1 / (cyclotron radius), in 1/radius; positive if it turns left.
    action, length, area : ndarray, shape (N,)
        S = L - kappa A and L, in units of the radius, and the area A that one traversal encloses,
        anticlockwise positive, in radius^2.
    lyapunov, trace : ndarray, shape (N,)
        Lambda and the trace of the monodromy matrix, for one traversal; lambda is 0 for an elliptic orbit.
    splitting : ndarray, shape (N,)
        Action of the reverse minus that of the word, in units of the radius, 2 kappa A to first order; NaN
        unless both are orbits.
    residual : ndarray, shape (N,)
        Largest violation of the law of reflection at a bounce, as a difference of cosines.
    least_sine : ndarray, shape (N,)
        Smallest sine of an angle between a path and the boundary at a bounce. Not a column. The residual does
        not see a bounce along the boundary, because the cosine has its extremum there.
    periods : tuple of int
        The periods whose words are all here; empty if the words were not chosen by period alone.
    notes : tuple of str
        What limits the list and its numbers, one line each.

    Examples
    --------
    >>> orbits = catalogue.field(0.05, p="2-8")
    >>> print(orbits)
    <3197 words of period 2 to 8 at a = 1.6, kappa = 0.05: 2084 orbits>
    >>> orbits.counts()["N_c"][-1]
    1375
    """

    _FIGURES: ClassVar[tuple[str, ...]] = ("field",)

    columns: ClassVar[tuple[str, ...]] = FIELD_COLUMNS
    selection: Selection
    code: Texts
    p: Integers
    kappa: Floats
    status: Texts
    action: Floats
    length: Floats
    area: Floats
    lyapunov: Floats
    trace: Floats
    splitting: Floats
    residual: Floats
    least_sine: Floats
    periods: tuple[int, ...] = ()
    notes: tuple[str, ...] = ()

    def __len__(self) -> int:
        return len(self.code)

    def __str__(self) -> str:
        subject = self.selection.describe(count=len(self) // max(len(self.kappas), 1))
        values = ", ".join(map(format_float, self.kappas[:_NAMED])) + ", ..." * (len(self.kappas) > _NAMED)
        return f"<{subject}, kappa = {values}: {several(int(self.exists.sum()), 'orbit')}>"

    def _columns_shown(self) -> dict[str, Sequence[Any]]:
        return {name: getattr(self, name)[:MOST_SHOWN].tolist() for name in FIELD_COLUMNS}

    @property
    def a(self) -> Floats:
        """Half lengths of the stadium, all the same, shape (N,)."""
        return np.full(len(self), self.selection.a)

    @property
    def kappas(self) -> list[float]:
        """The different curvatures in ascending order, in 1/radius."""
        values: list[float] = np.unique(self.kappa).tolist()
        return values

    @property
    def exists(self) -> Marks:
        """Which entries are orbits, unstable or stable, shape (N,)."""
        return np.isin(self.status, IN_FIELD)

    @property
    def points(self) -> list[Floats | None]:
        """Cartesian coordinates of the bounces: N arrays of shape (p, 2), or None where there is no orbit.

        The bounces are in the order of the code; the unit is the radius.
        """
        return [None if of_entry is None else of_entry[0] for of_entry in self._bounces]

    @property
    def sine(self) -> list[Floats | None]:
        """Sines of the angles between path and normal at the bounces: N arrays of shape (p,), or None.

        They are those of the path that leaves, and positive if it goes anticlockwise, as in `Orbit.sine`.
        """
        return [None if of_entry is None else of_entry[1] for of_entry in self._bounces]

    @cached_property
    def _bounces(self) -> list[tuple[Floats, Floats, Floats] | None]:
        """Points, sines and coordinates of each entry, from following the orbits again."""
        stadium = Stadium(self.selection.a)
        bounces: list[tuple[Floats, Floats, Floats] | None] = [None] * len(self)
        for p in np.unique(self.p[self.exists]).tolist():
            rows = np.flatnonzero(self.exists & (self.p == p))
            words, kappa = from_strings(self.code[rows].tolist()), self.kappa[rows]
            free = solve_in_doubles(words, stadium).coordinates
            followed = follow_in_field(stadium, words, free, np.zeros(len(rows)), kappa)
            paths = ArcPaths.of(stadium, words.T, followed.coordinates.T, kappa)
            points, sines = np.stack([paths.x.T, paths.y.T], -1), ANTICLOCKWISE[words] * paths.outgoing.T
            of_entries = zip(points, sines, followed.coordinates, strict=True)
            for row, of_entry in zip(rows.tolist(), of_entries, strict=True):
                bounces[row] = of_entry
        return bounces

    def by_bounce(self) -> Iterator[tuple[Any, ...]]:
        """Yield code, kappa and the columns of `query --by-bounce` for each bounce of the orbits."""
        stadium = Stadium(self.selection.a)
        entries = zip(self.code.tolist(), self.kappa.tolist(), self._bounces, strict=True)
        for code, kappa, of_entry in entries:
            if of_entry is not None:
                points, sine, coordinates = of_entry
                symbols = from_strings([code])[0]
                columns = (symbols, coordinates, *points.T, stadium.arclength(symbols, coordinates), sine,
                           *symbol_plane(symbols[None])[0].T)  # fmt: skip
                rows = zip(*(column.tolist() for column in columns), strict=True)
                yield from ((code, kappa, number, *row) for number, row in enumerate(rows, 1))

    def rows(self, names: Sequence[str] = FIELD_COLUMNS) -> Iterator[tuple[Any, ...]]:
        """Yield the named columns of each entry as plain values; missing numbers are None."""
        columns = (getattr(self, name).tolist() for name in names)
        return zip(*([None if value != value else value for value in column] for column in columns),
                   strict=True)  # fmt: skip

    def to_pandas(self) -> "pandas.DataFrame":
        """Return a pandas data frame (extra ``pandas``) with the columns of the JSON output."""
        columns = {name: getattr(self, name) for name in FIELD_COLUMNS}
        return data_frame(columns, selection=self.selection.describe())

    def counts(self) -> Result:
        """Return the numbers of orbits by period, and the entropy K_0, as in the paper's Table 1.

        The columns are p, N_c, elliptic (the stable ones among N_c), N and K_0; with several curvatures, the
        first is kappa. Periods that N needs are followed, too.

        Raises
        ------
        InputError
            If the words were chosen by anything but periods.
        """
        if not self.periods:
            raise InputError("counts are of whole periods: choose the words by p and a alone")
        lower = sorted(set().union(*map(of_divisors, self.periods)).difference(self.periods))
        tally = self._tally()
        if lower:
            tally += follow_words(whole_periods(self.selection, lower), self.kappas)._tally()

        def orbits(kappa: float, p: int) -> int:
            return sum(tally[kappa, p, status] for status in IN_FIELD)

        rows = []
        for kappa, p in product(self.kappas, self.periods):
            points = sum(d * orbits(kappa, d) for d in of_divisors(p))
            stable = tally[kappa, p, FieldStatus.ELLIPTIC.value]
            rows.append(
                (kappa, p, orbits(kappa, p), stable, points, math.log(points) / p if points else None)
            )
        names = ("kappa", "p", "N_c", "elliptic", "N", "K_0")
        columns = columns_of(names, rows)
        if len(self.kappas) == 1:
            del columns["kappa"]
        return Result(self.selection, columns, (self.selection.describe(),), self.notes)

    def _tally(self) -> "Counter[tuple[float, int, str]]":
        return Counter(zip(self.kappa.tolist(), self.p.tolist(), self.status.tolist(), strict=True))

    def _drawing(self, name: str) -> tuple[Sequence[Any], str]:
        if len(self.kappas) < 2 or not self.exists.any():
            raise InputError(f"{self} cannot be drawn: follow orbits to several kappa")
        return (self,), self.selection.describe(count=len(self) // len(self.kappas))


def curvatures(values: Any, a: float) -> Floats:
    """Return curvatures, shape (K,), given as one number or several.

    Raises
    ------
    InputError
        If one of them is not a number, or so large that an orbit might need more than half a circle.
    """
    kappa = np.unique(as_floats(values, "kappa: give one number, or a list of numbers"))
    if np.isnan(kappa).any():
        raise InputError("kappa = nan: give one number, such as 0.05, or a list of numbers")
    if not len(kappa):
        raise InputError("give at least one kappa, such as 0.05")
    largest = kappa[np.argmax(np.where(np.isfinite(kappa), np.abs(kappa), np.inf))]
    if not abs(largest) * (a + 1) < 1:
        raise InputError(
            f"kappa = {largest:g}: the circles' diameter 2/kappa must be above the longest chord, "
            f"{format_float(2 * a + 2)} at a = {format_float(a)}: give a kappa below {1 / (a + 1):.5g}"
        )
    return kappa


def follow_words(picked: PickedWords, kappa: Any, tell: Tell = nobody) -> FieldOrbits:
    """Follow words from kappa = 0 to one or several curvatures (`Catalogue.field`)."""
    stadium = Stadium(picked.selection.a)
    kappas = curvatures(kappa, stadium.a)
    total = sum(len(rows) for rows, _ in picked.batches)
    if total * len(kappas) > MOST:
        raise InputError(
            f"{total} words at {len(kappas)} curvatures are more than {MOST} entries: choose fewer"
        )
    places, parts, done = [np.zeros(0, np.intp)], [_NO_WORDS], 0
    for rows, words in picked.batches:
        tell(done, total, f"period {words.shape[1]}")
        parts.append(_follow_period(stadium, words, kappas))
        places.append((rows[:, None] * len(kappas) + np.arange(len(kappas))).ravel())
        done += len(rows)
    order = np.argsort(np.concatenate(places))
    columns: dict[str, Any] = {
        name: np.concatenate([part[name] for part in parts])[order] for name in parts[0]
    }
    orbits = FieldOrbits(picked.selection, **columns, periods=picked.periods)
    return replace(orbits, notes=(*picked.notes, *_notes(orbits)))


def follow_word(word: str, a: float, kappa: float) -> tuple[FieldStatus, ArcPaths]:
    """Return the status of one word at a curvature, and its path, for figures."""
    stadium, words, at = Stadium(a), from_strings([followable(word, a)]), curvatures(kappa, a)
    followed = follow_in_field(stadium, words, solve_in_doubles(words, stadium).coordinates, np.zeros(1), at)
    status = FieldStatus(str(measure(stadium, words, followed, at).status[0]))
    return status, ArcPaths.of(stadium, words.T, followed.coordinates.T, at)


_TANGENT = 1e-4
"""Sine of the angle between a path and the boundary below which the residual says little about a bounce."""

_NO_WORDS: dict[str, Any] = {
    name: np.zeros(
        0, {"code": np.dtypes.StringDType(), "status": np.dtypes.StringDType(), "p": np.int64}.get(name)
    )
    for name in (*FIELD_COLUMNS, "least_sine")
    if name != "a"
}
"""The columns of no words."""


def _follow_period(stadium: Stadium, words: Words, kappas: Floats) -> dict[str, Any]:
    """Follow words of one period, shape (N, p), to K curvatures; return the columns, shape (N K,)."""
    senses = BothSenses.of(words)
    numbers = senses.follow(stadium, solve_in_doubles(senses.least, stadium).coordinates, kappas)
    names = numbers[kappas[0]]
    columns = {name: np.stack([numbers[at][name] for at in kappas.tolist()], 1).ravel() for name in names}
    texts = np.dtypes.StringDType()
    return columns | {
        "code": np.repeat(np.array(to_strings(words), texts), len(kappas)),
        "p": np.full(len(words) * len(kappas), words.shape[1]),
        "kappa": np.tile(kappas, len(words)),
        "status": columns["status"].astype(texts),
    }


def _notes(orbits: FieldOrbits) -> Iterator[str]:
    """Yield what limits a list of words in a field, and their numbers."""
    statuses = orbits.status.tolist()
    if lost := statuses.count(FieldStatus.UNRESOLVED):
        yield f"{several(lost, 'row is', 'rows are')} unresolved: these words could not be followed to kappa"
    if stable := statuses.count(FieldStatus.ELLIPTIC):
        yield (
            f"{several(stable, 'orbit is', 'orbits are')} stable (elliptic): near a stable orbit, the "
            "averages of the paper's eqs. (6) and (7) do not hold"
        )
    if tangent := int((orbits.least_sine < _TANGENT).sum()):
        yield (
            f"{several(tangent, 'row has', 'rows have')} a bounce along the boundary, sin theta < "
            f"{_TANGENT:g}: rounding decides the status, and the residual does not see the angle"
        )
    if orbits.periods and not (
        orbits.selection.a == _CHECKED_A
        and any(max(map(abs, orbits.kappas)) <= kappa and max(orbits.periods) <= p for kappa, p in _CHECKED)
    ):
        ranges = ", or ".join(f"up to p = {p} and kappa = {kappa}" for kappa, p in _CHECKED)
        yield (
            "some words may be missing: in a strong field, there are orbits not connected with kappa = 0 "
            f"(at a = {_CHECKED_A}, none was found {ranges})"
        )
    if np.any(orbits.kappa):
        yield (
            "computed in doubles, without proof or error bounds; each word is followed from kappa = 0 to a "
            "single orbit, although it may have several"
        )
