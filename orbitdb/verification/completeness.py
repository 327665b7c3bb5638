"""The census of a catalogue: its file and schema, and whether its words and classes are all there.

The words of a period are complete if every class has all its images, each with the class and the
element that leads to it, and their number is that of the transfer matrix: by the table's key no word
is stored twice.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from orbitdb.orbits.orbit import Status
from orbitdb.store.asking.selection import Selection
from orbitdb.store.file.schema import DONE, FILLING
from orbitdb.store.reading import audit
from orbitdb.store.reading.catalogue import Catalogue
from orbitdb.store.reading.lives import birth_fills
from orbitdb.store.reading.soundness import is_written, sound_words
from orbitdb.store.reading.stored_blocks import (
    SYMBOLS_A_BLOCK,
    Ids,
    blocks,
    load_classes,
    load_sequences,
)
from orbitdb.symbols import symmetry
from orbitdb.symbols.automaton import RULE_NUMBERS
from orbitdb.symbols.counting import count_admissible, count_primitive
from orbitdb.symbols.pruning import rule_numbers, rules_broken
from orbitdb.symbols.words import (
    MAX_KEYED,
    MAX_PACKED,
    from_strings,
    is_primitive,
    key,
    least_rotation,
    least_rotations,
    pack,
    to_strings,
    unpack,
)
from orbitdb.verification.blocks import ClassBlock
from orbitdb.verification.check import Check, Step, judged

if TYPE_CHECKING:
    import sqlalchemy as sa


def check_file(connection: "sa.Connection") -> Iterator[Check]:
    """Check the file, its references, and its schema."""
    errors = audit.file_errors(connection)
    yield Check("file", 1, int(bool(errors)), first=errors[0] if errors else None)
    loose = audit.dangling(connection)
    yield Check("foreign keys", audit.row_count(connection), len(loose), first=loose[0] if loose else None)
    parts, different = audit.schema_differences(connection)
    yield Check("schema", parts, len(different), first=different[0] if different else None)


def check_counts(connection: "sa.Connection", selections: Sequence[Selection]) -> Iterator[Check]:
    """Check the numbers of words of every period, and the counts of every fill."""
    fills, words = audit.fills(connection), audit.word_counts(connection)
    chosen, born = {s.a: s for s in selections}, {each.p for each in birth_fills(connection)}
    for p in sorted({fill["p"] for fill in fills} | words.keys()):
        if any(selection.includes(p) for selection in selections):
            states = {fill["state"] for fill in fills if fill["p"] == p}
            sequences, classes, claimed = words.get(p, (0, 0, 0))
            if p in born and not states:  # births bring the classes of all words, and only the classes
                claimed = audit.words_without_fill(connection, p)
            yield _count(p, states, sequences, classes, claimed)
    for fill in fills:
        if fill["a"] in chosen and chosen[fill["a"]].includes(fill["p"]):
            statuses = audit.status_counts(connection, fill["stadium"], fill["p"])
            classes = words.get(fill["p"], (0, 0, 0))[1]
            wrong = list(_wrong_counts(fill, statuses, classes))
            label = f"p = {fill['p']} at a = {fill['a']:g}: {wrong[0]}" if wrong else None
            yield Check("fills", 1, int(bool(wrong)), first=label)


def _count(p: int, states: set[str], sequences: int, classes: int, claimed: int) -> Check:
    """Check a period's number of words; those of a fill that goes on come before their classes do."""
    expected = count_admissible(p) if DONE in states else sequences if states else claimed
    off = abs(sequences - expected) or (abs(claimed - expected) if DONE in states else 0)
    what = f"{sequences} sequences" if sequences != expected else f"classes of {claimed} sequences"
    first = f"p = {p}: {what} instead of {expected}" if off else None
    return Check("counts", sequences, off, first=first)


