"""Merge a part, a catalogue file of its own, into another catalogue: what the other lacks is copied.

SQLite copies the rows from file to file, in one transaction a part. Classes are matched by word, stadiums by
their a, runs by their start. Work on a period that has come further in the part replaces that of the target.
"""

from collections.abc import Iterator, Sequence
from contextlib import closing
from pathlib import Path
from typing import NamedTuple

import sqlalchemy as sa
from sqlalchemy import ColumnElement, Connection, FromClause, RowMapping, Table, func, insert, select

from orbitdb.errors import DamagedError, InputError, NotStoredError, StoreError
from orbitdb.period_ranges import written_periods
from orbitdb.progress import Tell, nobody
from orbitdb.store import tables as t
from orbitdb.store.attached import PART, Attached, lacking, same
from orbitdb.store.file import migrate, reading
from orbitdb.store.file_kind import need_newest
from orbitdb.store.journal import refuse_foreign_journal
from orbitdb.store.paths import file_id
from orbitdb.store.writer import Writer
from orbitdb.text import format_float, several


class Merged(NamedTuple):
    """What a part has added at one value of a; births and pruned words belong to none.

    Attributes
    ----------
    part : str
        Name of the file.
    a : float or None
    periods : str
        Periods that were added, or came further.
    words : int
        Number of words that were added.
    other : str
        What else was added.
    """

    part: str
    a: float | None
    periods: str
    words: int
    other: str


class Choice(NamedTuple):
    """Which part of a file is copied: rows at these a and of these ranges of periods; all if empty."""

    a: tuple[float, ...] = ()
    spans: tuple[tuple[int, int], ...] = ()

    def of_a(self, table: FromClause) -> ColumnElement[bool]:
        """Return the condition for rows of a table with an a."""
        return table.c.a.in_(self.a) if self.a else sa.true()

    def of_p(self, table: FromClause) -> ColumnElement[bool]:
        """Return the condition for rows of a table with a period, or with classes that have one."""
        if "p" in table.c:
            return t.in_spans(table.c.p, self.spans)
        classes = select(PART[t.cycle].c.id).where(t.in_spans(PART[t.cycle].c.p, self.spans))
        return table.c.cycle.in_(classes) if self.spans else sa.true()


EVERYTHING = Choice()


def merge_all(target: Path, parts: Sequence[Path], tell: Tell = nobody) -> list[Merged]:
    """Merge parts into a catalogue, one after another (`Catalogue.merge`)."""
    added: list[Merged] = []
    # without SQLite's checks of references, which the copied rows have passed in their own file
    with closing(Writer(target, {"command": "merge"}, references=False)) as writer:
        for number, part in enumerate(parts):
            tell(number, len(parts), part.name)
            added += merge(writer, part)
    return added


def copy_part(source: Path, draft: Path, chosen: Choice) -> None:
    """Make a new catalogue with a part of another one; raise `NotStoredError` if there is nothing in it."""
    migrate(draft)
    with closing(Writer(draft, {"command": "export"}, references=False)) as writer:
        added = merge(writer, source, chosen)
        if not added or (chosen.a and all(each.a is None for each in added)):
            raise NotStoredError("nothing of this is stored: choose another a or other periods")


class _NothingNewError(Exception):
    """The target has everything, so the transaction is undone."""


def merge(writer: Writer, path: Path, chosen: Choice = EVERYTHING) -> list[Merged]:
    """Copy what a catalogue lacks from a part, in one transaction, and return what that was.

    Raises
    ------
    StoreError
        If the part cannot be read, or contradicts the catalogue; then nothing is copied.
    """
    need_newest(path)
    refuse_foreign_journal(path)
    own = file_id(path)
    if own is not None and own.is_same(writer.file):
        raise InputError(f"{path} is the catalogue itself: name other files")
    try:
        with writer.attached(path), writer.transaction() as connection:
            added = _Merge(connection, path, chosen).run()
            if not added:
                raise _NothingNewError
            return added
    except _NothingNewError:
        return []
    except DamagedError:
        with reading(path) as connection:
            if connection.exec_driver_sql("PRAGMA quick_check(1)").scalar() != "ok":
                raise DamagedError(f"{path} is damaged; nothing of it was merged") from None
        raise


class _Stadium(NamedTuple):
    """A value of a, with its id in the part and in the target."""

    a: float
    theirs: int
    ours: int


