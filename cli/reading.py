"""Helpers for commands with a catalogue: codes, the values of a, notes on gaps, and rows in order."""

import heapq
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from datetime import UTC, datetime
from functools import cmp_to_key
from itertools import chain, islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

from orbitdb import __version__
from orbitdb.billiard import USUAL_A
from orbitdb.cli.options import Asked, Choice, HalfLengths, many_a, named
from orbitdb.cli.output import note, progress, repeats
from orbitdb.columns import COMPUTED, IN_CATALOGUE, Row
from orbitdb.errors import InputError
from orbitdb.store.paths import default_path
from orbitdb.text import exact, several

if TYPE_CHECKING:
    from orbitdb.store.connection import Moment
    from orbitdb.store.file import Migration
    from orbitdb.store.rows import Chosen
    from orbitdb.store.selection import Selection

OF_CATALOGUE = tuple(column.name for column in (*IN_CATALOGUE, *COMPUTED))
_NATURAL = ("p", "representative", "element")
"""The columns that decide the order of rows with equal sort keys."""


_AROUND = " \t\r\n\ufeff"
"""Characters allowed around a code, including the byte order mark of files from Windows."""


def given_codes(*given: Iterable[str] | None) -> Iterator[str]:
    """Yield the words given as arguments or with ``--code``, unchecked; ``-`` reads one per line of stdin."""
    try:
        for code in chain.from_iterable(codes or () for codes in given):
            if code == "-":
                yield from (code for line in sys.stdin or () if (code := line.strip(_AROUND)))
            else:
                yield code
    except UnicodeDecodeError:
        raise InputError("stdin is not text: write one code per line") from None


def primitive(code: str) -> str:
    """Parse a code; if it repeats a shorter word, write a note and return the shorter word."""
    from orbitdb.symbols.words import parse, primitive_root

    word = parse(code)
    root = primitive_root(word)
    if root != word:
        note(repeats(word, root))
    return root


def asked_columns(
    columns: str | None, usual: Sequence[str], a: Sequence[HalfLengths] | None, allowed: Sequence[str] = ()
) -> tuple[str, ...]:
    """Return the requested columns, or the usual ones if `columns` is None.

    `allowed` are the columns that may be requested, by default those of the catalogue. If --a may stand for
    several values, the column a is added: first, or second if the word comes first.
    """
    from orbitdb.store.selection import parse_names

    names = tuple(usual if columns is None else parse_names(columns, allowed or OF_CATALOGUE))
    if "a" in names or not many_a(a):
        return names
    place = 1 if names[:1] == ("code",) else 0
    return (*names[:place], "a", *names[place:])


@contextmanager
def reading(db: Path, asked: Asked, choice: Choice) -> "Iterator[tuple[Moment, tuple[Selection, ...]]]":
    """Open a catalogue at one moment; yield it with the subset that the options choose at each a."""
    from orbitdb.store.file import reading as opened

    values = named(asked)
    chosen = choice.at(values[0] if values else USUAL_A)  # reports wrong options first
    with opened(db) as moment:
        _note_rotations(chosen)
        values = values or _stored(moment, asked, db)
        yield moment, tuple(replace(chosen, a=a) for a in values)


def _note_rotations(chosen: "Selection") -> None:
    """Check the SQL filter; write a note if it compares a code with a rotation that no row contains."""
    if chosen.where is None:
        return
    from orbitdb.store.where import check, hint

    check(chosen.where, dict(chosen.parameters))
    if (advice := hint(chosen.where)) is not None:
        note(advice)


def bring(path: Path) -> "Migration":
    """Create a catalogue, or upgrade an older one to the latest schema and say so."""
    from orbitdb.store.file import migrate

    with progress("updating the catalogue to the latest schema"):
        done = migrate(path)
    if 0 < done.before < done.after:
        note(f"{path}: schema {done.before} -> {done.after}")
    return done


def known_catalogue(db: Path) -> Path | None:
    """Return the path of the catalogue; None if it does not exist, with a note unless it is the default."""
    from orbitdb.store.file import check_file

    if check_file(db) is not None:
        return db
    if db != default_path():
        note(f"no catalogue at {db}: solved on the spot")
    return None


