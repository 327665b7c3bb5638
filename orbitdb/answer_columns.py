"""The columns of answers that are not rows of the catalogue, grouped by what they describe."""

from orbitdb.column import NO_ORBIT, PLACE, Column

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
    Column("number", "integer", "position of a stored level among those of its parity; counted from 1"),
    Column("error", "number", "estimated error of k", "1/radius"),
    Column("exact", "number",
           "stored level with the same number; for comparison with the level computed from orbits",
           "1/radius", empty="not stored"),
    Column("after", "number", "last level of the list below a gap; levels are missing or spurious there",
           "1/radius", empty="at the beginning of the list"),
    Column("before", "number", "first level of the list above the gap", "1/radius",
           empty="at the end of the list"),
    Column("missing", "integer",
           "number of levels missing between the two; negative if levels are spurious or duplicated"),
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
    Column("levels", "integer", "number of levels", empty="for random matrices and random numbers"),
    Column("gap_ratio", "number", "mean ratio of neighbouring gaps, the smaller to the larger", "1",
           "gap_ratio_error"),
    Column("gap_ratio_error", "number", "standard error of gap_ratio", "1",
           empty="for random matrices and random numbers"),
    Column("spacing_variance", "number", "variance of the unfolded spacings, whose mean is 1", "1"),
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
    Column("height", "number", "|F| at a peak; from the levels if there are any, otherwise from orbits", "1"),
]  # fmt: skip
"""Columns of `spectrum`, for lengths and for peaks."""

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

OF_LIVES = [
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
        "window", "integer", "length of the longest windows examined, in edges; windows are pieces of a path"
    ),
    Column("lower", "number", "proved lower bound on the topological entropy per bounce", "1", "proved"),
    Column("upper", "number", "proved upper bound on the topological entropy per bounce", "1", "proved"),
    Column("windows", "integer", "number of windows examined; mirror images and reversals count as one"),
    Column("undecided", "integer", "how many of the longest windows are still undecided"),
    Column("proof", "text", "arithmetic of the proof; 'doubles' (with error bounds) or 'balls'"),
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
