"""The census of a catalogue: its file, and whether its classes are all there.

The classes of a period are complete if every row is as it must be (`orbitdb.verification.classes`), which
makes them different, and their words are as many as the transfer matrix says.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from typing import Any

import sqlalchemy as sa

from orbitdb.store.asking.selection import Selection
from orbitdb.store.file.schema import DONE, FILLING
from orbitdb.store.file.tables import birth_fill, cycle, element, metadata
from orbitdb.store.reading import audit
from orbitdb.store.reading.fills import counts_when_done, status_counts, words_up_to
from orbitdb.store.reading.lives import birth_fills
from orbitdb.symbols.counting import count_admissible
from orbitdb.symbols.enumeration import Span
from orbitdb.symbols.least_words import least_words
from orbitdb.symbols.members import ELEMENT_ROWS
from orbitdb.symbols.symmetry import SIZES
from orbitdb.verification.blocks import Part, is_chosen
from orbitdb.verification.check import Check, listed, shown, single


def file_parts(selections: Sequence[Selection]) -> list[Part]:
    """Return the whole file, and its counts of the chosen periods; what takes longest comes first."""
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
    wrong = [f"place {n} of {symmetry}" for symmetry, n, _ in sorted(stored ^ set(ELEMENT_ROWS))]
    yield listed("elements", len(stored), wrong)


def _counts(selections: Sequence[Selection], connection: sa.Connection) -> Iterator[Check]:
    """Check the numbers of words of every period, and the counts of every fill."""
    fills, births = audit.fills(connection), birth_fills(connection)
    sizes = sa.select(cycle.c.p, sa.func.count(), sa.func.sum(cycle.c.class_size)).group_by(cycle.c.p)
    words = {p: (classes, size) for p, classes, size in connection.execute(sizes)}
    whole = {fill["p"] for fill in fills if fill["state"] == DONE} | {each.p for each in births if each.whole}
    for p in sorted(whole | words.keys()):
        if is_chosen(p, selections):
            yield _count(p, words.get(p, (0, 0))[1], p in whole)
    chosen = {s.a: s for s in selections}
    here = [fill for fill in fills if fill["a"] in chosen and chosen[fill["a"]].includes(fill["p"])]
    solved = {n: status_counts(connection, n) for n in {fill["stadium"] for fill in here}}
    for fill in here:
        if fill["state"] == DONE:
            statuses = solved[fill["stadium"]].get(fill["p"], {})
            wrong = _wrong_counts(fill, statuses, words.get(fill["p"], (0, 0))[0])
        else:
            wrong = _wrong_cursor(connection, fill, fill["stadium"])
        yield single("fills", f"p = {fill['p']} at a = {fill['a']:g}", wrong)
    begun = sa.select(birth_fill).where(birth_fill.c.state != DONE).order_by(birth_fill.c.p)
    for row in connection.execute(begun).mappings().all():
        if is_chosen(row["p"], selections):
            yield single("births", f"p = {row['p']}", _wrong_cursor(connection, dict(row), None))


def _count(p: int, words: int, whole: bool) -> Check:
    """Check a period's number of words, of which all must be there if it is whole."""
    expected = count_admissible(p) if whole else words
    first = f"p = {p}: {words} words instead of {expected}" if words != expected else None
    return Check("counts", words, abs(words - expected), first=first)


def _wrong_cursor(connection: sa.Connection, row: Mapping[str, Any], stadium: int | None) -> Iterator[str]:
    """Yield what is wrong with a period in the making: all classes up to its cursor must be there."""
    p, cursor = row["p"], row["cursor"]
    if row["state"] != FILLING:
        yield f"state {row['state']}"
    elif cursor is not None and re.fullmatch(f"[0-7]{{{p}}}", cursor) is None:
        yield f"cursor {shown(cursor)}"
    else:
        parts = least_words(Span(p, -1, -1 if cursor is None else int(cursor, 8)))
        expected = sum(int(SIZES[part.stabiliser].sum()) for part in parts)
        stored = 0 if cursor is None else words_up_to(connection, stadium, p, cursor)
        yield from (f"{n} words instead of {expected}" for n in (stored, row["words"]) if n != expected)


def _wrong_counts(
    fill: Mapping[str, Any], statuses: Mapping[str, tuple[int, int]], classes: int
) -> Iterator[str]:
    """Yield what is wrong with the counts of a period that is filled, given those of its rows by status."""
    for name, value in counts_when_done(fill["p"], statuses).items():
        if fill[name] != value:
            yield f"{name} is {fill[name]} instead of {value}"
    solved = sum(count for _, count in statuses.values())
    if solved != classes:
        yield f"{solved} of {classes} classes have a row"
