"""A fill from nothing: time by stage and period, memory of all its processes, and what more processes gain.

Run it as ``python tests/benchmarks/bench_fill.py [PERIOD] [JOBS ...]`` with orbitdb installed, on Linux.
The stages are processor time a sequence; a machine that does something else meanwhile makes them longer.
With several numbers of jobs it ends with what they gain where nothing is stored.
"""

import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from statistics import median

from orbitdb.filling.blocks import cut_into_blocks
from orbitdb.filling.workers import HERE, Processes, Workers

MAIN = [sys.executable, "-P", "-c", "from orbitdb.cli.main import run; run()"]
SOLVED, REPEATS = 12, 9
STAGES = ("enumerating", "solving", "storing")


def descendants(process: int) -> list[int]:
    """Return a process and all that it has begun."""
    found = [process]
    for one in found:  # grows while it is read
        tasks = Path(f"/proc/{one}/task/{one}/children")
        found += [int(child) for child in tasks.read_text().split()] if tasks.exists() else []
    return found


def memory(processes: list[int]) -> float:
    """Return the memory of processes in MB, what they share counted once."""
    total = 0
    for process in processes:
        try:
            lines = Path(f"/proc/{process}/smaps_rollup").read_text().splitlines()
        except OSError:
            continue
        total += sum(int(line.split()[1]) for line in lines if line.startswith("Pss:"))
    return total / 1024


def fill(database: Path, p: int, jobs: int) -> tuple[float, float]:
    """Return the wall time in seconds and the peak memory in MB of a whole fill."""
    start, peak = time.perf_counter(), 0.0
    command = [*MAIN, "fill", "--p", str(p), "--jobs", str(jobs), "--db", str(database)]
    process = subprocess.Popen(command, stderr=subprocess.DEVNULL)
    while process.poll() is None:
        peak = max(peak, memory(descendants(process.pid)))
        time.sleep(0.1)
    assert process.returncode == 0
    return time.perf_counter() - start, peak


def solving(p: int, workers: Workers) -> float:
    """Return the time in seconds of finding and solving the words of a period."""
    start = time.perf_counter()
    for _ in workers.solved(cut_into_blocks(1.6, "newton", p, jobs=workers.jobs)):
        pass
    return time.perf_counter() - start


def gain(p: int, count: int) -> str:
    """Compare one process with several that are there already, by turns: the machine may change its pace."""
    with Processes(count) as workers:
        solving(p, workers)
        pairs = [(solving(p, HERE), solving(p, workers)) for _ in range(REPEATS)]
    one, several = (median(times) for times in zip(*pairs, strict=True))
    ratio = median(alone / together for alone, together in pairs)
    return f"{one:.2f} s by one process, {several:.2f} s by {count}, {ratio:.2f} times"


def main() -> None:
    p, *jobs = [int(text) for text in sys.argv[1:]] or [13]
    jobs = jobs or sorted({1, len(os.sched_getaffinity(0))})
    for count in jobs:
        with tempfile.TemporaryDirectory() as folder:
            database = Path(folder) / "orbits.db"
            seconds, peak = fill(database, p, count)
            size = database.stat().st_size / 1e6
            info = [*MAIN, "info", "--json", "--db", str(database)]
            rows = json.loads(subprocess.run(info, capture_output=True, text=True, check=True).stdout)
        print(f"fill --p {p} --jobs {count}: {seconds:.1f} s, {peak:.0f} MB of memory, {size:.0f} MB of disk")
        print(
            f"{'p':>4} {'sequences':>10} {'s':>7} "
            + " ".join(f"{name + ' us':>14}" for name in (*STAGES, "all"))
        )
        for row in rows:
            if row["stored"] < 10_000:
                continue
            each = [1e6 * row[name] / row["stored"] for name in STAGES]
            costs = " ".join(f"{cost:14.2f}" for cost in (*each, sum(each)))
            print(f"{row['p']:4} {row['stored']:10} {row['seconds']:7.1f} {costs}", flush=True)
    for count in (count for count in jobs if count > 1):
        for solved in sorted({min(p, SOLVED), p}):
            print(f"solving p = {solved}, without storing: {gain(solved, count)}", flush=True)


if __name__ == "__main__":
    main()
