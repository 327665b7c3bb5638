"""The classes of a catalogue and their words, block by block.

Of a period of which all classes are there, the words of a span at a time are enumerated, and what must be
stored of them is compared with what is, which is read in its order. Of other periods the words are looked up
class by class; so are those of a span that is not as it must be, to say which are wrong.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from orbitdb.billiard.stadium import STRAIGHT
from orbitdb.store.file.schema import DONE
from orbitdb.store.reading import audit
from orbitdb.store.reading.soundness import sound_words
from orbitdb.store.reading.stored_blocks import (
    Ids,
    StoredSpan,
    blocks,
    load_class_rows,
    load_classes,
    load_sequences,
    load_span,
)
from orbitdb.symbols import symmetry
from orbitdb.symbols.counting import count_admissible
from orbitdb.symbols.enumeration import MAX_PERIOD, Span, admissible_words, spans
from orbitdb.symbols.least_words import least_words
from orbitdb.symbols.words import (
    MAX_KEYED,
    MAX_PACKED,
    from_strings,
    key,
    keys,
    least_rotations,
    pack,
    to_strings,
    unpack,
    word_of,
)
from orbitdb.verification.blocks import ClassBlock
from orbitdb.verification.check import Check, Step, judged

if TYPE_CHECKING:
    import sqlalchemy as sa

_SPAN = 1 << 15
"""Words of a span: what is in work fits into the processor's cache."""

Entry = tuple[int, int, str | None]
"""What is stored of a word: its class, the element, and the rules it breaks."""


def word_blocks(connection: "sa.Connection", path: Path, chosen: Iterable[Ids]) -> Iterator[ClassBlock]:
    """Yield blocks of all classes that are chosen at some a."""
    ids: Ids = {}
    for part in chosen:
        for p, those in part.items():
            ids[p] = np.union1d(ids.get(p, those), those)
    fills = audit.fills(connection)
    done = {fill["p"] for fill in fills if fill["state"] == DONE}
    cursors = {fill["p"]: fill["cursor"] or "" for fill in fills if fill["p"] not in done}
    total, before = sum(map(len, ids.values())), 0
    for p, those in sorted(ids.items()):
        if p not in cursors and _are_all(those, p):
            yield from _span_blocks(path, p, those, before, total)
        else:
            for _, block, earlier in blocks({p: those}):
                yield WordBlock(path, p, block, before + earlier, total, cursors.get(p))
        before += len(those)


def _are_all(ids: NDArray[np.int64], p: int) -> bool:
    """Tell whether numbers, which rise, are those of all classes of a period."""
    if p > MAX_PERIOD or len(ids) * len(symmetry.ELEMENTS) < count_admissible(p):
        return False
    return np.array_equal(ids, np.concatenate([keys(part.codes, p) for part in least_words(Span.whole(p))]))


def _span_blocks(
    path: Path, p: int, ids: NDArray[np.int64], before: int, total: int
) -> Iterator["SpanBlock"]:
    """Yield blocks of all classes of a period."""
    start = 0
    for span in spans(p, _SPAN):
        end = int(np.searchsorted(ids, keys(np.array([span.upto]), p)[0], side="right"))
        yield SpanBlock(path, p, ids[start:end], before + start, total, span)
        start = end


@dataclass(frozen=True, eq=False)
class WordBlock(ClassBlock):
    """Classes of which the words are to be checked.

    Attributes
    ----------
    cursor : str or None
        The words of the period behind this one may not be stored yet.
    """

    cursor: str | None

    def checked(self, connection: "sa.Connection") -> Step:
        """Return what is found in the rows that a connection reads."""
        rows = load_classes(connection, self.ids)
        classes, families = _classes(rows, self.p)
        expected = [each for each in _entries(families) if self.cursor is None or each[0] <= self.cursor]
        checks = classes, _sequences(connection, self.p, expected)
        return Step(f"words, p = {self.p}", self.done, self.total, checks)


@dataclass(frozen=True, eq=False)
class SpanBlock(ClassBlock):
    """Words of a period of which all classes are to be checked, and those of the classes that begin there.

    Attributes
    ----------
    span : Span
        The words; the numbers are those of the classes whose least words are among them.
    """

    span: Span

    def checked(self, connection: "sa.Connection") -> Step:
        """Return what is found in the rows that a connection reads."""
        expected = _Expected(self.span)
        checks = *self._classes(connection, expected), self._words(connection, expected)
        return Step(f"words, p = {self.p}", self.done, self.total, checks)

    def _classes(self, connection: "sa.Connection", expected: "_Expected") -> Iterator[Check]:
        if load_class_rows(connection, self.ids) == expected.class_rows(self.p):
            yield Check("classes", len(self.ids))
            return
        check, families = _classes(load_classes(connection, self.ids), self.p)
        yield check
        strange = [(number, images) for number, images in families if images.get(word_of(number)) != 0]
        yield replace(_sequences(connection, self.p, _entries(strange)), rows=0)  # they are in other spans

    def _words(self, connection: "sa.Connection", expected: "_Expected") -> Check:
        if expected.is_stored(load_span(connection, self.span)):
            return Check("sequences", len(expected.codes))
        return _sequences(connection, self.p, expected.entries())


