"""``orbitdb info``, ``delete`` and ``migrate``: describe the catalogue, delete parts, update its schema."""

import sys
from itertools import groupby
from operator import attrgetter, itemgetter
from typing import TYPE_CHECKING, Annotated, Any

import typer

from orbitdb.cli import options
from orbitdb.cli.output import Output, note, write_facts
from orbitdb.cli.reading import bring
from orbitdb.errors import InputError
from orbitdb.text import exact, gigabytes, several

if TYPE_CHECKING:
    from sqlalchemy import Connection

EXAMPLES = {
    "info": ("info", "info --json"),
    "delete": ("delete --a 2.5", "delete --a 2.5 --p 12-13 --yes"),
    "migrate": ("migrate --db old.db",),
}
COLUMNS = ("a", "p", "state", "stored", "N_t", "N_c", "boundary", "unresolved",
           "seconds", "enumerating", "solving", "storing")  # fmt: skip
_SHOWN = len(COLUMNS) - 3
"""Number of columns shown to people; other formats add the processor times."""
_OF_FILL = attrgetter("p", "state", "words", "n_t", "n_c", "boundary", "unresolved",
                     "seconds", "enumerating", "solving", "storing")  # fmt: skip
_OF_TALLY = attrgetter("words", "n_c", "boundary", "unresolved")
_FEW = 4
"""If the entropy is bounded at more values of a than this, only those with filled periods are listed."""


def info(*, output: Output, db: options.Database) -> None:
    """Show where the catalogue is, what it contains, and the time and disk space that it took.

    stored is the number of words stored so far, and seconds the elapsed time. csv, tsv and json also have the
    processor times for enumerating, solving and storing, in seconds. A swept period stores no rows, and all
    its processor time is under solving.
    """
    from orbitdb.store.file import reading
    from orbitdb.store.lookup import a_values

    with reading(db) as moment:
        rows = [row for a in a_values(moment) for row in _periods(moment, a)]
        facts = _facts(moment) if output.table else []
    rows.sort(key=lambda row: row[:2])
    if not output.table:
        shown = _SHOWN if output.for_people else len(COLUMNS)
        output.write(COLUMNS[:shown], [row[:shown] for row in rows])
        return
    write_facts(facts)
    for a, rows_at_a in groupby(rows, key=itemgetter(0)):
        print(f"\na = {exact(a)}")
        output.write(COLUMNS[1:_SHOWN], [row[1:_SHOWN] for row in rows_at_a])


def delete(
    *,
    a: Annotated[float, options.a_option()],
    p: options.Periods = None,
    yes: Annotated[bool, typer.Option("--yes", help="Delete without asking.")] = False,
    db: options.Database,
) -> None:
    """Delete what is stored at one half length: orbits, fills, sweeps, levels, bounds and trajectories.

    With --p, only the orbits, fills and sweeps of these periods go. Births and deaths stay, because they
    belong to no half length. On a terminal you are asked first.
    """
    from orbitdb.catalogue import Catalogue

    catalogue = Catalogue(db)
    contents = catalogue.contents(a, p)
    where = f"at a = {exact(a)} in {db}"
    if not contents:
        note(f"nothing {f'of period {p} ' if p else ''}is stored {where}")
        raise typer.Exit(1)
    if not yes:
        if not sys.stdin.isatty():
            raise InputError(f"this would delete {contents} {where}: confirm with --yes")
        if not typer.confirm(f"Delete {contents} {where}?", err=True):
            note("nothing was deleted")
            raise typer.Exit(1)
    catalogue.delete(a, p)
    note(f"deleted {contents} {where}")


def migrate(db: options.Database) -> None:
    """Update a catalogue to the latest schema, or create an empty one."""
    before, after = bring(db)
    if before == after:
        note(f"{db}: schema {after} is the latest; nothing to do")
    elif not before:
        note(f"{db}: created, schema {after}")


def _periods(moment: "Connection", a: float) -> list[tuple[Any, ...]]:
    """Return one row per filled or swept period at a given a."""
    from orbitdb.store.fills import read_fills, read_sweeps

    fills = read_fills(moment, a)
    rows = [(a, *_OF_FILL(fill)) for fill in fills]
    filled = {fill.p for fill in fills if fill.whole}
    for sweep in read_sweeps(moment, a):
        if sweep.p not in filled:
            counts = _OF_TALLY(sweep.tally) if sweep.whole else (None,) * 4
            state = "swept" if sweep.whole else "sweeping"
            rows.append((a, sweep.p, state, 0, *counts, sweep.seconds, None, sweep.processor, None))
    return rows


def _facts(moment: "Connection") -> list[tuple[str, str]]:
    """Return the path, size and contents of the catalogue as pairs of a name and a text."""
    from orbitdb.store.connection import path_of
    from orbitdb.store.contents import room
    from orbitdb.store.lives import read_birth_fills
    from orbitdb.store.results import level_windows, trajectories
    from orbitdb.store.selection import written_periods
    from orbitdb.store.tables import SCHEMA_VERSION

    facts = [
        ("catalogue", str(path_of(moment).resolve())),
        ("schema", str(SCHEMA_VERSION)),
        ("size", gigabytes(path_of(moment).stat().st_size)),
    ]
    for name, (count, size) in room(moment).items():
        facts.append((name, f"{count}" if size is None else f"{count}, {size:.0f} bytes each"))
    if born := [fill.p for fill in read_birth_fills(moment) if fill.whole]:
        facts.append(("births", written_periods(born)))
    for a, ranges in groupby(level_windows(moment), key=itemgetter(0)):
        parts = [f"{parity} k = {low:g}..{high:g} ({count})" for _, parity, low, high, count in ranges]
        facts.append(("levels", f"a = {exact(a)}: {', '.join(parts)}"))
    for a, count, bounces in trajectories(moment):
        facts.append(("simulated", f"a = {exact(a)}: {several(count, 'average')}, up to {bounces} bounces"))
    return facts + _enclosures(moment)


def _enclosures(moment: "Connection") -> list[tuple[str, str]]:
    """Return lines with the proved bounds on the entropy; if there are many a, only those that are filled."""
    from orbitdb.entropy.bounds import BALLS
    from orbitdb.store.lookup import a_values
    from orbitdb.store.results import bounds_by_a

    curve, filled = bounds_by_a(moment), a_values(moment, ["fill"])
    listed = [bounds for bounds in curve if len(curve) <= _FEW or bounds.a in filled]
    lines = [
        f"a = {exact(bounds.a)}: {bounds.between}, {bounds.window} edges{', balls' * (bounds.proof == BALLS)}"
        for bounds in listed
    ]
    if others := [bounds.a for bounds in curve if bounds not in listed]:
        lines.append(
            f"enclosed at {len(others)} other values of a from {exact(others[0])} to {exact(others[-1])}"
        )
    return [("entropy", text) for text in lines]
