"""How results show themselves: as tables, as data frames, and as figures, which need optional packages."""

import shutil
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import asdict
from importlib import import_module
from numbers import Real
from typing import TYPE_CHECKING, Any, ClassVar, Self, SupportsIndex, TypeVar, overload

if TYPE_CHECKING:
    import pandas
    from matplotlib.axes import Axes


def load(module: str, use: str, extra: str) -> Any:
    """Import a module that needs an optional package.

    Parameters
    ----------
    module : str
    use : str
        The feature that needs the module, such as ``to_pandas()``.
    extra : str
        The extra of orbitdb that installs the package.

    Raises
    ------
    ModuleNotFoundError
        If the package is missing; the message says what to install.
    """
    try:
        return import_module(module)
    except ModuleNotFoundError as error:
        package = (error.name or "").partition(".")[0]
        if package == "orbitdb":
            raise
        raise ModuleNotFoundError(
            f"{use} needs {package}: pip install 'orbitdb[{extra}]'", name=error.name
        ) from None


def data_frame(values: Any, names: Sequence[str] | None = None, **attributes: str) -> "pandas.DataFrame":
    """Return a pandas data frame, made from a mapping of columns or from rows with the given names.

    Numbers are NaN where they are missing, so that no column of numbers has the type ``object``. The
    attributes, such as what was chosen, are those of ``DataFrame.attrs``.
    """
    frame: pandas.DataFrame = load("pandas", "to_pandas()", "pandas").DataFrame(values, columns=names)
    for name, column in frame.items():
        if column.dtype == object and all(value is None or isinstance(value, Real) for value in column):
            frame[name] = column.astype(float)
    frame.attrs |= attributes
    return frame


def figure_name(kind: str | None, own: Sequence[str]) -> str:
    """Return the figure of `own` with this name, by default the first; raise if there is none.

    Hyphens, underscores and blanks in a name are the same.
    """
    name: str = import_module("orbitdb.plots.registry").chosen_name(kind, own)
    return name


def drawn(figure: str, what: Sequence[Any], title: str, ax: "Axes | None") -> "Axes":
    """Draw a figure of the registry `orbitdb.plots.registry` on the axes, or in a new figure."""
    paths, registry = (load(f"orbitdb.plots.{each}", "plot()", "plot") for each in ("paths", "registry"))
    draw = registry.load_function(registry.figure_of(figure).axes)
    axes: Axes = paths.draw_titled(draw, what, title, ax)
    return axes


def columns_of(names: Sequence[str], rows: Sequence[Sequence[Any]]) -> dict[str, list[Any]]:
    """Return rows as columns with the given names."""
    return {name: [row[place] for row in rows] for place, name in enumerate(names)}


MOST_SHOWN = 20
"""Maximum number of rows that a result shows at the prompt and in a notebook."""

_LONGEST = 40
"""Longer texts are cut in such a table."""


def cell(value: Any) -> str:
    """Return a value as it is shown in a table: empty if it is missing, and a number with six digits."""
    if value is None or value != value:
        return ""
    text = f"{value:.6g}" if isinstance(value, float) else str(value)
    return text if len(text) <= _LONGEST else f"{text[: _LONGEST - 3]}..."


def text_table(
    columns: Mapping[str, Sequence[Any]], most: int | None = None, total: int | None = None
) -> list[str]:
    """Return the lines of a table of named columns.

    With `most`, it has no more rows than that and no more columns than fit into the terminal; the last lines
    say what is left out. The number of rows is `total`, if the columns have only the first ones.
    """
    count = len(next(iter(columns.values()), ())) if total is None else total
    room = None if most is None else shutil.get_terminal_size().columns
    lines = [""] * (1 + min(count, count if most is None else most))
    left_out: list[str] = []
    for name, values in columns.items():
        texts = [name, *map(cell, values[: len(lines) - 1])]
        width = max(map(len, texts)) + 2 * bool(lines[0])
        if left_out or (room is not None and lines[0] and len(lines[0]) + width > room):
            left_out.append(name)
            continue
        side = str.ljust if all(isinstance(value, str | None) for value in values[:most]) else str.rjust
        texts = [f"  {side(text, width - 2)}" if lines[0] else side(text, width) for text in texts]
        lines = list(map(str.__add__, lines, texts))
    lines = [line.rstrip() for line in lines]
    if (more := count - len(lines) + 1) > 0:
        lines.append(f"... and {more:,} more row{'s' * (more > 1)}")
    return [*lines, *([f"and the columns {', '.join(left_out)}"] if left_out else [])]