class _Expected:
    """What must be stored of the words of a span."""

    def __init__(self, span: Span) -> None:
        chunks = [np.zeros((0, span.p), dtype=np.uint8), *admissible_words(*span)]
        self.words = np.concatenate(chunks)
        self.codes = pack(self.words)
        self.classes = symmetry.classify_packed(self.codes, span.p)
        self.numbers = keys(self.classes.representative, span.p)

    def class_rows(self, p: int) -> list[tuple[Any, ...]]:
        """Return the rows of the classes whose least words are here."""
        least = np.flatnonzero(self.classes.representative == self.codes)
        words, masks = self.words[least], self.classes.stabiliser[least]
        sizes, walls = symmetry.SIZES[masks].tolist(), STRAIGHT[words].sum(axis=1).tolist()
        numbers = self.numbers[least].tolist()
        columns = zip(numbers, to_strings(words), sizes, walls, masks.tolist(), strict=True)
        return [(number, p, word, size, wall, *_labels(mask)) for number, word, size, wall, mask in columns]

    def is_stored(self, found: StoredSpan) -> bool:
        """Tell whether just these words are stored, each with its class and its element."""
        count, p = self.words.shape
        return (
            (found.total, found.longest) == (count, p if count else 0)  # so no other words join to the same
            and found.words == _digits(self.words)
            and found.elements == _digits(self.classes.element)
            and np.array_equal(found.cycles, self.numbers)
        )

    def entries(self) -> list[tuple[str, Entry]]:
        """Return the words, and what must be stored of each."""
        of_classes = zip(self.numbers.tolist(), self.classes.element.tolist(), strict=True)
        entries: Iterator[Entry] = ((number, element, None) for number, element in of_classes)
        return list(zip(to_strings(self.words), entries, strict=True))


@cache
def _labels(stabiliser: int) -> tuple[str, str]:
    return symmetry.time_reversal(stabiliser), symmetry.label(stabiliser)


def _digits(symbols: NDArray[np.uint8]) -> str:
    """Return symbols one behind the other."""
    return (symbols + np.uint8(ord("0"))).tobytes().decode("ascii")


def _classes(rows: Sequence[Mapping[str, Any]], p: int) -> tuple[Check, list[tuple[int, dict[str, int]]]]:
    """Check classes of one period; return also the numbers of those with sound words, with their images."""
    words = [row["word"] for row in rows]
    sound = sound_words(words, p)
    unsound = judged("classes", words, ~np.isin(np.arange(len(words)), sound))
    rows = [rows[i] for i in sound]
    families = class_members([words[i] for i in sound], p)
    wrong = [
        row["word"] != min(images)
        or (p <= MAX_KEYED and row["id"] != key(row["word"]))
        or row["p"] != p
        or row["class_size"] != len(images)
        or row["walls"] != row["word"].count("0") + row["word"].count("2")
        or (row["time_reversal"], row["symmetry"]) != _labels(stabiliser)
        for row, (images, stabiliser) in zip(rows, families, strict=True)
    ]
    found = judged("classes", [row["word"] for row in rows], wrong)
    check = unsound.joined(replace(found, rows=0))  # the rows are counted already
    return check, [(row["id"], images) for row, (images, _) in zip(rows, families, strict=True)]


def _entries(families: Iterable[tuple[int, dict[str, int]]]) -> list[tuple[str, Entry]]:
    """Return the words of classes, and what must be stored of each."""
    return [
        (word, (number, element, None)) for number, images in families for word, element in images.items()
    ]


def _sequences(connection: "sa.Connection", p: int, expected: Sequence[tuple[str, Entry]]) -> Check:
    """Check that words are stored as they must be."""
    stored = load_sequences(connection, p, [word for word, _ in expected])
    differ = [stored.get(word) != entry for word, entry in expected]
    return judged("sequences", [word for word, _ in expected], differ)


def class_members(words: Sequence[str], p: int) -> list[tuple[dict[str, int], int]]:
    """Return for each word its images, each with the first element that leads to it, and its stabiliser.

    The images are least rotations.
    """
    if p > MAX_PACKED:
        return [(symmetry.members(word), symmetry.class_of(word).stabiliser) for word in words]
    symbols = from_strings(words)
    images = [
        least_rotations(pack(symmetry.act_on_words(element, symbols)), p) for element in symmetry.ELEMENTS
    ]
    stabilisers = sum((image == images[0]).astype(int) << g for g, image in enumerate(images))
    columns = [to_strings(unpack(image, p)) for image in images]
    families = []
    for places, stabiliser in zip(zip(*columns, strict=True), np.asarray(stabilisers).tolist(), strict=True):
        first: dict[str, int] = {}
        for element, image in enumerate(places):
            first.setdefault(image, element)
        families.append((first, stabiliser))
    return families
