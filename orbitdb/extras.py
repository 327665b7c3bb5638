"""What not everybody has installed: loaded when it is used, with a word on how to get it."""

from importlib import import_module
from typing import Any


def load(module: str, use: str, extra: str) -> Any:
    """Return a module that needs, or is, a package of an extra.

    Parameters
    ----------
    module : str
    use : str
        What is asked for, such as ``to_pandas()``.
    extra : str
        The extra of this package that brings what it needs.

    Raises
    ------
    ModuleNotFoundError
        If it is not installed; the message says what to install.
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
