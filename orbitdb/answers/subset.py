"""`Subset`: chosen words as arrays."""

from collections.abc import Iterator, Sequence
from dataclasses import MISSING, dataclass, fields, replace
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, overload

import numpy as np
from numpy.typing import NDArray

from orbitdb.answers.results import MOST_ROWS, html_of_orbits
from orbitdb.arrays import Floats, Integers, Texts, Values
from orbitdb.billiard.stadium import Stadium
from orbitdb.columns import WRITTEN, kind_of
from orbitdb.display import MOST_SHOWN, Drawn, Table, load
from orbitdb.errors import InputError, SelectionError
from orbitdb.magnetic.action import area_slopes
from orbitdb.orbits.orbit import Orbit, error_of_quotient, pruned_word
from orbitdb.orbits.orbits import NUMBERS, finite
from orbitdb.orbits.status import EXISTING, Status
from orbitdb.output_files import arrow_batch, arrow_schema
from orbitdb.selection import Selection
from orbitdb.store.file import reading
from orbitdb.store.lookup import Lives, coordinates_of, find_or_solve, lives_of
from orbitdb.store.select import COORDINATES, WORDS
from orbitdb.store.sqlite import Connection
from orbitdb.store.tables import readable
from orbitdb.symbols.pruning import rules_of
from orbitdb.symbols.symmetry import AXIS, QUARTER_SIGNS, half_of
from orbitdb.symbols.words import WordError, from_strings, key, least_rotation, parse
from orbitdb.text import several

if TYPE_CHECKING:
    import pandas
    import pyarrow

    from orbitdb.answers.complete_periods import CompletePeriods
    from orbitdb.answers.results import Result

_BLOCK = 1 << 14
_SHOWN = ("code", "p", "status", "length", "lyapunov", "lambda_d", "lambda_c", "class_size")
"""The columns shown at the prompt."""
_SHARED_TEXTS = ("representative", "time_reversal", "symmetry", "solver")