def _wrong_counts(
    fill: Mapping[str, Any], statuses: Mapping[str, tuple[int, int]], classes: int
) -> Iterator[str]:
    """Yield what is wrong with the counts of a fill, given those of its rows by status."""
    if fill["state"] != DONE:
        if fill["state"] != FILLING:
            yield f"state {fill['state']}"
        return
    p, primitive = fill["p"], count_primitive(fill["p"])
    n_c, orbit_classes = statuses.get(Status.ORBIT, (0, 0))
    expected = {
        "primitive": primitive,
        **{f"rule_{n}": primitive - count_admissible(p, frozenset([n])) for n in sorted(RULE_NUMBERS)},
        "n_t": count_admissible(p),
        "n_c": n_c,
        "classes": orbit_classes,
        "boundary": statuses.get(Status.BOUNDARY, (0, 0))[0],
        "unresolved": statuses.get(Status.UNRESOLVED, (0, 0))[0],
    }
    for name, value in expected.items():
        if fill[name] != value:
            yield f"{name} is {fill[name]} instead of {value}"
    solved = sum(count for _, count in statuses.values())
    if solved != classes:
        yield f"{solved} of {classes} classes have a row"


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
        checks = tuple(_classes(connection, self.p, rows, self.cursor))
        return Step(f"words, p = {self.p}", self.done, self.total, checks)


def word_blocks(connection: "sa.Connection", path: Path, chosen: Iterable[Ids]) -> Iterator[WordBlock]:
    """Yield blocks of all classes that are chosen at some a."""
    ids: Ids = {}
    for part in chosen:
        for p, those in part.items():
            ids[p] = np.union1d(ids.get(p, those), those)
    ids = dict(sorted(ids.items()))
    fills = audit.fills(connection)
    done = {fill["p"] for fill in fills if fill["state"] == DONE}
    cursors = {fill["p"]: fill["cursor"] or "" for fill in fills if fill["p"] not in done}
    total = sum(map(len, ids.values()))
    for p, block, before in blocks(ids):
        yield WordBlock(path, p, block, before, total, cursors.get(p))


def _classes(
    connection: "sa.Connection", p: int, rows: Sequence[Mapping[str, Any]], cursor: str | None
) -> Iterator[Check]:
    """Check classes of one period and all their words; behind a cursor words may not be stored yet."""
    words = [row["word"] for row in rows]
    sound = sound_words(words, p)
    yield judged("classes", words, ~np.isin(np.arange(len(words)), sound))
    rows = [rows[i] for i in sound]
    families = class_members([words[i] for i in sound], p)
    wrong = [
        row["word"] != min(images)
        or (p <= MAX_KEYED and row["id"] != key(row["word"]))
        or row["p"] != p
        or row["class_size"] != len(images)
        or row["walls"] != row["word"].count("0") + row["word"].count("2")
        or row["time_reversal"] != symmetry.time_reversal(stabiliser)
        or row["symmetry"] != symmetry.label(stabiliser)
        for row, (images, stabiliser) in zip(rows, families, strict=True)
    ]
    found = judged("classes", [row["word"] for row in rows], wrong)
    yield replace(found, rows=0)  # the rows are counted above
    expected = [
        (word, (row["id"], element, None))
        for row, (images, _) in zip(rows, families, strict=True)
        for word, element in images.items()
        if cursor is None or word <= cursor
    ]
    stored = load_sequences(connection, p, [word for word, _ in expected])
    differ = [stored.get(word) != entry for word, entry in expected]
    yield judged("sequences", [word for word, _ in expected], differ)


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


def check_pruned(catalogue: Catalogue, selection: Selection) -> Iterator[Step]:
    """Check the words that are kept though they are pruned; they are the same for every a."""
    if selection.statuses and Status.GEOMETRIC not in selection.statuses:
        return
    rows = catalogue.rows(replace(selection, statuses=(Status.GEOMETRIC,)), ("p", "word", "rules"))
    block: list[tuple[int, str, str]] = []
    for row in rows:
        if block and (row[0] != block[0][0] or len(block) * row[0] >= SYMBOLS_A_BLOCK):
            yield _rules(block)
            block = []
        block.append((row[0], row[1], row[2]))
    if block:
        yield _rules(block)


def _rules(block: Sequence[tuple[int, str, str]]) -> Step:
    """Check pruned words of one period: least rotations, primitive, breaking the rules stored."""
    p, words = block[0][0], [word for _, word, _ in block]
    written = [is_written(word, p) for word in words]
    masks = iter(rules_broken(from_strings([w for w, ok in zip(words, written, strict=True) if ok])).tolist())
    wrong = [
        not ok
        or stored != ",".join(map(str, rule_numbers(next(masks))))
        or least_rotation(word) != word
        or not is_primitive(word)
        for (_, word, stored), ok in zip(block, written, strict=True)
    ]
    return Step(f"pruned words, p = {p}", 0, 1, (judged("rules", words, wrong),))
