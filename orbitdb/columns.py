"""The registry of columns: the meaning of every number and text in rows, files and JSON.

Queries, filters, sorting, formats, the screen and the documentation are built from it. What a column of the
catalogue is, stands in `orbitdb.store.views`.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

Row: TypeAlias = Sequence[Any]
"""One value per column; None if it is missing."""


@dataclass(frozen=True)
class Column:
    """The description of a column.

    Attributes
    ----------
    name : str
    kind : str
        ``text``, ``integer`` or ``number``; ``integers`` or ``numbers`` for lists; other kinds in words.
    means : str
        The meaning in a few words, then details after a semicolon.
    unit : str
        Unit of a number; ``1`` for a pure number, empty if it is not a quantity.
    bound : str
        The column that bounds its error, or ``exact``, ``proved`` or ``itself``; empty if none does.
    empty : str
        When the column has no value.
    written : bool
        Whether it is written if you name no columns.
    """

    name: str
    kind: str
    means: str
    unit: str = ""
    bound: str = ""
    empty: str = "never"
    written: bool = True

    @property
    def brief(self) -> str:
        """The meaning in a few words, without the details."""
        return self.means.partition(";")[0]


PRUNED = "geometrically pruned"
NO_ORBIT = "no orbit"
UNKNOWN = "no orbit; relaxation"
PLACE = "radius, rad"
"""Reasons why a column is empty, and the unit of a coordinate."""

OF_WORDS = [
    Column("code", "text",
           "the cyclic word, written as its least rotation; 'query --code' shows it in the rotation that you "
           "gave"),
    Column("p", "integer", "period, the number of bounces"),
    Column("representative", "text",
           "least word of the symmetry class; the least rotation of all images under the eight symmetries",
           empty=PRUNED),
    Column("class_size", "integer", "number of different cyclic words in the class; 1, 2, 4 or 8",
           empty=PRUNED),
    Column("symmetry", "text",
           "symmetries that map the cyclic word to itself; some of 'x', 'y', 'xy', 'T', 'xT', 'yT', 'xyT', "
           "separated by commas, or '1' for none. 'x' swaps left and right, 'y' swaps up and down, 'T' "
           "reverses time", empty=PRUNED),
    Column("time_reversal", "text",
           "'self' if the orbit retraces its path, otherwise 'pair'; the reverse is then another word, which "
           "is also counted", empty=PRUNED),
    Column("born", "number",
           "smallest a at which the word becomes an orbit; the view 'life' has all births with their errors",
           "radius", "born_error in life",
           "an orbit from a = 0 on; no births stored; geometrically pruned", written=False),
    Column("dies", "number",
           "smallest a at which the word ceases to be an orbit", "radius", "dies_error in life",
           "never dies; no births stored; geometrically pruned", written=False),
    Column("walls", "integer",
           "number of bounces on the straight walls; if it is odd, the eigenvalues of the monodromy matrix "
           "are negative", empty=PRUNED),
    Column("maslov", "integer",
           "Maslov index of one traversal, 3p - walls; each bounce adds 2, because waves vanish on the "
           "boundary, and each bounce on a semicircle 1 more, for the focus after it", empty=PRUNED),
    Column("half", "text",
           "symmetry that makes the second half of the orbit the image of the first; 'x', 'y' or 'xy'. In "
           "the quarter stadium, such an orbit closes after half of its length",
           empty="no such symmetry; geometrically pruned"),
    Column("quarter_maslov", "integer",
           "Maslov index of one traversal in the quarter stadium x, y >= 0; maslov/2 if the column half has "
           "a value, otherwise maslov. Bounces on the axes do not count: they give the sign of the parity",
           empty=PRUNED),
    Column("quarter_signs", "integers",
           "signs of one traversal in the quarter stadium for the parities ee, eo, oe and oo, in this order; "
           "the column half is the symmetry that gives them", empty=PRUNED, written=False),
    Column("quarter_orientations", "integer",
           "number of ways to traverse the orbit in the quarter stadium; 1 if it retraces its path there, "
           "otherwise 2. For the word 13, which lies on an axis, 1", empty=PRUNED, written=False),
    Column("rules", "integers",
           "numbers of the geometric rules that the word breaks; comma-separated text in SQL, a list in JSON "
           "and in files", empty="unless geometrically pruned"),
    Column("cycle", "integer", "id of the class in this file", empty=PRUNED, written=False),
    Column("element", "integer",
           "symmetry that maps the representative to the word; 1 for x, 2 for y, 4 for T, and sums of these "
           "for products", empty=PRUNED, written=False),
]  # fmt: skip
"""Columns of a word that do not depend on a."""

OF_ORBITS = [
    Column("a", "number", "half the length of a straight wall", "radius", "exact"),
    Column("status", "text",
           "status of the word; 'orbit', 'dynamical', 'geometric', 'boundary' or 'unresolved'",
           bound="proved"),
    Column("length", "number", "length of one traversal, L", "radius", "length_error", NO_ORBIT),
    Column("quarter_length", "number",
           "length of one traversal in the quarter stadium x, y >= 0; L/2 if the column half has a value, "
           "otherwise L", "radius", "length_error", NO_ORBIT),
    Column("quarter_lyapunov", "number",
           "lambda of one traversal in the quarter stadium x, y >= 0; lyapunov/2 if the column half has a "
           "value, otherwise lyapunov", "1", "lyapunov_error", NO_ORBIT),
    Column("lyapunov", "number",
           "lambda of one traversal; ln of the largest modulus of an eigenvalue of the monodromy matrix",
           "1", "lyapunov_error", NO_ORBIT),
    Column("lambda_d", "number",
           "lambda per bounce, lambda/p; its error bound is lyapunov_error divided by p", "1",
           "lyapunov_error", NO_ORBIT),
    Column("lambda_c", "number", "lambda per unit length, lambda/L", "1/radius", "lambda_c_error", NO_ORBIT),
    Column("margin", "number",
           "smallest distance of a bounce from the end of its wall or semicircle; 0 at a joint, negative if "
           "a bounce lies beyond the end. That of a dynamically pruned word belongs to its closed path, or, "
           "if a leg of that path with n straight bounces has a slope above 2(n + 1)/a (17/16a if n = 0) or "
           "below max(0, (n - 17/16)/(a + 1)), to the longest path within these limits",
           PLACE, "", PRUNED),
    Column("residual", "number",
           "largest violation of the law of reflection; the difference between the cosines of the two angles "
           "at a bounce, from the stored coordinates", "1", "", NO_ORBIT),
    Column("error", "number", "bound on the error of every coordinate", PLACE, "itself", UNKNOWN),
    Column("length_error", "number", "bound on the error of length", "radius", "itself", UNKNOWN),
    Column("lyapunov_error", "number", "bound on the error of lyapunov", "1", "itself", UNKNOWN),
    Column("lambda_c_error", "number", "bound on the error of lambda_c", "1/radius", "itself", UNKNOWN),
    Column("area", "number",
           "area that one traversal encloses; anticlockwise is positive. A weak magnetic field gives the "
           "orbit a phase proportional to it", "radius^2", "area_error", NO_ORBIT),
    Column("area_error", "number", "bound on the error of area", "radius^2", "itself", UNKNOWN),
    Column("iterations", "integer", "number of steps that the solver took", "1", "", PRUNED, written=False),
    Column("solver", "text",
           "'newton' or 'relaxation'; the paper's relaxation computes no error bounds", empty=PRUNED),
]  # fmt: skip
"""Columns of a word at one value of a; all words of a class share their values, but for the sign of area."""

IN_CATALOGUE = [*OF_WORDS, *OF_ORBITS]
"""The columns of the view ``catalogue``."""

COMPUTED = [
    Column("area_slope", "number",
           "derivative of the enclosed area in the curvature kappa of the path, at kappa = 0; in a weak "
           "magnetic field, the action is S = L - kappa area - kappa^2 area_slope / 2. It is computed when "
           "rows are read, so --where and --order cannot use it", "radius^3", "", NO_ORBIT),
    Column("reverse", "text",
           "the time-reversed word, written as its least rotation; the code itself if the orbit retraces its "
           "path. It is computed when rows are read, so --where and --order cannot use it", written=False),
    Column("words", "integer",
           "number of words of the class that fulfil the conditions; with --classes, where a row stands for "
           "them, otherwise 1", written=False),
]  # fmt: skip
"""Further columns of a row, which are computed when they are asked for; the view does not have them."""

WRITTEN = [
    "code", "representative", "a", "p", "status", "rules", "length", "lyapunov", "lambda_d", "lambda_c",
    "time_reversal", "class_size", "walls", "maslov", "margin", "residual", "error",
    "length_error", "lyapunov_error", "symmetry", "solver",
]  # fmt: skip
"""Columns written by default, in this order; other programs may rely on these names as JSON keys."""
WRITTEN += [each.name for each in (*IN_CATALOGUE, *COMPUTED) if each.written and each.name not in WRITTEN]

# columns of answers that are not rows of the catalogue

OF_BOUNCES = [
    Column("n", "integer", "number of the bounce, from 1; in the order of the code"),
    Column("symbol", "integer",
           "symbol of the bounce; 0 bottom wall, 2 top wall, 1 or 4 left and 3 or 5 right semicircle"),
    Column("coordinate", "number",
           "position of the bounce on its wall or semicircle; on a straight wall x, from -a to a, on a "
           "semicircle the angle from the outward horizontal, from -pi/2 to pi/2", PLACE, "error"),
    Column("x", "number", "x coordinate of the bounce; from the centre to the right", "radius", "error"),
    Column("y", "number", "y coordinate of the bounce; from the centre upwards", "radius", "error"),
    Column("arclength", "number",
           "position of the bounce along the boundary; anticlockwise from the left end of the bottom wall",
           "radius", "error"),
    Column("sine", "number",
           "sine of the angle between the outgoing path and the normal; positive if the path leads "
           "anticlockwise along the boundary", "1"),
    Column("gamma", "number",
           "future of the bounce as a number from 0 to 1; bounces whose gamma is close have the same future "
           "for a while, and those with a given block of symbols next fill an interval", "1"),
    Column("delta", "number",
           "past of the bounce as a number from 0 to 1; it is gamma of the reversed path", "1"),
]  # fmt: skip
"""Columns of a bounce; their error bounds do not include the rounding of the last digit."""

OF_ANSWERS = [
    Column("coordinates", "numbers", "coordinates of all bounces", PLACE, "error", NO_ORBIT),
    Column("stored", "yes or no", "whether the word is in the catalogue; if not, it was solved on the spot"),
    Column("exists", "pairs",
           "ranges of a in which the word is an orbit; each as [from, to], with null if it has no end",
           "radius", "", "unknown"),
]  # fmt: skip
"""Further columns of `query --code`; files contain the coordinates only on request."""

OF_TRAJECTORIES = [
    Column("first", "integer",
           "number of the first bounce near the orbit; bounce 1 is the first after the start, or the first "
           "given point, and 0 and negative numbers are bounces at or before the start"),
    Column("last", "integer", "number of the last bounce that is near the orbit"),
    Column("bounces", "integer", "number of bounces from the first to the last"),
    Column("turns", "number", "number of times that the trajectory goes round the orbit; bounces/p", "1"),
    Column("distance", "number",
           "smallest distance between a bounce and the corresponding bounce of the orbit", "radius"),
    Column("sequence", "text", "symbols of all bounces of the trajectory; not a cyclic word"),
    Column("sequence_first", "integer", "number of the first bounce in the sequence"),
]  # fmt: skip
"""Further columns of an orbit that a trajectory shadows (`identify`)."""

OF_LENGTHS = [
    Column("repetitions", "integer", "number of traversals, r"),
    Column("total", "number", "total length of all traversals, rL", "radius"),
    Column("difference", "number", "total minus the length that you asked for", "radius"),
]  # fmt: skip
"""Further columns of an orbit with a given length (`identify`)."""

OF_LEVELS = [
    Column("k", "number",
           "wavenumber of a level; k^2 is an eigenvalue of minus the Laplacian on functions that vanish at "
           "the boundary", "1/radius", "error"),
    Column("parity", "text",
           "parity in two letters, 'e' for even and 'o' for odd; first under x -> -x, then under y -> -y"),
    Column("number", "integer",
           "position of a level among those of its parity, or of all in the list; counted from 1, 0 for a "
           "spurious level"),
    Column("error", "number", "estimated error of k", "1/radius"),
    Column("exact", "number",
           "stored level with the same number; for comparison with the level computed from orbits",
           "1/radius", empty="not stored"),
    Column("after", "number", "last level of the list below a gap; levels are missing or spurious there",
           "1/radius", empty="at the beginning of the list"),
    Column("before", "number", "first level of the list above the gap", "1/radius",
           empty="at the end of the list"),
    Column("levels", "integer",
           "number of levels of the list between after and before; in doubt next to which of them levels are "
           "missing, or which of them are spurious; in statistics, the number of all levels",
           empty="for random matrices and random numbers"),
    Column("missing", "integer", "number of levels missing between after and before"),
    Column("spurious", "integer", "number of spurious or duplicate levels between after and before"),
    Column("probability", "number",
           "probability that the numbers of missing and spurious levels are right; with --numbers, that of "
           "the number of a level", "1"),
    Column("gaps", "pairs",
           "the gaps between neighbours from after to before, each with the probability of every number of "
           "levels missing in it; in JSON only"),
    Column("excess", "number",
           "number of levels missing below a level of the list; according to the orbits, not rounded", "1"),
    Column("strength", "number",
           "how strongly an orbit scars a level; the mean of psi^2 along the orbit times the area; in "
           "'spectrum --peaks' the modulus of the orbit's own contribution to F", "1"),
    Column("above", "number",
           "strength minus its mean over neighbouring levels, in standard deviations; over up to 15 levels "
           "of the same parity on each side", "1", empty="fewer than five of them, or all equal"),
]  # fmt: skip
"""Columns of `levels`, `assess` and `scars`."""

OF_STATISTICS = [
    Column("balls", "text",
           "'in' if the levels are unfolded with Weyl's law alone, 'out' if the contribution of the bouncing "
           "balls is removed as well", empty="for random matrices and random numbers"),
    Column("gap_ratio", "number", "mean ratio of neighbouring gaps, the smaller to the larger", "1",
           "gap_ratio_error"),
    Column("gap_ratio_error", "number", "standard error of gap_ratio", "1",
           empty="for random matrices and random numbers"),
    Column("spacing_variance", "number", "variance of the unfolded spacings, whose mean is near 1", "1"),
    *(Column(f"delta3_{n}", "number", f"Dyson and Mehta's Delta_3(L) at L = {n}; L in mean spacings", "1",
             empty="too few levels") for n in (1, 5, 20)),
    *(Column(f"variance_{n}", "number",
             f"variance of the number of levels in an interval of L = {n}; L in mean spacings", "1",
             empty="too few levels") for n in (1, 5, 20)),
]  # fmt: skip
"""Columns of `assess --statistics`."""

OF_SPECTRA = [
    Column("quantum_re", "number",
           "real part of F from the levels; F is the Fourier transform, at a given length, of the level "
           "density minus its smooth part, with the window sin^4(pi k/k_max)", "1", empty="no levels"),
    Column("quantum_im", "number", "imaginary part of F from the levels", "1", empty="no levels"),
    Column("orbits_re", "number",
           "real part of F from the trace formula; summed over the orbits and the bouncing balls", "1"),
    Column("orbits_im", "number", "imaginary part of F from the trace formula", "1"),
    Column("repetition", "integer", "number of traversals of an orbit or, for one parity, of its half"),
    Column("index", "integer", "Maslov index of all these traversals", empty="for the bouncing balls"),
    Column("sign", "integer",
           "sign by which the parity multiplies the amplitude; A is sign |A| exp(-i pi index / 2)",
           empty="for the bouncing balls"),
    Column("amplitude_re", "number",
           "real part of the amplitude A of a term Re(A exp(i k l)) of the density of levels; that of the "
           "bouncing balls depends on k and is given at k_max / 2", "radius"),
    Column("amplitude_im", "number", "imaginary part of the amplitude A", "radius"),
    Column("height", "number", "|F| at a peak; from the levels if there are any, otherwise from orbits", "1"),
]  # fmt: skip
"""Columns of `spectrum`, for lengths, peaks and terms."""

OF_COUNTS = [
    Column("N_t", "integer", "number of words that the geometric rules allow"),
    Column("N_c", "integer", "number of words that are orbits"),
    Column("N", "integer", "number of points on orbits of period p or a divisor of p",
           empty="a divisor of p is missing"),
    Column("K_0", "number", "estimate of the topological entropy, ln N / p", "1", empty="N is empty or 0"),
    Column("classes", "integer", "number of orbits up to symmetry"),
    Column("boundary", "integer", "number of orbits through a joint of wall and semicircle; not in N_c"),
    Column("unresolved", "integer", "number of words whose status is not decided"),
]  # fmt: skip
"""Columns of `table`, which describe a period as in the paper's Table 1."""

