"""The counts of the paper's Table 1 at any a: from a fill, a sweep, or births."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import sqlalchemy as sa
from numpy.typing import NDArray

from orbitdb.catalogue.gaps import written_periods
from orbitdb.numerals import exact
from orbitdb.store.asking.selection import Selection
from orbitdb.store.reading.fills import Fill
from orbitdb.store.reading.lives import birth_fills, counts_at
from orbitdb.store.reading.sweeps import sweeps

if TYPE_CHECKING:
    from orbitdb.orbits.sums import Tally

_COUNTS = ("n_t", "n_c", "classes", "boundary", "unresolved")
"""The columns of a fill that a tally has, in its order."""


@dataclass(frozen=True)
class Counted:
    """Counts of whole periods at one a.

    Attributes
    ----------
    a : float
        The stadium.
    known : dict of int to Tally
        By period; those that are not chosen are there where sums over divisors need them.
    chosen : tuple of int
        The chosen periods among them.
    from_births : tuple of int
        The chosen periods that births have counted, and no fill or sweep.
    from_sweeps : tuple of int
        The chosen periods that a sweep has counted, and no fill.
    """

    a: float
    known: Mapping[int, "Tally"]
    chosen: tuple[int, ...]
    from_births: tuple[int, ...]
    from_sweeps: tuple[int, ...] = ()

    @property
    def without_rows(self) -> tuple[int, ...]:
        """The chosen periods that no fill has counted."""
        return self.from_sweeps + self.from_births

    def cycles(self) -> NDArray[np.int64]:
        """Return how many words of each period 0 .. the highest chosen one are orbits; 0 of others."""
        found = np.zeros(max(self.chosen) + 1, dtype=np.int64)
        for p in self.chosen:
            found[p] = self.known[p].n_c
        return found

    def describe(self) -> str | None:
        """Say in one line which periods are counted from what else than a fill; None if there are none."""
        sources = {"from a sweep, their rows are not stored": self.from_sweeps,
                   "from births, with no fill": self.from_births}  # fmt: skip
        told = [
            f"{written_periods(periods)} at a = {exact(self.a)}: {source}"
            for source, periods in sources.items()
            if periods
        ]
        return "; ".join(told) or None


def count(connection: sa.Connection, fills: Sequence[Fill], selection: Selection) -> Counted:
    """Return the counts at one a, given what is filled there (`Catalogue.counts`)."""
    from orbitdb.orbits.sums import Tally

    known = {fill.p: Tally(*(getattr(fill, name) or 0 for name in _COUNTS)) for fill in fills if fill.whole}
    swept = {
        each.p: each.tally for each in sweeps(connection, selection.a) if each.whole and each.p not in known
    }
    known |= swept
    born = [each.p for each in birth_fills(connection) if each.whole and each.p not in known]
    wanted = [p for p in born if selection.includes(p)]
    chosen = sorted(p for p in (*known, *wanted) if selection.includes(p))
    needed = {p for p in born if any(multiple % p == 0 for multiple in chosen)}
    known.update((p, counts_at(connection, selection.a, p)) for p in needed)
    return Counted(selection.a, dict(sorted(known.items())), tuple(chosen), tuple(wanted),
                   tuple(p for p in swept if selection.includes(p)))  # fmt: skip
