"""All rows of a large subset as lines of text: what the words of a class share is written once, and copied.

The lines of the classes of one period lie in a draft on the disk meanwhile, so that memory does not grow with
them; each word takes the line of its class, with itself in it.
"""

import os
import tempfile
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import closing, contextmanager
from dataclasses import replace
from typing import IO, Any

import numpy as np
import sqlalchemy as sa
from numpy.typing import NDArray

from orbitdb.errors import StoreError
from orbitdb.store.asking.conditions import answering, conditions_of, containing
from orbitdb.store.asking.confinement import Patience
from orbitdb.store.asking.selection import Selection
from orbitdb.store.file.engines import little_kept
from orbitdb.store.file.schema import sequence
from orbitdb.store.reading.class_first import is_long, orders, pruned_words
from orbitdb.store.reading.class_view import class_view, same_for_classes
from orbitdb.store.reading.first_rows import keys_before_words
from orbitdb.store.reading.reader import Reader
from orbitdb.store.reading.soundness import need_words, unsound

_NAMES = ("code", "word")
_HERE = "<word>"
"""What stands in the line of a class where each of its words belongs."""

_BLOCK = 10_000

Lines = Callable[[Iterable[Sequence[Any]]], Iterator[str]]
"""What makes lines of rows."""


def spread_lines(
    reader: Reader, selection: Selection, columns: Sequence[str], order: str, lines: Lines
) -> Iterator[str] | None:
    """Return the rows of a whole subset as lines; None if it is small, or takes single words of classes.

    Parameters
    ----------
    reader : Reader
    selection : Selection
    columns : sequence of str
        Of the view ``catalogue``.
    order : str
        Only that of the table will do.
    lines : callable
        Makes a line of each row.
    """
    known = {*_NAMES, "rules", *class_view().c.keys()}
    if keys_before_words(order) or not known.issuperset(columns) or not set(_NAMES).intersection(columns):
        return None
    periods = periods_by_class(reader, selection)
    if periods is None:
        return None
    return (line for p in periods for line in _lines_of_period(reader, selection, columns, p, lines))


def periods_by_class(reader: Reader, selection: Selection) -> list[int] | None:
    """Return the chosen periods; None if the subset is small, or takes single words of classes."""
    whole = replace(selection, contains=None)
    with reader.reading() as connection:
        if not is_long(connection) or not same_for_classes(whole) or pruned_words(connection, whole):
            return None
        return [p for p in orders(connection) if selection.includes(p)]


def _lines_of_period(
    reader: Reader, selection: Selection, columns: Sequence[str], p: int, lines: Lines
) -> Iterator[str]:
    with _new_draft() as draft, reader.reading() as connection, little_kept(connection):
        numbers, ends = _write_classes(
            connection, replace(selection, contains=None), columns, p, lines, draft
        )
        if not len(numbers):
            return
        draft.flush()
        query = sa.select(sequence.c.word, sequence.c.cycle).where(sequence.c.p == p)
        if selection.contains is not None:
            query = query.where(containing(sequence.c.word, selection.contains))
        cursor = connection.execute(query.order_by(sequence.c.word)).cursor
        with closing(cursor):
            while block := cursor.fetchmany(_BLOCK):
                yield from _lines_of_block(block, p, numbers, ends, draft.fileno())


@contextmanager
def _new_draft() -> Iterator[IO[bytes]]:
    """Give a temporary file; its disk may be another one than that of what is written in the end."""
    try:
        with tempfile.TemporaryFile() as draft:
            yield draft
    except OSError as error:
        folder = tempfile.tempdir or "the folder for temporary files"
        raise StoreError(
            f"a draft cannot be written in {folder} ({error.strerror}): name another folder by TMPDIR"
        ) from error


def _write_classes(
    connection: sa.Connection,
    selection: Selection,
    columns: Sequence[str],
    p: int,
    lines: Lines,
    draft: IO[bytes],
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Write the lines of the chosen classes of one period; return their numbers, rising, and the ends."""
    known = class_view().c
    named = [_of_class(name) for name in columns]
    query = sa.select(known.cycle, *named).where(*conditions_of(selection, known), known.p == p)
    names = len(set(_NAMES).intersection(columns))
    numbers: list[NDArray[np.int64]] = [np.zeros(0, np.int64)]
    sizes: list[NDArray[np.int64]] = [np.zeros(1, np.int64)]
    with answering(connection, selection, Patience()):
        cursor = connection.execute(query.order_by(known.class_order)).cursor
        while block := cursor.fetchmany(_BLOCK):
            texts = [line.encode() for line in lines(row[1:] for row in block)]
            if any(text.count(_HERE.encode()) != names for text in texts):
                raise unsound("a text of a class of period", p)
            numbers.append(np.array([row[0] for row in block], np.int64))
            sizes.append(np.array(list(map(len, texts)), np.int64))
            draft.write(b"".join(texts))
    return np.concatenate(numbers), np.cumsum(np.concatenate(sizes))


def _of_class(name: str) -> sa.ColumnElement[Any]:
    """Return a column for the line of a class; geometric rules are broken by words of no class."""
    if name in _NAMES:
        return sa.literal(_HERE).label(name)
    return sa.null().label(name) if name == "rules" else class_view().c[name]


def places_of(
    wanted: NDArray[np.int64], numbers: NDArray[np.int64]
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return which of some numbers are among those that rise, at least one, and their places there."""
    places = np.searchsorted(numbers, wanted).clip(max=len(numbers) - 1)
    chosen = np.flatnonzero(numbers[places] == wanted)  # `np.isin` would sort all of them for each block
    return chosen, places[chosen]


def _lines_of_block(
    block: Sequence[tuple[str, int | None]],
    p: int,
    numbers: NDArray[np.int64],
    ends: NDArray[np.int64],
    draft: int,
) -> Iterator[str]:
    """Yield the lines of some words, but for those whose class is not chosen."""
    words, cycles = zip(*block, strict=True)
    need_words(words, [p] * len(words))
    wanted = np.array([number or 0 for number in cycles], np.int64)
    chosen, places = places_of(wanted, numbers)
    starts = ends[places]
    sizes = ends[places + 1] - starts
    for row, start, size in zip(chosen.tolist(), starts.tolist(), sizes.tolist(), strict=True):
        yield os.pread(draft, size, start).decode().replace(_HERE, words[row])
