"""The counts and sums of sweeps: all orbits of a period or a subset, without stored rows."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import sqlalchemy as sa

from orbitdb.errors import InputError
from orbitdb.extras import Record
from orbitdb.store.asking.selection import Selection
from orbitdb.store.asking.sweepable import selection_of
from orbitdb.store.file.schema import DONE, SWEPT
from orbitdb.store.file.tables import stadium, sweep
from orbitdb.store.reading.soundness import unsound
from orbitdb.symbols.enumeration import MAX_PERIOD

if TYPE_CHECKING:  # imported only if there are sums
    from orbitdb.averages.fixed_points import PeriodSums
    from orbitdb.averages.tilt_moments import TiltMoments
    from orbitdb.orbits.sums import Tally


@dataclass(frozen=True)
class Sweep(Record):
    """Progress and results of the sweep of a period at one a.

    Attributes
    ----------
    p : int
        Period.
    state : str
        ``filling`` or ``done``.
    tally : Tally
        The counts so far. For a subset, `words` counts all words, and `boundary` and `unresolved` ignore
        ranges, which apply to orbits.
    blocks : int
        Number of blocks so far.
    seconds, processor : float
        Elapsed time, and processor time.
    sums : PeriodSums or None
        The sums over all or the chosen orbits; None before it is done.
    moments : mapping of int to TiltMoments
        Moments for sum rules by level (`orbitdb.averages.sum_rules`); empty before it is done, and for a
        subset.
    selection : str
        The canonical text of the subset (`orbitdb.store.asking.sweepable`); empty for all orbits.
    """

    p: int
    state: str
    tally: "Tally"
    blocks: int
    seconds: float
    processor: float
    sums: "PeriodSums | None" = field(repr=False)
    moments: "Mapping[int, TiltMoments]" = field(repr=False)
    selection: str = ""

    @property
    def whole(self) -> bool:
        """Whether the whole period is swept; otherwise a sweep is running or was stopped."""
        return self.state == DONE

    def row(self) -> dict[str, Any]:
        """Return the counts by the names that they have in JSON."""
        counts = self.tally
        return {
            "p": self.p,
            "N_t": counts.words,
            "N_c": counts.n_c,
            "classes": counts.classes,
            "boundary": counts.boundary,
            "unresolved": counts.unresolved,
            "seconds": self.seconds,
            "processor_seconds": self.processor,
            "selection": self.selection,
        }


def sweeps(connection: sa.Connection, a: float, selection: str = "") -> list[Sweep]:
    """Return the sweeps at one a by period, of all orbits or of a subset given by its canonical text."""
    query = sa.select(sweep).join(stadium).where(stadium.c.a == a, sweep.c.selection == selection)
    return [_as_sweep(row) for row in connection.execute(query.order_by(sweep.c.p))]


def swept_subsets(connection: sa.Connection, a: float) -> list[Selection]:
    """Return the subsets, other than all orbits, that are swept at one a, whole or in part."""
    texts = sa.select(sweep.c.selection).distinct().join(stadium).order_by(sweep.c.selection)
    found = []
    for text in connection.scalars(texts.where(stadium.c.a == a, sweep.c.selection != "")):
        try:
            found.append(selection_of(text, a))
        except InputError as error:
            raise unsound("not a swept subset:", text) from error
    return found


def moments_of(found: Iterable[Sweep]) -> "list[Mapping[int, TiltMoments]]":
    """Return the moments of the swept periods after the exact ones, up to the first without any."""
    from orbitdb.averages.sum_rules import EXACT

    known = {each.p: each.moments for each in found}
    moments: list[Mapping[int, TiltMoments]] = []
    while each := known.get(EXACT + 1 + len(moments)):
        moments.append(each)
    return moments


def _as_sweep(row: sa.Row[Any]) -> Sweep:
    from orbitdb.averages.fixed_points import PeriodSums
    from orbitdb.averages.tilt_moments import from_bytes
    from orbitdb.orbits.sums import Tally

    values = row._mapping
    p, counts = values["p"], [values[name] for name in SWEPT]
    if not 2 <= p <= MAX_PERIOD or min(counts) < 0:
        raise unsound("a swept period of", p)
    sums, moments = None, {}
    if values["state"] == DONE:
        try:
            sums = PeriodSums.from_numbers(p, values["sums"] or b"")
            moments = from_bytes(values["moments"])
        except ValueError as error:
            raise unsound("sums of a sweep:", error) from error
    spent = values["blocks"], values["seconds"], values["processor"]
    return Sweep(p, values["state"], Tally(*counts), *spent, sums, moments, values["selection"])