def meant(db: Path, asked: Asked) -> tuple[float, ...]:
    """Return the values of a at which to look up single words; the catalogue need not exist."""
    from orbitdb.store.file import check_file
    from orbitdb.store.file import reading as opened

    if (values := named(asked)) is not None:
        return values
    if not asked and check_file(db) is None:
        return (USUAL_A,)
    with opened(db) as moment:
        return _stored(moment, asked, db)


def _stored(moment: "Moment", asked: Asked, path: Path) -> tuple[float, ...]:
    """Return every a with orbits or sweeps for --a all, or else the default a; note an unusual default."""
    from orbitdb.store.lookup import WITH_ORBITS, a_meant, a_values

    if asked:
        return tuple(a_values(moment, WITH_ORBITS)) or (USUAL_A,)
    if (a := a_meant(moment)) != USUAL_A:
        note(f"a = {exact(a)}, the only value in {path}")
    return (a,)


def note_gaps(moment: "Moment", *stadiums: "Selection", names: Sequence[str] = (), order: str = "p") -> None:
    """Write notes on chosen periods that are partly filled, not filled, or lack births that are needed."""
    from orbitdb.answers.completeness import gaps

    for chosen in stadiums:
        for text in gaps(moment, chosen, names=names, order=order):
            note(text)


def note_nothing(moment: "Moment", *stadiums: "Selection", more: str = "") -> None:
    """Write a note for each empty subset that includes a filled period."""
    from orbitdb.answers.completeness import nothing

    for chosen in stadiums:
        if text := nothing(moment, chosen):
            note(f"{text}{more}")


_falling: Callable[[Any], Any] = cmp_to_key(
    lambda one, other: 0 if one == other else 1 if one < other else -1
)
"""Sort key for descending order."""


def in_order(
    moment: "Moment",
    subsets: "Sequence[Chosen]",
    names: tuple[str, ...],
    order: str,
    limit: int | None,
    offset: int = 0,
) -> Iterator[Row]:
    """Return the rows of one subset, or of one subset at each of several a, merged into one order.

    Empty fields come last, whether the order is ascending or descending.
    """
    from orbitdb.store.query import parse_order
    from orbitdb.store.rows import rows_of

    end = None if limit is None else limit + offset
    if len(subsets) == 1:
        return rows_of(moment, subsets[0], names, offset, end)
    falling = parse_order(order)
    for name in _NATURAL:
        falling.setdefault(name, False)

    def place(row: Row) -> tuple[Any, ...]:
        keys = zip(row[len(names) :], falling.values(), strict=True)
        return tuple(
            (value is None, _falling(value) if falls and value is not None else value)
            for value, falls in keys
        )

    streams = (rows_of(moment, chosen, (*names, *falling), 0, end) for chosen in subsets)
    return (row[: len(names)] for row in islice(heapq.merge(*streams, key=place), offset, end))


def described(stadiums: "Sequence[Selection]", total: int | None = None, classes: bool = False) -> str:
    """Describe the chosen rows at one or several a, with their number if `total` is given."""
    values = [chosen.a for chosen in stadiums]
    if not classes:
        return stadiums[0].describe(values, total)
    number = "classes" if total is None else several(total, "class", "classes")
    return f"{number} of {stadiums[0].describe(values)}"


def provenance(
    moment: "Moment", stadiums: "Sequence[Selection]", many: bool, classes: bool = False
) -> dict[str, Any]:
    """Return the provenance of rows; if `many`, its a and partial periods are lists with one item per a."""
    from orbitdb.answers.completeness import partial_periods

    values = [chosen.a for chosen in stadiums]
    partial = [partial_periods(moment, chosen) for chosen in stadiums]
    return {
        "orbitdb": __version__,
        "selection": described(stadiums, classes=classes),
        "a": values if many else values[0],
        "database": str(moment.path.resolve()),
        "date": datetime.now(UTC).isoformat(timespec="seconds"),
        "partial": partial if many else partial[0],
    }
