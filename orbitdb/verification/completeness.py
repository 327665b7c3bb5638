"""Check the file, the completeness of its classes, and the row of each class.

The row of a class or a pruned word, including its id, must follow from its word alone. The id is the key of
the representative, so no class is stored twice, and no word belongs to two classes. The classes of a period
are complete if they contain as many words as the transfer matrix says.
"""

import re
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import partial
from itertools import chain
from typing import Any

import sqlalchemy as sa

from orbitdb.numerals import exact
from orbitdb.plaintext import shortened
from orbitdb.store.asking.selection import Selection
from orbitdb.store.file.ids import LONG
from orbitdb.store.file.schema import DONE, FILLING
from orbitdb.store.file.tables import birth_fill, cycle, element, fill, metadata, orbit, pruned
from orbitdb.store.reading import audit
from orbitdb.store.reading.fills import counts_when_done, status_counts, words_up_to
from orbitdb.store.reading.lives import birth_fills
from orbitdb.store.reading.soundness import is_written, sound_words
from orbitdb.symbols import symmetry
from orbitdb.symbols.enumeration import Span, least_words
from orbitdb.symbols.pruning import FAMILY, count_admissible, rule_numbers, rules_broken
from orbitdb.symbols.symmetry import ELEMENT_ROWS, joined_members, joined_words
from orbitdb.symbols.words import (
    MAX_KEYED,
    are_primitive,
    from_strings,
    key,
    keys_of_period,
    least_rotation,
    least_rotations,
    pack,
)
from orbitdb.verification.check import Block, Check, Part, blocks, is_chosen, judged, listed, single
from orbitdb.verification.provenance import parameters_of


def file_parts(selections: Sequence[Selection]) -> list[Part]:
    """Return the parts that check the file and the counts of the chosen periods, the slowest first."""
    whole = [Part("file", find) for find in (_references, _file, _elements)]
    return [*whole, Part("counts", partial(_counts, selections))]


def _references(connection: sa.Connection) -> Iterator[Check]:
    tables = metadata.sorted_tables
    rows = sum(connection.scalar(sa.select(sa.func.count()).select_from(table)) or 0 for table in tables)
    dangling = connection.exec_driver_sql("PRAGMA foreign_key_check").all()
    yield listed("foreign keys", rows, [f"{child} -> {parent}" for child, _, parent, _ in dangling])


def _file(connection: sa.Connection) -> Iterator[Check]:
    said = str(connection.exec_driver_sql("PRAGMA integrity_check").scalar())
    yield listed("file", 1, [] if said == "ok" else [said])


def _elements(connection: sa.Connection) -> Iterator[Check]:
    stored = {tuple(row) for row in connection.execute(sa.select(element))}
    wrong = [f"position {n} of {symmetry}" for symmetry, n, _ in sorted(stored ^ set(ELEMENT_ROWS))]
    yield listed("elements", len(stored), wrong)


def _counts(selections: Sequence[Selection], connection: sa.Connection) -> Iterator[Check]:
    fills, births = audit.fill_rows(connection), birth_fills(connection)
    sizes = sa.select(cycle.c.p, sa.func.count(), sa.func.sum(cycle.c.class_size)).group_by(cycle.c.p)
    words = defaultdict(lambda: (0, 0), {p: tuple(each) for p, *each in connection.execute(sizes)})
    done = {row["p"] for row in fills if row["state"] == DONE} | {each.p for each in births if each.whole}
    for p in sorted(done | words.keys()):
        if is_chosen(p, selections):
            yield _count(p, words[p][1], p in done)
    chosen = {s.a: s for s in selections}
    here = [row for row in fills if row["a"] in chosen and chosen[row["a"]].includes(row["p"])]
    numbers = {a: audit.stadium_id(connection, a) for a in chosen}
    known = {a: number for a, number in numbers.items() if number is not None}
    solved = {number: status_counts(connection, number) for number in known.values()}
    for a, number in known.items():
        named = {row["p"] for row in here if row["a"] == a}
        others = [p for p in solved[number] if chosen[a].includes(p) and p not in named]
        for p in _unnamed(connection, number, others):
            yield Check("fills", 0, 1, first=f"p = {p} at a = {exact(a)}: filled, but without a row in fill")
    wrong: Iterator[str]
    for row in here:
        if row["state"] == DONE:
            statuses = solved[row["stadium"]].get(row["p"], {})
            wrong = chain(wrong_end(row), _wrong_counts(row, statuses, words[row["p"]][0]))
        else:
            wrong = _wrong_cursor(connection, fill, row, row["stadium"])
        yield single("fills", f"p = {row['p']} at a = {exact(row['a'])}", wrong)
    for row in map(dict, connection.execute(sa.select(birth_fill).order_by(birth_fill.c.p)).mappings()):
        if is_chosen(row["p"], selections):
            whole = row["state"] == DONE
            wrong = wrong_end(row) if whole else _wrong_cursor(connection, birth_fill, row, None)
            yield single("births", f"p = {row['p']}", wrong)


def _unnamed(connection: sa.Connection, stadium: int, periods: Iterable[int]) -> Iterator[int]:
    """Yield those periods that contain rows from a fill of periods; single words need no row in `fill`."""
    asked = parameters_of(connection)
    for p in periods:
        runs = [number for number, by in asked.items() if p in by.get("periods", ())]
        if not runs:
            continue
        here = (orbit.c.stadium == stadium) & orbit.c.cycle.between(*keys_of_period(p))
        if connection.scalar(sa.select(sa.exists().where(here, orbit.c.run.in_(runs)))):
            yield p


