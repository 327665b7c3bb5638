"""Merge a part, a catalogue file of its own, into another catalogue: what the other lacks is copied.

SQLite copies the rows from file to file, in one transaction a part. Classes are matched by word, stadiums by
their a, runs by their start. Work on a period that has come further in the part replaces that of the target.
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any, NamedTuple

from orbitdb.errors import DamagedError, InputError, NotStoredError, StoreError
from orbitdb.progress import Tell, nobody
from orbitdb.store import tables as t
from orbitdb.store.file import migrate, reading
from orbitdb.store.file_kind import need_newest
from orbitdb.store.journal import refuse_foreign_journal
from orbitdb.store.paths import file_id
from orbitdb.store.selection import written_periods
from orbitdb.store.sqlite import Driver, driver_of
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

    def of_a(self, column: str) -> str:
        """Return a condition in SQL for a column with an a; the chosen values are in a temporary table."""
        return f"{column} IN (SELECT a FROM temp.chosen)" if self.a else "1"

    def of_p(self, column: str) -> str:
        """Return a condition in SQL for a column with a period."""
        spans = (f"{column} BETWEEN {low} AND {high}" for low, high in self.spans)
        return f"({' OR '.join(spans)})" if self.spans else "1"


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
        with writer.attached(path), writer.writing() as connection:
            added = _Merge(driver_of(connection), path, chosen).run()
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


_RUNS_OF = (
    *("orbit", "certificate", "change", "trajectory", "entropy_bound", "open_stadium", "level_fill"),
    *("sweep", "sweep_block"),
)
"""The tables whose rows say which run wrote them."""

_RUN = "(SELECT own FROM temp.ran WHERE part = o.run)"
"""The id of a run in the target."""

_OWN = "ifnull((SELECT own FROM temp.long WHERE part = {0}), {0})"
"""The id of a class in the target, given its id in the part."""


class _Merge:
    """One transaction that copies from the attached file ``part``."""

    def __init__(self, driver: Driver, path: Path, chosen: Choice) -> None:
        self.ask, self.path, self.chosen = driver.execute, path, chosen
        self.found: dict[float | None, Merged] = {}

    def run(self) -> list[Merged]:
        with _temporary(self.ask):
            for a in self.chosen.a:
                self.ask("INSERT INTO temp.chosen VALUES (?)", (a,))
            self.classes()
            self.runs()
            for a, theirs, ours in self.stadiums():
                self.orbits(a, theirs, ours)
                self.fills(a, theirs, ours)
                self.sweeps(a, theirs, ours)
                self.trajectories(a, theirs, ours)
            self.bounds_agree()
            self.of_a("entropy_bound", "bound")
            self.of_a("open_stadium", "open stadium")
            self.levels()
            self.births()
            self.pruned()
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

    # what rows refer to

    def classes(self) -> None:
        """Copy the classes that the target lacks; long words get ids of their own there."""
        only = self.chosen.of_p("p")
        other = self.ask(
            "SELECT c.word FROM part.cycle c JOIN main.cycle m USING (id) WHERE id < ? AND m.word <> c.word",
            (t.LONG,),
        ).fetchone()
        if other:
            self.refuse(f"another class has the number of {other[0]}")
        names = ", ".join(column.name for column in t.cycle.c if column.name != "id")
        new = f"SELECT id, {names} FROM part.cycle WHERE id < {t.LONG} AND {only}"
        self.ask(f"INSERT OR IGNORE INTO main.cycle (id, {names}) {new}")
        ours = dict(self.ask("SELECT word, id FROM main.cycle WHERE id >= ?", (t.LONG,)))
        free = max(ours.values(), default=t.LONG - 1) + 1
        for number, *row in self.ask(
            f"SELECT id, {names} FROM part.cycle WHERE id >= ? AND {only}", (t.LONG,)
        ).fetchall():
            word = row[1]
            if word not in ours:
                ours[word] = free
                self.ask(
                    f"INSERT INTO main.cycle (id, {names}) VALUES (?, {', '.join('?' * len(row))})",
                    (free, *row),
                )
                free += 1
            self.ask("INSERT INTO temp.long VALUES (?, ?)", (number, ours[word]))

    def runs(self) -> None:
        """Copy the runs that wrote rows of the part, and number them as the target does."""
        used = " UNION ".join(f"SELECT run FROM part.{table}" for table in _RUNS_OF)
        for number, *row in self.ask(
            f"SELECT id, started, version, parameters FROM part.run WHERE id IN ({used})"
        ).fetchall():
            same = "SELECT id FROM main.run WHERE (started, version, parameters) = (?, ?, ?)"
            known = self.ask(same, row).fetchone()
            if known is None:
                known = self.ask(
                    "INSERT INTO main.run (started, version, parameters) VALUES (?, ?, ?) RETURNING id", row
                ).fetchone()
            self.ask("INSERT INTO temp.ran VALUES (?, ?)", (number, *known))

    def stadiums(self) -> Iterator[tuple[float, int, int]]:
        """Yield each a of the part with its id there and in the target."""
        for theirs, a in self.ask(
            f"SELECT id, a FROM part.stadium WHERE {self.chosen.of_a('a')} ORDER BY a"
        ).fetchall():
            self.ask("INSERT OR IGNORE INTO main.stadium (a) VALUES (?)", (a,))
            ((ours,),) = self.ask("SELECT id FROM main.stadium WHERE a = ?", (a,)).fetchall()
            yield a, theirs, ours

    # what is stored at an a

    def orbits(self, a: float, theirs: int, ours: int) -> None:
        """Copy the orbits that the target lacks, and the certificates of equal rows."""
        cycle, only = _OWN.format("o.cycle"), self.chosen.of_p("c.p")
        rows = "part.orbit o JOIN part.cycle c ON c.id = o.cycle"
        own = f"m.stadium = {ours} AND m.cycle = {cycle}"
        both = f"{rows} JOIN main.orbit m ON {own}"
        chosen = f"WHERE o.stadium = {theirs} AND {only}"
        beyond = " OR ".join(f"abs(m.{name} - o.{name}) > m.{error} + o.{error}" for name, error in _BOUNDED)
        other = self.ask(
            f"SELECT c.word FROM {both} {chosen} AND (m.status <> o.status OR {beyond})"
        ).fetchone()
        if other:
            self.refuse(f"{other[0]} at a = {format_float(a)} has other numbers, beyond their error bounds")
        new = f"FROM {rows} {chosen} AND NOT EXISTS (SELECT 1 FROM main.orbit m WHERE {own})"
        ((words,),) = self.ask(f"SELECT ifnull(sum(c.class_size), 0) {new}").fetchall()
        names = [column.name for column in t.orbit.c if column.name not in ("stadium", "cycle", "run")]
        values = ", ".join(f"o.{name}" for name in names)
        self.ask(
            f"INSERT INTO main.orbit (stadium, cycle, run, {', '.join(names)}) "
            f"SELECT {ours}, {cycle}, {_RUN}, {values} {new}"
        )
        equal = " AND ".join(f"m.{name} IS o.{name}" for name in names if name != "iterations")
        proved = self.ask(
            f"""INSERT OR IGNORE INTO main.certificate (stadium, cycle, radius, bits, version, run)
            SELECT {ours}, {cycle}, p.radius, p.bits, p.version, {_RUN.replace("o.run", "p.run")}
            FROM {both} JOIN part.certificate p ON p.stadium = o.stadium AND p.cycle = o.cycle
            {chosen} AND {equal}"""
        ).rowcount
        self.add(a, words=words, other=several(proved, "certificate") if proved else "")

    def fills(self, a: float, theirs: int, ours: int) -> None:
        """Take the cursors and counts of periods that are further in the part."""
        further = self.further("fill", theirs, ours)
        for p in further:
            self.replace("fill", theirs, ours, p)
        self.add(a, further)

    def sweeps(self, a: float, theirs: int, ours: int) -> None:
        """Copy the sweeps that are further in the part, with their blocks."""
        counts = " OR ".join(f"m.{name} <> o.{name}" for name in t.TALLIED)
        other = self.ask(
            f"""SELECT o.p FROM part.sweep o JOIN main.sweep m ON m.stadium = {ours} AND m.p = o.p
            WHERE o.stadium = {theirs} AND o.state = 'done' AND m.state = 'done' AND ({counts})"""
        ).fetchone()
        if other:
            self.refuse(f"the sweep of period {other[0]} at a = {format_float(a)} has other counts")
        further = self.further("sweep", theirs, ours)
        for p in further:
            self.ask(f"DELETE FROM main.sweep_block WHERE stadium = {ours} AND p = {p}")
            self.replace("sweep", theirs, ours, p)
            self.replace("sweep_block", theirs, ours, p)
        if further:
            self.add(a, other=f"{several(len(further), 'sweep')} ({written_periods(further)})")

    def further(self, table: str, theirs: int | None = None, ours: int | None = None) -> list[int]:
        """Return the periods of a table of cursors whose work has come further in the part."""
        query = f"SELECT p, state, cursor FROM {{}}.{table} WHERE {{}} AND {self.chosen.of_p('p')}"
        at = [f"stadium = {number}" if number is not None else "1" for number in (theirs, ours)]
        stored = {p: _reached(state, cursor) for p, state, cursor in self.ask(query.format("main", at[1]))}
        rows = self.ask(query.format("part", at[0]) + " ORDER BY p").fetchall()
        return [p for p, state, cursor in rows if _reached(state, cursor) > stored.get(p, _NOT_BEGUN)]

    def replace(self, table: str, theirs: int | None, ours: int | None, p: int) -> None:
        """Replace the rows of a period in a table by those of the part."""
        own = {"stadium": str(ours), "run": _RUN}
        names = [column.name for column in t.TABLES[table].c]
        values = ", ".join(own.get(name, f"o.{name}") for name in names)
        at = "" if theirs is None else f" AND o.stadium = {theirs}"
        self.ask(
            f"INSERT OR REPLACE INTO main.{table} ({', '.join(names)}) "
            f"SELECT {values} FROM part.{table} o WHERE o.p = {p}{at}"
        )

    def trajectories(self, a: float, theirs: int, ours: int) -> None:
        """Copy the averages over trajectories that the target lacks."""
        names = [column.name for column in t.trajectory.c if column.name not in ("id", "stadium", "run")]
        same = " AND ".join(f"m.{name} = o.{name}" for name in names)
        values = ", ".join(f"o.{name}" for name in names)
        added = self.ask(
            f"""INSERT INTO main.trajectory (stadium, run, {", ".join(names)})
            SELECT {ours}, {_RUN}, {values} FROM part.trajectory o WHERE o.stadium = {theirs}
            AND NOT EXISTS (SELECT 1 FROM main.trajectory m WHERE m.stadium = {ours} AND {same})"""
        ).rowcount
        if added:
            self.add(a, other=f"{several(added, 'average')} over trajectories")

    def bounds_agree(self) -> None:
        """Refuse bounds that exclude those of the target."""
        other = self.ask(
            "SELECT a FROM part.entropy_bound o JOIN main.entropy_bound m USING (a) "
            "WHERE m.lower > o.upper OR o.lower > m.upper"
        ).fetchone()
        if other:
            self.refuse(f"the bounds on the entropy at a = {format_float(other[0])} exclude one another")

    def of_a(self, table: str, noun: str) -> None:
        """Copy the rows of a table with a column a that the target lacks."""
        names = [column.name for column in t.TABLES[table].c]
        key = [column.name for column in t.TABLES[table].primary_key]
        values = ", ".join(_RUN if name == "run" else f"o.{name}" for name in names)
        same = " AND ".join(f"m.{name} = o.{name}" for name in key)
        new = f"""FROM part.{table} o WHERE {self.chosen.of_a("o.a")}
            AND NOT EXISTS (SELECT 1 FROM main.{table} m WHERE {same})"""
        for a, count in self.ask(f"SELECT o.a, count(*) {new} GROUP BY o.a").fetchall():
            self.add(a, other=several(count, noun))
        self.ask(f"INSERT INTO main.{table} ({', '.join(names)}) SELECT {values} {new}")

    def levels(self) -> None:
        """Copy the levels of ranges of k that the target lacks."""
        agree = """SELECT a, parity, number FROM part.level o JOIN main.level m USING (a, parity, number)
            WHERE abs(m.k - o.k) > m.error + o.error"""
        if other := self.ask(agree).fetchone():
            self.refuse(f"level {other[2]} of parity {other[1]} at a = {format_float(other[0])} differs")
        columns = "a, parity, low, high, below, seconds, run"
        windows = self.ask(f"SELECT {columns} FROM part.level_fill WHERE {self.chosen.of_a('a')}").fetchall()
        added: dict[float, int] = {}
        for window in windows:
            added[window[0]] = added.get(window[0], 0) + self.window(*window)
        for a, count in added.items():
            self.add(a, other=several(count, "level") if count else "")

    def window(
        self, a: float, parity: str, low: float, high: float, below: int, seconds: float, run: int
    ) -> int:
        """Copy the levels of what the target lacks of a range of k, and return their number."""
        at, inside, copied = (a, parity), "a = ? AND parity = ? AND k >= ? AND k < ?", 0
        stored = self.ask("SELECT low, high FROM main.level_fill WHERE a = ? AND parity = ? ORDER BY low", at)
        for start, end in _uncovered(stored.fetchall(), low, high):
            before = self.ask(f"SELECT count(*) FROM part.level WHERE {inside}", (*at, low, start)).fetchone()
            self.ask(
                "INSERT INTO main.level_fill (a, parity, low, high, below, seconds, run) "
                "VALUES (?, ?, ?, ?, ?, ?, (SELECT own FROM temp.ran WHERE part = ?))",
                (*at, start, end, below + before[0], seconds * (end - start) / (high - low), run),
            )
            columns = "a, parity, number, k, error"
            new = f"SELECT {columns} FROM part.level WHERE {inside}"
            copied += self.ask(f"INSERT INTO main.level ({columns}) {new}", (*at, start, end)).rowcount
        return copied

    # what does not depend on a

    def births(self) -> None:
        """Copy the births and deaths of periods that are further in the part."""
        differ = f"""SELECT c.word FROM part.change o JOIN part.cycle c ON c.id = o.cycle
            JOIN main.change m ON m.cycle = {_OWN.format("o.cycle")} AND m.number = o.number
            WHERE m.kind <> o.kind OR abs(m.a - o.a) > m.error + o.error LIMIT 1"""
        if other := self.ask(differ).fetchone():
            self.refuse(f"births or deaths of {other[0]} differ")
        further = self.further("birth_fill")
        names = [column.name for column in t.change.c if column.name not in ("cycle", "run")]
        for p in further:
            own = f"(SELECT id FROM {{}}.cycle WHERE p = {p})"
            self.ask(f"DELETE FROM main.change WHERE cycle IN {own.format('main')}")
            values = ", ".join(f"o.{name}" for name in names)
            self.ask(
                f"""INSERT INTO main.change (cycle, run, {", ".join(names)})
                SELECT {_OWN.format("o.cycle")}, {_RUN}, {values}
                FROM part.change o WHERE o.cycle IN {own.format("part")}"""
            )
            self.replace("birth_fill", None, None, p)
        if further:
            self.add(None, other=f"births ({written_periods(further)})")

    def pruned(self) -> None:
        """Copy the geometrically pruned words that the target lacks."""
        last = f"(SELECT min(min(id), {-t.LONG}) - 1 FROM main.pruned)"
        number = f"CASE WHEN id > {-t.LONG} THEN id ELSE {last} - row_number() OVER () END"
        added = self.ask(
            f"""INSERT INTO main.pruned (id, p, word, rules)
            SELECT {number}, p, word, rules FROM part.pruned o WHERE {self.chosen.of_p("p")}
            AND NOT EXISTS (SELECT 1 FROM main.pruned m WHERE m.p = o.p AND m.word = o.word)"""
        ).rowcount
        for p in self.further("pruned_fill"):
            self.replace("pruned_fill", None, None, p)
        if added:
            self.add(None, other=several(added, "geometrically pruned word"))


@contextmanager
def _temporary(ask: Callable[..., Any]) -> Iterator[None]:
    """Make tables of the chosen a, and of which number of the part is which of the target; remove them."""
    numbers = "part INTEGER PRIMARY KEY, own INTEGER NOT NULL"
    tables = {"long": numbers, "ran": numbers, "chosen": "a REAL"}
    for name, contents in tables.items():
        ask(f"CREATE TEMP TABLE {name} ({contents})")
    try:
        yield
    finally:
        for name in tables:
            ask(f"DROP TABLE temp.{name}")


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
