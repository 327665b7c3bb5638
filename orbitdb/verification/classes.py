"""The rows of classes and of pruned words, each compared with what follows from its word, ids and all.

It does not matter what has stored a row: a fill, births or a single word. Rows that are as they must be are
of different classes, for the id is the key of the least word, and no id comes twice: so no class is stored
twice, and no word in two classes. `orbitdb.verification.completeness` tells how many there must be.
"""

from collections.abc import Iterator, Sequence
from functools import cache, partial
from typing import Any

import sqlalchemy as sa

from orbitdb.store.asking.selection import Selection
from orbitdb.store.file.schema import LONG
from orbitdb.store.file.tables import cycle, pruned
from orbitdb.store.reading.audit import by_period, ids_in, load_rows
from orbitdb.store.reading.soundness import is_written, sound_words
from orbitdb.symbols import symmetry
from orbitdb.symbols.members import joined_members, joined_words
from orbitdb.symbols.pruning import FAMILY, rule_numbers, rules_broken
from orbitdb.symbols.words import (
    MAX_KEYED,
    are_primitive,
    from_strings,
    key,
    least_rotation,
    least_rotations,
    pack,
)
from orbitdb.verification.blocks import Block, Part, blocks, is_chosen
from orbitdb.verification.check import Check, judged

Row = tuple[Any, ...]


def class_parts(connection: sa.Connection, selections: Sequence[Selection]) -> Iterator[Part]:
    """Yield blocks of all classes and pruned words of the chosen periods; of all, if no a is chosen."""
    for table in (cycle, pruned):
        found = by_period(connection, ids_in(connection, table.c.id), table)
        for block in blocks({p: ids for p, ids in found.items() if is_chosen(p, selections)}):
            stage, name = ("classes",) * 2 if table is cycle else ("pruned words", "rules")
            yield block.part(stage, partial(_compared, name))


def _compared(name: str, block: Block, connection: sa.Connection) -> Iterator[Check]:
    """Check rows of `cycle`, or of `pruned`."""
    of_pruned = name == "rules"
    rows = load_rows(connection, pruned if of_pruned else cycle, block.ids)
    expected = _expected(rows, block.p, of_pruned)
    wrong = [row != must for row, must in zip(rows, expected, strict=True)]
    yield judged(name, [row[2] for row in rows], wrong)


def _expected(rows: Sequence[Row], p: int, of_pruned: bool) -> list[Row | None]:
    """Return rows as their words say that they must be; None for words that must not be there."""
    words = [row[2] for row in rows]
    if of_pruned:
        sound = [i for i, word in enumerate(words) if is_written(word, p)]
    else:
        sound = sound_words(words, p).tolist()
    found: list[Row | None] = [None] * len(rows)
    if known := [words[i] for i in sound]:
        rest = _pruned_rows(known, p) if of_pruned else _class_rows(known, p)
        for i, columns in zip(sound, rest, strict=True):
            found[i] = columns and (_id(columns[1], of_pruned, rows[i][0]), *columns)
    return found


def _id(word: str, of_pruned: bool, stored: int) -> int:
    """Return the id that a word must have; longer ones are numbered as they came."""
    if len(word) <= MAX_KEYED:
        return -key(word) if of_pruned else key(word)
    return min(stored, -LONG) if of_pruned else max(stored, LONG)


def _class_rows(words: Sequence[str], p: int) -> Iterator[Row]:
    """Yield what rows of the classes of some words must have behind their ids."""
    if p > MAX_KEYED:
        families = [symmetry.class_of(word) for word in words]
        stabilisers = [each.stabiliser for each in families]
        joined = [joined_members(each.representative) for each in families]
    else:
        found = symmetry.classify(least_rotations(pack(from_strings(words)), p), p)
        stabilisers = found.stabiliser.tolist()
        joined = joined_words(found.representative, found.stabiliser, p)
    for mask, members in zip(stabilisers, joined, strict=True):
        least = members[:p]
        walls = least.count("0") + least.count("2")
        yield p, least, symmetry.class_size(mask), walls, *_labels(mask), members


@cache
def _labels(stabiliser: int) -> tuple[str, str]:
    return symmetry.time_reversal(stabiliser), symmetry.label(stabiliser)


def _pruned_rows(words: Sequence[str], p: int) -> Iterator[Row | None]:
    """Yield what rows of some words must have behind their ids if they are pruned; None for others."""
    symbols = from_strings(words)
    masks, primitive = rules_broken(symbols).tolist(), are_primitive(symbols).tolist()
    for word, mask, whole in zip(words, masks, primitive, strict=True):
        is_pruned = mask and whole and word != FAMILY
        yield (p, least_rotation(word), ",".join(map(str, rule_numbers(mask)))) if is_pruned else None
