"""Check the file, the counts of its periods, and the row of each class.

The row of a class or a pruned word, including its id, must follow from its word alone. The id is the key of
the representative, so no class is stored twice, and no word belongs to two classes. The classes of a period
are complete if they contain as many words as the transfer matrix says.
"""

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
from sqlalchemy import Connection

from orbitdb.store.fills import counts_when_done, status_counts, words_up_to
from orbitdb.store.selection import Selection
from orbitdb.store.tables import DONE, LONG, TABLES
from orbitdb.symbols import symmetry
from orbitdb.symbols.pruning import FAMILY, count_admissible, rule_numbers, rules_broken
from orbitdb.symbols.symmetry import joined_members, joined_words
from orbitdb.symbols.words import (
    MAX_KEYED,
    are_primitive,
    from_strings,
    key,
    least_rotation,
    least_rotations,
    pack,
)
from orbitdb.text import exact
from orbitdb.verification.checks import (
    LISTED,
    Block,
    Check,
    Part,
    as_list,
    blocks,
    by_period,
    differences,
    is_chosen,
    judged,
    listed,
    single,
)


def file_parts(selections: Sequence[Selection]) -> list[Part]:
    """Return the parts that check the file and the counts of the chosen periods."""
    return [Part("file", _file), Part("counts", partial(_counts, selections))]


def _file(connection: Connection) -> Iterator[Check]:
    rows = sum(connection.exec_driver_sql(f"SELECT count(*) FROM {table}").scalar() for table in TABLES)
    dangling = connection.exec_driver_sql("PRAGMA foreign_key_check")
    faults = [f"a row of {child} refers to a missing row of {parent}" for child, _, parent, _ in dangling]
    answer = str(connection.exec_driver_sql("PRAGMA integrity_check").scalar())
    yield listed("file", rows, faults if answer == "ok" else [answer, *faults])


def _counts(selections: Sequence[Selection], connection: Connection) -> Iterator[Check]:
    """Check the words of whole periods against the transfer matrix, and all counts against the rows."""
    fills = fill_rows(connection)
    births = list(connection.exec_driver_sql("SELECT * FROM birth_fill").mappings())
    sizes = "SELECT p, count(*), sum(class_size) FROM cycle GROUP BY p"
    stored: dict[int, tuple[int, int]] = defaultdict(lambda: (0, 0))
    stored |= {p: (classes, words) for p, classes, words in connection.exec_driver_sql(sizes)}
    whole = {row["p"] for row in (*fills, *births) if row["state"] == DONE}
    for p in sorted(whole | stored.keys()):
        if is_chosen(p, selections):
            words = stored[p][1]
            expected = count_admissible(p) if p in whole else words
            first = f"p = {p}: {words} words instead of {expected}" if words != expected else None
            yield Check("counts", words, abs(words - expected), first=first)
    chosen = {selection.a: selection for selection in selections}
    for row in fills:
        if row["a"] in chosen and chosen[row["a"]].includes(row["p"]):
            if row["state"] == DONE:
                statuses = status_counts(connection, row["stadium"], row["p"]).get(row["p"], {})
                faults = _wrong_counts(row, statuses, stored[row["p"]][0])
            else:
                faults = _wrong_cursor(connection, row, row["stadium"])
            yield single("counts", f"p = {row['p']} at a = {exact(row['a'])}", faults)
    for row in births:
        if row["state"] != DONE and is_chosen(row["p"], selections):
            yield single("births", f"p = {row['p']}", _wrong_cursor(connection, row, None))


def fill_rows(connection: Connection) -> list[dict[str, Any]]:
    """Return the rows of `fill`, each with its value of a."""
    query = "SELECT * FROM fill JOIN stadium ON stadium.id = fill.stadium ORDER BY a, p"
    return list(connection.exec_driver_sql(query).mappings())


def _wrong_counts(
    row: Mapping[str, Any], statuses: Mapping[str, tuple[int, int]], classes: int
) -> Iterator[str]:
    """Yield the wrong counts of a filled period, given its numbers of words and classes by status."""
    expected = counts_when_done(row["p"], statuses) | {"words": count_admissible(row["p"])}
    yield from differences(row, expected)
    solved = sum(count for _, count in statuses.values())
    if solved != classes:
        yield f"{solved} of {classes} classes have a row"


def _wrong_cursor(connection: Connection, row: Mapping[str, Any], number: int | None) -> Iterator[str]:
    """Yield the fault of an unfinished period, of which all words up to the cursor must be stored."""
    cursor, p = row["cursor"], row["p"]
    words = 0 if cursor is None else words_up_to(connection, number, p, cursor)
    if words != row["words"]:
        yield f"{words} words up to {cursor} instead of {row['words']}"


def class_parts(connection: Connection, selections: Sequence[Selection]) -> Iterator[Part]:
    """Yield parts that check the classes and pruned words of the chosen periods, or of all periods."""
    for table in ("cycle", "pruned"):
        ids = by_period(connection, table)
        for block in blocks({p: of_period for p, of_period in ids.items() if is_chosen(p, selections)}):
            yield block.part("classes", partial(_compared, table == "pruned"))


def _compared(of_pruned: bool, block: Block, connection: Connection) -> Iterator[Check]:
    """Check rows of `cycle` or `pruned` against the values that follow from their words."""
    query = f"SELECT * FROM {'pruned' if of_pruned else 'cycle'} WHERE id {LISTED}"
    rows = connection.exec_driver_sql(query, {"ids": as_list(block.ids)}).fetchall()
    words = [row[2] for row in rows]
    symbols = from_strings(words)
    broken = rules_broken(symbols)
    expected = _pruned_rows(words, block.p, broken.tolist()) if of_pruned else _class_rows(words, block.p)
    same = [
        row == (_id(columns[1], of_pruned, row[0]), *columns)
        for row, columns in zip(rows, expected, strict=True)
    ]
    right = np.array(same) & ((broken > 0) == of_pruned) & are_primitive(symbols)
    yield judged("classes", words, ~right)


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
        joined = [joined_members(family.representative) for family in families]
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
