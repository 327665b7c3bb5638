"""The registry of columns: the meaning and the source of every number and text in rows, files and JSON.

Views, queries, filters, sorting, formats, the screen, `Orbit`, `Subset` and the documentation are built from
it. A column computed from others is one entry with a formula (`add`), and needs no migration of files.
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
           "the cyclic word, written as its least rotation; 'query --code' shows it in the rotation that you "
           "gave", sql=_CODE, single=True),
    Column("word", "text", "alias of code", sql=_CODE, single=True, written=False),
    Column("p", "integer", "period, the number of bounces", sql="cycle.p"),
    Column("representative", "text",
           "least word of the symmetry class; the least rotation of all images under the eight symmetries",
           empty=PRUNED, sql="cycle.word"),
    Column("class_size", "integer", "number of different cyclic words in the class; 1, 2, 4 or 8",
           empty=PRUNED, sql="cycle.class_size"),
    Column("symmetry", "text",
           "symmetries that map the cyclic word to itself; some of 'x', 'y', 'xy', 'T', 'xT', 'yT', 'xyT', "
           "separated by commas, or '1' for none. 'x' swaps left and right, 'y' swaps up and down, 'T' "
           "reverses time", empty=PRUNED, sql="cycle.symmetry"),
    Column("time_reversal", "text",
           "'self' if the orbit retraces its path, otherwise 'pair'; the reverse is then another word, which "
           "is also counted", empty=PRUNED, sql="cycle.time_reversal"),
    Column("born", "number",
           "smallest a at which the word becomes an orbit; the view 'life' has all births with their errors",
           "radius", "born_error in life",
           "an orbit from a = 0 on; no births stored; geometrically pruned",
           sql=_END.format(value="nullif(change.a, 0.0)", number=1), written=False),
    Column("dies", "number",
           "smallest a at which the word ceases to be an orbit", "radius", "dies_error in life",
           "never dies; no births stored; geometrically pruned",
           sql=_END.format(value="change.a", number=2), written=False),
    Column("walls", "integer",
           "number of bounces on the straight walls; if it is odd, the eigenvalues of the monodromy matrix "
           "are negative", empty=PRUNED, sql="cycle.walls"),
    Column("maslov", "integer",
           "Maslov index of one traversal, 3p - walls; each bounce adds 2, because waves vanish on the "
           "boundary, and each bounce on a semicircle 1 more, for the focus after it", empty=PRUNED,
           formula="3 * p - walls"),
    Column("rules", "integers",
           "numbers of the geometric rules that the word breaks; comma-separated text in SQL, a list in JSON "
           "and in files", empty="unless geometrically pruned", sql="NULL", single=True),
    Column("cycle", "integer", "id of the class in this file", empty=PRUNED,
           sql="orbit.cycle", written=False),
    Column("element", "integer",
           "symmetry that maps the representative to the word; 1 for x, 2 for y, 4 for T, and sums of these "
           "for products", empty=PRUNED, sql="element.element", single=True, written=False),
]  # fmt: skip
"""Columns of a word that do not depend on a."""

OF_ORBITS = [
    Column("a", "number", "half the length of a straight wall", "radius", "exact", sql="stadium.a"),
    Column("status", "text",
           "status of the word; 'orbit', 'dynamical', 'geometric', 'boundary' or 'unresolved'",
           bound="proved", sql="orbit.status"),
    Column("length", "number", "length of one traversal, L", "radius", "length_error", NO_ORBIT,
           sql="orbit.length"),
    Column("lyapunov", "number",
           "lambda of one traversal; ln of the largest modulus of an eigenvalue of the monodromy matrix",
           "1", "lyapunov_error", NO_ORBIT, sql="orbit.lyapunov"),
    Column("lambda_d", "number",
           "lambda per bounce, lambda/p; its error bound is lyapunov_error divided by p", "1",
           "lyapunov_error", NO_ORBIT, formula="lyapunov / p"),
    Column("lambda_c", "number", "lambda per unit length, lambda/L", "1/radius", "lambda_c_error", NO_ORBIT,
           formula="lyapunov / length"),
    Column("margin", "number",
           "smallest distance of a bounce from the end of its wall or semicircle; 0 at a joint, negative if "
           "a bounce lies beyond the end", PLACE, "", PRUNED, sql="orbit.margin"),
    Column("residual", "number",
           "largest violation of the law of reflection; the difference between the cosines of the two angles "
           "at a bounce, from the stored coordinates", "1", "", NO_ORBIT, sql="orbit.residual"),
    Column("error", "number", "bound on the error of every coordinate", PLACE, "itself", UNKNOWN,
           sql="orbit.error"),
    Column("length_error", "number", "bound on the error of length", "radius", "itself", UNKNOWN,
           sql="orbit.length_error"),
    Column("lyapunov_error", "number", "bound on the error of lyapunov", "1", "itself", UNKNOWN,
           sql="orbit.lyapunov_error"),
    Column("lambda_c_error", "number", "bound on the error of lambda_c", "1/radius", "itself", UNKNOWN,
           formula="1.000001 * ((lyapunov_error + lambda_c * length_error) / (length - length_error)"
                   " + 1.2e-16 * lambda_c)"),
    Column("iterations", "integer", "number of steps that the solver took", "1", "", PRUNED,
           sql="orbit.iterations", written=False),
    Column("solver", "text",
           "'newton' or 'relaxation'; the paper's relaxation computes no error bounds", empty=PRUNED,
           sql="orbit.solver"),
]  # fmt: skip
"""Columns of a word at one value of a; all words of a class share their values."""

IN_CATALOGUE = [*OF_WORDS, *OF_ORBITS]
"""The columns of the view ``catalogue``."""

WRITTEN = [
    "code", "representative", "a", "p", "status", "rules", "length", "lyapunov", "lambda_d", "lambda_c",
    "time_reversal", "class_size", "walls", "maslov", "margin", "residual", "error",
    "length_error", "lyapunov_error", "symmetry", "solver",
]  # fmt: skip
"""Columns written by default, in this order; other programs may rely on these names as JSON keys."""
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
"""Every group of columns, with the name of what they describe."""

EVERY = {column.name: column for _, group in reversed(GROUPS) for column in group}
"""All columns by name; if a name occurs in several groups, the first group's column is used."""


def add(column: Column) -> None:
    """Add a column of orbits that a formula computes; call this before importing other parts of orbitdb.

    Raises
    ------
    ValueError
        If the name is taken, the formula is missing, or it names a column that does not exist.
    """
    known = {each.name for each in IN_CATALOGUE}
    if column.name in EVERY or not column.needs or not known.issuperset(column.needs):
        raise ValueError(f"{column.name}: give a new name, and a formula that uses columns of the catalogue")
    OF_ORBITS.append(column)
    IN_CATALOGUE.append(column)
    WRITTEN.append(column.name)
    EVERY[column.name] = column


def kind_of(name: str) -> str:
    """Return the kind of a column; an unknown column is assumed to be a number."""
    return EVERY[name].kind if name in EVERY else "number"