OF_FIELD = [
    Column("kappa", "number",
           "curvature of the path in a magnetic field, 1 / (cyclotron radius); positive if it turns left",
           "1/radius", "exact"),
    Column("action", "number",
           "action of one traversal in the field, S = L - kappa A; A is the enclosed area, anticlockwise "
           "positive", "radius", "", NO_ORBIT),
    Column("trace", "number", "trace of the monodromy matrix of one traversal", "1", "", NO_ORBIT),
    Column("splitting", "number",
           "action of the reverse minus that of the word, in the same field; 2 kappa A to first order",
           "radius", "", "the word or its reverse is no orbit"),
    Column("elliptic", "integer", "number of orbits that are stable, |tr M| < 2; they are among N_c"),
]  # fmt: skip
"""Further columns of `field`, which computes everything in doubles, without error bounds."""

OF_LIVES = [
    Column("word", "text", "representative of the symmetry class"),
    Column("born", "number", "value of a at which the class becomes an orbit as a grows", "radius",
           "born_error", "an orbit from a = 0 on"),
    Column("born_error", "number", "bound on the error of born", "radius", "itself"),
    Column("dies", "number", "value of a at which the class next ceases to be an orbit", "radius",
           "dies_error", "never dies"),
    Column("dies_error", "number", "bound on the error of dies", "radius", "itself", "never dies"),
]  # fmt: skip
"""Columns of the view ``life``, which describe a range of a in which a class is an orbit."""

