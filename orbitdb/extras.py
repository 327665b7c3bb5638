"""Import optional packages when they are needed, and use them for the data frames and figures of results."""

from collections.abc import Sequence
from dataclasses import asdict
from importlib import import_module
from numbers import Real
from typing import TYPE_CHECKING, Any, ClassVar, TypeVar

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


def data_frame(values: Any, names: Sequence[str] | None = None) -> "pandas.DataFrame":
    """Return a pandas data frame, made from a mapping of columns or from rows with the given names.

    Numbers are NaN where they are missing, so that no column of numbers has the type ``object``.
    """
    frame: pandas.DataFrame = load("pandas", "to_pandas()", "pandas").DataFrame(values, columns=names)
    for name, column in frame.items():
        if column.dtype == object and all(value is None or isinstance(value, Real) for value in column):
            frame[name] = column.astype(float)
    return frame


def figure_name(kind: str | None, own: Sequence[str]) -> str:
    """Return the one of the figures `own` that is meant, by default the first; raise if it is none of them.

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

    def row(self) -> dict[str, Any]:
        """Return the values under the names that they have in JSON."""
        return {_IN_JSON.get(name, name): value for name, value in asdict(self).items()}  # type: ignore[call-overload]


_IN_JSON = {"n_t": "N_t", "n_c": "N_c", "word": "representative"}


_Row = TypeVar("_Row")


class Rows(list[_Row]):
    """A list of records or named tuples, which are the rows of a data frame."""

    def to_pandas(self) -> "pandas.DataFrame":
        """Return a data frame with one row per entry (extra ``pandas``)."""
        return data_frame([one.row() if isinstance(one, Record) else one._asdict() for one in self])  # type: ignore[attr-defined]


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
