"""``orbitdb scars``: measure how strongly orbits scar levels."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from orbitdb.cli import options
from orbitdb.cli.arguments import primitive
from orbitdb.cli.given_levels import Parities, Range, read_range
from orbitdb.cli.output import Output
from orbitdb.cli.progress import progress
from orbitdb.cli.reading import known_catalogue, meant
from orbitdb.cli.render import code_text, note
from orbitdb.errors import InputError
from orbitdb.numerals import exact

if TYPE_CHECKING:
    from orbitdb.quantum.weyl import Parity

EXAMPLES = ("scars 13 --k 20:22", "scars --k 20:20.5 --parity ee", "scars 0123 --k 10:20 --format csv")


def scars(
    *,
    word: Annotated[
        str | None, typer.Argument(metavar="WORD", help="The orbit [default: the shortest stored orbits].")
    ] = None,
    k: Range,
    parity: Parities = None,
    a: options.StoredHalfLength = None,
    output: Output,
    db: options.Database,
) -> None:
    """Measure how strongly orbits scar quantum levels.

    strength is the mean of psi^2 along the orbit, times the area: 1 on average, but 2 or 0 for an orbit on a
    symmetry axis. above is the difference from the mean strength of the 15 levels of the same parity on each
    side, in standard deviations. With WORD, you see all levels, the most scarred first. Without WORD, you see
    for each level the five of the twenty shortest stored orbits that scar it most.
    """
    from orbitdb.answers.scars import Scar
    from orbitdb.quantum.weyl import parities_of

    low, high = read_range("--k", k)
    with progress("waves"):
        found = _found(word, low, high, parities_of(parity), a, db)
    output.write(Scar._fields, found)
    if not found:
        note(f"no level with k from {low:g} to {high:g}")
        raise typer.Exit(1)


def _found(
    word: str | None, low: float, high: float, parities: "list[Parity]", asked: float | None, db: Path
) -> list[tuple[object, ...]]:
    from orbitdb.answers.scars import scars_of, scars_of_shortest
    from orbitdb.store.reading.lookup import find_or_solve
    from orbitdb.store.reading.moment import reading

    (a,) = meant(db, asked)
    if word is None:
        with reading(db) as moment:
            return list(scars_of_shortest(moment, a, low, high, parities))
    orbit = find_or_solve(known_catalogue(db), primitive(word), a)
    if orbit.points is None:
        raise InputError(f"{code_text(word)} at a = {exact(a)} scars nothing: {orbit.status.sentence}")
    return list(scars_of(orbit, low, high, parities))
