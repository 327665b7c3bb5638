"""Width of the entropy bounds against time and memory.

    python tests/benchmarks/bench_bounds.py [SECONDS [A ...]]

Each a in a process of its own, so that its peak memory is its own. Of every level: the CPU time since the
beginning, all levels before it included; other work on the machine disturbs it little. SECONDS are of CPU
time, too: a level that would not fit into them is not begun.
"""

import resource
import subprocess
import sys
import time

from orbitdb.billiard.stadium import Stadium
from orbitdb.cli.render import number
from orbitdb.entropy.bounds import levels

LENGTHS = (1.6, 0.5, 1.0, 3.0, 10.0, 0.2, 0.05)
SECONDS = 10.0
_GROWTH = 1.8


def run(a: float, seconds: float) -> None:
    """Print a line for each level at one a."""
    began = before = time.process_time()
    for found in levels(Stadium(a)):
        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
        print(
            f"{a:6g} {found.window:6d} {number('lower', found.lower)} {number('upper', found.upper)}"
            f" {found.upper - found.lower:9.1e} {found.windows:9d} {found.undecided:9d}"
            f" {time.process_time() - began:8.2f} {peak:8.0f}",
            flush=True,
        )
        took, before = time.process_time() - before, time.process_time()
        if before - began + _GROWTH * took > seconds:
            break


def main() -> None:
    """Print a table for each a."""
    seconds = float(sys.argv[1]) if sys.argv[1:] else SECONDS
    lengths = [float(text) for text in sys.argv[2:]] or LENGTHS
    if len(lengths) == 1:
        run(lengths[0], seconds)
        return
    print("     a window      lower      upper     width   windows undecided  seconds       MB", flush=True)
    for a in lengths:
        subprocess.run([sys.executable, __file__, str(seconds), str(a)], check=True)


if __name__ == "__main__":
    main()
