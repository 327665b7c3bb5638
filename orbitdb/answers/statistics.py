"""Counts, entropies and Lyapunov averages by period in a single table: `Catalogue.statistics`."""

from orbitdb.answers.complete_periods import read_noted
from orbitdb.answers.entropy import enclosure, entropy_of_rows, outside
from orbitdb.answers.lyapunov import lyapunov_of_rows
from orbitdb.answers.results import Result
from orbitdb.store.selection import Selection
from orbitdb.store.sqlite import Connection
from orbitdb.symbols.pruning import count_admissible


def statistics(connection: Connection, selection: Selection, weight: str = "exp") -> Result:
    """Return counts, entropies and Lyapunov averages of complete periods (`Catalogue.statistics`)."""
    notes: list[str] = []
    subset = read_noted(connection, selection, notes, swept=True)
    if subset is None:
        return Result(selection, {}, (), tuple(notes))
    periods, classes = subset.shown, subset.classes.p.tolist()
    columns = {
        "N_t": [count_admissible(p) for p in periods],
        "N_c": subset.cycles()[periods].tolist(),
        "classes": [None if p in subset.swept else classes.count(p) for p in periods],
    }
    for result in (entropy_of_rows(subset), lyapunov_of_rows(subset, weight)):
        columns |= {name: list(values) for name, values in result.columns.items()}
        notes += result.notes
    proved = enclosure(connection, selection.a)
    notes.append(outside(periods, columns["h_zeta"], proved.bounds, subset.selection))
    columns |= proved.columns(len(periods))
    return Result(subset.selection, columns, (proved.fact,), tuple(dict.fromkeys(filter(None, notes))))
