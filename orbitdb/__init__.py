"""orbitdb: a certified catalogue of the unstable periodic orbits of the stadium billiard.

The catalogue
    `Catalogue` is a database file to fill, query and check; a `Selection` describes a subset of it. Its
    methods return a `Subset` (rows as arrays), a `Listing` (rows one by one), `OrbitClasses` (one row per
    class), a `Result` (a table by period), a `Histogram`, `Births` (a list of `Life`), `EntropyBounds`, a
    `Reference`, `Levels`, a `Spectrum`, an `Assessment`, a `Verification`, a `SqlResult`, `Info`,
    `Contents`, a `Dataset`, `Need` (an estimate), a `Migration`, or `Rows` (a list) of `Fill`,
    `Sweep`, `BirthFill`, `Merged` or `Scar`. `FieldOrbits` are words in a magnetic field. A `Trajectory` has
    the orbits that it shadows as `Followed`, and `Candidates` are a list of `Candidate`, orbits with a given
    length.
Orbits
    `solve_word` solves one word, and `solve` many, as texts or as an array; `existence` finds the ranges of
    a in which a word is an orbit, and `closed_form` writes their ends with square roots. The results are
    `Orbit`, `Orbits` and `Status`. `Stadium` is the billiard.
Trajectories
    `trajectory` follows any trajectory, as `Bounces`; `simulate` averages over random ones, as a
    `Reference`. A `PruningFront` is the border of the orbits in the plane of `symbol_plane`, with a `Front`
    each for walls and semicircles. `read_points` reads the points of a trajectory from a file.
The open stadium
    `escape` finds how fast trajectories escape through openings of the boundary, as an `Escape`, whose
    openings are `Opening`.
Quantum levels
    `levels` computes all levels of a stadium in a range of k, and `waves` the `Wave` of each level.
    `read_levels` reads a list of levels from a file, and `weyl_number` is their smooth number.
Errors
    The messages of `InputError`, `StoreError` and `WorkError` say in one line what is wrong and what to do.

Examples
--------
>>> from orbitdb import solve_word
>>> orbit = solve_word("1232131", 1.6)
>>> orbit.status, round(orbit.length, 9), round(orbit.lyapunov, 9)
(<Status.ORBIT: 'orbit'>, 22.454362411, 9.637918174)

These names are the public interface. Everything else may change between versions.
"""

