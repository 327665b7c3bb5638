"""Whether a fill, a sweep, and sums over the rows of the fill agree.

    python tests/benchmarks/bench_sums.py 13

At three a, for all periods up to the one named: counts must be equal; of sums and averages by sum rules the
largest differences are shown, relative and absolute.
"""

import sys
import tempfile
from contextlib import closing
from pathlib import Path

import numpy as np

from orbitdb.averages.period_sums import PeriodSums
from orbitdb.filling.periods import fill_periods
from orbitdb.filling.sweeps import sweep_periods
from orbitdb.store.asking.selection import Selection
from orbitdb.store.file.migrate import migrate
from orbitdb.store.reading.catalogue import Catalogue
from orbitdb.store.reading.leg_terms import sum_rules_of
from orbitdb.store.reading.whole_periods import read_whole


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


def main() -> None:
    """Compare at three a."""
    for a in (0.5, 1.0, 1.6):
        with tempfile.TemporaryDirectory() as folder:
            sums, averages = compared(Path(folder) / "orbits.db", a, int(sys.argv[1]))
        print(
            f"a = {a:3}: counts are equal, sums to {sums:.1e}, averages by sum rules to {averages:.1e}",
            flush=True,
        )


if __name__ == "__main__":
    main()
