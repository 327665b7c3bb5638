"""The registry of columns: what every number and text in rows, files and JSON is, and where it comes from.

The views, queries, filters, orders, formats, the screen, `Orbit`, `Subset` and the documentation follow it. A
column that is computed from others is one entry with a formula (`add`); no file needs a migration for it.
"""

import re
from dataclasses import dataclass


@dataclass(frozen=True)
class Column:
    """What a column holds.

    Attributes
    ----------
    name : str
    kind : str
        ``text``, ``integer`` or ``number``; ``integers`` or ``numbers`` for a list of them; else in words.
    means : str
        Its meaning; a few words, then details after a semicolon.
    unit : str
        Unit of a number; ``1`` for a pure number, empty if it is not a quantity.
    bound : str
        The columns that bound its error, or ``exact``, ``proved``, ``itself``; empty without a bound.
    empty : str
        When it has no value.
    sql : str
        Of a column of the catalogue: its value in a row of the tables that the view ``class`` joins, or,
        if `single`, the view ``catalogue``.
    formula : str
        Instead of `sql`: the value from other columns, written with ``+ - * / ( )``, numbers and their
        names, which SQLite and Python read alike.
    single : bool
        Whether the words of one symmetry class differ in it.
    written : bool
        Whether it is written where no columns are named.
    """

    name: str
    kind: str
    means: str
    unit: str = ""
    bound: str = ""
    empty: str = "never"
    sql: str = ""
    formula: str = ""
    single: bool = False
    written: bool = True

    @property
    def needs(self) -> tuple[str, ...]:
        """The columns in the formula."""
        return tuple(dict.fromkeys(NAME.findall(self.formula)))

    @property
    def brief(self) -> str:
        """The meaning in a few words."""
        return self.means.partition(";")[0]


NAME = re.compile(r"\b[a-z]\w*")

_PRUNED = "geometrically pruned"
_NONE = "no orbit"
_UNKNOWN = "no orbit; relaxation"
_PLACE = "radius, rad"

_CODE = "substr(cycle.words, 1 + cycle.p * element.n, cycle.p)"
_END = "(SELECT {value} FROM change WHERE change.cycle = orbit.cycle AND change.number = {number})"

OF_WORDS = [
    Column("code", "text",
           "the cyclic word as its least rotation; 'query --code' gives it in the rotation that was asked "
           "for", sql=_CODE, single=True),
    Column("word", "text", "the same as code", sql=_CODE, single=True, written=False),
    Column("p", "integer", "period: the number of bounces", sql="cycle.p"),
    Column("representative", "text",
           "least word of the symmetry class; of all rotations of all images under the eight symmetries",
           empty=_PRUNED, sql="cycle.word"),
    Column("class_size", "integer", "different cyclic words in the class; 1, 2, 4 or 8", empty=_PRUNED,
           sql="cycle.class_size"),
    Column("symmetry", "text",
           "symmetries that map the cyclic word to itself; some of 'x', 'y', 'xy', 'T', 'xT', 'yT', 'xyT', "
           "with commas between, or '1' for none: 'x' mirrors left and right, 'y' up and down, 'T' reverses "
           "time", empty=_PRUNED, sql="cycle.symmetry"),
    Column("time_reversal", "text",
           "'self' if it retraces its path, else 'pair'; its reverse is then another word, counted, too",
           empty=_PRUNED, sql="cycle.time_reversal"),
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
           "odd", empty=_PRUNED, sql="cycle.walls"),
    Column("maslov", "integer",
           "Maslov index of one traversal, 3p - walls; 2 for every reflection, where waves vanish, and 1 for "
           "the focus after every bounce on a semicircle", empty=_PRUNED, formula="3 * p - walls"),
    Column("rules", "integers",
           "geometric rules that the word breaks; in SQL a text with commas between, a list in JSON and in "
           "files", empty="unless geometrically pruned", sql="NULL", single=True),
    Column("cycle", "integer", "number of the class in this file", empty=_PRUNED,
           sql="orbit.cycle", written=False),
    Column("element", "integer",
           "symmetry that carries the representative to the word; 1 for x, 2 for y, 4 for T, and their sums",
           empty=_PRUNED, sql="element.element", single=True, written=False),
]  # fmt: skip
"""What does not depend on a."""

