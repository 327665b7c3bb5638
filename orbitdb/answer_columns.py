"""The columns of answers other than rows of the catalogue, by what they describe."""

from orbitdb.column import NO_ORBIT, PLACE, Column

OF_BOUNCES = [
    Column("n", "integer", "number of the bounce; from 1, in the order of the code"),
    Column("symbol", "integer", "the wall that is hit; 0 bottom, 2 top, 1 and 4 left, 3 and 5 right"),
    Column("coordinate", "number",
           "the bounce on its wall; x on a straight wall, from -a to a, on a semicircle the angle from the "
           "outward horizontal, from -pi/2 to pi/2", PLACE, "error"),
    Column("x", "number", "its distance from the centre to the right", "radius", "error"),
    Column("y", "number", "its distance from the centre upwards", "radius", "error"),
    Column("arclength", "number",
           "its place along the boundary; anticlockwise from the left end of the bottom wall",
           "radius", "error"),
    Column("sine", "number",
           "sine of the angle between the path that leaves and the normal; positive where it goes "
           "anticlockwise", "1"),
]  # fmt: skip
"""Columns of a bounce; the bounds leave out the rounding of the last digit."""

OF_ANSWERS = [
    Column("coordinates", "numbers", "the coordinates of all bounces", PLACE, "error", NO_ORBIT),
    Column("stored", "yes or no", "whether it comes from the catalogue; otherwise it was solved on the spot"),
    Column("exists", "pairs",
           "the ranges of a in which the word is an orbit; null for no end", "radius", "", "unknown"),
]  # fmt: skip
"""Further columns of `query --code`; files have the coordinates on request."""

OF_TRAJECTORIES = [
    Column("first", "integer",
           "number of the first bounce that is near the orbit; 1 is the first one after a start, or the "
           "first point, 0 and less are before a start"),
    Column("last", "integer", "number of the last bounce near the orbit"),
    Column("bounces", "integer", "bounces in a row from the first to the last"),
    Column("turns", "number", "how often the bounces go round the orbit; bounces/p", "1"),
    Column("distance", "number", "least distance between one of the bounces and that of the orbit", "radius"),
    Column("sequence", "text", "symbols of all bounces of the trajectory; not a cyclic word"),
    Column("sequence_first", "integer", "number of its first bounce"),
]  # fmt: skip
"""Further columns of an orbit that a trajectory shadows (`identify`)."""

OF_LENGTHS = [
    Column("repetitions", "integer", "number of traversals, r"),
    Column("total", "number", "length of all traversals, rL", "radius"),
    Column("difference", "number", "total less the length that you asked for", "radius"),
]  # fmt: skip
"""Further columns of an orbit with a given length (`identify`)."""

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
"""Columns of `levels`, `assess` and `scars`."""

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
"""Columns of `assess --statistics`."""

OF_SPECTRA = [
    Column("quantum_re", "number",
           "real part of F at a length, of the levels; the Fourier transform of their density less the "
           "smooth one, with the window sin^4(pi k/k_max)", "1", empty="no levels"),
    Column("quantum_im", "number", "its imaginary part", "1", empty="no levels"),
    Column("orbits_re", "number", "real part of F by the trace formula; orbits and bouncing balls", "1"),
    Column("orbits_im", "number", "its imaginary part", "1"),
    Column("height", "number", "|F| at a peak; of levels if there are some, else of orbits", "1"),
]  # fmt: skip
"""Columns of `spectrum`, for lengths and peaks."""

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
    Column("born", "number", "where the class begins to be an orbit as a grows", "radius", "born_error",
           "an orbit from a = 0 on"),
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
    Column("lambda_d", "number", "lambda per bounce, mean over random trajectories", "1"),
    Column("lambda_d_error", "number", "its standard error", "1"),
    Column("lambda_c", "number", "lambda per length, mean over them", "1/radius"),
    Column("lambda_c_error", "number", "its standard error", "1/radius"),
    Column("mean_free_path", "number", "mean path between bounces", "radius"),
    Column("mean_free_path_error", "number", "its standard error", "radius"),
    Column("bounces", "integer", "total number of bounces"),
    Column("groups", "integer", "number of independent starts"),
    Column("seed", "integer", "seed of the random numbers"),
]
"""What `simulate` stores of random trajectories."""
