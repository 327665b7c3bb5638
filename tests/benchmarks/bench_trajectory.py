"""Bounces a second of the trajectory reference on one core: python tests/benchmarks/bench_trajectory.py.

Medians of CPU time, so that other work on the machine disturbs them little.
"""

import statistics
import time

import numpy as np

from orbitdb.billiard.stadium import Stadium
from orbitdb.trajectories.ensemble import Reference, simulate
from orbitdb.trajectories.rays import bounce, random_rays

BOUNCES = 4_000_000
REPEATS = 5


def averages(a: float) -> tuple[float, Reference]:
    """Return bounces a second of `simulate`, the settling of tangent vectors included, and its result."""
    rates = []
    for seed in range(REPEATS):
        start = time.process_time()
        found = simulate(Stadium(a), BOUNCES, seed)
        rates.append(found.bounces / (time.process_time() - start))
    return statistics.median(rates), found


def single_bounces(a: float, n: int = 4096, steps: int = 200) -> float:
    """Return bounces a second when every bounce, on walls too, is made by itself."""
    rates = []
    for seed in range(REPEATS):
        rays = random_rays(Stadium(a), n, np.random.default_rng(seed))
        start = time.process_time()
        for _ in range(steps):
            rays = bounce(rays, a).rays
        rates.append(n * steps / (time.process_time() - start))
    return statistics.median(rates)


def main() -> None:
    """Print a line for each a."""
    print("       a   simulate   one by one   million bounces a second; lambda_d, lambda_c with errors")
    for a in (0.001, 0.1, 1.0, 1.6, 10.0, 1000.0):
        rate, found = averages(a)
        print(
            f"{a:8g} {rate / 1e6:10.1f} {single_bounces(a) / 1e6:12.1f}"
            f"   {found.lambda_d:.5f} +- {found.lambda_d_error:.5f}"
            f"  {found.lambda_c:.5f} +- {found.lambda_c_error:.5f}"
        )


if __name__ == "__main__":
    main()
