"""The columns: what every number and text in rows, files and JSON is, its unit, and what bounds its error.

Said once, here, for the schema, the files, the command line, the terminal UI and the documentation. How a
column is computed is said in `orbitdb/store/file/schema.py` (`SHARED`, `OF_WORD`); files that exist get it by
a migration.
"""

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
        Its meaning; a few words, and behind a semicolon what is to be said besides.
    unit : str
        Of a number; ``1`` for a pure one, empty for what is no quantity.
    bound : str
        The columns that bound its error, or ``exact``, ``proved``, ``itself``; empty where nothing does.
    empty : str
        Where there is no value.
    """

    name: str
    kind: str
    means: str
    unit: str = ""
    bound: str = ""
    empty: str = "never"

    @property
    def brief(self) -> str:
        """The meaning in a few words."""
        return self.means.partition(";")[0]


_PRUNED = "geometrically pruned"
_NONE = "no orbit"
_UNKNOWN = "no orbit; relaxation"
_PLACE = "radius, rad"

OF_WORDS = (
    Column("code", "text",
           "the cyclic word as its least rotation; 'query --code' gives it in the rotation that was asked "
           "for"),
    Column("word", "text", "the same as code"),
    Column("p", "integer", "period: the number of bounces"),
    Column("representative", "text",
           "least word of the symmetry class; of all rotations of all images under the eight symmetries",
           empty=_PRUNED),
    Column("class_size", "integer", "different cyclic words in the class; 1, 2, 4 or 8", empty=_PRUNED),
    Column("symmetry", "text",
           "symmetries that map the cyclic word to itself; some of 'x', 'y', 'xy', 'T', 'xT', 'yT', 'xyT', "
           "with commas between, or '1' for none: 'x' mirrors left and right, 'y' up and down, 'T' reverses "
           "time", empty=_PRUNED),
    Column("time_reversal", "text",
           "'self' if it retraces its path, else 'pair'; its reverse is then another word, counted, too",
           empty=_PRUNED),
    Column("born", "number",
           "first a at which the word becomes an orbit; every birth and its error is in the view "
           "'life'", "radius", "born_error in life",
           "an orbit from a = 0 on; no births stored; geometrically pruned"),
    Column("dies", "number",
           "first a at which it ceases to be one", "radius", "dies_error in life",
           "never does; no births stored; geometrically pruned"),
    Column("walls", "integer",
           "bounces on the straight walls; the eigenvalues of the monodromy matrix are negative where it is "
           "odd", empty=_PRUNED),
    Column("maslov", "integer",
           "Maslov index of one traversal, 3p - walls; 2 for every reflection, and 1 for the focus behind "
           "every bounce on a semicircle", empty=_PRUNED),
    Column("rules", "integers",
           "geometric rules that the word breaks; in SQL a text with commas between, a list in JSON and in "
           "files", empty="unless geometrically pruned"),
    Column("cycle", "integer", "number of the class in this file", empty=_PRUNED),
    Column("element", "integer",
           "symmetry that carries the representative to the word; 1 for x, 2 for y, 4 for T, and their sums",
           empty=_PRUNED),
)  # fmt: skip
"""What does not depend on a."""

OF_ORBITS = (
    Column("a", "number", "half the length of a straight wall", "radius", "exact"),
    Column("status", "text",
           "what has become of the word; 'orbit', 'dynamical', 'geometric', 'boundary' or 'unresolved'",
           bound="proved"),
    Column("length", "number", "length of one traversal, L", "radius", "length_error", _NONE),
    Column("lyapunov", "number",
           "lambda of one traversal; ln of the largest modulus of an eigenvalue of the monodromy matrix",
           "1", "lyapunov_error", _NONE),
    Column("lambda_d", "number",
           "lambda per bounce, lambda/p; so is the bound", "1", "lyapunov_error", _NONE),
    Column("lambda_c", "number", "lambda per length, lambda/L", "1/radius", "both errors", _NONE),
    Column("margin", "number",
           "least distance of a bounce from the end of its wall; in units of its coordinate, negative "
           "outside, 0 through a joint of wall and semicircle", _PLACE, "", _PRUNED),
    Column("residual", "number",
           "largest violation of the law of reflection; the difference of the cosines at a bounce, of the "
           "stored coordinates", "1", "", _NONE),
    Column("error", "number", "bound on the error of every coordinate", _PLACE, "itself", _UNKNOWN),
    Column("length_error", "number", "bound on the error of length", "radius", "itself", _UNKNOWN),
    Column("lyapunov_error", "number", "bound on the error of lyapunov", "1", "itself", _UNKNOWN),
    Column("iterations", "integer", "steps that the solver took", "1", "", _PRUNED),
    Column("solver", "text",
           "'newton' or 'relaxation'; the paper's relaxation knows no error bounds", empty=_PRUNED),
)  # fmt: skip
"""What is of one word at one a; all words of a class share it."""

OF_BOUNCES = (
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
)  # fmt: skip
"""One row a bounce, of orbits that have coordinates; bounds but for the rounding of the last digit."""

OF_ANSWERS = (
    Column("coordinates", "numbers", "the coordinates of all bounces", _PLACE, "error", _NONE),
    Column("stored", "yes or no", "whether it comes from the catalogue; else it was solved on the spot"),
    Column("exists", "pairs",
           "the ranges of a in which the word is an orbit; null for no end", "radius", "", "unknown"),
)  # fmt: skip
"""What `query --code` tells besides; coordinates are in files, too, if asked for."""

OF_TRAJECTORIES = (
    Column("first", "integer",
           "number of the first bounce that is near the orbit; 1 is the first one behind a start, or the "
           "first point, 0 and less are before a start"),
    Column("last", "integer", "number of the last bounce that is"),
    Column("bounces", "integer", "bounces in a row from the first to the last"),
    Column("turns", "number", "how often they go round the orbit; bounces/p", "1"),
    Column("distance", "number", "least distance of one of them from that of the orbit", "radius"),
    Column("sequence", "text", "symbols of all bounces of the trajectory; no cyclic word"),
    Column("sequence_first", "integer", "number of the first of them"),
)  # fmt: skip
"""What `identify` tells of an orbit that a trajectory shadows, besides."""

OF_LENGTHS = (
    Column("repetitions", "integer", "number of traversals, r"),
    Column("total", "number", "length of them all, rL", "radius"),
    Column("difference", "number", "that less the length that was asked for", "radius"),
)  # fmt: skip
"""What `identify` tells of an orbit with a length, besides."""

OF_LEVELS = (
    Column("k", "number",
           "a level; k^2 is an eigenvalue of minus the Laplacian with functions that are 0 on the boundary",
           "1/radius", "error"),
    Column("parity", "text",
           "two letters, 'e' for even and 'o' for odd; under x -> -x, then under y -> -y"),
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
)  # fmt: skip
"""What `levels`, `assess` and `scars` tell of a level, with the estimate of its error."""

OF_STATISTICS = (
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
)  # fmt: skip
"""What `assess --statistics` tells of the levels of a parity."""

OF_SPECTRA = (
    Column("quantum_re", "number",
           "real part of F at a length, of the levels; the Fourier transform of their density less the "
           "smooth one, with the window sin^4(pi k/k_max)", "1", empty="no levels"),
    Column("quantum_im", "number", "its imaginary part", "1", empty="no levels"),
    Column("orbits_re", "number", "real part of F by the trace formula; orbits and bouncing balls", "1"),
    Column("orbits_im", "number", "its imaginary part", "1"),
    Column("height", "number", "|F| at a peak; of levels if there are some, else of orbits", "1"),
)  # fmt: skip
"""What `spectrum` tells of lengths and peaks."""

IN_CATALOGUE = (*OF_WORDS, *OF_ORBITS)
"""The columns of the view ``catalogue``."""

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
)
"""All of them, each group with what its columns are of."""

EVERY = tuple(column for _, group in GROUPS for column in group)

_KINDS = {column.name: column.kind for column in EVERY}


def kind_of(name: str) -> str:
    """Return the kind of a column; a number where nothing is known of it."""
    return _KINDS.get(name, "number")
