"""orbitdb: a certified catalogue of the unstable periodic orbits of the stadium billiard.

The catalogue
    `Catalogue`: a database file, opened for reading; `Selection`: a chosen subset of it; `Subset`: the
    chosen rows as arrays. `Catalogue.identify` finds a `Trajectory`, with the orbits that it shadows as
    `Followed`, or each `Candidate` for a length.
Orbits
    `solve_word` solves one word, `solve` many as arrays; `existence` finds the ranges of a in which a word
    is an orbit. The results are `Orbit`, `Orbits` and `Status`. `Stadium` is the billiard.
Trajectories
    `simulate` averages over random trajectories; the result is a `Reference`.
Quantum levels
    `levels` computes all levels of a stadium in a range of k, as one `Levels` for each window and parity.
Errors
    `InputError`, `StoreError`, `WorkError`: each says in one line what is wrong and what to do.

Examples
--------
>>> from orbitdb import solve_word
>>> orbit = solve_word("1232131", 1.6)
>>> orbit.status, round(orbit.length, 9), round(orbit.lyapunov, 9)
(<Status.ORBIT: 'orbit'>, 22.454362411, 9.637918174)

These names are the public interface. Everything else may change between versions.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:  # isort: off
    from orbitdb.billiard.stadium import Stadium as Stadium
    from orbitdb.catalogue import Catalogue as Catalogue
    from orbitdb.answers.identification import (
        Candidate as Candidate,
        Followed as Followed,
        Trajectory as Trajectory,
    )
    from orbitdb.answers.subset import Subset as Subset
    from orbitdb.errors import InputError as InputError, StoreError as StoreError, WorkError as WorkError
    from orbitdb.orbits.newton import solve as solve
    from orbitdb.orbits.orbit import Orbit as Orbit, Orbits as Orbits, Status as Status
    from orbitdb.orbits.single_word import existence as existence, solve_word as solve_word
    from orbitdb.quantum.levels import Levels as Levels, levels as levels
    from orbitdb.store.asking.selection import Selection as Selection
    from orbitdb.trajectories.ensemble import Reference as Reference, simulate as simulate
    # isort: on

__version__ = "0.2.0"

_HOMES = {
    "billiard.stadium": ("Stadium",),
    "catalogue": ("Catalogue",),
    "answers.identification": ("Candidate", "Followed", "Trajectory"),
    "answers.subset": ("Subset",),
    "errors": ("InputError", "StoreError", "WorkError"),
    "orbits.single_word": ("existence", "solve_word"),
    "orbits.newton": ("solve",),
    "orbits.orbit": ("Orbit", "Orbits", "Status"),
    "quantum.levels": ("Levels", "levels"),
    "store.asking.selection": ("Selection",),
    "trajectories.ensemble": ("Reference", "simulate"),
}
_HOME_OF = {name: f"orbitdb.{home}" for home, names in _HOMES.items() for name in names}

__all__ = ["__version__", *_HOME_OF]


def __getattr__(name: str) -> Any:
    """Load a public name when it is first used, so that light commands stay light."""
    if name not in _HOME_OF:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(_HOME_OF[name]), name)


def __dir__() -> list[str]:
    return sorted(__all__)