from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:  # isort: off
    from orbitdb.averages.simulation import simulate as simulate
    from orbitdb.billiard.stadium import Stadium as Stadium
    from orbitdb.catalogue import Catalogue as Catalogue
    from orbitdb.answers.identification import (
        Candidate as Candidate,
        Candidates as Candidates,
        Followed as Followed,
        Trajectory as Trajectory,
    )
    from orbitdb.answers.dataset import Dataset as Dataset
    from orbitdb.answers.histogram import Histogram as Histogram
    from orbitdb.answers.info import Info as Info
    from orbitdb.answers.sql_result import SqlResult as SqlResult
    from orbitdb.filling.estimate import Need as Need
    from orbitdb.store.file import Migration as Migration
    from orbitdb.store.merging import Merged as Merged
    from orbitdb.answers.listing import Listing as Listing
    from orbitdb.answers.field import FieldOrbits as FieldOrbits
    from orbitdb.answers.results import Births as Births, Result as Result
    from orbitdb.answers.scars import Scar as Scar
    from orbitdb.answers.subset import Subset as Subset
    from orbitdb.entropy_bounds.bounds import EntropyBounds as EntropyBounds
    from orbitdb.display import Rows as Rows
    from orbitdb.errors import InputError as InputError, StoreError as StoreError, WorkError as WorkError
    from orbitdb.open_stadium.escape import Escape as Escape
    from orbitdb.open_stadium.openings import Opening as Opening
    from orbitdb.open_stadium.question import escape as escape
    from orbitdb.orbits.births import closed_form as closed_form
    from orbitdb.orbits.exponents import OrbitClasses as OrbitClasses
    from orbitdb.orbits.solve import existence as existence, solve as solve, solve_word as solve_word
    from orbitdb.orbits.orbit import Orbit as Orbit
    from orbitdb.orbits.orbits import Orbits as Orbits
    from orbitdb.orbits.status import Status as Status
    from orbitdb.quantum.missing_levels import Assessment as Assessment
    from orbitdb.quantum.exact_levels import Levels as Levels, levels as levels
    from orbitdb.quantum.level_files import read_levels as read_levels
    from orbitdb.quantum.length_spectrum import Spectrum as Spectrum
    from orbitdb.quantum.waves import Wave as Wave, waves as waves
    from orbitdb.quantum.weyl import weyl_number as weyl_number
    from orbitdb.selection import Selection as Selection
    from orbitdb.store.lookup import Life as Life
    from orbitdb.store.periods import BirthFill as BirthFill, Contents as Contents
    from orbitdb.store.periods import Fill as Fill, Sweep as Sweep
    from orbitdb.symbols.plane import symbol_plane as symbol_plane
    from orbitdb.trajectories.ensemble import Reference as Reference
    from orbitdb.trajectories.point_files import read_points as read_points
    from orbitdb.trajectories.pruning_front import Front as Front, PruningFront as PruningFront
    from orbitdb.trajectories.trajectory import Bounces as Bounces, trajectory as trajectory
    from orbitdb.verification.verify import Verification as Verification
    # isort: on

__version__ = "0.2.0"

if find_spec("orbitdb.cli") is None:  # in the source folder, two packages lie beside this one
    __path__.append(str(Path(__file__).parent.parent))

_HOMES = {
    "averages.simulation": ("simulate",),
    "billiard.stadium": ("Stadium",),
    "catalogue": ("Catalogue",),
    "answers.identification": ("Candidate", "Candidates", "Followed", "Trajectory"),
    "answers.dataset": ("Dataset",),
    "answers.histogram": ("Histogram",),
    "answers.info": ("Info",),
    "answers.sql_result": ("SqlResult",),
    "filling.estimate": ("Need",),
    "store.file": ("Migration",),
    "store.merging": ("Merged",),
    "answers.listing": ("Listing",),
    "answers.field": ("FieldOrbits",),
    "answers.results": ("Births", "Result"),
    "answers.scars": ("Scar",),
    "answers.subset": ("Subset",),
    "entropy_bounds.bounds": ("EntropyBounds",),
    "display": ("Rows",),
    "errors": ("InputError", "StoreError", "WorkError"),
    "open_stadium.escape": ("Escape",),
    "open_stadium.openings": ("Opening",),
    "open_stadium.question": ("escape",),
    "orbits.births": ("closed_form",),
    "orbits.exponents": ("OrbitClasses",),
    "orbits.orbit": ("Orbit",),
    "orbits.solve": ("existence", "solve", "solve_word"),
    "orbits.orbits": ("Orbits",),
    "orbits.status": ("Status",),
    "quantum.missing_levels": ("Assessment",),
    "quantum.exact_levels": ("Levels", "levels"),
    "quantum.length_spectrum": ("Spectrum",),
    "quantum.level_files": ("read_levels",),
    "quantum.waves": ("Wave", "waves"),
    "quantum.weyl": ("weyl_number",),
    "selection": ("Selection",),
    "store.lookup": ("Life",),
    "store.periods": ("BirthFill", "Contents", "Fill", "Sweep"),
    "symbols.plane": ("symbol_plane",),
    "trajectories.ensemble": ("Reference",),
    "trajectories.point_files": ("read_points",),
    "trajectories.pruning_front": ("Front", "PruningFront"),
    "trajectories.trajectory": ("Bounces", "trajectory"),
    "verification.verify": ("Verification",),
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
