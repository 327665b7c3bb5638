"""What not everybody has installed: loaded when it is used, with a word on how to get it."""

from importlib import import_module
from typing import Any


def load(module: str, use: str, extra: str) -> Any:
    """Return a module that needs, or is, a package of an extra, for a use such as ``to_pandas()``.

    Where it is not installed, a `ModuleNotFoundError` says what to install.
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
