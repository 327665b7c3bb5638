"""``orbitdb entropy``: the topological entropy over a chosen subset of orbits."""

import math
from typing import TYPE_CHECKING, Any

import typer

from orbitdb.cli import enclosed, options
from orbitdb.cli.averaging import (
    counts_without_rows,
    note_divisors,
    note_faults,
    note_uncounted,
    of_periods,
    read_classes,
    write_answers,
)
from orbitdb.cli.half_lengths import Answer, several
from orbitdb.cli.options import Format
from orbitdb.cli.progress import Progress, progress
from orbitdb.cli.reading import averaged, note_gaps, reading_all
from orbitdb.cli.render import note

if TYPE_CHECKING:
    from orbitdb.store.asking.selection import Selection
    from orbitdb.store.reading.catalogue import Catalogue
    from orbitdb.store.reading.counted import Counted
    from orbitdb.store.reading.enclosures import Enclosure

EXAMPLES = """
Examples:

  orbitdb entropy

  orbitdb entropy --p 2-9 --reversal self --json

  orbitdb entropy --a all --format csv
"""
COLUMNS = ("p", "N", "K_0", "h_zeta", "h_zeta_change")


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command(epilog=EXAMPLES)(entropy)


@options.with_choice
def entropy(
    *,
    a: options.StoredHalfLengths = None,
    choice: options.Choice,
    format_: options.OutputFormat = Format.TABLE,
    json: options.Json = False,
    db: options.Database = None,
) -> None:
    """Compute the topological entropy of the chosen orbits, by period.

    N: points on orbits of period p and its divisors; K_0 = ln N / p; h_zeta: from the leading zero of
    the zeta function cut off at p, which converges much faster, with its change from p - 1. The proved
    bounds are those that 'orbitdb bounds' has stored.
    """
    form, many = options.chosen(format_, json), several(a)
    with progress("reading orbits") as shown, reading_all(db, a, averaged(choice)) as (catalogue, stadiums):
        found = [_at_one(catalogue, chosen, form, many, shown) for chosen in stadiums]
    write_answers(found, many, form)


def _at_one(
    catalogue: "Catalogue", chosen: "Selection", form: Format, many: bool, shown: Progress
) -> Answer | None:
    """Return the entropies at one a, from counts where there are no rows; None if there are neither."""
    from orbitdb.averages import by_period
    from orbitdb.averages.standing import faults_of, standing

    counted = counts_without_rows(catalogue, chosen)
    proved = enclosed.enclosure(catalogue, chosen.a)
    if counted is not None:
        note_gaps(catalogue, chosen, left_out=True, counted=counted)
        return _of_counts(counted, chosen, form, many, proved)
    note_uncounted(catalogue, chosen)
    subset = read_classes(catalogue, chosen, swept=True)
    if subset is None:
        return None
    shown.tell("expanding the zeta function")
    found = by_period.entropy_of_counts(subset.cycles())
    note(subset.selection.describe())
    if form is Format.TABLE:
        _note_proved(subset.selection.a, many, proved)
    note_faults(subset, faults_of(found, subset.periods))
    note_divisors(subset.periods, subset.selection)
    columns = standing(found, subset.periods)
    columns |= _proved_columns(proved, len(columns["p"]), form)
    return of_periods(chosen.a, subset.periods, _names(columns), columns)


def _note_proved(a: float, many: bool, proved: "tuple[Enclosure, str] | None") -> None:
    """Say what is known of the entropy of all orbits by proof."""
    from orbitdb.entropy.letters import geometric_entropy
    from orbitdb.numerals import exact

    most = f"at most {math.ceil(geometric_entropy() * 1e6) / 1e6:.6f} at any a"
    if proved is None:
        note(f"of all orbits it is {most}: 'orbitdb bounds --a {exact(a)}' encloses it")
    else:
        note(f"{enclosed.told(proved, a, many)}; {most}")


def _proved_columns(
    proved: "tuple[Enclosure, str] | None", count: int, form: Format
) -> dict[str, list[float | str]]:
    """Return proved bounds as columns, where no note tells of them."""
    return enclosed.columns_of(None if proved is None or form is Format.TABLE else proved[0], count)


def _names(columns: dict[str, list[Any]]) -> list[str]:
    """Return the names of the columns of entropies that there are."""
    return [*COLUMNS, *(name for name in enclosed.COLUMNS if name in columns)]


def _of_counts(
    counted: "Counted", chosen: "Selection", form: Format, many: bool, proved: "tuple[Enclosure, str] | None"
) -> Answer:
    """Return the entropies of counts, and what is proved beside them."""
    from orbitdb.averages import by_period
    from orbitdb.averages.fixed_points import missing_periods
    from orbitdb.averages.standing import faults_of, standing
    from orbitdb.store.reading.whole_periods import why_missing

    found = by_period.entropy_of_counts(counted.cycles())
    if missing := missing_periods(max(counted.chosen), counted.chosen):
        note(f"the zeta function lacks p = {why_missing(missing, chosen)}")
    if form is Format.TABLE:
        _note_proved(counted.a, many, proved)
    if fault := faults_of(found, counted.chosen):
        note(fault)
    note_divisors(counted.chosen, chosen)
    columns = standing(found, counted.chosen)
    columns |= _proved_columns(proved, len(columns["p"]), form)
    return of_periods(counted.a, counted.chosen, _names(columns), columns)
