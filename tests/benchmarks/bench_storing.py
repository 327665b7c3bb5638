"""How near storing is to SQLite: rows of one period inserted again by SQLite's own driver, and nothing else.

Run it as ``python tests/benchmarks/bench_storing.py DATABASE [PERIOD]``; it prints processor time a sequence
for each table, with the settings of a fill (WAL, synchronous = NORMAL, 64 rows a statement, one transaction a
block), and what the fill of DATABASE took to store them.
"""

import sqlite3
import sys
import tempfile
import time
from bisect import bisect_right
from contextlib import closing
from itertools import chain, islice
from pathlib import Path

ROWS_A_STATEMENT = 64
BLOCK = 1 << 15
TABLES = ("cycle", "sequence", "orbit")
INTO = dict(zip(TABLES, TABLES, strict=True)) | {"sequence": "sequence (p, word, cycle, element)"}
NULL = float("nan")


def read(database: Path, p: int) -> tuple[dict[str, list[tuple]], list[str], float]:
    """Return the rows of a period by table, in order, what makes the tables, and the time of the fill."""
    low, high = 1 << 3 * p, (1 << 3 * p + 1) - 1
    queries = {
        "cycle": "SELECT * FROM cycle WHERE id BETWEEN :low AND :high ORDER BY id",
        "sequence": "SELECT p, word, cycle, element FROM sequence WHERE p = :p ORDER BY word",
        "orbit": "SELECT * FROM orbit WHERE stadium = 1 AND cycle BETWEEN :low AND :high ORDER BY cycle",
    }
    values = {"p": p, "low": low, "high": high}
    with closing(sqlite3.connect(f"file:{database}?mode=ro", uri=True)) as source:
        rows = {
            name: [tuple(map(as_bound, row)) for row in source.execute(query, values)]
            for name, query in queries.items()
        }
        made = [
            source.execute("SELECT sql FROM sqlite_master WHERE name = ?", (name,)).fetchone()[0]
            for name in TABLES
        ]
        (storing,) = source.execute("SELECT storing FROM fill WHERE stadium = 1 AND p = ?", (p,)).fetchone()
    return rows, made, storing


def as_bound(value: object) -> object:
    """Return a value as a fill gives it to the driver, which looks for adapters of None and bytes."""
    if value is None:
        return NULL
    return bytearray(value) if isinstance(value, bytes) else value


def insert(target: sqlite3.Connection, table: str, rows: list[tuple]) -> None:
    """Insert rows, many a statement."""
    width = len(rows[0]) if rows else 1
    values = chain.from_iterable(rows)
    row = f"({', '.join('?' * width)})"
    while several := tuple(islice(values, ROWS_A_STATEMENT * width)):
        places = ", ".join([row] * (len(several) // width))
        target.execute(f"INSERT OR IGNORE INTO {table} VALUES {places}", several)


def store(rows: dict[str, list[tuple]], made: list[str], path: Path) -> dict[str, float]:
    """Insert all rows block by block as a fill does; return the processor time in seconds by table."""
    numbers = {name: [row[place] for row in rows[name]] for name, place in (("cycle", 0), ("orbit", 1))}
    done, spent = dict.fromkeys(numbers, 0), dict.fromkeys((*TABLES, "commit"), 0.0)
    with closing(sqlite3.connect(path, isolation_level=None)) as target:
        for setting in ("journal_mode = WAL", "synchronous = NORMAL", "foreign_keys = OFF"):
            target.execute(f"PRAGMA {setting}")
        for table in made:
            target.execute(table)
        for start in range(0, len(rows["sequence"]), BLOCK):
            block = {"sequence": rows["sequence"][start : start + BLOCK]}
            last = int("1" + block["sequence"][-1][1], 8)
            for name, known in numbers.items():
                end = bisect_right(known, last)
                block[name], done[name] = rows[name][done[name] : end], end
            target.execute("BEGIN IMMEDIATE")
            for name in TABLES:
                clock = time.thread_time()
                insert(target, INTO[name], block[name])
                spent[name] += time.thread_time() - clock
            clock = time.thread_time()
            target.execute("COMMIT")
            spent["commit"] += time.thread_time() - clock
    return spent


def main() -> None:
    database, *more = sys.argv[1:]
    p = int(more[0]) if more else 13
    rows, made, storing = read(Path(database).resolve(), p)
    with tempfile.TemporaryDirectory() as folder:
        spent = store(rows, made, Path(folder) / "again.db")
    each = {
        name: 1e6 * seconds / len(rows["sequence"]) for name, seconds in (spent | {"fill": storing}).items()
    }
    told = ", ".join(f"{name} {each[name]:.2f}" for name in spent)
    alone = sum(each[name] for name in spent)
    print(f"p = {p}, us a sequence: {told}; all {alone:.2f}, a fill {each['fill']:.2f}")


if __name__ == "__main__":
    main()
