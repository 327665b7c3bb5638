"""What commands that read a catalogue begin with: which a is meant, and what of the subset is filled."""

from collections.abc import Iterator, Sequence
from contextlib import closing, contextmanager
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
def reading(db: Path | None, a: float | None, choice: Choice) -> "Iterator[tuple[Catalogue, Selection]]":
    """Give a catalogue as it is at one moment, and the subset chosen by options at the a that is meant."""
    from orbitdb.billiard.stadium import Stadium

    values = None if a is None else (Stadium(a).a,)
    with _opened(db, values, False, choice) as (catalogue, (chosen,)):
        yield catalogue, chosen


@contextmanager
def reading_all(
    db: Path | None, asked: Sequence[str] | None, choice: Choice
) -> "Iterator[tuple[Catalogue, tuple[Selection, ...]]]":
    """Give a catalogue as it is at one moment, and the subset chosen by options at every a that is meant."""
    with _opened(db, arguments.named(asked), bool(asked), choice) as found:
        yield found


@contextmanager
def _opened(
    db: Path | None, values: Sequence[float] | None, every: bool, choice: Choice
) -> "Iterator[tuple[Catalogue, tuple[Selection, ...]]]":
    from orbitdb.catalogue.catalogue import Catalogue

    chosen = choice.at(values[0] if values else USUAL_A)  # reports a wrong option first
    with closing(Catalogue(db, values[0] if values else None)) as opened, opened.at_one_moment() as catalogue:
        _note_rotations(chosen)
        if values is None:
            values = arguments.stored(catalogue) if every else (_told(catalogue.a, catalogue.path),)
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


def known_catalogue(db: Path | None) -> Path | None:
    """Return where the catalogue is, None where there is none; say so if it was named."""
    from orbitdb.store.file.database import check_file, default_path

    path = db or default_path()
    if check_file(path) is not None:
        return path
    if db is not None:
        note(f"no catalogue at {path}: solved on the spot")
    return None


def all_meant(path: Path, asked: Sequence[str] | None) -> tuple[float, ...]:
    """Return every a that is meant where single words are asked for, in a catalogue or without one.

    Raises
    ------
    StoreError
        If all are asked for that are stored, and there is no catalogue.
    """
    values = arguments.named(asked)
    if values is not None:
        return values
    if not asked:
        return (meant(path, None),)
    from orbitdb.catalogue.catalogue import Catalogue

    with closing(Catalogue(path)) as catalogue:
        return arguments.stored(catalogue)


def meant(path: Path, a: float | None) -> float:
    """Return the a that is meant where a single word is asked for, in a catalogue or without one."""
    from orbitdb.billiard.stadium import Stadium
    from orbitdb.store.file.database import check_file
    from orbitdb.store.reading.lookup import a_meant

    if a is not None:
        return Stadium(a).a
    if check_file(path) is None:
        return USUAL_A
    return _told(a_meant(path), path)


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