@dataclass(frozen=True, eq=False, repr=False)
class Subset(Table, Drawn):
    """The chosen words as arrays with one entry per word; missing numbers are NaN.

    `plot` draws the bounces in phase space (``phase-space``, as by default), the number of orbits up to each
    length (``lengths``), or each orbit in a picture of its own (``sheet``).

    Attributes
    ----------
    selection : Selection
        What was chosen; ``selection.describe()`` puts it into words.
    code, status : ndarray of str, shape (N,)
        Least rotations, and values of `Status`.
    representative, time_reversal, symmetry, solver : ndarray of str, shape (N,)
        The class's least word, ``self`` or ``pair``, the symmetry label, and ``newton`` or
        ``relaxation``; empty for geometrically pruned words, which have no class.
    p, class_size, walls : ndarray of int, shape (N,)
        Period, number of words in the symmetry class, and number of straight bounces; the last two are 0 for
        words without a class.
    length, lyapunov, margin, residual, error, length_error, lyapunov_error, area, area_error : ndarray, (N,)
        As in `Orbits`; length and margin in units of the radius, the enclosed area in radius^2.
    born, dies : ndarray, shape (N,)
        The values of a at the first birth and death; NaN for a word without one, and in the periods whose
        births are not stored, which `notes` names.
    element, cycle : ndarray of int, shape (N,)
        The symmetry that maps the representative to the word, and the id of the class in the file; 0 for
        words without a class.
    words : ndarray of int, shape (N,)
        Number of words that an entry stands for: 1, or with ``classes`` the chosen words of its class.
    coordinates : ndarray, shape (sum of p,), or None
        Coordinates of all words, one word after another (see `of_period`), if you asked for them; NaN for
        words that have none. `of_period`, `coordinates_of` and `plot` read them when they are needed.
    unfilled : str or None
        A line that names the chosen periods that are not filled or lack births.
    notes : tuple of str
        Which a was taken if none was named, and what is missing: partial or unfilled periods, and births.
    filled : tuple of int
        The chosen periods that are completely filled, and whose births are stored if the choice depends on
        them; averages use only these.
    total : int or None
        Number of all chosen words if the subset is only a part of them, else None.
    path : Path or None
        The file that the rows were read from; orbits read their coordinates there when asked.
    by_class : bool
        Whether each entry stands for a class; these have no counts or averages by period.
    cut : bool
        Whether a limit left out some of the chosen words; what is left has none, either.

    Examples
    --------
    >>> subset = catalogue.select(p="2-4", status="orbit", order="length")
    >>> print(subset)
    <41 orbits of period 2 to 4 at a = 1.6>
    >>> subset[:2]
    <2 of 41 orbits of period 2 to 4 at a = 1.6>
    code  p  status   length  lyapunov  lambda_d  lambda_c  class_size
    13    2  orbit      10.4    4.2275   2.11375   0.40649           1
    013   3  orbit   10.8507   4.39285   1.46428  0.404846           4
    >>> subset[0].code, "31" in subset
    ('13', True)
    >>> subset[subset.length > 12].code.tolist()[:2]
    ['1155', '3344']
    """

    _FIGURES: ClassVar[tuple[str, ...]] = ("phase-space", "lengths", "sheet")

    selection: Selection
    code: Texts
    p: Integers
    status: Texts
    representative: Texts
    time_reversal: Texts
    symmetry: Texts
    solver: Texts
    class_size: Integers
    walls: Integers
    length: Floats
    lyapunov: Floats
    margin: Floats
    residual: Floats
    error: Floats
    length_error: Floats
    lyapunov_error: Floats
    area: Floats
    area_error: Floats
    born: Floats
    dies: Floats
    element: Integers
    cycle: Integers
    words: Integers
    coordinates: Floats | None = None
    unfilled: str | None = None
    notes: tuple[str, ...] = ()
    filled: tuple[int, ...] = ()
    total: int | None = None
    path: Path | None = None
    by_class: bool = False
    cut: bool = False

    def __len__(self) -> int:
        return len(self.code)

    def __str__(self) -> str:
        part, total = ("", len(self)) if self.total is None else (f"{len(self)} of ", self.total)
        of_classes = f"{several(total, 'class', 'classes')} of {self.selection.describe()}"
        text = part + (of_classes if self.by_class else self.selection.describe(count=total))
        return f"<{'; '.join(filter(None, [text if len(self) or not self.unfilled else '', self.unfilled]))}>"

    def _columns_shown(self) -> dict[str, Sequence[Any]]:
        first = self[:MOST_SHOWN]
        columns = {name: getattr(first, name).tolist() for name in _SHOWN}
        return columns | {"class_size": [size or None for size in columns["class_size"]]}

    def __iter__(self) -> Iterator[Orbit]:
        """Yield each word as an orbit."""
        return map(self._orbit, range(len(self)))

    def __contains__(self, word: object) -> bool:
        """Tell whether the subset contains a word, in any rotation, or an equal orbit."""
        if isinstance(word, Orbit):
            return word in [*self[self.code == word.code]]
        try:
            return isinstance(word, str) and least_rotation(parse(word)) in self.code
        except WordError:
            return False

    @overload
    def __getitem__(self, rows: int | np.integer[Any]) -> Orbit: ...
    @overload
    def __getitem__(self, rows: slice | Sequence[int] | NDArray[Any]) -> "Subset": ...
    def __getitem__(self, rows: Any) -> "Orbit | Subset":
        """Return one word as an orbit, or a subset for a slice, an array of indices or a mask."""
        if isinstance(rows, str):
            raise TypeError(f"rows are indexed by number, not by {rows!r:.40}: ask the catalogue for words")
        if isinstance(rows, np.ma.MaskedArray):
            rows = rows.filled(False) if rows.dtype == np.bool_ else rows.compressed()
        places = np.arange(len(self))[list(rows) if isinstance(rows, tuple) else rows]
        if places.ndim == 0:
            return self._orbit(int(places))
        if np.array_equal(places, np.arange(len(self))):
            return self
        parts: dict[str, Any] = {name: getattr(self, name)[places] for name in ARRAY_FIELDS}
        if self.coordinates is not None:
            of_words = (self.coordinates_of(place) for place in places.tolist())
            parts["coordinates"] = np.concatenate([np.zeros(0), *of_words])
        return replace(self, **parts, total=len(self) if self.total is None else self.total)

    def _orbit(self, n: int) -> Orbit:
        """Return word n as an orbit; coordinates that were not read, and `exists`, are read when asked."""
        word, a = str(self.code[n]), self.selection.a
        if (pruned := pruned_word(word, a)) is not None:
            return replace(pruned, stored=True)
        status = Status(str(self.status[n]))
        coordinates: Any = None
        if status in EXISTING and self.coordinates is not None:
            coordinates = self.coordinates_of(n)
        elif status in EXISTING and self.path is not None:
            coordinates = partial(_read_coordinates, self.path, word, a)
        values: dict[str, Any] = {name: str(getattr(self, name)[n]) for name in _SHARED_TEXTS}
        values |= {name: finite(getattr(self, name)[n]) for name in NUMBERS}
        values |= {"class_size": int(self.class_size[n]), "coordinates": coordinates}
        if self.path is not None:
            values["exists"] = partial(_read_lives, self.path, values["representative"])
        return Orbit(code=word, a=a, status=status, stored=True, **values)

    @property
    def maslov(self) -> Integers:
        """Maslov indices of one traversal, 3p - walls, shape (N,)."""
        return 3 * self.p - self.walls

    @property
    def half(self) -> Texts:
        """The symmetries of the second halves of the orbits (`Orbit.half`), empty if none; shape (N,)."""
        return np.array([half_of(label) or "" for label in self.symmetry.tolist()], np.dtypes.StringDType())

    @property
    def quarter_length(self) -> Floats:
        """Lengths of one traversal in the quarter stadium x, y >= 0, shape (N,)."""
        return self.length / self._parts

    @property
    def quarter_lyapunov(self) -> Floats:
        """Lambda of one traversal in the quarter stadium, shape (N,)."""
        return self.lyapunov / self._parts

    @property
    def quarter_maslov(self) -> Integers:
        """Maslov indices of one traversal in the quarter stadium, shape (N,)."""
        return self.maslov // self._parts

    @property
    def quarter_signs(self) -> Integers:
        """Signs of one traversal in the quarter for the parities ee, eo, oe and oo, shape (N, 4)."""
        return np.array([QUARTER_SIGNS[half or None] for half in self.half.tolist()], np.int64).reshape(-1, 4)

    @property
    def quarter_orientations(self) -> Integers:
        """Numbers of ways to traverse the orbits in the quarter (1 or 2), shape (N,)."""
        return np.where(self.representative == AXIS, 1, self.class_size * self._parts // 4)

    @property
    def _parts(self) -> Integers:
        """Numbers of traversals in the quarter for each in the full stadium: 2 if there is a `half`."""
        return np.where(self.half == "", 1, 2)

    @property
    def lambda_d(self) -> Floats:
        """Lambda per bounce, shape (N,)."""
        return self.lyapunov / self.p

    @property
    def lambda_c(self) -> Floats:
        """Lambda per unit length, in 1/radius, shape (N,)."""
        return self.lyapunov / self.length

    @property
    def lambda_c_error(self) -> Floats:
        """Bounds on the errors of `lambda_c`, shape (N,)."""
        return error_of_quotient(self.lambda_c, self.length, self.lyapunov_error, self.length_error)

    @property
    def area_slope(self) -> Floats:
        """Derivatives of the areas in the curvature (`Orbit.area_slope`), shape (N,)."""
        slopes, stadium = np.full(len(self), np.nan), Stadium(self.selection.a)
        for p in np.unique(self.p).tolist():
            slopes[self.p == p] = area_slopes(stadium, *self.of_period(p))
        return slopes

    @cached_property
    def start(self) -> Integers:
        """Index in ``coordinates`` at which each word begins, and at which the last ends, shape (N + 1,)."""
        return np.concatenate([np.zeros(1, np.int64), np.cumsum(self.p)])

    def coordinates_of(self, n: int) -> Floats:
        """Return the coordinates of word n, shape (p,), in the order of its symbols."""
        return self._every_coordinate[self.start[n] : self.start[n + 1]]

    def of_period(self, p: int) -> tuple[NDArray[np.uint8], Floats]:
        """Return the symbols of all words of one period, and their coordinates, each of shape (N_p, p)."""
        rows = np.flatnonzero(self.p == p)
        places = self.start[rows][:, None] + np.arange(p)
        return from_strings(self.code[rows].tolist()).reshape(-1, p), self._every_coordinate[places]

    @cached_property
    def _every_coordinate(self) -> Floats:
        """The coordinates of all words, read from the file if ``coordinates`` is None."""
        if self.coordinates is not None:
            return self.coordinates
        if self.path is None:
            return np.full(int(self.p.sum()), np.nan)
        with reading(self.path) as connection:
            return self.read_coordinates(connection)

    def read_coordinates(self, connection: Connection) -> Floats:
        """Return the coordinates of all words (see `coordinates`), read from the catalogue."""
        names = ("p", "representative", "code", "element")
        rows = {name: getattr(self, name).tolist() for name in names}
        return coordinates_of(connection, self.selection.a, {**rows, "id": self.cycle.tolist()})

    def _columns(self) -> Iterator[tuple[str, Values]]:
        """Yield the columns of a table, with None where a word without a class has no value.

        They are made one at a time, because together they take as much memory as the subset.
        """
        classless = (self.representative == "").tolist()
        for name in (*WRITTEN, "born", "dies", *[WORDS] * self.by_class):
            if name == "area_slope" and self.coordinates is None:
                continue
            values: Any = getattr(self, name, None)
            kind = kind_of(name)
            if name == "rules":
                pairs = zip(self.code.tolist(), classless, strict=True)
                yield name, [list(rules_of(word)) if no else [] for word, no in pairs]
            elif name == "a":
                yield name, np.full(len(self), self.selection.a)
            elif kind == "text":
                yield name, _texts(values)
            elif kind == "integer" and name != "p":
                yield name, [None if no else n for n, no in zip(values.tolist(), classless, strict=True)]
            else:
                yield name, values
        if self.coordinates is not None:
            parts = np.split(self.coordinates, self.start[1:-1])
            yield COORDINATES, [None if np.isnan(x[0]) else x for x in parts[: len(self)]]

    def to_pandas(self) -> "pandas.DataFrame":
        """Return the rows as a pandas data frame (extra ``pandas``).

        Missing texts and integers are NA, missing numbers NaN. Coordinates, if they were read, are arrays.
        """
        pd = load("pandas", "to_pandas()", "pandas")
        table: dict[str, Any] = {}
        for name, values in self._columns():
            if isinstance(values, np.ndarray):
                table[name] = values
            elif kind_of(name) in ("numbers", "integers"):
                table[name] = pd.Series(values, dtype=object)
            else:
                table[name] = pd.array(values, "string" if kind_of(name) == "text" else "Int64")
        frame: pandas.DataFrame = pd.DataFrame(table, copy=False)  # each column once in memory
        frame.attrs |= {"selection": self.selection.describe()}
        return frame

    def to_arrow(self) -> "pyarrow.Table":
        """Return the rows as an Arrow table (extra ``parquet``), typed like an exported parquet file."""
        arrow = load("pyarrow", "to_arrow()", "parquet")
        names, values = zip(*self._columns(), strict=True)
        schema = arrow_schema(names, {"selection": self.selection.describe(), "a": self.selection.a})
        return arrow.Table.from_batches([arrow_batch(values, schema)])

    def __arrow_c_stream__(self, requested_schema: object = None) -> object:
        """Export the rows through Arrow's C interface, which polars and DuckDB read (extra ``parquet``)."""
        return self.to_arrow().__arrow_c_stream__(requested_schema)

    def entropy(self) -> "Result":
        """Return the topological entropy of these orbits by period (`Catalogue.entropy`)."""
        from orbitdb.answers.entropy import entropy_of_rows

        return entropy_of_rows(self._whole())

    def averages(self, weight: str = "exp") -> "Result":
        """Return the Lyapunov exponents averaged over these orbits by period (`Catalogue.lyapunov`)."""
        from orbitdb.answers.lyapunov import lyapunov_of_rows

        return lyapunov_of_rows(self._whole(), weight)

    def table(self) -> "Result":
        """Return counts by period as in the paper's Table 1; N_t counts words of any status."""
        from orbitdb.answers.entropy import table_of_rows

        self._need_words()
        return table_of_rows(self.selection, self.filled, self.p, self.status, self.representative)

    def _whole(self) -> "CompletePeriods":
        """Return the orbits of the completely filled periods, each as a class with a single word."""
        from orbitdb.answers.complete_periods import CompletePeriods, of_orbits
        from orbitdb.orbits.exponents import OrbitClasses

        self._need_words()
        chosen = of_orbits(self.selection)
        rows = np.flatnonzero(np.isin(self.status, chosen.statuses) & np.isin(self.p, self.filled))
        number = np.array([key(word) for word in self.representative[rows].tolist()], dtype=np.int64)
        length, lyapunov, walls = self.length[rows], self.lyapunov[rows], self.walls[rows]
        with readable(f"a row of {self.selection.describe()}"):
            classes = OrbitClasses(self.p[rows], np.ones_like(rows), length, lyapunov, walls, number=number)
        return CompletePeriods(chosen, chosen, self.filled, classes=classes, part=self.total is not None)

    def _need_words(self) -> None:
        if self.by_class:
            raise SelectionError("counts and averages need every word: select without classes=True")
        if self.cut:
            raise SelectionError("counts and averages need every word: select without a limit")

    def _drawing(self, name: str) -> tuple[Sequence[Any], str]:
        orbits = self[np.flatnonzero(np.isin(self.status, EXISTING))]
        if not len(orbits):
            raise InputError(f"there is nothing to draw in {self}")
        what: tuple[Any, ...] = ([*orbits],)
        if name == "lengths":
            what = orbits.length, np.ones(len(orbits))
        elif name == "phase-space":
            periods = np.unique(orbits.p).tolist()
            parts = [(*orbits.of_period(p), orbits.lambda_d[orbits.p == p]) for p in periods]
            what = Stadium(self.selection.a), parts
        return what, self.selection.describe()

    def _repr_html_(self) -> str:
        return html_of_orbits(str(self).strip("<>"), [*self[:MOST_ROWS]], len(self))


ARRAY_FIELDS = [
    field.name for field in fields(Subset) if field.default is MISSING and field.name != "selection"
]
"""The fields with one entry per word."""


def _read_coordinates(path: Path, word: str, a: float) -> Floats | None:
    return find_or_solve(path, word, a).coordinates


def _read_lives(path: Path, representative: str) -> Lives | None:
    with reading(path) as connection:
        return lives_of(connection, representative)


def _texts(values: Texts) -> list[str | None]:
    """Return texts as a list, with None for empty ones; equal texts are a single object, to save memory."""
    single: dict[str, str] = {}
    blocks = (values[start : start + _BLOCK].tolist() for start in range(0, len(values), _BLOCK))
    return [single.setdefault(text, text) or None for block in blocks for text in block]
