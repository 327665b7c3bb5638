"""Results: `Result`, a table by period; `Births`, the lives of classes; and orbits as HTML with pictures."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from html import escape
from itertools import zip_longest
from typing import TYPE_CHECKING, Any

from orbitdb.billiard.stadium import Stadium
from orbitdb.display import (
    MOST_SHOWN,
    Drawn,
    Rows,
    data_frame,
    drawn,
    figure_name,
    html_of,
    html_table,
    text_table,
)
from orbitdb.errors import InputError
from orbitdb.orbits.orbit import Orbit
from orbitdb.orbits.status import EXISTING
from orbitdb.selection import Selection
from orbitdb.store.lookup import Life
from orbitdb.svg import orbit_svg
from orbitdb.text import format_float, shortened

if TYPE_CHECKING:
    import pandas
    from matplotlib.axes import Axes


TABLE = ("p", "N_t", "N_c", "N", "K_0", "classes", "boundary", "unresolved")
"""The columns of the paper's Table 1, then the numbers of classes and of words with other statuses."""

PROVED = ("h_lower", "h_upper", "h_proof")
"""Proved bounds on the topological entropy of all orbits."""

UP_TO_CUT = ("cut", "lambda_d_zeta", "lambda_c_zeta", "mean_path_zeta", "z0")
_DRAWN = {"entropy": "h_zeta", "lyapunov": "lambda_d", "lambda_d": "lambda_d", "lambda_c": "lambda_c"}
"""The figures of a result, and the column that each draws."""

ENDED = ("p", "word", "class_size", "born", "dies", "dies_error", "reborn")
"""The columns of lives that end."""

TRAJECTORIES = ("lambda_d", "lambda_d_error", "lambda_c", "lambda_c_error")


@dataclass(frozen=True, eq=False, repr=False)
class Result:
    """A small table, one row per period and a; the prompt shows its first rows, and print all.

    Attributes
    ----------
    selection : Selection
        What was chosen; at the first a, if there are several.
    columns : mapping of str to list
        The values of each column; None for a missing value.
    facts : tuple of str
        The subset and related results, one line each.
    notes : tuple of str
        What is missing, and why values are None, one line each.

    Examples
    --------
    >>> table = catalogue.table(p="2-4")
    >>> print(*repr(table).splitlines()[:4], sep="\\n")
    p  N_t  N_c    N       K_0  classes  boundary  unresolved
    2    1    1    2  0.346574        1         0           0
    3    8    8   24   1.05935        2         0           0
    4   32   32  130   1.21688        8         0           0
    >>> table["N_c"]
    [1, 8, 32]
    """

    selection: Selection
    columns: Mapping[str, Sequence[Any]]
    facts: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()

    def __len__(self) -> int:
        return len(next(iter(self.columns.values()), ()))

    def __getitem__(self, name: str) -> list[Any]:
        """Return the values of a column."""
        if name not in self.columns:
            raise KeyError(f"no column {name!r}: the columns are {', '.join(self.columns)}")
        return list(self.columns[name])

    def rows(self, names: Sequence[str] | None = None) -> Iterator[tuple[Any, ...]]:
        """Yield the rows, with all columns or only the named ones."""
        return zip(*(self.columns[name] for name in names or self.columns), strict=True)

    def __repr__(self) -> str:
        lines = text_table(self.columns, MOST_SHOWN) if len(self) else [f"<no {self.selection.describe()}>"]
        return "\n".join([*lines, *self.facts, *self.notes])

    def __str__(self) -> str:
        return "\n".join([*text_table(self.columns), *self.facts, *self.notes])

    def _repr_html_(self) -> str:
        notes = "<br>".join(map(escape, (*self.facts, *self.notes)))
        return f"{html_of(self.columns)}<small>{notes}</small>"

    def to_pandas(self) -> "pandas.DataFrame":
        """Return a pandas data frame (extra ``pandas``) with the columns of the JSON output."""
        return data_frame(dict(self.columns), selection=self.selection.describe())

    def plot(self, kind: str | None = None, ax: "Axes | None" = None) -> "Axes":
        """Plot averages by period, as in the paper's Figs. 5 and 6 (extra ``plot``).

        Parameters
        ----------
        kind : str, optional
            ``entropy`` or ``lyapunov``, by default the one that the result has; ``lyapunov`` is the same as
            ``lambda_d``, and ``lambda_c`` is the exponent per length.
        ax : matplotlib.axes.Axes, optional
            Axes to draw in; by default those of a new figure.

        Raises
        ------
        InputError
            If the result does not have these averages, or has several a.
        """
        if "a" in self.columns:
            raise InputError("this result has several a, and a figure shows one: ask for each a alone")
        kinds = [name for name, column in _DRAWN.items() if {"p", column} <= self.columns.keys()]
        if not kinds or not len(self):
            raise InputError("this result has no averages to draw: entropy() and lyapunov() have")
        name = figure_name(kind, kinds)
        if name == "entropy":
            return drawn(name, (self,), self.selection.describe(), ax)
        return drawn("lyapunov", (self, _DRAWN[name]), self.selection.describe(), ax)


