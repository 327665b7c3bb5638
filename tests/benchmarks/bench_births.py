"""Births from nothing: time of the whole process, what they say against fills and 50 digits, and all deaths.

Run it as ``python tests/benchmarks/bench_births.py [PERIOD]`` with orbitdb installed; 13 takes a minute
or two. To period 11 the counts are compared with those of solving all classes, at joints and 20 other a,
and 300 births with their values to 50 digits.
"""

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))

from births50 import birth_error

from orbitdb.billiard.stadium import Stadium
from orbitdb.catalogue.catalogue import Catalogue
from orbitdb.orbits.newton import solve
from orbitdb.orbits.tally import Tally
from orbitdb.symbols.counting import count_admissible
from orbitdb.symbols.words import from_strings

MAIN = [sys.executable, "-P", "-c", "from orbitdb.cli.main import run; run()"]
COMPARED = 11
CHECKED = 300
PLACES = (0.5, 1.0, 2.0, 2.5, *np.geomspace(0.03, 16, 20).tolist())


def run(*arguments: str) -> tuple[float, float]:
    """Run a command; return wall time and processor time in seconds."""
    start, before = time.perf_counter(), os.times()
    subprocess.run([*MAIN, *arguments], check=True, capture_output=True)
    after = os.times()
    used = after.children_user + after.children_system - before.children_user - before.children_system
    return time.perf_counter() - start, used


def solved(catalogue: Catalogue, p: int, a: float) -> Tally:
    """Return the counts of a period by solving all its classes."""
    lives = {life.word: life.class_size for life in catalogue.births(p)}
    status = solve(from_strings(list(lives)), Stadium(a)).status
    size = np.array(list(lives.values()))
    words = {name: int(size[status == name].sum()) for name in ("orbit", "boundary", "unresolved")}
    classes = int((status == "orbit").sum())
    return Tally(count_admissible(p), words["orbit"], classes, words["boundary"], words["unresolved"])


def against_50_digits(catalogue: Catalogue, periods: range) -> tuple[float, int]:
    """Return the largest relative error of some births, and how many are farther off than their bounds."""
    with catalogue.reading() as connection:
        rows = connection.exec_driver_sql(
            "SELECT word, bounce, joint, a, error FROM change JOIN cycle ON id = cycle"
            f" WHERE kind = 'born' AND a > 0 AND p BETWEEN {periods[0]} AND {periods[-1]} ORDER BY cycle"
        ).all()
    chosen = np.random.default_rng(1).choice(len(rows), CHECKED, replace=False)
    off = [birth_error(*rows[i][:4]) for i in chosen]
    relative = max(float(each) / rows[i].a for each, i in zip(off, chosen, strict=True))
    return relative, sum(bool(each > rows[i].error) for each, i in zip(off, chosen, strict=True))


def main() -> None:
    highest = int(sys.argv[1]) if len(sys.argv) > 1 else COMPARED
    with tempfile.TemporaryDirectory() as folder:
        database = Path(folder) / "orbits.db"
        for p in sorted({min(COMPARED, highest), highest}):
            wall, used = run("births", "--p", str(p), "--db", str(database))
            print(f"births to p = {p}: {wall:.1f} s, {used:.1f} s of processors", flush=True)
        times = [run("table", "--a", "0.77", "--db", str(database)) for _ in range(3)]
        wall, used = min(times)
        print(f"table --a 0.77: {wall:.2f} s, {used:.2f} s of processors")
        catalogue = Catalogue(database)
        for each in catalogue.birth_fills():
            ends = sorted(life.dies for life in catalogue.births(each.p) if life.dies is not None)
            print(f"p = {each.p}: {each.births} births, {each.deaths} classes die, at {ends}")
        worst, over = against_50_digits(catalogue, range(5, min(COMPARED, highest) + 1))
        print(f"{CHECKED} births to 50 digits: {over} beyond their bounds, worst relative error {worst:.1e}")
        different = 0
        for a in PLACES:
            known = catalogue.counts(a=a).known
            for p in range(2, min(COMPARED, highest) + 1):
                different += known[p] != solved(catalogue, p, a)
        print(f"counts at {len(PLACES)} values of a: {different} differ from those of solving")


if __name__ == "__main__":
    main()