class _Merge:
    """One transaction that copies from an attached part."""

    def __init__(self, connection: Connection, path: Path, chosen: Choice) -> None:
        self.connection, self.path, self.chosen = connection, path, chosen
        self.ask, self.part = connection.execute, Attached(connection)
        self.found: dict[float | None, Merged] = {}

    def run(self) -> list[Merged]:
        self.classes()
        self.part.copy_runs()
        for stadium in self.stadiums():
            self.orbits(stadium)
            self.certificates(stadium)
            self.fills(stadium)
            self.sweeps(stadium)
            self.trajectories(stadium)
        self.bounds_agree()
        self.of_a(t.entropy_bound, "bound")
        self.of_a(t.open_stadium, "open stadium")
        self.levels()
        self.births()
        self.pruned()
        self.part.forget()
        return [found for found in self.found.values() if found.periods or found.words or found.other]

    def refuse(self, what: str) -> None:
        raise StoreError(f"{self.path} contradicts the catalogue: {what}; nothing of it was merged")

    def add(self, a: float | None, periods: Sequence[int] = (), words: int = 0, other: str = "") -> None:
        """Note what was added at an a."""
        old = self.found.get(a, Merged(self.path.name, a, "", 0, ""))
        spans = written_periods(periods) if periods else ""
        self.found[a] = old._replace(
            periods=old.periods or spans.removeprefix("periods ").removeprefix("period "),
            words=old.words + words,
            other="; ".join(filter(None, (old.other, other))),
        )

    def classes(self) -> None:
        """Copy the classes that the target lacks."""
        theirs = PART[t.cycle].c
        differ = sa.and_(theirs.id < t.LONG, theirs.word != t.cycle.c.word)
        if other := self.part.differing(t.cycle, ("id",), differ):
            self.refuse(f"another class has the number of {other.word}")
        self.part.copy_classes(self.chosen.of_p(PART[t.cycle]))

    def stadiums(self) -> Iterator[_Stadium]:
        """Yield each a of the part, after storing it in the target."""
        theirs, own = PART[t.stadium], t.stadium.c
        chosen = self.chosen.of_a(theirs)
        self.ask(
            insert(t.stadium).prefix_with("OR IGNORE").from_select(["a"], select(theirs.c.a).where(chosen))
        )
        query = select(own.a, theirs.c.id, own.id).join_from(theirs, t.stadium, own.a == theirs.c.a)
        yield from (_Stadium(*row) for row in self.ask(query.where(chosen).order_by(own.a)).all())

    # what is stored at an a

    def orbits(self, stadium: _Stadium) -> None:
        """Copy the orbits that the target lacks."""
        theirs, own = PART[t.orbit], t.orbit.c
        chosen = (theirs.c.stadium == stadium.theirs, self.chosen.of_p(theirs))
        beyond = (
            func.abs(own[name] - theirs.c[name]) > own[error] + theirs.c[error] for name, error in _BOUNDED
        )
        differ = sa.and_(*chosen, sa.or_(own.status != theirs.c.status, *beyond))
        if other := self.part.differing(t.orbit, _KEY, differ, stadium=stadium.ours):
            at = f"{self.part.word_of(other)} at a = {format_float(stadium.a)}"
            self.refuse(f"{at} has other numbers, beyond their error bounds")
        before = self.words(stadium)
        self.part.copy(t.orbit, *chosen, or_="IGNORE", stadium=stadium.ours)
        self.add(stadium.a, words=self.words(stadium) - before)

    def words(self, stadium: _Stadium) -> int:
        """Return the number of words that the target stores at an a."""
        sizes = select(func.sum(t.cycle.c.class_size)).join_from(t.orbit, t.cycle)
        return self.connection.scalar(sizes.where(t.orbit.c.stadium == stadium.ours)) or 0

    def certificates(self, stadium: _Stadium) -> None:
        """Copy the certificates of orbits whose rows are equal in both files."""
        theirs, proof, own = PART[t.orbit], PART[t.certificate], t.orbit.c
        values = {*own.keys()} - {"stadium", "cycle", "run", "iterations"}
        equal = (own[name].is_not_distinct_from(theirs.c[name]) for name in sorted(values))
        proved = (theirs.c.stadium == proof.c.stadium, theirs.c.cycle == proof.c.cycle)
        pairs = theirs.join(t.orbit, same(t.orbit, _KEY, stadium=stadium.ours))
        kept = sa.exists().select_from(pairs).where(*proved, *equal).correlate(proof)
        at = (proof.c.stadium == stadium.theirs, self.chosen.of_p(proof))
        count = self.part.copy(t.certificate, *at, kept, or_="IGNORE", stadium=stadium.ours)
        self.add(stadium.a, other=several(count, "certificate") if count else "")

    def fills(self, stadium: _Stadium) -> None:
        """Take the cursors and counts of periods that are further in the part."""
        further = self.further(t.fill, stadium)
        for p in further:
            self.replace(t.fill, p, stadium)
        self.add(stadium.a, further)

    def sweeps(self, stadium: _Stadium) -> None:
        """Copy the sweeps that are further in the part, with their blocks."""
        theirs, own, block = PART[t.sweep].c, t.sweep.c, t.sweep_block.c
        counts = sa.or_(*(own[name] != theirs[name] for name in t.TALLIED))
        differ = sa.and_(
            theirs.stadium == stadium.theirs, theirs.state == t.DONE, own.state == t.DONE, counts
        )
        if other := self.part.differing(t.sweep, ("stadium", "p"), differ, stadium=stadium.ours):
            self.refuse(f"the sweep of period {other.p} at a = {format_float(stadium.a)} has other counts")
        further = self.further(t.sweep, stadium)
        for p in further:
            self.ask(sa.delete(t.sweep_block).where(block.stadium == stadium.ours, block.p == p))
            self.replace(t.sweep, p, stadium)
            self.replace(t.sweep_block, p, stadium)
        if further:
            self.add(stadium.a, other=f"{several(len(further), 'sweep')} ({written_periods(further)})")

    def further(self, table: Table, stadium: _Stadium | None = None) -> list[int]:
        """Return the periods of a table of cursors whose work has come further in the part."""

        def reached(source: FromClause, stadium: int | None) -> dict[int, float]:
            at = sa.true() if stadium is None else source.c.stadium == stadium
            query = select(source.c.p, source.c.state, source.c.cursor).order_by(source.c.p)
            rows = self.ask(query.where(at, self.chosen.of_p(source)))
            return {p: _reached(state, cursor) for p, state, cursor in rows}

        stored = reached(table, stadium and stadium.ours)
        rest = reached(PART[table], stadium and stadium.theirs)
        return [p for p, far in rest.items() if far > stored.get(p, _NOT_BEGUN)]

    def replace(self, table: Table, p: int, stadium: _Stadium | None = None) -> None:
        """Replace the rows of a period in a table by those of the part."""
        theirs = PART[table].c
        if stadium is None:
            self.part.copy(table, theirs.p == p, or_="REPLACE")
        else:
            at = (theirs.p == p, theirs.stadium == stadium.theirs)
            self.part.copy(table, *at, or_="REPLACE", stadium=stadium.ours)

    def trajectories(self, stadium: _Stadium) -> None:
        """Copy the averages over trajectories that the target lacks."""
        values = {*t.trajectory.c.keys()} - {"id", "run"}
        new = lacking(t.trajectory, values, stadium=stadium.ours)
        at = PART[t.trajectory].c.stadium == stadium.theirs
        added = self.part.copy(t.trajectory, at, new, id=None, stadium=stadium.ours)
        if added:
            self.add(stadium.a, other=f"{several(added, 'average')} over trajectories")

    def bounds_agree(self) -> None:
        """Refuse bounds that exclude those of the target."""
        theirs, own = PART[t.entropy_bound].c, t.entropy_bound.c
        apart = sa.or_(own.lower > theirs.upper, theirs.lower > own.upper)
        if other := self.part.differing(t.entropy_bound, ("a",), apart):
            self.refuse(f"the bounds on the entropy at a = {format_float(other.a)} exclude one another")

    def of_a(self, table: Table, noun: str) -> None:
        """Copy the rows of a table with a column a that the target lacks."""
        theirs = PART[table]
        new = (self.chosen.of_a(theirs), lacking(table, table.primary_key.columns.keys()))
        counts = select(theirs.c.a, func.count()).where(*new).group_by(theirs.c.a)
        for a, count in self.ask(counts).all():
            self.add(a, other=several(count, noun))
        self.part.copy(table, *new)

    def levels(self) -> None:
        """Copy the levels of ranges of k that the target lacks."""
        theirs, own = PART[t.level].c, t.level.c
        differ = func.abs(own.k - theirs.k) > own.error + theirs.error
        if other := self.part.differing(t.level, ("a", "parity", "number"), differ):
            where = f"parity {other.parity} at a = {format_float(other.a)}"
            self.refuse(f"level {other.number} of {where} differs")
        fill = PART[t.level_fill]
        added: dict[float, int] = {}
        for window in self.ask(select(fill).where(self.chosen.of_a(fill))).mappings().all():
            added[window["a"]] = added.get(window["a"], 0) + self.window(window)
        for a, count in added.items():
            self.add(a, other=several(count, "level") if count else "")

    def window(self, window: RowMapping) -> int:
        """Copy the levels of what the target lacks of a range of k, and return their number."""
        theirs, fill, own = PART[t.level].c, PART[t.level_fill].c, t.level_fill.c
        low, high = window["low"], window["high"]
        this = [fill[name] == window[name] for name in ("a", "parity", "low")]
        here = [theirs[name] == window[name] for name in ("a", "parity")]
        stored = select(own.low, own.high).where(*(own[name] == window[name] for name in ("a", "parity")))
        copied = 0
        for start, end in _uncovered(self.ask(stored.order_by(own.low)).all(), low, high):
            before = select(func.count()).where(*here, theirs.k >= low, theirs.k < start)
            below = window["below"] + (self.connection.scalar(before) or 0)
            seconds = window["seconds"] * (end - start) / (high - low)
            self.part.copy(t.level_fill, *this, low=start, high=end, below=below, seconds=seconds)
            copied += self.part.copy(t.level, *here, theirs.k >= start, theirs.k < end)
        return copied

    # what does not depend on a

    def births(self) -> None:
        """Copy the births and deaths of periods that are further in the part."""
        theirs, own, cycle = PART[t.change], t.change.c, PART[t.cycle]
        differ = sa.or_(own.kind != theirs.c.kind, func.abs(own.a - theirs.c.a) > own.error + theirs.c.error)
        if other := self.part.differing(t.change, ("cycle", "number"), differ):
            self.refuse(f"births or deaths of {self.part.word_of(other)} differ")
        further = self.further(t.birth_fill)
        for p in further:
            self.ask(sa.delete(t.change).where(own.cycle.in_(select(t.cycle.c.id).where(t.cycle.c.p == p))))
            self.part.copy(t.change, theirs.c.cycle.in_(select(cycle.c.id).where(cycle.c.p == p)))
            self.replace(t.birth_fill, p)
        if further:
            self.add(None, other=f"births ({written_periods(further)})")

    def pruned(self) -> None:
        """Copy the geometrically pruned words that the target lacks."""
        theirs = PART[t.pruned]
        short = theirs.c.id > -t.LONG
        new = (self.chosen.of_p(theirs), lacking(t.pruned, ("p", "word")))
        added = self.part.copy(t.pruned, *new, short)
        for number, p, word in self.ask(
            select(theirs.c.id, theirs.c.p, theirs.c.word).where(*new, ~short)
        ).all():
            (own,) = t.pruned_ids(self.connection, p, [word])
            added += self.part.copy(t.pruned, theirs.c.id == number, id=own)
        for p in self.further(t.pruned_fill):
            self.replace(t.pruned_fill, p)
        if added:
            self.add(None, other=several(added, "geometrically pruned word"))


_KEY = ("stadium", "cycle")
"""The key of an orbit."""

_BOUNDED = (
    *(("length", "length_error"), ("lyapunov", "lyapunov_error"), ("area", "area_error")),
    ("margin", "error"),
)
"""Columns of an orbit, and those with the bounds on their errors."""

_NOT_BEGUN = -2
"""Less than what any period has reached."""


def _reached(state: str, cursor: str | None) -> float:
    """Return a number that grows with the work on a period."""
    if state == t.DONE:
        return float("inf")
    return -1 if cursor is None else int(cursor, 8)


def _uncovered(
    stored: Sequence[tuple[float, float]], low: float, high: float
) -> Iterator[tuple[float, float]]:
    """Yield the parts of a range that the stored ranges, in order, leave open."""
    for start, end in stored:
        if start >= high:
            break
        if low < start:
            yield low, start
        low = max(low, end)
    if low < high:
        yield low, high
