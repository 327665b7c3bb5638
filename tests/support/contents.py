"""Make and alter catalogues, and read their contents in forms that can be compared."""

import gzip
import sqlite3
from collections.abc import Callable, Iterable, Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any, TypeVar

import pytest
from made_levels import keep_made_levels
from sqlalchemy import Connection, Engine, event

from orbitdb.answers.complete_periods import Counted, counts
from orbitdb.answers.completeness import Coverage
from orbitdb.catalogue import Catalogue
from orbitdb.filling import sweeps
from orbitdb.filling.sweeps import sweep_periods
from orbitdb.selection import Selection
from orbitdb.store.file import reading
from orbitdb.store.tables import TABLES
from orbitdb.verification.checks import Check
from orbitdb.verification.verify import report, verify

Answer = TypeVar("Answer")

_TABLES = {
    "cycle": "*",
    "pruned": "*",
    "stadium": "*",
    "orbit": "stadium, cycle, status, coordinates, length, lyapunov, margin, residual, error, length_error,"
    " lyapunov_error, iterations, solver",
    "fill": "stadium, p, state, cursor, words, primitive, rule_1, rule_6, n_t, n_c, classes, boundary",
}


def counts_of(catalogue: Catalogue, **criteria: Any) -> Counted:
    """Return the counts from which `Catalogue.table` is made, with where they come from."""
    criteria = {"a": catalogue.a, "status": (), **criteria}
    with reading(catalogue.path) as connection:
        return counts(Coverage(connection, Selection.from_criteria(**criteria)))


def made(path: Path, *fills: Iterable[object]) -> Path:
    """Create a catalogue and run fills in it."""
    Catalogue.create(path)
    for fill in fills:
        for _ in fill:
            pass
    return path


SCHEMA_9 = Path(__file__).parents[1] / "store" / "files" / "schema-9.db.gz"
"""A small catalogue that the last version with schema 9 made, with rows in every table but `sweep_block`."""


