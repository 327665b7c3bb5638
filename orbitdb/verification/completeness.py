"""The census of a catalogue: its file and schema, and whether its words and classes are all there.

The words of a period are complete if every class has all its images, each with the class and the
element that leads to it, and their number is that of the transfer matrix: by the table's key no word
is stored twice. The words themselves are checked in `orbitdb.verification.word_blocks`.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from orbitdb.orbits.orbit import Status
from orbitdb.store.asking.selection import Selection
from orbitdb.store.file.schema import DONE, FILLING
from orbitdb.store.reading import audit
from orbitdb.store.reading.catalogue import Catalogue
from orbitdb.store.reading.lives import birth_fills
from orbitdb.store.reading.soundness import is_written
from orbitdb.store.reading.stored_blocks import SYMBOLS_A_BLOCK
from orbitdb.symbols.automaton import RULE_NUMBERS
from orbitdb.symbols.counting import count_admissible, count_primitive
from orbitdb.symbols.pruning import rule_numbers, rules_broken
from orbitdb.symbols.words import from_strings, is_primitive, least_rotation
from orbitdb.verification.blocks import Part
from orbitdb.verification.check import Check, Step, judged

if TYPE_CHECKING:
    import sqlalchemy as sa


@dataclass(frozen=True, eq=False)
class FilePart(Part):
    """One of the promises of the whole file, a name of `OF_FILE`."""

    name: str

    def checked(self, connection: "sa.Connection") -> Step:
        """Return what is found in what a connection reads."""
        rows, wrong = OF_FILE[self.name](connection)
        return Step("file", 0, 1, (Check(self.name, rows, len(wrong), first=wrong[0] if wrong else None),))


def _file(connection: "sa.Connection") -> tuple[int, list[str]]:
    return 1, audit.file_errors(connection)[:1]


def _references(connection: "sa.Connection") -> tuple[int, list[str]]:
    return audit.row_count(connection), audit.dangling(connection)


OF_FILE = {"foreign keys": _references, "file": _file, "schema": audit.schema_differences}
"""What is looked at, and what is wrong; the longest first."""


@dataclass(frozen=True, eq=False)
class CountsPart(Part):
    """The numbers of words of every period, and the counts of every fill."""

    selections: tuple[Selection, ...]

    def checked(self, connection: "sa.Connection") -> Step:
        """Return what is found in what a connection reads."""
        return Step("counts", 0, 1, tuple(check_counts(connection, self.selections)))


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
    stadiums = {fill["stadium"] for fill in fills if fill["a"] in chosen}
    solved = {stadium: audit.status_counts(connection, stadium) for stadium in stadiums}
    for fill in fills:
        if fill["a"] in chosen and chosen[fill["a"]].includes(fill["p"]):
            statuses = solved[fill["stadium"]].get(fill["p"], {})
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
