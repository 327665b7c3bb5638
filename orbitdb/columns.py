"""The registry of columns: what every number and text in rows, files and JSON is, and where it comes from.

The views, queries, filters, orders, formats, the screen, `Orbit`, `Subset` and the documentation follow it. A
column that is computed from others is one entry with a formula (`add`); no file needs a migration for it.
"""

from orbitdb.answer_columns import (
    OF_ANSWERS,
    OF_BOUNCES,
    OF_BOUNDS,
    OF_COUNTS,
    OF_ENSEMBLES,
    OF_LENGTHS,
    OF_LEVELS,
    OF_LIVES,
    OF_SPECTRA,
    OF_STATISTICS,
    OF_TRAJECTORIES,
)
from orbitdb.column import NO_ORBIT, PLACE, PRUNED, UNKNOWN, Column

_CODE = "substr(cycle.words, 1 + cycle.p * element.n, cycle.p)"
_END = "(SELECT {value} FROM change WHERE change.cycle = orbit.cycle AND change.number = {number})"

OF_WORDS = [
    Column("code", "text",
           "the cyclic word as its least rotation; 'query --code' gives it in the rotation that you "
           "asked for", sql=_CODE, single=True),
    Column("word", "text", "the same as code", sql=_CODE, single=True, written=False),
    Column("p", "integer", "period: the number of bounces", sql="cycle.p"),
    Column("representative", "text",
           "least word of the symmetry class; of all rotations of all images under the eight symmetries",
           empty=PRUNED, sql="cycle.word"),
    Column("class_size", "integer", "different cyclic words in the class; 1, 2, 4 or 8", empty=PRUNED,
           sql="cycle.class_size"),
    Column("symmetry", "text",
           "symmetries that map the cyclic word to itself; some of 'x', 'y', 'xy', 'T', 'xT', 'yT', 'xyT', "
           "with commas between, or '1' for none: 'x' mirrors left and right, 'y' up and down, 'T' reverses "
           "time", empty=PRUNED, sql="cycle.symmetry"),
    Column("time_reversal", "text",
           "'self' if it retraces its path, else 'pair'; its reverse is then another word, which counts too",
           empty=PRUNED, sql="cycle.time_reversal"),
    Column("born", "number",
           "first a at which the word becomes an orbit; every birth and its error is in the view "
           "'life'", "radius", "born_error in life",
           "an orbit from a = 0 on; no births stored; geometrically pruned",
           sql=_END.format(value="nullif(change.a, 0.0)", number=1), written=False),
    Column("dies", "number",
           "first a at which it ceases to be one", "radius", "dies_error in life",
           "never does; no births stored; geometrically pruned",
           sql=_END.format(value="change.a", number=2), written=False),
    Column("walls", "integer",
           "bounces on the straight walls; the eigenvalues of the monodromy matrix are negative where it is "
           "odd", empty=PRUNED, sql="cycle.walls"),
    Column("maslov", "integer",
           "Maslov index of one traversal, 3p - walls; 2 for every reflection, where waves vanish, and 1 for "
           "the focus after every bounce on a semicircle", empty=PRUNED, formula="3 * p - walls"),
    Column("rules", "integers",
           "geometric rules that the word breaks; in SQL a text with commas between, a list in JSON and in "
           "files", empty="unless geometrically pruned", sql="NULL", single=True),
    Column("cycle", "integer", "number of the class in this file", empty=PRUNED,
           sql="orbit.cycle", written=False),
    Column("element", "integer",
           "symmetry that carries the representative to the word; 1 for x, 2 for y, 4 for T, and their sums",
           empty=PRUNED, sql="element.element", single=True, written=False),
]  # fmt: skip
"""Columns that do not depend on a."""

