"""Check the file, the counts of its periods, and the row of each class.

The row of a class or a pruned word, including its id, must follow from its word alone. The id is the key of
the representative, so no class is stored twice, and no word belongs to two classes. The classes of a period
are complete if they contain as many words as an independent count says (`orbitdb.symbols.edges`).
"""

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from orbitdb.store.periods import (
    counts_when_done,
    pruned_up_to,
    read_pruned_fills,
    status_counts,
    words_up_to,
)
from orbitdb.store.tables import DONE, LONG, TABLES
from orbitdb.symbols import symmetry
from orbitdb.symbols.edges import count_by_edges
from orbitdb.symbols.pruning import FAMILY, count_admissible, count_pruned, rule_numbers, rules_broken
from orbitdb.symbols.symmetry import joined_words
from orbitdb.symbols.words import (
    MAX_KEYED,
    are_primitive,
    from_strings,
    key,
    least_rotation,
    least_rotations,
    pack,
)
from orbitdb.text import format_float
from orbitdb.verification.checks import LISTED, Block, Check, Part, Scope, blocks, differences


def integrity(scope: Scope) -> Iterator[Check]:
    """Check the file as SQLite sees it."""
    answer = str(scope.scalar("PRAGMA integrity_check"))
    yield Check.listed("file", 0, [] if answer == "ok" else [answer])
    yield Check("file", sum(scope.scalar(f"SELECT count(*) FROM {table}") for table in TABLES))


def references(scope: Scope) -> Iterator[Check]:
    """Check that every reference points to a row."""
    dangling = scope.query("PRAGMA foreign_key_check")
    faults = [f"a row of {child} refers to a missing row of {parent}" for child, _, parent, _ in dangling]
    yield Check.listed("file", 0, faults)


def counts(scope: Scope) -> Iterator[Check]:
    """Check the words of whole periods against the transfer matrix, and all counts against the rows."""
    fills = fill_rows(scope)
    births = scope.records("SELECT * FROM birth_fill")
    sizes = "SELECT p, count(*), sum(class_size) FROM cycle GROUP BY p"
    stored: dict[int, tuple[int, int]] = defaultdict(lambda: (0, 0))
    stored |= {p: (classes, words) for p, classes, words in scope.query(sizes)}
    whole = {row["p"] for row in (*fills, *births) if row["state"] == DONE}
    for p in sorted(whole | stored.keys()):
        if scope.chooses(p):
            words = stored[p][1]
            expected = count_by_edges(p) if p in whole else words
            first = f"p = {p}: {words} words instead of {expected}" if words != expected else None
            yield Check("counts", words, abs(words - expected), first=first)
    chosen = {selection.a: selection for selection in scope.selections}
    for row in fills:
        if row["a"] in chosen and chosen[row["a"]].includes(row["p"]):
            if row["state"] == DONE:
                statuses = status_counts(scope.connection, row["stadium"], row["p"]).get(row["p"], {})
                faults = _wrong_counts(row, statuses, stored[row["p"]][0])
            else:
                faults = _wrong_cursor(scope, row, row["stadium"])
            yield Check.single("counts", f"p = {row['p']} at a = {format_float(row['a'])}", faults)
    for p, (words, complete) in read_pruned_fills(scope.connection).items():
        if scope.chooses(p):
            faults = _wrong_pruned(scope, p, words, complete)
            yield Check.single("counts", f"pruned words of p = {p}", faults)
    for row in births:
        if row["state"] != DONE and scope.chooses(row["p"]):
            yield Check.single("births", f"p = {row['p']}", _wrong_cursor(scope, row, None))


def fill_rows(scope: Scope) -> list[dict[str, Any]]:
    """Return the rows of `fill`, each with its value of a."""
    query = "SELECT * FROM fill JOIN stadium ON stadium.id = fill.stadium ORDER BY a, p"
    return scope.records(query)


