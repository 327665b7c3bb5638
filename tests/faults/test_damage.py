"""A damaged or altered file gives a one-line error, never a traceback, and `verify` finds the damage."""

import random
import sqlite3
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest
from contents import alter, made
from processes import run_several, seeded
from quick import fuzz_but, slow_but

from orbitdb.catalogue import Catalogue
from orbitdb.errors import StoreError
from orbitdb.filling.births import fill_births
from orbitdb.store.file.schema import PAGE_SIZE

COMMANDS = (
    ["query", "--p", "5", "--json"],
    ["query", "--code", "1232131"],
    ["table"],
    ["info"],
    ["fill", "--p", "8"],
    ["fill", "--p", "5", "--a", "1"],
    ["export", "--format", "csv", "--coordinates", "--p", "6"],
    ["verify"],
)
UNCHECKED = {
    "fill": {"seconds", "enumerating", "solving", "storing", "cursor", "words"},
    "run": {"started", "version", "parameters"},
    "orbit": {"iterations", "run"},
    "stadium": set(),
}
"""Columns that cannot be recomputed: times and provenance."""


def judge(found: list[tuple[list[str], int, str]]) -> int:
    """Check exit codes and messages of commands; return the exit code of ``verify``."""
    for arguments, code, err in found:
        allowed = {0, 1, 3} if arguments[0] == "verify" else {0, 3}
        assert code in allowed, (arguments, code, err)
        assert "Traceback" not in err
        assert code != 3 or len(err.splitlines()) == 1, (arguments, err)
    return found[-1][1]


def checked_rows(path: Path) -> dict[str, list[tuple[Any, ...]]]:
    """Return everything that ``verify`` checks."""
    tables = {}
    with closing(sqlite3.connect(path)) as plain:
        plain.text_factory = bytes
        for table in ("cycle", "element", "pruned", "orbit", "fill", "stadium"):
            names = [row[1].decode() for row in plain.execute(f"PRAGMA table_info({table})")]
            wanted = ", ".join(name for name in names if name not in UNCHECKED.get(table, set()))
            tables[table] = plain.execute(f"SELECT {wanted} FROM {table} NOT INDEXED").fetchall()
    return tables


def put(path: Path, data: bytes) -> None:
    """Write a file without a journal."""
    for part in path.parent.glob(f"{path.name}-*"):
        part.unlink()
    path.write_bytes(data)


def truncated(data: bytes, moments: random.Random) -> bytes:
    return data[: moments.randrange(100, len(data))]


def noisy_page(data: bytes, moments: random.Random) -> bytes:
    start = PAGE_SIZE * moments.randrange(len(data) // PAGE_SIZE)
    return data[:start] + moments.randbytes(PAGE_SIZE) + data[start + PAGE_SIZE :]


def empty_page(data: bytes, moments: random.Random) -> bytes:
    start = PAGE_SIZE * moments.randrange(len(data) // PAGE_SIZE)
    return data[:start] + bytes(PAGE_SIZE) + data[start + PAGE_SIZE :]


def flipped_bit(data: bytes, moments: random.Random) -> bytes:
    place, bit = moments.randrange(len(data)), moments.randrange(8)
    return data[:place] + bytes([data[place] ^ 1 << bit]) + data[place + 1 :]


@pytest.mark.parametrize("harm", slow_but(1, [noisy_page, truncated, empty_page, flipped_bit]))
def test_damage_is_reported_in_one_line(filled, cli, harm):
    broken = filled.with_name("broken.db")
    broken.write_bytes(harm(filled.read_bytes(), seeded(1)))
    ends = [(each, cli(*each, "--db", str(broken))) for each in COMMANDS]
    judge([(arguments, end.code, end.err) for arguments, end in ends])


@pytest.mark.slow
@pytest.mark.parametrize(
    ("harm", "times"),
    fuzz_but([(noisy_page, 1)], [(truncated, 1), (noisy_page, 1), (empty_page, 1), (flipped_bit, 8)]),
)
def test_verify_finds_all_damage_to_checked_rows(filled, harm, times):
    moments, data, sound = seeded(2026), filled.read_bytes(), checked_rows(filled)
    broken = filled.with_name("broken.db")
    for _ in range(times):
        harmed = harm(data, moments)
        put(broken, harmed)
        if judge(run_several([["verify"]], broken)) == 0:
            assert checked_rows(broken) == sound
        put(broken, harmed)
        judge(run_several(COMMANDS, broken))


@pytest.mark.parametrize(
    ("statement", "question", "message"),
    [
        ("UPDATE fill SET p = 1 WHERE p = 6", Catalogue.fills, "a fill of period '1'"),
        ("UPDATE fill SET n_c = NULL WHERE p = 5", Catalogue.table, "a filled period without counts, '5'"),
        (
            "INSERT INTO birth_fill (p, state, seconds, words) VALUES (1, 'done', 0, 0)",
            Catalogue.birth_fills,
            "births of period '1'",
        ),
        (
            "UPDATE orbit SET length = 9e999 WHERE length IS NOT NULL",
            lambda catalogue: catalogue.select(p=5),
            "infinite numbers in the column 'length'",
        ),
        (
            "INSERT INTO trajectory SELECT id, id, 1, 1, 'abc', 1, 1, 1, 1, 1, 1, 1 FROM stadium",
            Catalogue.reference,
            "not a seed: 'abc'",
        ),
    ],
)
def test_the_altered_value_is_named(own, statement, question, message):
    alter(own, statement)
    with closing(Catalogue(own, a=1.6)) as catalogue, pytest.raises(StoreError) as error:
        question(catalogue)
    assert str(error.value).startswith(f"the catalogue was altered: {message}")
    assert str(error.value).endswith("; 'orbitdb verify' shows what is wrong")


def test_rows_with_altered_texts_are_not_exported(own, tmp_path, cli):
    target = tmp_path / "rows.parquet"
    last = "p = 5 AND word = (SELECT max(word) FROM cycle WHERE p = 5)"
    alter(own, "UPDATE pruned SET rules = '7' WHERE p = 3", f"UPDATE cycle SET symmetry = 'ξ' WHERE {last}")
    for asked, told in (
        (("query", "--status", "geometric", "-c", "code,rules", "--format", "csv"), "rules '7'"),
        (("export", str(target), "--p", "5", "--coordinates"), "was altered: not a symmetry: 'ξ'"),
    ):
        outcome = cli(*asked, "--a", "1.6")
        assert outcome.code == 3
        assert told in outcome.err
        assert outcome.err.endswith("'orbitdb verify' shows what is wrong\n")
    assert not target.exists()


def test_births_of_a_class_that_is_not_a_word_are_refused(tmp_path):
    path = tmp_path / "births.db"
    alter(
        made(path, fill_births(path, [4])),
        "UPDATE change SET a = 1.6, error = 0.01",
        "UPDATE change SET cycle = 0x105f WHERE cycle = (SELECT max(cycle) FROM change)",
        "UPDATE cycle SET id = 0x105f WHERE id = (SELECT max(id) FROM cycle)",
    )
    told = pytest.raises(
        StoreError, match="the catalogue was altered: an invalid word in a class with births: '0137'"
    )
    with closing(Catalogue(path, a=1.6)) as catalogue, told:
        catalogue.counts(p=4)
