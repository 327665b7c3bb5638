"""Import optional packages when they are needed, and use them for the data frames and figures of results."""

from collections.abc import Sequence
from dataclasses import asdict
from importlib import import_module
from numbers import Real
from typing import TYPE_CHECKING, Any, TypeVar

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


def drawn(figure: str, what: Sequence[Any], title: str, ax: "Axes | None") -> "Axes":
    """Draw a figure of `orbitdb.plots`, such as ``curves.draw_levels``, on the axes or in a new figure."""
    module, name = figure.split(".")
    plots, paths = (load(f"orbitdb.plots.{each}", "plot()", "plot") for each in (module, "paths"))
    axes: Axes = paths.draw_titled(getattr(plots, name), what, title, ax)
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
    """Base of results that can be drawn as a figure."""

    def _figure(self) -> tuple[str, Sequence[Any], str]:
        """Return arguments for `drawn`: the function in `orbitdb.plots`, what it draws, and the title."""
        raise NotImplementedError

    def plot(self, ax: "Axes | None" = None) -> "Axes":
        """Draw the result with matplotlib.

        Parameters
        ----------
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
        return drawn(*self._figure(), ax)
