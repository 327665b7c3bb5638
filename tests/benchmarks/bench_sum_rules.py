"""Compare sum rules with trajectories: deviations, error estimates, and how often the estimates hold.

Run it as ``python tests/benchmarks/bench_sum_rules.py [PERIOD [A ...]]`` with orbitdb installed. By default,
the period is 13 and there are eight half lengths, which takes about a minute. No catalogue is needed.
"""

import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))

from solutions import class_rows, lyapunov, sum_rules_to

from orbitdb.averages.exact_means import exact_means
from orbitdb.averages.sum_rules import SumRules
from orbitdb.billiard.stadium import Stadium
from orbitdb.trajectories.ensemble import Reference
from orbitdb.trajectories.legwise import simulate_legs

PERIOD = 13
HALF_LENGTHS = (0.1, 0.2, 0.5, 1.0, 1.6, 3.0, 6.0, 12.0)
FIRST = 7
BOUNCES = 20_000_000


def report(a: float, highest: int) -> tuple[SumRules, Reference]:
    """Print the line for a half length."""
    means = exact_means(a)
    clock = time.process_time()
    found = sum_rules_to(a, highest)
    seconds = time.process_time() - clock
    clock = time.process_time()
    known = simulate_legs(Stadium(a), BOUNCES, means.growth)
    simulated = time.process_time() - clock
    rows = class_rows(a, highest)
    zeta = lyapunov(rows, highest).lambda_d_zeta[-1] / known.lambda_d - 1
    low, high = (bound * Stadium(a).legs_per_bounce for bound in means.bounds)
    print(
        f"{a:6g} {len(rows):8} {found.level[-1]:5} {known.lambda_d:11.7f} {known.lambda_d_error:8.1e}"
        f" {low:9.6f} {high:9.6f} {found.lambda_d_sum_rule[-1]:10.6f}"
        f" {found.lambda_d_sum_rule[-1] / known.lambda_d - 1:+9.1e}"
        f" {found.lambda_d_sum_rule_error[-1] / known.lambda_d:8.1e} {zeta:+8.1e}"
        f" {seconds:6.2f} {simulated:6.2f}",
        flush=True,
    )
    return found, known


def main() -> None:
    """Print the deviations, and how often the estimates hold."""
    highest = int(sys.argv[1]) if len(sys.argv) > 1 else PERIOD
    half_lengths = [float(text) for text in sys.argv[2:]] or list(HALF_LENGTHS)
    print(f"lambda_d from all orbits to p = {highest}; CPU seconds of orbits and sum rules, of trajectories")
    print(
        "     a  classes level  trajectory    error     below     above  sum rules deviation estimate"
        "     zeta  rules  traj."
    )
    found = {a: report(a, highest) for a in half_lengths}
    print(f"\n|deviation| / estimate at p = {FIRST} .. {highest}: it holds where this is below 1")
    held = all_of_them = 0
    for a, (averages, known) in found.items():
        later = averages.p >= FIRST
        deviation = np.abs(averages.lambda_d_sum_rule - known.lambda_d)[later]
        shares = deviation / averages.lambda_d_sum_rule_error[later]
        held, all_of_them = held + int((shares < 1).sum()), all_of_them + len(shares)
        print(f"{a:6g} ", " ".join(f"{share:5.2f}" for share in shares))
    print(f"the estimate holds {held} times out of {all_of_them}")


if __name__ == "__main__":
    main()