def html_table(head: Iterable[str], rows: Iterable[Sequence[str]], left: Collection[str] = ()) -> str:
    """Return an HTML table of texts, which are HTML themselves; the columns in `left` are aligned left.

    Notebooks align cells to the right unless told otherwise.
    """
    names = [*head]
    styles = [' style="text-align: left"' * (name in left) for name in names]

    def line(tag: str, cells: Sequence[str]) -> str:
        pairs = zip(styles, cells, strict=True)
        return f"<tr>{''.join(f'<{tag}{style}>{cell}</{tag}>' for style, cell in pairs)}</tr>"

    body = "".join(f"{line('td', row)}\n" for row in rows)
    return f"<table>\n<thead>{line('th', names)}</thead>\n<tbody>\n{body}</tbody>\n</table>"


def html_of(columns: Mapping[str, Sequence[Any]], total: int | None = None) -> str:
    """Return an HTML table of named columns, of no more than `MOST_SHOWN` rows.

    The number of rows is `total`, if the columns have only the first ones.
    """
    from html import escape  # which takes a twentieth of the start of a command

    rows = [*zip(*(values[:MOST_SHOWN] for values in columns.values()), strict=True)]
    texts = [name for name, values in columns.items() if all(isinstance(v, str | None) for v in values)]
    table = html_table(map(escape, columns), ([escape(cell(value)) for value in row] for row in rows), texts)
    more = (len(next(iter(columns.values()), ())) if total is None else total) - len(rows)
    return f"{table}<p>… and {more:,} more</p>" if more else table


class Record:
    """Base of dataclasses whose objects are rows of a table."""

    def to_pandas(self) -> "pandas.DataFrame":
        """Return a data frame with this single row; ``pandas.concat`` joins several of them.

        Raises
        ------
        ModuleNotFoundError
            If pandas is not installed (extra ``pandas``).
        """
        return data_frame([self.row()])

    def _repr_html_(self) -> str:
        return html_of({name: [value] for name, value in self.row().items()})

    def row(self) -> dict[str, Any]:
        """Return the values under the names that they have in JSON."""
        return {_IN_JSON.get(name, name): value for name, value in asdict(self).items()}  # type: ignore[call-overload]


_IN_JSON = {"n_t": "N_t", "n_c": "N_c", "word": "representative"}


_Row = TypeVar("_Row")


class Rows(list[_Row]):
    """A list of records or named tuples, which shows itself as a table and gives a data frame."""

    def _rows(self) -> list[dict[str, Any]]:
        return [one.row() if isinstance(one, Record) else one._asdict() for one in self]  # type: ignore[attr-defined]

    def _table(self) -> dict[str, list[Any]]:
        rows = self._rows()
        return {name: [row[name] for row in rows] for name in (rows[0] if rows else ())}

    @overload
    def __getitem__(self, place: SupportsIndex) -> _Row: ...
    @overload
    def __getitem__(self, place: slice) -> Self: ...
    def __getitem__(self, place: Any) -> Any:
        """Return an entry, or for a slice a list that shows itself in the same way."""
        found = super().__getitem__(place)
        return type(self)(found) if isinstance(place, slice) else found

    def __repr__(self) -> str:
        return "\n".join(text_table(self._table(), MOST_SHOWN)) if self else "[]"

    def _repr_html_(self) -> str:
        return html_of(self._table())

    def to_pandas(self) -> "pandas.DataFrame":
        """Return a data frame with one row per entry (extra ``pandas``)."""
        return data_frame(self._rows())


class Table:
    """Base of results that show themselves as one line in print, and as a line and a table at the prompt."""

    def __str__(self) -> str:
        raise NotImplementedError

    def _columns_shown(self) -> Mapping[str, Sequence[Any]]:
        """Return the columns of at least the first `MOST_SHOWN` rows."""
        raise NotImplementedError

    def __len__(self) -> int:
        raise NotImplementedError

    def _repr_html_(self) -> str:
        from html import escape

        return f"<p>{escape(str(self).strip('<>'))}</p>{html_of(self._columns_shown(), len(self))}"

    def __repr__(self) -> str:
        table = text_table(self._columns_shown(), MOST_SHOWN, len(self)) if len(self) else []
        return "\n".join([str(self), *table])


class Drawn:
    """Base of results that can be drawn as one or several figures."""

    _FIGURES: ClassVar[tuple[str, ...]] = ()
    """Names of the figures in `orbitdb.plots.registry`; the first is the usual one."""

    def _drawing(self, name: str) -> tuple[Sequence[Any], str]:
        """Return the arguments, apart from the axes, of the function that draws a figure, and its title."""
        raise NotImplementedError

    def plot(self, kind: str | None = None, ax: "Axes | None" = None) -> "Axes":
        """Draw the result with matplotlib.

        Parameters
        ----------
        kind : str, optional
            The figure, named as for `orbitdb plot`, if there are several.
        ax : matplotlib.axes.Axes, optional
            The axes to draw on; by default those of a new figure.

        Returns
        -------
        matplotlib.axes.Axes

        Raises
        ------
        ValueError
            If there is nothing to draw.
        ModuleNotFoundError
            If matplotlib is not installed (extra ``plot``).
        """
        name = figure_name(kind, self._FIGURES)
        what, title = self._drawing(name)
        return drawn(name, what, title, ax)