OF_BOUNDS = [
    Column(
        "edges",
        "integer",
        "number of edges of the longest windows examined; a window is a piece of a path, and an edge leads "
        "from one bounce to the next",
    ),
    Column("lower", "number", "proved lower bound on the topological entropy per bounce", "1", "proved"),
    Column("upper", "number", "proved upper bound on the topological entropy per bounce", "1", "proved"),
    Column("estimate", "number", "middle of the two bounds, which is not proved", "1"),
    Column("windows", "integer", "number of windows examined; mirror images and reversals count as one"),
    Column("undecided", "integer", "how many of the longest windows are still undecided"),
    Column("arithmetic", "text", "arithmetic of the proof; 'doubles' (with error bounds) or 'balls'"),
]
"""Columns of `bounds`, which describe the entropy at one value of a."""

OF_ENSEMBLES = [
    Column("lambda_d", "number", "lambda per bounce, averaged over random trajectories", "1"),
    Column("lambda_d_error", "number", "standard error of lambda_d", "1"),
    Column("lambda_c", "number", "lambda per unit length, averaged over random trajectories", "1/radius"),
    Column("lambda_c_error", "number", "standard error of lambda_c", "1/radius"),
    Column("mean_free_path", "number", "mean distance between successive bounces", "radius"),
    Column("mean_free_path_error", "number", "standard error of mean_free_path", "radius"),
    Column("bounces", "integer", "total number of bounces"),
    Column("groups", "integer", "number of independent starts"),
    Column("seed", "integer", "seed of the random numbers"),
]
"""Columns of `simulate`, which describe averages over random trajectories."""

