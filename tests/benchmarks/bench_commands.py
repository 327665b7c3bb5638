"""Whole-process times of the commands that users wait for: median of several runs, and peak memory.

Run it as ``python tests/benchmarks/bench_commands.py [RUNS]`` with orbitdb installed.
"""

import os
import statistics
import sys
import tempfile
import time
from pathlib import Path

MAIN = [sys.executable, "-P", "-c", "from orbitdb.cli.main import run; run()"]


def run(arguments: list[str], database: Path) -> tuple[float, float]:
    """Return the wall time in seconds and the peak memory in MB of one process."""
    start = time.perf_counter()
    process = os.fork()
    if process == 0:
        quiet = os.open(os.devnull, os.O_WRONLY)
        os.dup2(quiet, 1)
        os.dup2(quiet, 2)
        os.environ["ORBITDB_DB"] = str(database)
        os.execv(MAIN[0], [*MAIN, *arguments])
    _, status, usage = os.wait4(process, 0)
    assert os.waitstatus_to_exitcode(status) == 0, arguments
    return time.perf_counter() - start, usage.ru_maxrss / 1024


def main() -> None:
    runs = int(sys.argv[1]) if len(sys.argv) > 1 else 5
    cases = [
        ("--help", ["--help"], False),
        ("fill --p 11, empty", ["fill", "--p", "11"], True),
        ("fill --p 11, filled", ["fill", "--p", "11"], False),
        ("query --code 1232131", ["query", "--code", "1232131"], False),
        ("table", ["table"], False),
        ("entropy", ["entropy"], False),
        ("lyapunov", ["lyapunov"], False),
        ("fill --p 11 --a 1, second a", ["fill", "--p", "11", "--a", "1"], True),
        ("fill --p 13, empty", ["fill", "--p", "13"], True),
    ]
    print(f"{'command':30} {'median s':>9} {'min s':>7} {'MB':>6}")
    with tempfile.TemporaryDirectory() as folder:
        database = Path(folder) / "orbits.db"
        for name, arguments, fresh in cases:
            times, memory = [], 0.0
            for _ in range(runs):
                if fresh:
                    for file in Path(folder).iterdir():
                        file.unlink()
                if "--a" in arguments:
                    run(["fill", "--p", "11"], database)
                seconds, peak = run(arguments, database)
                times.append(seconds)
                memory = max(memory, peak)
            print(f"{name:30} {statistics.median(times):9.2f} {min(times):7.2f} {memory:6.0f}", flush=True)


if __name__ == "__main__":
    main()
