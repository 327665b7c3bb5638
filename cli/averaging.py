"""What the averages by period share: the classes they read, and what is said of them."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import typer

from orbitdb.cli.options import Format
from orbitdb.cli.reading import note_gaps, note_nothing
from orbitdb.cli.render import note, write

if TYPE_CHECKING:
    from orbitdb.store.asking.selection import Selection
    from orbitdb.store.reading.catalogue import Catalogue
    from orbitdb.store.reading.whole_periods import WholePeriods


def read_classes(catalogue: "Catalogue", chosen: "Selection", swept: bool = False) -> "WholePeriods":
    """Return the chosen classes of whole periods; say what is left out, and leave if there is none."""
    from orbitdb.store.reading.whole_periods import read_whole

    subset = read_whole(catalogue, chosen, swept)
    note_gaps(catalogue, chosen, left_out=True, counted=subset.counted() if subset.swept else None)
    if not len(subset.classes) and not any(sums.ranges.least for sums in subset.swept.values()):
        note_nothing(catalogue, subset.selection)
        raise typer.Exit(1)
    return subset


def note_divisors(periods: Sequence[int]) -> None:
    """Say which sums over fixed points lack periods."""
    from orbitdb.averages.fixed_points import missing_divisors

    for p in periods:
        if gaps := missing_divisors(p, periods):
            note(f"p = {p}: the sums over fixed points lack the periods {', '.join(map(str, gaps))}")


def write_periods(
    subset: "WholePeriods", names: Sequence[str], columns: dict[str, list[Any]], form: Format
) -> None:
    """Write one row a whole period."""
    rows = [list(row) for row in zip(*(columns[name] for name in names), strict=True)]
    write(names, [row for row in rows if row[names.index("p")] in subset.periods], form)


def note_faults(subset: "WholePeriods", fault: str) -> None:
    """Say what is missing to the zeta function, and where it has no zero that can be used."""
    if subset.missing:
        note(f"the zeta function lacks the periods {subset.why_missing()}")
    if fault:
        note(fault)


def known(value: Any) -> Any:
    """Return a number, None for one that is not."""
    return None if value != value else value
