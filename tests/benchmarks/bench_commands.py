"""Times of the commands that users wait for, the whole process: medians of several runs, and peak memory.

Run it as ``python tests/benchmarks/bench_commands.py [RUNS] [WORDS]`` with orbitdb installed, not editable:
the finder of an editable install takes 20 ms a process. WORDS chooses the commands that have them in their
names. Beside the seconds that pass stand those of the processors, which other programs disturb less, and how
many of these go into imports; the first lines say what Python and the libraries alone take on this machine.
"""

import os
import statistics
import sys
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

MAIN = "from orbitdb.cli.main import run; run()"

TIMED = """
import _frozen_importlib as machinery, atexit, os, sys, time
load, spent, depth = machinery._find_and_load, 0.0, 0
def timed(*names):
    global spent, depth
    start, depth = time.process_time(), depth + 1
    try:
        return load(*names)
    finally:
        depth -= 1
        spent += 0.0 if depth else time.process_time() - start
machinery._find_and_load = timed
told = int(sys.argv.pop(1))
atexit.register(lambda: os.write(told, str(spent).encode()))
"""
"""Tells through a pipe, at the end, how long imports took."""

LIBRARIES = ["pass", "import typer", "import numpy", "import sqlalchemy", "import numpy, sqlalchemy"]

CASES = [
    ("--help", ["--help"], ""),
    ("query --code 1232131", ["query", "--code", "1232131"], "fill --p 11"),
    ("query --code 1232131, births only", ["query", "--code", "1232131"], "births --p 11"),
    ("query --p 5", ["query", "--p", "5"], "fill --p 11"),
    ("info", ["info"], "fill --p 11"),
    ("table", ["table"], "fill --p 11"),
    ("table --a 0.77, births only", ["table", "--a", "0.77"], "births --p 11"),
    ("entropy", ["entropy"], "fill --p 11"),
    ("lyapunov", ["lyapunov"], "fill --p 11"),
    ("fill --p 11, empty", ["fill", "--p", "11"], ""),
    ("fill --p 11, filled", ["fill", "--p", "11"], "fill --p 11"),
    ("fill --p 11 --a 1, second a", ["fill", "--p", "11", "--a", "1"], "fill --p 11"),
    ("fill --p 13, empty", ["fill", "--p", "13"], ""),
    ("births --p 11, empty", ["births", "--p", "11"], ""),
]
"""Commands, and the one that has made the catalogue before; each run has a catalogue of its own."""


class Run(NamedTuple):
    """What one process took: seconds as they pass, of processors, of these for imports, and MB."""

    wall: float
    processor: float
    imports: float
    peak: float


def run(code: str, arguments: list[str], database: Path) -> Run:
    """Run Python on a piece of code."""
    start = time.perf_counter()
    reading, writing = os.pipe()
    process = os.fork()
    if process == 0:
        quiet = os.open(os.devnull, os.O_WRONLY)
        os.dup2(quiet, 1)
        os.dup2(quiet, 2)
        os.set_inheritable(writing, True)
        os.environ["ORBITDB_DB"] = str(database)
        os.execv(sys.executable, [sys.executable, "-P", "-c", TIMED + code, str(writing), *arguments])
    os.close(writing)
    _, status, usage = os.wait4(process, 0)
    wall = time.perf_counter() - start
    assert os.waitstatus_to_exitcode(status) == 0, arguments
    with open(reading, "rb") as pipe:
        imports = float(pipe.read())
    return Run(wall, usage.ru_utime + usage.ru_stime, imports, usage.ru_maxrss / 1024)


def measure(runs: int, name: str, code: str, arguments: list[str], before: bytes) -> None:
    """Run a command several times, each on a copy of a catalogue, and print a line."""
    taken = []
    for _ in range(runs):
        with tempfile.TemporaryDirectory() as folder:
            database = Path(folder) / "orbits.db"
            if before:
                database.write_bytes(before)
            taken.append(run(code, arguments, database))
    middle = Run(*map(statistics.median, zip(*taken, strict=True)))
    least = min(each.processor for each in taken)
    share = middle.imports / middle.processor
    told = f"{middle.wall:7.2f} {middle.processor:9.3f} {least:7.3f} {share:8.0%} {middle.peak:5.0f}"
    print(f"{name:36} {told}", flush=True)


def prepared(command: str) -> bytes:
    """Return the catalogue that a command makes."""
    if not command:
        return b""
    with tempfile.TemporaryDirectory() as folder:
        database = Path(folder) / "orbits.db"
        run(MAIN, command.split(), database)
        return database.read_bytes()


def main() -> None:
    runs = int(sys.argv[1]) if len(sys.argv) > 1 else 5
    cases = [case for case in CASES if all(word in case[0] for word in sys.argv[2:])]
    made = {command: prepared(command) for command in {before for _, _, before in cases}}
    print(f"{'':36} {'wall s':>7} {'process s':>9} {'least':>7} {'imports':>8} {'MB':>5}")
    for code in LIBRARIES:
        measure(runs, code.replace("pass", "python"), code, [], b"")
    for name, arguments, before in cases:
        measure(runs, name, MAIN, arguments, made[before])


if __name__ == "__main__":
    main()