OF_ORBITS = [
    Column("a", "number", "half the length of a straight wall", "radius", "exact", sql="stadium.a"),
    Column("status", "text",
           "what has become of the word; 'orbit', 'dynamical', 'geometric', 'boundary' or 'unresolved'",
           bound="proved", sql="orbit.status"),
    Column("length", "number", "length of one traversal, L", "radius", "length_error", _NONE,
           sql="orbit.length"),
    Column("lyapunov", "number",
           "lambda of one traversal; ln of the largest modulus of an eigenvalue of the monodromy matrix",
           "1", "lyapunov_error", _NONE, sql="orbit.lyapunov"),
    Column("lambda_d", "number",
           "lambda per bounce, lambda/p; so is the bound", "1", "lyapunov_error", _NONE,
           formula="lyapunov / p"),
    Column("lambda_c", "number", "lambda per length, lambda/L", "1/radius", "lambda_c_error", _NONE,
           formula="lyapunov / length"),
    Column("margin", "number",
           "least distance of a bounce from the end of its wall; in units of its coordinate, negative "
           "outside, 0 through a joint of wall and semicircle", _PLACE, "", _PRUNED, sql="orbit.margin"),
    Column("residual", "number",
           "largest violation of the law of reflection; the difference of the cosines at a bounce, of the "
           "stored coordinates", "1", "", _NONE, sql="orbit.residual"),
    Column("error", "number", "bound on the error of every coordinate", _PLACE, "itself", _UNKNOWN,
           sql="orbit.error"),
    Column("length_error", "number", "bound on the error of length", "radius", "itself", _UNKNOWN,
           sql="orbit.length_error"),
    Column("lyapunov_error", "number", "bound on the error of lyapunov", "1", "itself", _UNKNOWN,
           sql="orbit.lyapunov_error"),
    Column("lambda_c_error", "number", "bound on the error of lambda_c", "1/radius", "itself", _UNKNOWN,
           formula="1.000001 * ((lyapunov_error + lambda_c * length_error) / (length - length_error)"
                   " + 1.2e-16 * lambda_c)"),
    Column("iterations", "integer", "steps that the solver took", "1", "", _PRUNED,
           sql="orbit.iterations", written=False),
    Column("solver", "text",
           "'newton' or 'relaxation'; the paper's relaxation knows no error bounds", empty=_PRUNED,
           sql="orbit.solver"),
]  # fmt: skip
"""What is of one word at one a; all words of a class share it."""

OF_BOUNCES = [
    Column("n", "integer", "number of the bounce; from 1, in the order of the code"),
    Column("symbol", "integer", "the wall that is hit; 0 bottom, 2 top, 1 and 4 left, 3 and 5 right"),
    Column("coordinate", "number",
           "the bounce on its wall; x on a straight wall, from -a to a, on a semicircle the angle from the "
           "outward horizontal, from -pi/2 to pi/2", _PLACE, "error"),
    Column("x", "number", "where it is, from the centre to the right", "radius", "error"),
    Column("y", "number", "where it is, from the centre upwards", "radius", "error"),
    Column("arclength", "number",
           "its place along the boundary; anticlockwise from the left end of the bottom wall",
           "radius", "error"),
    Column("sine", "number",
           "sine of the angle between the path that leaves and the normal; positive where it goes "
           "anticlockwise", "1"),
]  # fmt: skip
"""One row a bounce, of orbits that have coordinates; bounds but for the rounding of the last digit."""

OF_ANSWERS = [
    Column("coordinates", "numbers", "the coordinates of all bounces", _PLACE, "error", _NONE),
    Column("stored", "yes or no", "whether it comes from the catalogue; else it was solved on the spot"),
    Column("exists", "pairs",
           "the ranges of a in which the word is an orbit; null for no end", "radius", "", "unknown"),
]  # fmt: skip
"""What `query --code` tells besides; coordinates are in files, too, if asked for."""

