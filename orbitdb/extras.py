"""Optional packages, imported on use, with a message on how to install them."""

from importlib import import_module
from typing import Any


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