def _wrong_counts(
    row: Mapping[str, Any], statuses: Mapping[str, tuple[int, int]], classes: int
) -> Iterator[str]:
    """Yield the wrong counts of a filled period, given its numbers of words and classes by status."""
    expected = counts_when_done(row["p"], statuses) | {"words": count_by_edges(row["p"])}
    yield from differences(row, expected)
    solved = sum(count for _, count in statuses.values())
    if solved != classes:
        yield f"{solved} of {classes} classes have a row"


def _wrong_cursor(scope: Scope, row: Mapping[str, Any], number: int | None) -> Iterator[str]:
    """Yield the faults of an unfinished period: all its words up to the cursor must be stored."""
    cursor, p = row["cursor"], row["p"]
    if row["words"] == count_admissible(p) and row["classes"] is not None:
        yield "all words are stored and counted, but the period is not marked as done"
    words = 0 if cursor is None else words_up_to(scope.connection, number, p, cursor)
    if words != row["words"]:
        yield f"{words} words up to {cursor} instead of {row['words']}"


def _wrong_pruned(scope: Scope, p: int, words: int, complete: bool) -> Iterator[str]:
    """Yield the faults of the pruned words of a period: all up to the cursor must be stored."""
    last = scope.scalar(f"SELECT cursor FROM pruned_fill WHERE p = {p}")
    stored = 0 if last is None else pruned_up_to(scope.connection, p, last)
    if stored != words:
        yield f"{stored} words up to {last} instead of {words}"
    if complete and words != (total := count_pruned(p)):
        yield f"{words} words instead of {total}"


def classes(scope: Scope) -> Iterator[Part]:
    """Check the classes and pruned words of the chosen periods, or of all periods."""
    for table in ("cycle", "pruned"):
        for block in blocks(scope.ids(table)):
            yield block.part("classes", partial(_compared, table == "pruned"))


def _compared(of_pruned: bool, block: Block, scope: Scope) -> Iterator[Check]:
    """Check rows of `cycle` or `pruned` against the values that follow from their words."""
    query = f"SELECT * FROM {'pruned' if of_pruned else 'cycle'} WHERE id {LISTED}"
    rows = scope.query(query, ids=block.ids)
    block.check_complete(rows)
    words = [row[2] for row in rows]
    symbols = from_strings(words)
    broken = rules_broken(symbols)
    expected = _pruned_rows(words, block.p, broken.tolist()) if of_pruned else _class_rows(words, block.p)
    same = [
        row == (_id(columns[1], of_pruned, row[0]), *columns)
        for row, columns in zip(rows, expected, strict=True)
    ]
    right = np.array(same) & ((broken > 0) == of_pruned) & are_primitive(symbols)
    yield Check.judged("classes", words, ~right)


def _id(word: str, of_pruned: bool, stored: int) -> int:
    """Return the id that a word must have; words too long for a key are numbered one after another."""
    if len(word) <= MAX_KEYED:
        return -key(word) if of_pruned else key(word)
    return min(stored, -LONG) if of_pruned else max(stored, LONG)


def _class_rows(words: Sequence[str], p: int) -> Iterator[tuple[Any, ...]]:
    """Yield, for the class of each word, the values that its row must have after the id."""
    if p > MAX_KEYED:
        families = [symmetry.class_of(word) for word in words]
        stabilisers = [family.stabiliser for family in families]
        joined = ["".join(family.words) for family in families]
    else:
        classes = symmetry.classify(least_rotations(pack(from_strings(words)), p), p)
        stabilisers = classes.stabiliser.tolist()
        joined = joined_words(classes.representative, classes.stabiliser, p)
    for mask, members in zip(stabilisers, joined, strict=True):
        least = members[:p]
        walls = least.count("0") + least.count("2")
        labels = symmetry.time_reversal(mask), symmetry.label(mask)
        yield p, least, symmetry.class_size(mask), walls, *labels, members


def _pruned_rows(words: Sequence[str], p: int, broken: Sequence[int]) -> Iterator[tuple[Any, ...]]:
    """Yield, for each word, the values that its row must have after the id."""
    for word, mask in zip(words, broken, strict=True):
        yield p, least_rotation(word), "" if word == FAMILY else ",".join(map(str, rule_numbers(mask)))
