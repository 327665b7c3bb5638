"""What the averages by period share: the classes they read, and what is said of them."""

from collections.abc import Collection, Iterable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import typer

from orbitdb.cli.half_lengths import Answer, joined
from orbitdb.cli.options import Format
from orbitdb.cli.reading import note_gaps, note_nothing
from orbitdb.cli.render import note, write

if TYPE_CHECKING:
    from orbitdb.store.asking.selection import Selection
    from orbitdb.store.reading.catalogue import Catalogue
    from orbitdb.store.reading.counted import Counted
    from orbitdb.store.reading.whole_periods import WholePeriods


def counts_without_rows(catalogue: "Catalogue", chosen: "Selection") -> "Counted | None":
    """Return counts in which sweeps and births stand for fills, where all orbits of periods are chosen."""
    if not _all_orbits(chosen):
        return None
    counted = catalogue.counts(chosen)
    return counted if counted.without_rows else None


def _all_orbits(chosen: "Selection") -> bool:
    """Tell whether nothing but periods is chosen of the orbits."""
    from orbitdb.orbits.orbit import Status

    alone = replace(chosen, statuses=()) if chosen.statuses == (Status.ORBIT,) else chosen
    return alone == type(chosen)(chosen.a, chosen.periods)


def note_uncounted(catalogue: "Catalogue", chosen: "Selection") -> None:
    """Say why births do not answer for a subset of the orbits of periods that only they know."""
    from orbitdb.store.asking.sweepable import why_not_swept
    from orbitdb.store.reading.fills import written_periods

    if _all_orbits(chosen):
        return
    known = [] if why_not_swept(chosen) else [s.p for s in catalogue.sweeps(chosen.a, chosen) if s.whole]
    born = catalogue.counts(type(chosen)(chosen.a, chosen.periods)).from_births
    if born := tuple(p for p in born if p not in known):
        note(
            f"births tell how many orbits of {written_periods(born)} there are at a = {chosen.a:g}, "
            "and not which of them are chosen: leave out all but --p, or fill them"
        )


def read_classes(
    catalogue: "Catalogue", chosen: "Selection", swept: bool = False, nothing: str = ""
) -> "WholePeriods | None":
    """Return the chosen classes of whole periods, None if there is none; say what is left out.

    What is said of no orbits ends with ``nothing``.
    """
    from orbitdb.store.reading.whole_periods import read_whole

    subset = read_whole(catalogue, chosen, swept)
    note_gaps(catalogue, chosen, left_out=True, counted=subset.counted() if subset.swept else None)
    if not len(subset.classes) and not any(sums.ranges.least for sums in subset.swept.values()):
        note_nothing(catalogue, subset.selection, nothing, swept=bool(subset.swept))
        return None
    return subset


def note_divisors(periods: Sequence[int], chosen: "Selection") -> None:
    """Say which sums over fixed points lack periods, and why these are not there."""
    from orbitdb.averages.fixed_points import missing_divisors
    from orbitdb.store.reading.whole_periods import why_missing

    for p in periods:
        if gaps := missing_divisors(p, periods):
            note(f"p = {p}: the sums over fixed points lack p = {why_missing(gaps, chosen)}")


def of_periods(
    a: float, periods: Collection[int], names: Sequence[str], columns: dict[str, list[Any]]
) -> Answer:
    """Return one row a whole period."""
    rows = zip(*(columns[name] for name in names), strict=True)
    place = names.index("p")
    return Answer(a, names, [list(row) for row in rows if row[place] in periods])


def write_answers(found: "Iterable[Answer | None]", many: bool, form: Format) -> None:
    """Write what is found at one a, or at several; leave if there is nothing."""
    answers = [each for each in found if each is not None]
    if not answers:
        raise typer.Exit(1)
    write(*joined(answers, many), form)


def note_faults(subset: "WholePeriods", fault: str) -> None:
    """Say what is missing to the zeta function, and where it has no zero that can be used."""
    if subset.missing:
        note(f"the zeta function lacks p = {subset.why_missing()}")
    if fault:
        note(fault)


def known(value: Any) -> Any:
    """Return a number, None for one that is not."""
    return None if value != value else value
