"""What a sweep takes: in one process, in two, and on a dask cluster of one worker and of two.

    python tests/benchmarks/bench_sweep.py 16

Seconds as they pass, and of processors: of the process that stores, and of all blocks. All are run by turns,
and again in the opposite order, and the ratios are of the shorter times, so that what else the machine does
tells on all of them. Then what a block costs the process that stores, and from both how long a sweep of
p = 20 would take with more workers.
"""

import math
import resource
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import ExitStack, closing, contextmanager
from pathlib import Path

from orbitdb.catalogue.catalogue import Catalogue
from orbitdb.filling import sweeps, swept_blocks
from orbitdb.filling.cluster import Cluster
from orbitdb.filling.sweeps import sweep_periods
from orbitdb.filling.workers import HERE, Processes, Workers
from orbitdb.store.file.migrate import migrate
from orbitdb.symbols.counting import count_admissible

A, _TOP = 1.6, 20
KINDS = (("here", 1), ("processes", 1), ("processes", 2), ("dask", 1), ("dask", 2))


@contextmanager
def solvers(kind: str, count: int) -> Iterator[Workers]:
    """Give what solves."""
    with ExitStack() as until:
        if kind == "here":
            yield HERE
        elif kind == "processes":
            processes = until.enter_context(Processes(count))
            processes.start()
            yield processes
        else:
            from distributed import LocalCluster

            cluster = LocalCluster(n_workers=count, threads_per_worker=1, dashboard_address="127.0.0.1:0")
            until.enter_context(cluster)
            yield until.enter_context(Cluster(cluster.scheduler_address))


def swept(highest: int, workers: Workers, path: Path) -> tuple[float, float, float, int]:
    """Sweep all periods; return seconds as they pass, of this process and of the blocks, and their number."""
    migrate(path)
    clock, own = time.monotonic(), time.process_time()
    for _ in sweep_periods(path, A, range(2, highest + 1), workers):
        pass
    clock, own = time.monotonic() - clock, time.process_time() - own
    with closing(Catalogue(path)) as catalogue:
        found = catalogue.sweeps(A)
    return clock, own, sum(each.processor for each in found), sum(each.blocks for each in found)


def main() -> None:
    """Measure and estimate."""
    highest = int(sys.argv[1])
    sequences = sum(count_admissible(p) for p in range(2, highest + 1))
    print("solved by        seconds  of this process  of the blocks  blocks  MB here")
    best: dict[tuple[str, int], float] = {}
    for kind, count in (*KINDS, *reversed(KINDS)):
        with tempfile.TemporaryDirectory() as folder, solvers(kind, count) as workers:
            clock, own, blocks, number = swept(highest, workers, Path(folder) / "orbits.db")
        memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1000
        print(
            f"{kind:9} {count} {clock:12.1f} {own:16.1f} {blocks:14.1f} {number:7d} {memory:8.0f}", flush=True
        )
        best[kind, count] = min(clock, best.get((kind, count), math.inf))
    for kind in ("processes", "dask"):
        print(f"two workers against one, {kind}: {best[kind, 1] / best[kind, 2]:.2f} times as fast")
    _estimate(blocks / sequences * count_admissible(_TOP))


def _estimate(work: float) -> None:
    """Say how long a sweep of the highest period would take, of which the blocks take so many seconds."""
    begun = time.process_time()
    count = sum(1 for _ in swept_blocks.cut_into_swept_blocks(A, _TOP))
    cutting = (time.process_time() - begun) / count
    swept_blocks._LEAST, sweeps.SMALL = 8, 1
    with tempfile.TemporaryDirectory() as folder, solvers("dask", 2) as workers:
        own, number = swept(10, workers, Path(folder) / "orbits.db")[1::2]
    each = own / number + cutting
    print(f"p = {_TOP}: {count} blocks of {work / count:.2f} s; {1000 * each:.1f} ms of each here")
    for size in (2, 64, 1024):
        print(f"{size:5d} workers: {max(math.ceil(count / size) * work / count, count * each):6.0f} s")


if __name__ == "__main__":
    main()
