"""Whether a fill, a sweep, and sums over the rows of the fill agree.

    python tests/benchmarks/bench_sums.py 13

At three a, for all periods up to the one named: counts must be equal; of sums and averages by sum rules the
largest differences are shown, relative and absolute. So are those of sums over subsets; the bounds
of the last are numbers that are stored.
"""

import sys
import tempfile
from contextlib import closing
from pathlib import Path

import numpy as np

from orbitdb.averages.period_sums import PeriodSums
from orbitdb.catalogue.catalogue import Catalogue
from orbitdb.catalogue.whole_periods import read_whole, sum_rules_of
from orbitdb.filling.periods import fill_periods
from orbitdb.filling.sweeps import sweep_periods
from orbitdb.store.asking.criteria import choose
from orbitdb.store.asking.selection import Selection
from orbitdb.store.file.migrate import migrate

SUBSETS = (
    {"time_reversal": "self"},
    {"time_reversal": "pair"},
    {"symmetry": "x,T,xT"},
    {"contains": "13"},
    {"contains": "0131313131"},
    {"length": (None, 20.0)},
    {"lambda_d": (0.8, 1.0)},
    {"margin": (0.05, None)},
    {"time_reversal": "pair", "contains": "31", "length": (8, 30), "lambda_c": (None, 0.45)},
)


def compared(path: Path, a: float, highest: int) -> tuple[float, float]:
    """Sweep and fill; return by how much sums differ, and lambda per leg."""
    periods = range(2, highest + 1)
    migrate(path)
    for _ in sweep_periods(path, a, periods):
        pass
    with closing(Catalogue(path)) as catalogue:
        swept = {each.p: each for each in catalogue.sweeps(a)}
        without_rows = sum_rules_of(read_whole(catalogue, Selection(a), swept=True))
    for _ in fill_periods(path, a, periods):
        pass
    with closing(Catalogue(path)) as catalogue:
        fills = {fill.p: fill for fill in catalogue.fills(a)}
        rows = catalogue.classes(a=a, status="orbit").rows().by_period()
        with_rows = sum_rules_of(read_whole(catalogue, Selection(a)))
    worst = 0.0
    for p in periods:
        for name in ("n_c", "classes", "boundary", "unresolved"):
            assert getattr(swept[p].tally, name) == getattr(fills[p], name), (a, p, name)
        assert swept[p].tally.words == fills[p].n_t, (a, p)
        worst = max(worst, np.abs(swept[p].sums.sums / PeriodSums.of(rows[p], p).sums - 1).max())
    return worst, float(np.nanmax(np.abs(without_rows.lambda_l - with_rows.lambda_l)))


def compared_subsets(path: Path, a: float, highest: int) -> float:
    """Sweep subsets, and return by how much sums differ from those over stored rows of the same orbits."""
    worst = 0.0
    with closing(Catalogue(path)) as catalogue:
        some = catalogue.classes(a=a, status="orbit")
        low, high = sorted(some.length[[len(some) // 4, len(some) // 2]].tolist())
        for criteria in (*SUBSETS, {"length": (low, high)}):
            chosen = choose(a, p=range(2, highest + 1), **criteria)
            for _ in sweep_periods(path, a, range(2, highest + 1), selection=chosen):
                pass
            rows = catalogue.classes(chosen)
            for each in catalogue.sweeps(a, chosen):
                here = rows.p == each.p
                counts = int(rows.chosen[here].sum()), int(here.sum())
                assert (each.tally.n_c, each.tally.classes) == counts, (a, each.p, criteria)
                if here.any():
                    expected = PeriodSums.of(rows.rows().rows(here), each.p)
                    worst = max(worst, np.abs(each.sums.sums / expected.sums - 1).max())
    return worst


def main() -> None:
    """Compare at three a."""
    for a in (0.5, 1.0, 1.6):
        with tempfile.TemporaryDirectory() as folder:
            path, highest = Path(folder) / "orbits.db", int(sys.argv[1])
            sums, averages = compared(path, a, highest)
            of_subsets = compared_subsets(path, a, highest)
        print(
            f"a = {a:3}: counts are equal, sums to {sums:.1e}, averages by sum rules to {averages:.1e}, "
            f"sums over subsets to {of_subsets:.1e}",
            flush=True,
        )


if __name__ == "__main__":
    main()