def _count(p: int, words: int, whole: bool) -> Check:
    """Check that a period has all its words if it is marked as complete."""
    expected = count_admissible(p) if whole else words
    first = f"p = {p}: {words} words instead of {expected}" if words != expected else None
    return Check("counts", words, abs(words - expected), first=first)


def wrong_end(row: Mapping[str, Any]) -> Iterator[str]:
    """Yield the faults in the cursor and the number of words of a finished period."""
    p, cursor, words = (row[name] for name in ("p", "cursor", "words"))
    if cursor != (last := f"{Span.whole(p).upto:0{p}o}"):
        yield f"cursor {shortened(str(cursor))} instead of {last}"
    if words != (total := count_admissible(p)):
        yield f"{words} words instead of {total}"


def wrong_cursor(table: sa.Table, row: Mapping[str, Any], stored: int | None = None) -> Iterator[str]:
    """Yield the faults in the row of an unfinished period, which must have no results yet.

    All words up to its cursor must be counted, and also stored if this kind of work stores words.
    """
    p, cursor = row["p"], row["cursor"]
    early = [c.name for c in table.c if c.nullable and c.name not in ("cursor", "run")]
    if row["state"] != FILLING:
        yield f"state {row['state']}"
    elif any(row[name] is not None for name in early):
        yield "final counts, although the period is not done"
    elif cursor is not None and re.fullmatch(f"[0-7]{{{p}}}", cursor) is None:
        yield f"cursor {shortened(cursor)}"
    else:
        parts = least_words(Span(p, -1, -1 if cursor is None else int(cursor, 8)))
        expected = sum(int(symmetry.SIZES[part.stabiliser].sum()) for part in parts)
        found = (row["words"],) if stored is None else (stored, row["words"])
        yield from (f"{n} words instead of {expected}" for n in found if n != expected)


def _wrong_cursor(
    connection: sa.Connection, table: sa.Table, row: Mapping[str, Any], stadium: int | None
) -> Iterator[str]:
    """Yield the faults in the row of an unfinished period whose words are stored."""
    cursor, p = row["cursor"], row["p"]
    is_code = cursor is not None and re.fullmatch(f"[0-7]{{{p}}}", cursor)
    yield from wrong_cursor(table, row, words_up_to(connection, stadium, p, cursor) if is_code else 0)


def _wrong_counts(
    fill: Mapping[str, Any], statuses: Mapping[str, tuple[int, int]], classes: int
) -> Iterator[str]:
    """Yield the wrong counts of a filled period, given its numbers of words and classes by status."""
    for name, value in counts_when_done(fill["p"], statuses).items():
        if fill[name] != value:
            yield f"{name} is {fill[name]} instead of {value}"
    solved = sum(count for _, count in statuses.values())
    if solved != classes:
        yield f"{solved} of {classes} classes have a row"


def class_parts(connection: sa.Connection, selections: Sequence[Selection]) -> Iterator[Part]:
    """Yield parts that check the classes and pruned words of the chosen periods, or of all periods."""
    for table in (cycle, pruned):
        found = audit.by_period(connection, audit.ids_in(connection, table.c.id), table)
        for block in blocks({p: ids for p, ids in found.items() if is_chosen(p, selections)}):
            stage, name = ("classes",) * 2 if table is cycle else ("pruned words", "rules")
            yield block.part(stage, partial(_compared, name))


def _compared(name: str, block: Block, connection: sa.Connection) -> Iterator[Check]:
    """Check rows of `cycle` or `pruned` against the values that follow from their words."""
    of_pruned, p = name == "rules", block.p
    rows = audit.load_rows(connection, pruned if of_pruned else cycle, block.ids)
    words, wrong = [row[2] for row in rows], [True] * len(rows)
    if of_pruned:
        sound = [i for i, word in enumerate(words) if is_written(word, p)]
    else:
        sound = sound_words(words, p).tolist()
    if known := [words[i] for i in sound]:
        expected = _pruned_rows(known, p) if of_pruned else _class_rows(known, p)
        for i, columns in zip(sound, expected, strict=True):
            number = rows[i][0]
            wrong[i] = columns is None or rows[i] != (_id(columns[1], of_pruned, number), *columns)
    yield judged(name, words, wrong)


def _id(word: str, of_pruned: bool, stored: int) -> int:
    """Return the id that a word must have; words too long for a key are numbered one after another."""
    if len(word) <= MAX_KEYED:
        return -key(word) if of_pruned else key(word)
    return min(stored, -LONG) if of_pruned else max(stored, LONG)


def _class_rows(words: Sequence[str], p: int) -> Iterator[tuple[Any, ...]]:
    """Yield, for the class of each word, the values that its row must have after the id."""
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
        yield (
            p,
            least,
            symmetry.class_size(mask),
            walls,
            symmetry.time_reversal(mask),
            symmetry.label(mask),
            members,
        )


def _pruned_rows(words: Sequence[str], p: int) -> Iterator[tuple[Any, ...] | None]:
    """Yield, for each word, the values that its row must have after the id; None if it is not pruned."""
    symbols = from_strings(words)
    masks, primitive = rules_broken(symbols).tolist(), are_primitive(symbols).tolist()
    for word, mask, whole in zip(words, masks, primitive, strict=True):
        is_pruned = mask and whole and word != FAMILY
        yield (p, least_rotation(word), ",".join(map(str, rule_numbers(mask)))) if is_pruned else None
