"""``orbitdb info``: where and what the database is."""

from typing import TYPE_CHECKING, Any

from orbitdb.cli import options
from orbitdb.cli.options import Format
from orbitdb.cli.render import write, write_facts
from orbitdb.plaintext import printable

if TYPE_CHECKING:
    from orbitdb.catalogue.catalogue import Catalogue
    from orbitdb.store.reading.records import Enclosure
    from orbitdb.store.reading.sweeps import Sweep

EXAMPLES = """
Examples:

  orbitdb info

  orbitdb info --json
"""
COLUMNS = ("a", "p", "state", "stored", "N_t", "N_c", "boundary", "unresolved",
           "seconds", "enumerating", "solving", "storing")  # fmt: skip
_SHOWN = len(COLUMNS) - 3
"""Columns for people, that 80 characters hold: those of processors come in the other formats."""
_FEW = 4
"""Values of a whose entropies stand in lines of their own."""


def info(
    format_: options.OutputFormat = Format.TABLE,
    json: options.Json = False,
    db: options.Database = None,
) -> None:
    """Show where the catalogue is, what is filled, and what that took in time and room.

    stored: sequences so far; seconds: as they passed. csv, tsv and json have enumerating, solving and
    storing besides, the seconds of processors. Of periods that are swept no rows are stored; solving has
    all of it. selection: of which orbits, where chosen ones are swept.
    """
    from orbitdb.catalogue.catalogue import Catalogue

    form = options.chosen(format_, json)
    with Catalogue(db).at_one_moment() as catalogue:
        rows = [row for a in catalogue.a_values() for row in _periods(catalogue, a)]
        chosen = [row for a in catalogue.a_values() for row in _swept_subsets(catalogue, a)]
        facts = _facts(catalogue) if form is Format.TABLE else []
    if form is Format.TABLE:
        write_facts(facts)
        _write_tables(rows, chosen)
        return
    if chosen:
        rows = sorted([*((*row, None) for row in rows), *chosen], key=lambda row: row[:2])
    names = (*COLUMNS, "selection") if chosen else COLUMNS
    if form in options.FOR_PEOPLE:
        names, rows = _for_people(names), [_for_people(row) for row in rows]
    write(names, rows, form)


def _for_people(row: tuple[Any, ...]) -> tuple[Any, ...]:
    return row[:_SHOWN] + row[len(COLUMNS) :]


def _write_tables(rows: list[tuple[Any, ...]], chosen: list[tuple[Any, ...]]) -> None:
    """Write the periods, and then those of every swept subset behind a line that names it."""
    parts = {None: rows} | {of: [row for row in chosen if row[-1] == of] for *_, of in chosen}
    for of, part in parts.items():
        if part:
            print("" if of is None else f"\nselection  {printable(of)}")
            write(COLUMNS[:_SHOWN], [row[:_SHOWN] for row in part], Format.TABLE)


def _periods(catalogue: "Catalogue", a: float) -> list[tuple[Any, ...]]:
    """Return what is filled at one a, and what is swept besides, a row a period."""
    fills = catalogue.fills(a)
    rows: list[tuple[Any, ...]] = [
        (
            a, fill.p, fill.state, fill.words, fill.n_t, fill.n_c, fill.boundary, fill.unresolved,
            fill.seconds, fill.enumerating, fill.solving, fill.storing,
        )
        for fill in fills
    ]  # fmt: skip
    filled = {fill.p for fill in fills if fill.whole}
    rows += [_swept(a, each) for each in catalogue.sweeps(a) if each.p not in filled]
    return sorted(rows, key=lambda row: row[:2])


def _swept_subsets(catalogue: "Catalogue", a: float) -> list[tuple[Any, ...]]:
    """Return what is swept of chosen orbits at one a, and not filled: a row a subset and period."""
    filled = {fill.p for fill in catalogue.fills(a) if fill.whole}
    found = [each for chosen in catalogue.swept_subsets(a) for each in catalogue.sweeps(a, chosen)]
    return [(*_swept(a, each), each.selection) for each in found if each.p not in filled]


def _swept(a: float, sweep: "Sweep") -> tuple[Any, ...]:
    """Return the row of a swept period."""
    tally, nothing = sweep.tally, (None,) * 4
    counts = (tally.words, tally.n_c, tally.boundary, tally.unresolved) if sweep.whole else nothing
    state = "swept" if sweep.whole else "sweeping"
    return (a, sweep.p, state, 0, *counts, sweep.seconds, None, sweep.processor, None)


def _facts(catalogue: "Catalogue") -> list[tuple[str, str]]:
    """Return where the catalogue is and what it takes, in words."""
    from orbitdb.catalogue.gaps import written_periods
    from orbitdb.filling.estimate import gigabytes
    from orbitdb.store.file.schema import SCHEMA_VERSION
    from orbitdb.store.reading.records import room

    with catalogue.reading() as connection:
        taken = room(connection)
    facts = [
        ("catalogue", str(catalogue.path.resolve())),
        ("schema", str(SCHEMA_VERSION)),
        ("size", gigabytes(catalogue.path.stat().st_size)),
    ]
    for name, count, each in (
        ("classes", taken.classes, taken.per_class),
        ("orbits", taken.orbits, taken.per_orbit),
    ):
        facts.append((name, f"{count}" if each is None else f"{count}, {each:.0f} bytes each"))
    if born := [each.p for each in catalogue.birth_fills() if each.whole]:
        facts.append(("births", written_periods(born)))
    return facts + _enclosures(catalogue)


def _enclosures(catalogue: "Catalogue") -> list[tuple[str, str]]:
    """Return the proved bounds on the entropy, a line an a; of many, where periods are filled."""
    from orbitdb.numerals import exact

    curve, filled = catalogue.entropy_curve(), [a for a in catalogue.a_values() if catalogue.fills(a)]
    told = [each for each in curve if len(curve) <= _FEW or each.a in filled]
    lines = [f"a = {exact(each.a)}: {each.between}, {_windows(each)}" for each in told]
    others = [each.a for each in curve if each not in told]
    if others:
        lines.append(f"enclosed at {len(others)} other a from {exact(others[0])} to {exact(others[-1])}")
    return [("entropy", text) for text in lines]


def _windows(found: "Enclosure") -> str:
    """Say what bounds rest on, more briefly than `basis`: a line with all digits of a has 80 characters."""
    from orbitdb.store.file.schema import BALLS

    return f"{found.window} edges" + (", balls" if found.proof == BALLS else "")