OF_ORBITS = [
    Column("a", "number", "half the length of a straight wall", "radius", "exact", sql="stadium.a"),
    Column("status", "text",
           "the status of the word; 'orbit', 'dynamical', 'geometric', 'boundary' or 'unresolved'",
           bound="proved", sql="orbit.status"),
    Column("length", "number", "length of one traversal, L", "radius", "length_error", NO_ORBIT,
           sql="orbit.length"),
    Column("lyapunov", "number",
           "lambda of one traversal; ln of the largest modulus of an eigenvalue of the monodromy matrix",
           "1", "lyapunov_error", NO_ORBIT, sql="orbit.lyapunov"),
    Column("lambda_d", "number",
           "lambda per bounce, lambda/p; its bound is divided by p too", "1", "lyapunov_error", NO_ORBIT,
           formula="lyapunov / p"),
    Column("lambda_c", "number", "lambda per length, lambda/L", "1/radius", "lambda_c_error", NO_ORBIT,
           formula="lyapunov / length"),
    Column("margin", "number",
           "least distance of a bounce from the end of its wall; in units of its coordinate, negative "
           "outside, 0 through a joint of wall and semicircle", PLACE, "", PRUNED, sql="orbit.margin"),
    Column("residual", "number",
           "largest violation of the law of reflection; the difference of the cosines at a bounce, of the "
           "stored coordinates", "1", "", NO_ORBIT, sql="orbit.residual"),
    Column("error", "number", "bound on the error of every coordinate", PLACE, "itself", UNKNOWN,
           sql="orbit.error"),
    Column("length_error", "number", "bound on the error of length", "radius", "itself", UNKNOWN,
           sql="orbit.length_error"),
    Column("lyapunov_error", "number", "bound on the error of lyapunov", "1", "itself", UNKNOWN,
           sql="orbit.lyapunov_error"),
    Column("lambda_c_error", "number", "bound on the error of lambda_c", "1/radius", "itself", UNKNOWN,
           formula="1.000001 * ((lyapunov_error + lambda_c * length_error) / (length - length_error)"
                   " + 1.2e-16 * lambda_c)"),
    Column("iterations", "integer", "steps that the solver took", "1", "", PRUNED,
           sql="orbit.iterations", written=False),
    Column("solver", "text",
           "'newton' or 'relaxation'; the paper's relaxation knows no error bounds", empty=PRUNED,
           sql="orbit.solver"),
]  # fmt: skip
"""Columns of a word at one a; the words of a class share them."""

IN_CATALOGUE = [*OF_WORDS, *OF_ORBITS]
"""The columns of the view ``catalogue``."""

WRITTEN = [
    "code", "representative", "a", "p", "status", "rules", "length", "lyapunov", "lambda_d", "lambda_c",
    "time_reversal", "class_size", "walls", "maslov", "margin", "residual", "error",
    "length_error", "lyapunov_error", "symmetry", "solver",
]  # fmt: skip
"""Columns written by default, in order; programs may rely on these names as keys of JSON."""
WRITTEN += [each.name for each in IN_CATALOGUE if each.written and each.name not in WRITTEN]

GROUPS = (
    ("word", OF_WORDS),
    ("orbit", OF_ORBITS),
    ("bounce", OF_BOUNCES),
    ("answer", OF_ANSWERS),
    ("trajectory", OF_TRAJECTORIES),
    ("length", OF_LENGTHS),
    ("level", OF_LEVELS),
    ("statistics", OF_STATISTICS),
    ("spectrum", OF_SPECTRA),
    ("table", OF_COUNTS),
    ("life", OF_LIVES),
    ("entropy", OF_BOUNDS),
    ("simulation", OF_ENSEMBLES),
)
"""Every group, with what its columns describe."""

EVERY = {column.name: column for _, group in reversed(GROUPS) for column in group}
"""Every column by name; the earlier group wins."""


def add(column: Column) -> None:
    """Add a column of orbits with a formula, before anything else of the program is imported.

    Raises
    ------
    ValueError
        If the name is taken, or the formula names a column that does not exist.
    """
    known = {each.name for each in IN_CATALOGUE}
    if column.name in EVERY or not column.needs or not known.issuperset(column.needs):
        raise ValueError(f"{column.name}: give a new name, and a formula over columns of the catalogue")
    OF_ORBITS.append(column)
    IN_CATALOGUE.append(column)
    WRITTEN.append(column.name)
    EVERY[column.name] = column


def kind_of(name: str) -> str:
    """Return the kind of a column; an unknown one is a number."""
    return EVERY[name].kind if name in EVERY else "number"