OF_TRAJECTORIES = [
    Column("first", "integer",
           "number of the first bounce that is near the orbit; 1 is the first one after a start, or the "
           "first point, 0 and less are before a start"),
    Column("last", "integer", "number of the last bounce that is"),
    Column("bounces", "integer", "bounces in a row from the first to the last"),
    Column("turns", "number", "how often they go round the orbit; bounces/p", "1"),
    Column("distance", "number", "least distance of one of them from that of the orbit", "radius"),
    Column("sequence", "text", "symbols of all bounces of the trajectory; no cyclic word"),
    Column("sequence_first", "integer", "number of the first of them"),
]  # fmt: skip
"""What `identify` tells of an orbit that a trajectory shadows, besides."""

OF_LENGTHS = [
    Column("repetitions", "integer", "number of traversals, r"),
    Column("total", "number", "length of them all, rL", "radius"),
    Column("difference", "number", "that less the length that was asked for", "radius"),
]  # fmt: skip
"""What `identify` tells of an orbit with a length, besides."""

OF_LEVELS = [
    Column("k", "number",
           "a level; k^2 is an eigenvalue of minus the Laplacian with functions that are 0 on the boundary",
           "1/radius", "error"),
    Column("parity", "text",
           "two letters, 'e' for even and 'o' for odd; under x -> -x, then under y -> -y"),
    Column("number", "integer", "number of a stored level in its parity; from 1"),
    Column("error", "number", "estimate of the error of k", "1/radius"),
    Column("exact", "number",
           "the stored level with the same number, beside one from orbits", "1/radius",
           empty="none is stored"),
    Column("after", "number", "the level of a list below a place where levels are missing", "1/radius",
           empty="at the beginning"),
    Column("before", "number", "the level of a list above that place", "1/radius", empty="at the end"),
    Column("missing", "integer",
           "how many levels are missing there; a negative number counts spurious or double ones"),
    Column("strength", "number",
           "how strongly an orbit scars a level; the mean of psi^2 along it times the area; with "
           "'spectrum --peaks' |F| of the terms of one class alone", "1"),
    Column("above", "number",
           "strength less the mean of the levels of its parity in the range, in standard deviations", "1",
           empty="fewer than five levels"),
]  # fmt: skip
"""What `levels`, `assess` and `scars` tell of a level, with the estimate of its error."""

OF_STATISTICS = [
    Column("balls", "text",
           "'in' for levels unfolded with Weyl's law, 'out' with the bouncing balls taken out, too"),
    Column("levels", "integer", "number of levels", empty="random matrices and numbers"),
    Column("gap_ratio", "number", "mean of min/max of neighbouring gaps", "1", "gap_ratio_error"),
    Column("gap_ratio_error", "number", "its standard error", "1", empty="random matrices and numbers"),
    Column("spacing_variance", "number", "variance of the spacings, in their mean", "1"),
    *(Column(f"delta3_{n}", "number", f"Dyson and Mehta's Delta_3 in stretches of L = {n} mean spacings", "1",
             empty="too few levels") for n in (1, 5, 20)),
    *(Column(f"variance_{n}", "number", f"variance of the number of levels in L = {n} mean spacings", "1",
             empty="too few levels") for n in (1, 5, 20)),
]  # fmt: skip
"""What `assess --statistics` tells of the levels of a parity."""

OF_SPECTRA = [
    Column("quantum_re", "number",
           "real part of F at a length, of the levels; the Fourier transform of their density less the "
           "smooth one, with the window sin^4(pi k/k_max)", "1", empty="no levels"),
    Column("quantum_im", "number", "its imaginary part", "1", empty="no levels"),
    Column("orbits_re", "number", "real part of F by the trace formula; orbits and bouncing balls", "1"),
    Column("orbits_im", "number", "its imaginary part", "1"),
    Column("height", "number", "|F| at a peak; of levels if there are some, else of orbits", "1"),
]  # fmt: skip
"""What `spectrum` tells of lengths and peaks."""

