"""Helpers for commands that ask a catalogue: codes, columns, and the values of a."""

import sys
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING

from orbitdb.billiard import USUAL_A
from orbitdb.cli.grids import Asked, GivenValues, many_a, named
from orbitdb.cli.notes import note, progress, takes_a
from orbitdb.cli.options import SelectionOptions
from orbitdb.cli.output import repeats
from orbitdb.columns import COMPUTED, IN_CATALOGUE
from orbitdb.errors import InputError, StoreError
from orbitdb.store.paths import default_path
from orbitdb.text import several

if TYPE_CHECKING:
    from orbitdb.catalogue import Catalogue
    from orbitdb.selection import Selection
    from orbitdb.store.file import Migration

OF_CATALOGUE = tuple(column.name for column in (*IN_CATALOGUE, *COMPUTED))
COORDINATES = "coordinates"

_AROUND = " \t\r\n\ufeff"
"""Characters allowed around a code, including the byte order mark of files from Windows."""


_FEW = 3
"""Number of words that repeat a shorter one which are named."""


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


def primitive_words(codes: Iterable[str]) -> list[str]:
    """Parse codes, as `primitive` does; if some cannot be read, raise an error that names all of these."""
    from orbitdb.symbols.words import parse, primitive_root, read_words

    words = read_words(codes, read=parse)
    roots = [*map(primitive_root, words)]
    repeated = [(word, root) for word, root in zip(words, roots, strict=True) if word != root]
    for word, root in repeated[:_FEW]:
        note(repeats(word, root))
    if more := len(repeated[_FEW:]):
        note(f"likewise {several(more, 'other word')}")
    return roots


def chosen_codes(code: Iterable[str] | None) -> list[str] | None:
    """Return the words of --code that choose rows, or None without it."""
    if code is None:
        return None
    if not (codes := primitive_words(given_codes(code))):
        raise InputError("stdin contains no code")
    return codes


def asked_columns(
    columns: str | None, usual: Sequence[str], a: Sequence[GivenValues] | None, allowed: Sequence[str] = ()
) -> tuple[str, ...]:
    """Return the requested columns, or the usual ones if `columns` is None.

    `allowed` are the columns that may be requested, by default those of the catalogue. A text that begins
    with a plus adds columns to the usual ones. If --a may stand for several values, the column a is added:
    first, or second if the word comes first.
    """
    names = tuple(usual)
    if columns is not None:
        adds = columns.lstrip().startswith("+")
        named = _named_columns(columns, allowed or (*OF_CATALOGUE, COORDINATES), adds)
        names = tuple(dict.fromkeys((*usual, *named))) if adds else named
    if "a" in names or not many_a(a):
        return names
    place = 1 if names[:1] == ("code",) else 0
    return (*names[:place], "a", *names[place:])


def _named_columns(text: str, columns: Sequence[str], adds: bool) -> tuple[str, ...]:
    """Read names of columns, separated by commas; each must be one of `columns`, with a plus if `adds`."""
    from orbitdb.criteria import unknown_column
    from orbitdb.errors import SelectionError

    names = tuple(name.strip().removeprefix("+" if adds else "") for name in text.split(","))
    for name in names:
        if name not in columns:
            raise unknown_column(name, columns)
    if twice := [name for place, name in enumerate(names) if name in names[:place]]:
        raise SelectionError(f"column {twice[0]!r} is named twice")
    return names


@contextmanager
def snapshot(
    db: Path,
    asked: Asked,
    choice: SelectionOptions,
    usual: Sequence[str] | None = None,
    code: Iterable[str] | None = None,
) -> "Iterator[tuple[Catalogue, tuple[Selection, ...]]]":
    """Open a catalogue, and yield a snapshot of it with the subset that the options choose at each a.

    `usual` and `code` are those of `SelectionOptions.at`.
    """
    from orbitdb.catalogue import Catalogue

    values = named(asked)
    chosen = choice.at(values[0] if values else USUAL_A, usual, code)  # reports wrong options first
    catalogue = Catalogue(db)
    with catalogue.snapshot() as then:
        yield then, tuple(replace(chosen, a=a) for a in _values(then, asked))


@contextmanager
def snapshot_at(db: Path, asked: float | None) -> "Iterator[tuple[Catalogue, float]]":
    """Open a catalogue, and yield a snapshot of it with the given or the default a."""
    with snapshot(db, asked, SelectionOptions()) as (catalogue, (chosen,)):
        yield catalogue, chosen.a


@contextmanager
def solving(db: Path, asked: Asked) -> "Iterator[tuple[Catalogue, tuple[float, ...]]]":
    """Yield a snapshot of a catalogue that need not exist, and the values of a at which to look up words.

    A note says that there is no catalogue, unless it is the default one.
    """
    from orbitdb.catalogue import Catalogue

    catalogue = Catalogue(db, missing_ok=named(asked) is not None or not asked)
    with catalogue.snapshot() as then:
        values = _values(then, asked)
        if then.missing and db != default_path():
            note(f"no catalogue at {db}: solved on the spot")
        yield then, values


def given_a(db: Path, asked: Asked) -> tuple[float, ...]:
    """Return the given values of a, or else the default one of a catalogue, which need not exist."""
    from orbitdb.catalogue import Catalogue

    return _values(Catalogue(db, missing_ok=True), asked)


def _values(catalogue: "Catalogue", asked: Asked) -> tuple[float, ...]:
    """Return the given values of a, every one with orbits or sweeps, or the default one, with a note."""
    values, said = named(asked), None
    if values is None and asked:
        values = tuple(catalogue.a_values(orbits=True))
    if not values:
        values, said = (catalogue.a,), None if asked else catalogue.note_on_a
    if len(values) == 1:
        takes_a(*values, said)
    return values


def storable(catalogue: "Catalogue", store: bool | None) -> bool:
    """Return whether to store a result, and make or upgrade the catalogue for it; raise, or note why not."""
    if store is False:
        return False
    try:
        bring(catalogue.path)
        catalogue.check_writable()
    except StoreError as error:
        if store:
            raise
        note(f"the result is not saved: {error}")
        return False
    return True


def bring(path: Path) -> "Migration":
    """Create a catalogue, or upgrade an older one to the latest schema and say so."""
    from orbitdb.catalogue import Catalogue

    with progress("updating the catalogue to the latest schema"):
        done = Catalogue.migrate(path)
    if 0 < done.before < done.after:
        note(f"{path}: schema {done.before} -> {done.after}")
    return done
