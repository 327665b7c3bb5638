"""What commands that read a catalogue begin with: which a is meant, and what of the subset is filled."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

from orbitdb import __version__
from orbitdb.cli import arguments
from orbitdb.cli.choice import Choice
from orbitdb.cli.options import USUAL_A
from orbitdb.cli.render import note
from orbitdb.errors import InputError
from orbitdb.numerals import exact

if TYPE_CHECKING:
    from orbitdb.catalogue.catalogue import Catalogue
    from orbitdb.store.asking.selection import Selection


@contextmanager
def reading(
    db: Path, asked: Sequence[str] | float | None, choice: Choice
) -> "Iterator[tuple[Catalogue, tuple[Selection, ...]]]":
    """Give a catalogue as it is at one moment, and the subset chosen by options at every a that is meant."""
    from orbitdb.catalogue.catalogue import Catalogue

    values = arguments.named(asked)
    chosen = choice.at(values[0] if values else USUAL_A)  # reports a wrong option first
    with Catalogue(db, values[0] if values else None) as opened, opened.at_one_moment() as catalogue:
        _note_rotations(chosen)
        if values is None:
            values = arguments.stored(catalogue) if asked else (_told(catalogue.a, catalogue.path),)
        yield catalogue, tuple(replace(chosen, a=a) for a in values)


def _note_rotations(chosen: "Selection") -> None:
    """Say where a filter compares codes with a rotation that names no row, once it is seen to be sound."""
    if chosen.where is None:
        return
    from orbitdb.store.asking.codes import hint
    from orbitdb.store.asking.expressions import check

    check(chosen.where, dict(chosen.parameters))
    if (told := hint(chosen.where)) is not None:
        note(told)


def averaged(choice: Choice) -> Choice:
    """Return the options that choose what is averaged over.

    Raises
    ------
    InputError
        If they ask for every status: averages are over those that have a length.
    """
    if choice.status is not None and choice.status.strip() == "all":
        raise InputError("only orbits (and boundary) have averages and lengths: leave out --status all")
    return choice


def known_catalogue(db: Path) -> Path | None:
    """Return where the catalogue is, None where there is none; say so if it was named."""
    from orbitdb.store.file.database import check_file, default_path

    if check_file(db) is not None:
        return db
    if db != default_path():
        note(f"no catalogue at {db}: solved on the spot")
    return None


def meant(db: Path, asked: Sequence[str] | float | None) -> tuple[float, ...]:
    """Return every a that is meant where single words are asked for, in a catalogue or without one.

    Raises
    ------
    StoreError
        If all are asked for that are stored, and there is no catalogue.
    """
    from orbitdb.store.file.database import check_file
    from orbitdb.store.reading.lookup import a_meant

    values = arguments.named(asked)
    if values is not None:
        return values
    if asked:
        from orbitdb.catalogue.catalogue import Catalogue

        with Catalogue(db) as catalogue:
            return arguments.stored(catalogue)
    return (USUAL_A,) if check_file(db) is None else (_told(a_meant(db), db),)


def _told(a: float, path: Path) -> float:
    """Return the a that is meant where none is named; say so where it is not the usual one."""
    if a != USUAL_A:
        note(f"a = {exact(a)}, the only one in {path}")
    return a


def note_gaps(
    catalogue: "Catalogue", *stadiums: "Selection", names: Sequence[str] = (), order: str = "p"
) -> None:
    """Say which chosen periods are stored in part, are not filled, or lack births that matter."""
    from orbitdb.catalogue.gaps import gaps

    for chosen in stadiums:
        for told in gaps(catalogue, chosen, names=names, order=order):
            note(told)


def note_nothing(catalogue: "Catalogue", *stadiums: "Selection", more: str = "") -> None:
    """Say that a subset is empty, if any of its periods is filled: of others that is not known."""
    from orbitdb.catalogue.gaps import nothing

    for chosen in stadiums:
        for told in nothing(catalogue, chosen):
            note(f"{told}{more}")


def provenance(catalogue: "Catalogue", stadiums: "Sequence[Selection]", many: bool) -> dict[str, Any]:
    """Return where rows come from; of many a, each with its own partial periods."""
    values = [chosen.a for chosen in stadiums]
    partial = [[fill.p for fill in catalogue.partial(chosen)] for chosen in stadiums]
    return {
        "orbitdb": __version__,
        "selection": stadiums[0].describe(values),
        "a": values if many else values[0],
        "database": str(catalogue.path.resolve()),
        "date": datetime.now(UTC).isoformat(timespec="seconds"),
        "partial": partial if many else partial[0],
    }