OF_COUNTS = [
    Column("N_t", "integer", "words that the geometric rules allow"),
    Column("N_c", "integer", "words that are orbits"),
    Column("N", "integer", "points on orbits of period p or a divisor of p", empty="a divisor not filled"),
    Column("K_0", "number", "topological entropy by period, ln N / p", "1", empty="N is empty or 0"),
    Column("classes", "integer", "orbits up to symmetry"),
    Column("boundary", "integer", "orbits through a joint of wall and semicircle; not counted in N_c"),
    Column("unresolved", "integer", "words that are not decided"),
]
"""What `table` tells of a period, as in the paper's Table 1."""

OF_LIVES = [
    Column("born", "number", "where the class begins to be an orbit as a grows; from a = 0 on: 0 in files, "
           "NULL in SQL", "radius", "born_error"),
    Column("born_error", "number", "bound on the error of born", "radius", "itself"),
    Column("dies", "number", "where the class next ceases to be one", "radius", "dies_error", "no end"),
    Column("dies_error", "number", "bound on the error of dies", "radius", "itself", "no end"),
]  # fmt: skip
"""What the view ``life`` tells of a stretch of a over which a class is an orbit."""

OF_BOUNDS = [
    Column("window", "integer", "edges of the longest windows"),
    Column("lower", "number", "proved lower bound on the topological entropy per bounce", "1", "proved"),
    Column("upper", "number", "proved upper bound", "1", "proved"),
    Column("windows", "integer", "windows examined; mirror images and reversals count once"),
    Column("undecided", "integer", "windows of the longest length that are not decided"),
    Column("proof", "text", "what decided the windows; 'doubles' with error bounds or 'balls'"),
]
"""What `bounds` tells of the entropy at one a."""

OF_ENSEMBLES = [
    Column("lambda_d", "number", "lambda per bounce, mean over random trajectories", "1", "lambda_d_error"),
    Column("lambda_d_error", "number", "its standard error", "1"),
    Column("lambda_c", "number", "lambda per length, mean over them", "1/radius", "lambda_c_error"),
    Column("lambda_c_error", "number", "its standard error", "1/radius"),
    Column("mean_free_path", "number", "mean path between bounces", "radius", "mean_free_path_error"),
    Column("mean_free_path_error", "number", "its standard error", "radius"),
    Column("bounces", "integer", "total number of bounces"),
    Column("groups", "integer", "number of independent starts"),
    Column("seed", "integer", "seed of the random numbers"),
]
"""What `simulate` stores of random trajectories."""

IN_CATALOGUE = [*OF_WORDS, *OF_ORBITS]
"""The columns of the view ``catalogue``."""

WRITTEN = [
    "code", "representative", "a", "p", "status", "rules", "length", "lyapunov", "lambda_d", "lambda_c",
    "time_reversal", "class_size", "walls", "maslov", "margin", "residual", "error",
    "length_error", "lyapunov_error", "symmetry", "solver",
]  # fmt: skip
"""What is written where no columns are named, in order; programs may rely on these names as keys of JSON."""
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
"""All of them, each group with what its columns are of."""

EVERY = {column.name: column for _, group in reversed(GROUPS) for column in group}
"""The columns by name; of two with one name, the earlier group's."""


def add(column: Column) -> None:
    """Add a column of orbits with a formula; the rest of the program must not be imported yet.

    Raises
    ------
    ValueError
        If there is such a column, or the formula names one that does not exist.
    """
    known = {each.name for each in IN_CATALOGUE}
    if column.name in EVERY or not column.needs or not known.issuperset(column.needs):
        raise ValueError(f"{column.name}: give a new name, and a formula over columns of the catalogue")
    OF_ORBITS.append(column)
    IN_CATALOGUE.append(column)
    WRITTEN.append(column.name)
    EVERY[column.name] = column


def kind_of(name: str) -> str:
    """Return the kind of a column; a number where nothing is known of it."""
    return EVERY[name].kind if name in EVERY else "number"
