"""Catalogues with schema 6 are backed up, upgraded to the latest schema, and sound afterwards."""

import shutil
import sqlite3
import subprocess
import sys
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest
from contents import alter
from older import add_classes, empty, make_older
from processes import start
from there import there

from orbitdb.errors import StoreError
from orbitdb.store.file.database import check_file, need_newest
from orbitdb.store.file.ids import LONG
from orbitdb.store.file.migrate import migrate
from orbitdb.store.file.schema import SCHEMA_VERSION
from orbitdb.symbols.enumeration import Span, least_words
from orbitdb.symbols.words import key, keys, parse, word_of

LONG_WORDS = [parse("1^30 5^29"), parse("1^12 3^11 02")]
KEYED = parse("1^10 3^10")
"""A word as long as words with a key can be."""

PRUNED = {
    "012": "1",
    "0" * 19 + "1": "1,3",
    "0" * 22 + "1": "1,3",
    "0" * 24 + "2": "1,2",
    "1" * 24 + "2": "3",
}
REFERRING = {
    "orbit": "status, coordinates, length, lyapunov, margin, iterations, solver, run, stadium",
    "certificate": "radius, bits, version, run, stadium",
    "change": "number, a, error, kind, bounce, joint, event, slope, run",
}
KEPT = ("stadium", "run", "trajectory", "entropy_bound", "sweep", "sweep_block")


def least_of(p: int) -> list[str]:
    found = [word for part in least_words(Span.whole(p)) for word in keys(part.codes, p).tolist()]
    return [word_of(each) for each in found]


