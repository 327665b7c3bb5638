"""``orbitdb levels``: find the quantum levels of the stadium."""

from pathlib import Path
from typing import Annotated

import typer

from orbitdb.billiard import USUAL_A
from orbitdb.cli import options
from orbitdb.cli.given_levels import Parities, SomeRange, read_range
from orbitdb.cli.output import Output, note, progress
from orbitdb.cli.reading import bring
from orbitdb.errors import InputError
from orbitdb.text import several

EXAMPLES = (
    "levels --k 0:30",
    "levels --k 0:12 --parity oo --a 0.5 --json",
    "levels --k 20:21 --no-store --format csv",
    "levels --method orbits --parity oo",
)
COLUMNS = ("k", "error", "parity")


def levels(
    *,
    context: typer.Context,
    k: SomeRange = None,
    method: Annotated[
        str, typer.Option(help="elements (spectral elements), or orbits (from stored orbits, less precise).")
    ] = "elements",
    parity: Parities = None,
    a: options.HalfLength = USUAL_A,
    jobs: options.Jobs = None,
    store: Annotated[bool, typer.Option(help="Save the levels in the catalogue.")] = True,
    output: Output,
    db: options.Database,
) -> None:
    """Find all levels of the quantum stadium in a range of k, each with an estimate of its error.

    The values k^2 are the eigenvalues of minus the Laplacian, for functions that vanish on the boundary. A
    parity has two letters, e (even) or o (odd): the first for x -> -x, the second for y -> -y. Levels already
    in the catalogue are not computed again, so an interrupted run continues where it stopped.

    With --method orbits, level n is the k at which the number of levels below k, computed from the orbits,
    first reaches n - 1/2. These levels are not stored. The column exact shows level n from the catalogue, if
    it is there. Without --k, the levels end where the rms error reaches a fifth of the mean spacing.
    """
    if method == "orbits":
        options.refuse_idle(context, "with --method orbits", "jobs", "store")
        count = _from_orbits(k, parity, a, output, db)
    elif method != "elements":
        raise InputError(f"method {method!r}: use elements or orbits")
    elif k is None:
        raise InputError("give the range of k, such as --k 0:30")
    else:
        count = _from_elements(k, parity, a, jobs, output, db if store else None)
    if not count:
        raise typer.Exit(1)


def _from_elements(
    k: str, parity: str | None, a: float, jobs: int | None, output: Output, db: Path | None
) -> int:
    """Find levels with spectral elements, save them if a catalogue is given, and return their number."""
    import numpy as np

    from orbitdb.billiard.stadium import Stadium
    from orbitdb.filling.records import find_levels
    from orbitdb.quantum.levels import Levels, windows
    from orbitdb.quantum.weyl import parities_of, weyl

    low, high = read_range("--k", k)
    stadium, parities = Stadium(a), parities_of(parity)
    for one in parities:
        list(windows(stadium, one, low, high))  # a refused range must leave no file
    if db is not None:
        bring(db)
    with progress("levels") as shown:
        parts = find_levels(db, stadium, low, high, parities, jobs, shown)
    listed = Levels.joined(a, low, high, parts)
    output.write(
        COLUMNS,
        zip(listed.k.tolist(), listed.error.tolist(), listed.parity.tolist(), strict=True),
    )
    for one, windows_of in parts.items():
        below = min(part.below + int((part.k < low).sum()) for part in windows_of if part.high > low)
        of_parity = listed.parity == str(one)
        own, error = listed.k[of_parity], listed.error[of_parity]
        places = np.linspace(low, high, 2000)
        off = float((below + np.searchsorted(own, places) - weyl(stadium, one)(places)).mean())
        worst = f", errors up to {error.max():.0e}" if len(own) else ""
        count = several(len(own), "level")
        note(f"{one}: {count}, none missing; on average {off:+.2f} from Weyl's law{worst}")
    return len(listed)


def _from_orbits(k: str | None, parity: str | None, a: float, output: Output, db: Path) -> int:
    """Show the levels computed from the stored orbits; return their number."""
    from orbitdb.answers.levels import beside, levels_from_orbits
    from orbitdb.quantum.weyl import parities_of
    from orbitdb.store.file import reading

    low, high = (0.0, None) if k is None else read_range("--k", k)
    with progress("summing orbits"), reading(db) as moment:
        listed = levels_from_orbits(moment, a, high, parities_of(parity))
        exact = beside(moment, listed)
    rows = zip(listed.k.tolist(), listed.error.tolist(), listed.parity.tolist(), exact, strict=True)
    shown = [row for row in rows if row[0] >= low]
    output.write((*COLUMNS, "exact"), shown)
    note(f"{several(len(shown), 'level')} below k = {listed.high:g}: {listed.basis}")
    return len(shown)
