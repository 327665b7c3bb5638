"""``orbitdb scars``: measure how strongly orbits scar levels."""

from typing import Annotated

import typer

from orbitdb.cli import options
from orbitdb.cli.arguments import primitive
from orbitdb.cli.given_levels import Parities, read_range
from orbitdb.cli.output import Output, note
from orbitdb.cli.progress import progress
from orbitdb.cli.reading import known_catalogue, meant
from orbitdb.errors import InputError
from orbitdb.text import real

EXAMPLES = (
    "scars 13 --k 20:22",
    "scars --k 20:20.5 --parity ee",
    "scars 02 --k 20:22 --order strength",
    "scars 0123 --k 15.3 --parity oo",
)


def scars(
    *,
    word: Annotated[
        str | None, typer.Argument(metavar="WORD", help="The orbit [default: the shortest stored orbits].")
    ] = None,
    k: Annotated[
        str, typer.Option(metavar="FROM:TO", help="Range of k, or a single k for the nearest level.")
    ],
    parity: Parities = None,
    order: Annotated[str, typer.Option(help="above, strength (the largest first) or k.")] = "above",
    a: options.StoredHalfLength = None,
    output: Output,
    db: options.Database,
) -> None:
    """Measure how strongly orbits scar quantum levels.

    strength is the mean of psi^2 along the orbit, times the area: 1 on average, but 2 or 0 for an orbit on a
    symmetry axis. For the bouncing balls, 02, it is the mean over the rectangle that they fill. above is the
    difference from the mean strength of the 15 levels of the same parity on each side, in standard
    deviations. With WORD, you see all levels, the most scarred first. Without WORD, you see for each level
    the five orbits that scar it most, out of the bouncing balls and the twenty shortest stored orbits. The
    waves take longest, because each parity needs those of 30 neighbours, too.
    """
    from orbitdb.answers.scars import Scar, check_scarring, scars_of, shortest_orbits
    from orbitdb.quantum.weyl import parities_of
    from orbitdb.store.file import reading
    from orbitdb.store.lookup import find_or_solve

    low, high = _range(k)
    parities, (at,) = parities_of(parity), meant(db, a)
    if word is None:
        with reading(db) as moment:
            orbits = shortest_orbits(moment, at)
    else:
        orbits = [find_or_solve(known_catalogue(db), primitive(word), at)]
        check_scarring(orbits[0])
    with progress("waves") as tell:
        rows = scars_of(orbits, low, high, parities, order, tell)
    output.write(Scar._fields, rows)
    if not rows:
        note(f"no level with k from {low:g} to {high:g}")
        raise typer.Exit(1)


def _range(text: str) -> tuple[float, float | None]:
    """Parse a range of k, or a single k."""
    if ":" in text:
        return read_range("--k", text)
    try:
        k = real(text)
    except ValueError:
        k = -1.0
    if not 0 < k < 1e6:
        raise InputError(f"--k {text!r:.40}: give FROM:TO, such as 20:22, or one k above 0")
    return k, None
