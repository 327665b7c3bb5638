"""orbitdb: a certified catalogue of the unstable periodic orbits of the stadium billiard.

from orbitdb import Catalogue, Stadium, solve_word
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from orbitdb.version import __version__

if TYPE_CHECKING:
    from orbitdb.orbits import Orbit, Orbits, Status
    from orbitdb.selection import Selection
    from orbitdb.solve import solve, solve_word
    from orbitdb.stadium import Stadium
    from orbitdb.store.catalogue import Catalogue

__all__ = [
    "Catalogue",
    "Orbit",
    "Orbits",
    "Selection",
    "Stadium",
    "Status",
    "__version__",
    "solve",
    "solve_word",
]

_HOMES = {
    "Catalogue": "orbitdb.store.catalogue",
    "Orbit": "orbitdb.orbits",
    "Orbits": "orbitdb.orbits",
    "Selection": "orbitdb.selection",
    "Stadium": "orbitdb.stadium",
    "Status": "orbitdb.orbits",
    "solve": "orbitdb.solve",
    "solve_word": "orbitdb.solve",
}


def __getattr__(name: str) -> Any:
    """Load a public name when it is first used, so that light commands stay light."""
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(_HOMES[name]), name)


def __dir__() -> list[str]:
    return sorted(__all__)