@pytest.fixture(scope="module")
def older_once(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A catalogue with schema 6 that has rows in every table and half-finished fills."""
    path = tmp_path_factory.mktemp("older") / "old.db"
    with closing(empty(path)) as plain:
        words = [word for p in range(2, 6) for word in least_of(p)] + ["013311133313", KEYED] + LONG_WORDS
        numbers = add_classes(plain, words)
        half = least_of(5)[7]
        plain.executemany(
            "INSERT INTO sequence VALUES (?, ?, NULL, NULL, ?)",
            [(len(word), word, rules) for word, rules in PRUNED.items()],
        )
        plain.executescript(
            "INSERT INTO run VALUES (1, 'now', '0.2', '{}');"
            "INSERT INTO stadium VALUES (1, 1.6), (2, 0.1);"
            "INSERT INTO fill (stadium, p, state, cursor, seconds, words, n_t)"
            " VALUES (1, 4, 'done', '7777', 0.25, 32, 32), (1, 5, 'filling', NULL, 0, 0, NULL),"
            f" (2, 5, 'filling', '{half}', 0.1, 13, NULL);"
            "INSERT INTO birth_fill (p, state, cursor, seconds, words)"
            f" VALUES (5, 'filling', '{half}', 1, 13);"
            "INSERT INTO trajectory VALUES (1, 1, 9, 3, '7', 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 1);"
            "INSERT INTO entropy_bound VALUES (1.6, 'balls', 5, 0.1, 0.7, 100, 3, 1);"
            "INSERT INTO sweep VALUES"
            " (1, 9, 'p = 9', 'filling', '000000010', 1, 0.5, 0.7, 9, 8, 7, 6, 5, NULL, x'01', 1);"
            "INSERT INTO sweep_block VALUES (1, 9, 'p = 9', 0, x'0203', x'04', 1);"
        )
        for which, (number, word) in enumerate(zip(numbers, words, strict=True)):
            stored = (1, 2) if (len(word), word) <= (5, half) else (1,)
            for stadium in stored:
                row = (stadium, number, "orbit", bytes([which, stadium]), 1 / (which + 3), 0.1 * which, 1e-9)
                plain.execute(
                    "INSERT INTO orbit VALUES (?, ?, ?, ?, ?, ?, ?, 0, 0, 0, 0, 4, 'newton', 1)", row
                )
            if which % 3 == 0 or number < 0:
                plain.execute("INSERT INTO certificate VALUES (1, ?, ?, 128, 'x', 1)", (number, 0.1 * which))
            plain.execute(
                "INSERT INTO change VALUES (?, 1, ?, 1e-9, 'born', 1, '+', NULL, 0.5, 1)",
                (number, 0.1 * which),
            )
            if which % 2:  # a word counts once, however often it changes
                plain.execute(
                    "INSERT INTO change VALUES (?, 2, ?, 1e-9, 'died', 1, '+', NULL, 0.5, 1)",
                    (number, 0.1 * which + 1),
                )
    return path


@pytest.fixture
def older(older_once: Path, tmp_path: Path) -> Path:
    return Path(shutil.copy(older_once, tmp_path / "old.db"))


def asked(path: Path, statement: str) -> list[tuple[Any, ...]]:
    with closing(sqlite3.connect(path)) as plain:
        return sorted(plain.execute(statement), key=repr)


def held(path: Path) -> dict[str, list[tuple[Any, ...]]]:
    """Return the contents of a catalogue with either schema, in a form that does not depend on class ids."""
    with closing(sqlite3.connect(path)) as plain:
        if plain.execute("PRAGMA user_version").fetchone() == (6,):
            pruned = "SELECT p, word, rules FROM sequence WHERE cycle IS NULL"
            words = (
                "SELECT sequence.p, sequence.word, element, cycle.* FROM sequence JOIN cycle ON id = cycle"
            )
        else:
            pruned = "SELECT p, word, rules FROM pruned"
            words = (
                "SELECT p, substr(words, 1 + p * n, p), element, cycle.*"
                " FROM cycle JOIN element USING (symmetry)"
            )
        names = [row[1] for row in plain.execute("PRAGMA table_info(catalogue)")]
    view = ", ".join(name for name in names if name not in ("cycle", "maslov", "lambda_c_error"))
    found = {"words": [row[:3] + row[4:10] for row in asked(path, words)], "pruned": asked(path, pruned)}
    found["catalogue"] = asked(path, f"SELECT {', '.join(sorted(view.split(', ')))} FROM catalogue"
                                     " WHERE status <> 'geometric'")  # fmt: skip
    lives = "SELECT p, class_size, word, coalesce(born, 0.0), born_error, dies, dies_error FROM life"
    found["life"] = asked(path, lives)
    for table, columns in REFERRING.items():
        found[table] = asked(
            path, f"SELECT word, {columns} FROM {table} JOIN cycle ON cycle.id = {table}.cycle"
        )
    for table in KEPT:
        found[table] = asked(path, f"SELECT * FROM {table}")
    return found


def test_a_migration_loses_nothing(older):
    before = held(older)
    assert migrate(older) == (6, SCHEMA_VERSION, older.with_name("old.db.schema-6"))
    after = held(older)
    for name, rows in before.items():
        assert after[name] == rows, name
    assert len(after["catalogue"]) > 200
    with closing(sqlite3.connect(older)) as plain:
        assert plain.execute("PRAGMA foreign_key_check").fetchall() == []
        assert plain.execute("PRAGMA integrity_check").fetchall() == [("ok",)]
        assert plain.execute("PRAGMA freelist_count").fetchone() == (0,)
    need_newest(older)


def test_long_and_pruned_words_get_their_own_ids(older):
    migrate(older)
    long = asked(older, f"SELECT id, word FROM cycle WHERE id >= {LONG}")
    assert [row[0] for row in long] == [LONG, LONG + 1]
    assert [row[1] for row in long] == LONG_WORDS
    pruned = {word: number for number, word in asked(older, "SELECT id, word FROM pruned")}
    short, as_long, *longer = PRUNED
    keyed = {word: -key(word) for word in (short, as_long)}
    assert pruned == keyed | {word: -LONG - n for n, word in enumerate(longer)}
    assert asked(older, f"SELECT id FROM cycle WHERE word = '{KEYED}'") == [(key(KEYED),)]


def test_half_filled_periods_count_the_words_of_their_classes(older):
    migrate(older)
    sizes = dict(asked(older, "SELECT word, class_size FROM cycle WHERE p = 5"))
    stored = sum(sizes[word] for word in least_of(5)[:8])
    fills = asked(older, "SELECT stadium, p, state, words, seconds FROM fill")
    assert fills == [(1, 4, "done", 32, 0.25), (1, 5, "filling", 0, 0.0), (2, 5, "filling", stored, 0.1)]
    assert asked(older, "SELECT words FROM birth_fill") == [(stored,)]


@pytest.mark.parametrize("version", [1, 5])
def test_files_before_schema_6_are_refused(older, version):
    with closing(sqlite3.connect(older)) as plain:
        plain.execute(f"PRAGMA user_version = {version}")
    before = older.read_bytes()
    for use in (check_file, migrate, need_newest):
        with pytest.raises(StoreError, match=f"schema {version}.*fill") as error:
            use(older)
        assert "\n" not in str(error.value)
    assert older.read_bytes() == before
    assert [each.name for each in older.parent.iterdir()] == ["old.db"]


@pytest.mark.parametrize(
    "statement",
    [
        "UPDATE cycle SET word = 'x' WHERE id = -1",
        "UPDATE cycle SET word = cast(x'ff' AS TEXT), p = 0 WHERE id = -2",
        "UPDATE sequence SET word = 'none' WHERE p = 3 AND rules IS NOT NULL",
        "UPDATE sequence SET cycle = NULL WHERE p = 4",
    ],
)
def test_a_failed_migration_leaves_the_file_unchanged(older, statement):
    alter(older, statement)
    before = asked(older, "SELECT type, name, sql FROM sqlite_master")
    with pytest.raises(StoreError) as error:
        migrate(older)
    assert "\n" not in str(error.value)
    assert asked(older, "SELECT type, name, sql FROM sqlite_master") == before
    assert asked(older, "PRAGMA user_version") == [(6,)]


def test_tables_added_by_users_stay(older):
    alter(
        older,
        "CREATE TABLE mine (cycle REFERENCES cycle (id))",
        "CREATE VIEW words AS SELECT word FROM sequence",
        "INSERT INTO mine SELECT id FROM cycle WHERE id > 0",
    )
    before = asked(older, "SELECT * FROM mine")
    migrate(older)
    assert asked(older, "SELECT * FROM mine") == before
    with closing(sqlite3.connect(older)) as plain:
        assert plain.execute("PRAGMA foreign_key_check").fetchall() == []


# through commands


@pytest.fixture
def varied_older(varied: Path, tmp_path: Path) -> Path:
    path = Path(shutil.copy(varied, tmp_path / "old.db"))
    make_older(path)
    return path


@pytest.mark.slow
def test_bounds_migrate_an_older_catalogue_only_if_they_are_stored(varied_older, cli):
    before = varied_older.read_bytes()
    shown = cli("bounds", "--window", "3", "--db", str(varied_older))
    assert shown.code == 0
    assert "has the older schema 6" in shown.err
    assert varied_older.read_bytes() == before
    assert [each.name for each in varied_older.parent.iterdir()] == ["old.db"]
    stored = cli("bounds", "--window", "3", "--store", "--db", str(varied_older))
    assert stored.code == 0
    assert stored.err.startswith(f"{varied_older}: schema 6 -> {SCHEMA_VERSION}")


def test_a_fill_migrates_an_older_catalogue(varied_older, cli):
    outcome = cli("fill", "--p", "3", "--a", "2", "--db", str(varied_older))
    assert outcome.code == 0
    assert "old.db.schema-6" in outcome.err
    assert cli("verify", "--db", str(varied_older)).code == 0


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="needs POSIX signals")
def test_two_processes_can_migrate_at_once(older):
    before = held(older)
    processes = [start("migrate", "--db", older) for _ in range(2)]
    for process in processes:
        _, err = process.communicate(timeout=100)
        assert process.returncode == 0, err
        assert len(err.splitlines()) == 1
    assert held(older) == before
    assert held(older.with_name("old.db.schema-6")) == before


_KILLED = """
import os, signal, sqlite3, sys
from pathlib import Path
from alembic import command
from orbitdb.store.file import migrate
path, connect = Path(sys.argv[1]), sqlite3.connect
def counted(*arguments, **options):
    connection = connect(*arguments, **options)
    connection.set_trace_callback(told)
    return connection
def told(statement):
    global left
    left -= 1
    if left < 0:
        os.kill(os.getpid(), signal.SIGKILL)
for line in sys.stdin:
    left = int(line)
    child = os.fork()  # which saves imports
    if not child:
        sqlite3.connect = counted
        migrate.migrate(path)
        os._exit(0)
    os.waitpid(child, 0)
    print(flush=True)
"""


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="needs POSIX signals")
def test_a_killed_migration_leaves_the_old_or_the_new_schema(older):
    """The process is killed after every few statements, from the backup to the commit and the last one."""
    whole, before = older.read_bytes(), held(older)
    versions, statements = [6], 0
    process = subprocess.Popen(
        [sys.executable, "-P", "-c", _KILLED, older], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    while versions[-3:] != 3 * [SCHEMA_VERSION]:
        statements += 15
        for part in older.parent.glob("old.db*"):
            part.unlink()
        older.write_bytes(whole)
        print(statements, file=process.stdin, flush=True)
        assert there(process.stdout).readline() == "\n"
        with closing(sqlite3.connect(older)) as plain:
            assert plain.execute("PRAGMA integrity_check").fetchone() == ("ok",)
            versions.append(plain.execute("PRAGMA user_version").fetchone()[0])
        assert migrate(older).after == SCHEMA_VERSION
        assert held(older) == before
    process.communicate()
    assert process.returncode == 0
    assert versions.count(6) > 5