def over_a(results: Sequence[Result]) -> Result:
    """Join results at several a into one, whose first column is ``a``.

    A value is None if the result at its a does not have the column. Facts and notes begin with their a.
    """
    rows = [result for result in results if len(result)]
    columns: dict[str, list[Any]] = {"a": [result.selection.a for result in rows for _ in range(len(result))]}
    for name in dict.fromkeys(name for result in rows for name in result.columns):
        columns[name] = [value for result in rows for value in result.columns.get(name, [None] * len(result))]

    def said(kind: str) -> tuple[str, ...]:
        pairs = [
            (f"a = {format_float(each.selection.a)}", text)
            for each in results
            for text in getattr(each, kind)
        ]
        return tuple(text if at in text else f"{at}: {text}" for at, text in pairs)

    return Result(results[0].selection, columns, said("facts"), said("notes"))


class Births(Drawn, Rows[Life]):
    """The lives of the classes of one period, in order of birth: a list of `Life`.

    `plot` draws the number of words that are orbits against ``a``.

    Attributes
    ----------
    notes : tuple of str
        Which births are missing, if any, and how to find them.
    """

    _FIGURES = ("births",)
    notes: tuple[str, ...] = ()

    def __repr__(self) -> str:
        return "\n".join([super().__repr__(), *self.notes])

    def ended(self) -> Iterator[tuple[Any, ...]]:
        """Yield the lives that end, by word, as rows with the columns `ENDED`.

        The last column is the beginning of the next life of the same word, or None.
        """
        lives = sorted(self, key=lambda life: (life.word, life.born or 0.0))
        for life, following in zip_longest(lives, lives[1:]):
            if life.dies is not None:
                reborn = following.born if following and following.word == life.word else None
                yield life.p, life.word, life.class_size, life.born, life.dies, life.dies_error, reborn

    def _drawing(self, name: str) -> tuple[Sequence[Any], str]:
        if not self:
            raise InputError("there are no births to draw: fill_births finds them")
        return (self,), f"orbits of period {self[0].p} at each a"


MOST_ROWS = 10
_PICTURE = 150
"""Width of a picture in a table, in pixels."""
MOST_BOUNCES = 200
"""Longer orbits get no small picture, because it would be a smudge."""

_HEADINGS = ("", "code", "p", "status", "length", "λ", "λ<sub>d</sub>", "λ<sub>c</sub>", "class", "symmetry")
_TEXTS = ("code", "status", "symmetry")


def html_of_orbits(title: str, orbits: Sequence[Orbit], total: int) -> str:
    """Return an HTML table of orbits with small pictures, a title, and the number of orbits not shown."""
    table = f"\n{html_table(_HEADINGS, map(_cells, orbits), _TEXTS)}" if orbits else ""
    more = f"\n<p>… and {total - len(orbits):,} more</p>" if total > len(orbits) else ""
    return f"<p>{escape(title)}</p>{table}{more}"


def _cells(orbit: Orbit) -> list[str]:
    points = orbit.points if orbit.status in EXISTING and orbit.p <= MOST_BOUNCES else None
    picture = "" if points is None else orbit_svg(Stadium(orbit.a), points, orbit.code, orbit.code, _PICTURE)
    numbers = ((orbit.length, 7), (orbit.lyapunov, 7), (orbit.lambda_d, 6), (orbit.lambda_c, 6))
    texts = [shortened(orbit.code), str(orbit.p), orbit.status,
             *("" if value is None else f"{value:.{digits}f}" for value, digits in numbers),
             str(orbit.class_size or ""), orbit.symmetry or ""]  # fmt: skip
    return [picture, *map(escape, texts)]