def begin_sweep(path: Path, a: float, p: int, blocks: int = 2) -> None:
    """Sweep a period in small blocks, and stop after the first ones."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sweeps, "CLASSES", 64)
        steps = sweep_periods(path, a, [p])
        for _ in range(blocks):
            next(steps)
        steps.close()


def awkward(path: Path) -> None:
    """Make a catalogue with what others lack.

    At a = 1.6 there are periods 2-8, two windows of levels of one parity with a gap between them,
    certificates, and negative areas. At a = 0.3 there are periods 2-4 and 6-7, averages and a bound; at 3 and
    2.5 sweeps alone; at 2 averages alone; at 1 levels alone, with one missing and one spurious in one gap.
    Sweeps of period 8 were stopped at 0.3 and 2.5.
    There are births of p = 2-7, one made-up death, and pruned words. Period 8 is stored at one value of a,
    and has no births.
    """
    path.write_bytes(gzip.decompress(SCHEMA_9.read_bytes()))
    catalogue = Catalogue.create(path, a=0.3)
    catalogue.sweep([6], a=2.5)
    catalogue.sweep("6-7")  # before the fill, which makes sweeps needless
    catalogue.fill("6-7")
    for a in (0.3, 2.5):
        begin_sweep(path, a, 8)
    catalogue.simulate(bounces=2000, seed=1)
    catalogue.simulate(bounces=2000, seed=1, a=2.0)
    catalogue.prove_bounds(3)
    keep_made_levels(path, 1.0)
    fifth = "a = 1 AND parity = 'ee' AND number = 5"
    fourth = "SELECT k FROM level WHERE a = 1 AND parity = 'ee' AND number = 4"
    last_born = "SELECT * FROM change WHERE kind = 'born' ORDER BY a DESC LIMIT 1"
    alter(
        path,
        f"UPDATE level SET k = ({fourth}) + 1e-6 WHERE {fifth}",
        "INSERT INTO change (cycle, number, a, error, kind, slope, run)"
        f" SELECT cycle, 2, a + 0.5, error, 'died', slope, run FROM ({last_born})",
    )
    catalogue.close()


def whole(path: Path) -> dict[str, list[tuple[Any, ...]]]:
    """Return every row of every table, in stored order, except the runs."""
    with closing(sqlite3.connect(path)) as plain:
        assert plain.execute("PRAGMA foreign_key_check").fetchall() == []
        return {name: plain.execute(f"SELECT * FROM {name}").fetchall() for name in TABLES if name != "run"}


def alter(path: Path, *statements: str) -> None:
    """Alter a file with SQL statements, including those that SQLite forbids by default."""
    with closing(sqlite3.connect(path)) as plain, plain:
        plain.execute("PRAGMA writable_schema = ON")
        for statement in statements:
            plain.execute(statement)


def ask(path: Path, query: str) -> list[tuple[Any, ...]]:
    """Return the rows of a query."""
    with closing(sqlite3.connect(path)) as plain:
        return plain.execute(query).fetchall()


@contextmanager
def before_statements(look: Callable[[str], object]) -> Iterator[None]:
    """Call a function before each statement that is no PRAGMA, with the statement; it may raise."""

    def listen(_connection: Connection, _cursor: object, statement: str, *_others: object) -> None:
        if "PRAGMA" not in statement:
            look(statement)

    event.listen(Engine, "before_cursor_execute", listen)
    try:
        yield
    finally:
        event.remove(Engine, "before_cursor_execute", listen)


def content(path: Path) -> dict[str, list[tuple[Any, ...]]]:
    """Return everything stored except times, row ids and provenance."""
    with closing(sqlite3.connect(path)) as plain:
        found = {
            "catalogue": plain.execute(
                "SELECT a, p, code, representative, status, rules, length, lyapunov, margin, element"
                " FROM catalogue ORDER BY a, p, code"
            ).fetchall(),
            "pruned": plain.execute("SELECT p, word, rules FROM pruned ORDER BY p, word").fetchall(),
            "coordinates": plain.execute(
                "SELECT a, word, coordinates FROM orbit JOIN cycle ON cycle.id = orbit.cycle"
                " JOIN stadium ON stadium.id = orbit.stadium ORDER BY a, p, word"
            ).fetchall(),
            "fill": plain.execute(
                "SELECT a, p, state, n_t, n_c, classes, boundary FROM fill"
                " JOIN stadium ON stadium.id = fill.stadium ORDER BY a, p"
            ).fetchall(),
        }
        assert plain.execute("PRAGMA foreign_key_check").fetchall() == []
    return found


def rows(path: Path) -> dict[str, list[tuple[Any, ...]]]:
    """Return every row except times and provenance, with row ids, in stored order."""
    with closing(sqlite3.connect(path)) as plain:
        assert plain.execute("PRAGMA foreign_key_check").fetchall() == []
        return {
            table: plain.execute(f"SELECT {names} FROM {table}").fetchall()
            for table, names in _TABLES.items()
        }


def is_sound(path: Path) -> bool:
    """Tell whether SQLite finds the file intact, after recovering its journal."""
    with closing(sqlite3.connect(path)) as plain:
        return plain.execute("PRAGMA integrity_check").fetchall() == [("ok",)]


def agrees(path: Path) -> int:
    """Check that the classes up to each cursor are stored with their words and orbits; count the words."""
    with closing(sqlite3.connect(path, timeout=30, isolation_level=None)) as plain:
        if not plain.execute("PRAGMA user_version").fetchone()[0]:
            return 0
        plain.execute("BEGIN")
        fills = plain.execute("SELECT stadium, p, state, cursor, words, n_t FROM fill").fetchall()
        for stadium, p, state, cursor, words, n_t in fills:
            stored = plain.execute(
                "SELECT coalesce(sum(class_size), 0), coalesce(sum(length(words)) / p, 0),"
                " coalesce(sum(iif(orbit.cycle, class_size, 0)), 0)"
                " FROM cycle LEFT JOIN orbit ON orbit.cycle = cycle.id AND orbit.stadium = ?"
                " WHERE p = ? AND word <= ?",
                (stadium, p, cursor),
            ).fetchone()
            beyond = plain.execute(
                "SELECT count(*) FROM cycle JOIN orbit ON orbit.cycle = cycle.id AND orbit.stadium = ?"
                " WHERE p = ? AND word > ?",
                (stadium, p, cursor),
            ).fetchone()
            assert stored == (words, words, words)
            assert beyond == (0,)
            assert (state == "done") == (n_t is not None)
            assert n_t in (None, words)
    return sum(words for *_, words, _ in fills)


def checks(path: Path, selection: Selection | None = None, **options: Any) -> dict[str, Check]:
    with reading(path) as connection:
        steps = verify(connection, [selection or Selection()], **options)
        return {check.name: check for check in report(steps)}


def answer(path: Path, ask: Callable[..., Answer], *arguments: Any, **options: Any) -> Answer:
    """Ask a catalogue a question at one moment."""
    with reading(path) as connection:
        return ask(connection, *arguments, **options)
