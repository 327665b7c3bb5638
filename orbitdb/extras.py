"""Optional packages, imported on use, and what results do with them: data frames and figures."""

from collections.abc import Sequence
from dataclasses import asdict
from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import pandas
    from matplotlib.axes import Axes


def load(module: str, use: str, extra: str) -> Any:
    """Import a module that needs a package of an extra.

    Parameters
    ----------
    module : str
    use : str
        The feature that needs it, such as ``to_pandas()``.
    extra : str
        The extra of orbitdb with that package.

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
    """Return a pandas data frame of columns by name, or of rows with these names."""
    frame: pandas.DataFrame = load("pandas", "to_pandas()", "pandas").DataFrame(values, columns=names)
    return frame


def drawn(figure: str, what: Sequence[Any], title: str, ax: "Axes | None") -> "Axes":
    """Draw a figure of `orbitdb.plots`, such as ``curves.draw_levels``, on axes or in a new figure."""
    module, name = figure.split(".")
    plots, paths = (load(f"orbitdb.plots.{each}", "plot()", "plot") for each in (module, "paths"))
    axes: Axes = paths.draw_titled(getattr(plots, name), what, title, ax)
    return axes


class Record:
    """Base of dataclasses that are one row of a table."""

    def to_pandas(self) -> "pandas.DataFrame":
        """Return a data frame with this one row; ``pandas.concat`` joins those of several.

        Raises
        ------
        ModuleNotFoundError
            If pandas is not installed (extra ``pandas``).
        """
        return data_frame([self.row()])

    def row(self) -> dict[str, Any]:
        """Return the values by the names that they have in JSON."""
        return {_IN_JSON.get(name, name): value for name, value in asdict(self).items()}  # type: ignore[call-overload]


_IN_JSON = {"n_t": "N_t", "n_c": "N_c"}


class Drawn:
    """Base of results with one figure."""

    def _figure(self) -> tuple[str, Sequence[Any], str]:
        """Return the function in `orbitdb.plots`, what it draws, and the title (`drawn`)."""
        raise NotImplementedError

    def plot(self, ax: "Axes | None" = None) -> "Axes":
        """Draw it with matplotlib.

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
            If there is nothing to draw.
        ModuleNotFoundError
            If matplotlib is not installed (extra ``plot``).
        """
        return drawn(*self._figure(), ax)
