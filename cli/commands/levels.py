"""``orbitdb levels``: find the quantum levels of the stadium."""

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from orbitdb.cli import options
from orbitdb.cli.given_levels import Parities, RangeOfK, read_k
from orbitdb.cli.notes import note, notes, progress
from orbitdb.cli.output import Output
from orbitdb.cli.snapshots import given_a, snapshot_at, storable
from orbitdb.errors import InputError
from orbitdb.text import several

if TYPE_CHECKING:
    from orbitdb.quantum.exact_levels import Levels

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
    k: RangeOfK = None,
    method: Annotated[
        str, typer.Option(help="elements (spectral elements), or orbits (from stored orbits, less precise).")
    ] = "elements",
    parity: Parities = None,
    a: options.HalfLength = None,
    jobs: options.Jobs = None,
    store: options.Store = None,
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
        count = _from_elements(k, parity, a, jobs, store, output, db)
    if not count:
        raise typer.Exit(1)


def _from_elements(
    k: str,
    parity: str | None,
    a: float | None,
    jobs: int | None,
    store: bool | None,
    output: Output,
    db: Path,
) -> int:
    """Find levels with spectral elements, save them if a catalogue is given, and return their number."""
    from orbitdb.billiard.stadium import Stadium
    from orbitdb.catalogue import Catalogue
    from orbitdb.quantum.exact_levels import level_tasks
    from orbitdb.quantum.weyl import k_range, parities_of

    low, high = k_range(read_k(k))
    parities = parities_of(parity)
    (at,) = given_a(db, a)
    for one in parities:
        list(level_tasks(Stadium(at), one, low, high))  # a refused range must leave no file
    catalogue = Catalogue(db, at, missing_ok=True)
    keeps = storable(catalogue, store)
    with progress("levels") as shown:
        listed = catalogue.fill_levels((low, high), parity=parity, jobs=jobs, store=keeps, progress=shown)
    output.write(COLUMNS, _rows(listed))
    notes(listed.notes)
    return len(listed)


def _rows(levels: "Levels") -> "Iterator[tuple[float, float, str]]":
    return zip(levels.k.tolist(), levels.error.tolist(), levels.parity.tolist(), strict=True)


def _from_orbits(k: str | None, parity: str | None, a: float | None, output: Output, db: Path) -> int:
    """Show the levels computed from the stored orbits; return their number."""
    from orbitdb.quantum.weyl import k_ends

    low, high = (0.0, None) if k is None else k_ends(read_k(k))
    with progress("summing orbits"), snapshot_at(db, a) as (then, at):
        listed = then.levels((0, high), parity=parity, method="orbits", a=at)
        exact = then._stored_counterparts(listed)
    shown = [(*row, of) for row, of in zip(_rows(listed), exact, strict=True) if row[0] >= low]
    output.write((*COLUMNS, "exact"), shown)
    where = f"with k from {low:g} to {listed.high:g}" if low else f"below k = {listed.high:g}"
    note(f"{several(len(shown), 'level')} {where}: {listed.basis}")
    return len(shown)