OF_ESCAPE = [
    Column("n", "integer", "number of bounces"),
    Column("t", "integer", "time, at speed 1", "radius"),
    Column("legs", "integer", "number of crossings from one semicircle to the other"),
    Column("survival", "number", "share of the trajectories that have not escaped by then", "1", "error"),
    Column("error", "number", "standard error of survival", "1"),
    Column("tail", "number", "limit of survival for large n or t; derived, but not proved", "1",
           empty="by legs"),
    Column("measure", "number", "open share of the perimeter, mu", "1", "exact"),
    Column("c1", "number", "constant of c1/n, the tail of survival; derived, but not proved", "1"),
    Column("c2", "number", "constant of c2/n^2, the second part of the tail", "1"),
    Column("d1", "number", "constant of d1/t, the tail in time; derived, but not proved", "radius"),
    *(column for each, unit in (("leg", "1"), ("time", "1/radius"), ("bounce", "1")) for column in (
        Column(f"rate_{each}", "number", f"escape rate per {each}", unit, f"rate_{each}_error",
               "not defined"),
        Column(f"rate_{each}_error", "number", f"estimated error of rate_{each}", unit,
               empty="not defined"))),
    Column("n_tail", "number", "number of bounces from which the tail is larger than the exponential", "1",
           empty="no rate or no tail"),
    Column("t_tail", "number", "time from which the tail is larger than the exponential", "radius",
           empty="no rate or no tail"),
    Column("opening", "text", "openings of the boundary, separated by blanks", empty="only patterns"),
    Column("without", "text", "patterns of symbols, separated by blanks", empty="only openings"),
    Column("trajectories", "integer", "number of random trajectories; 0 for rates alone"),
    Column("bounces", "integer", "number of bounces up to which the trajectories were followed"),
    Column("seed", "integer", "seed of the random numbers"),
]  # fmt: skip
"""Columns of `escape`."""

GROUPS = (
    ("word", OF_WORDS),
    ("orbit", OF_ORBITS),
    ("computed", COMPUTED),
    ("bounce", OF_BOUNCES),
    ("answer", OF_ANSWERS),
    ("trajectory", OF_TRAJECTORIES),
    ("length", OF_LENGTHS),
    ("level", OF_LEVELS),
    ("statistics", OF_STATISTICS),
    ("spectrum", OF_SPECTRA),
    ("table", OF_COUNTS),
    ("field", OF_FIELD),
    ("life", OF_LIVES),
    ("entropy", OF_BOUNDS),
    ("simulation", OF_ENSEMBLES),
    ("escape", OF_ESCAPE),
)
"""Every group of columns, with the name of what they describe."""

EVERY = {column.name: column for _, group in reversed(GROUPS) for column in group}
"""All columns by name; if a name occurs in several groups, the first group's column is used."""


def kind_of(name: str) -> str:
    """Return the kind of a column; an unknown column is assumed to be a number."""
    return EVERY[name].kind if name in EVERY else "number"
