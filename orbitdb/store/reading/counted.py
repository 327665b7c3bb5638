"""The counts of the paper's Table 1 at any a: from a fill where there is one, else from births."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import sqlalchemy as sa

from orbitdb.store.asking.selection import Selection
from orbitdb.store.reading.fills import Fill, exact, written_periods
from orbitdb.store.reading.lives import Counts, birth_fills, counts_at


@dataclass(frozen=True)
class Counted:
    """Counts of whole periods at one a.

    Attributes
    ----------
    a : float
        The stadium.
    known : dict of int to Counts
        By period; those that are not chosen are there where sums over divisors need them.
    chosen : tuple of int
        The chosen periods among them.
    from_births : tuple of int
        The chosen periods that no fill has counted.
    """

    a: float
    known: Mapping[int, Counts]
    chosen: tuple[int, ...]
    from_births: tuple[int, ...]

    def describe(self) -> str | None:
        """Say in one line which periods are counted from births; None if there are none."""
        if not self.from_births:
            return None
        return f"{self.from_births_written()} at a = {exact(self.a)}: from births, with no fill"

    def from_births_written(self) -> str:
        """Write the periods that are counted from births, such as "periods 2-8"."""
        return written_periods(self.from_births)


def count(connection: sa.Connection, fills: Sequence[Fill], selection: Selection) -> Counted:
    """Return the counts at one a, given what is filled there (`Catalogue.counts`)."""
    known = {
        fill.p: Counts(fill.p, fill.n_t or 0, fill.n_c or 0, fill.classes or 0, fill.boundary or 0,
                       fill.unresolved or 0)
        for fill in fills
        if fill.whole
    }  # fmt: skip
    born = [each.p for each in birth_fills(connection) if each.whole and each.p not in known]
    wanted = [p for p in born if selection.includes(p)]
    chosen = sorted(p for p in (*known, *wanted) if selection.includes(p))
    needed = {p for p in born if any(multiple % p == 0 for multiple in chosen)}
    known.update((p, counts_at(connection, selection.a, p)) for p in needed)
    return Counted(selection.a, dict(sorted(known.items())), tuple(chosen), tuple(wanted))
