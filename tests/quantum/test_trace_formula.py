"""The trace formula: parities add up to all levels, and the length spectrum of levels shows the orbits."""

import math

import numpy as np
import pytest
from contents import alter, answer
from there import there

from orbitdb import Catalogue, InputError, Stadium, solve_word
from orbitdb.answers.stadium_levels import read_orbits
from orbitdb.billiard.stability import bounce_matrices
from orbitdb.orbits.least_values import least_exponent, least_length
from orbitdb.quantum.bouncing_balls import edges, family
from orbitdb.quantum.exact_levels import levels
from orbitdb.quantum.length_spectrum import TERMS, of_family, of_levels, of_terms
from orbitdb.quantum.trace_formula import largest_amplitude, orbit_terms
from orbitdb.quantum.weyl import Parity
from orbitdb.selection import Selection
from orbitdb.symbols.words import from_strings, least_rotation
from orbitdb.text import upwards

X = np.linspace(9.5, 11.7, 60)


@pytest.fixture
def catalogue(filled):
    return Catalogue(filled)


@pytest.fixture
def classes(catalogue):
    return answer(catalogue.path, read_orbits, Selection(1.6))[0]


def test_terms_of_the_four_parities_add_up_to_those_of_all_levels(classes):
    longest = 24.0
    assert len(set(classes.symmetry)) > 5
    x = np.linspace(9.5, 20.0, 80)
    whole = of_terms(orbit_terms(classes, longest), x, 0.0, 25.0)
    parts = sum(of_terms(orbit_terms(classes, longest, parity), x, 0.0, 25.0) for parity in Parity)
    np.testing.assert_allclose(parts, whole, atol=1e-10 * np.abs(whole).max())


def test_terms_are_amplitudes_of_single_orbits(catalogue):
    classes, _ = answer(catalogue.path, read_orbits, Selection(1.6))
    codes = there(classes.representative)
    terms, k = orbit_terms(classes, 24.0), 7.3
    waves = (terms.amplitude * np.exp(1j * k * terms.length)).real
    assert set(terms.repetitions) == {1, 2}
    assert set(terms.repetitions * classes.maslov[terms.orbit] % 4) == {0, 1, 2, 3}
    for wave, n, times in [*zip(waves, terms.orbit, terms.repetitions.tolist(), strict=True)][::5]:
        single = catalogue[codes[n]].amplitude(k, times)
        assert wave == pytest.approx(classes.words[n] * single, abs=1e-12)


@pytest.mark.parametrize("parity", [None, "oe"])
def test_a_spectrum_covers_the_given_range_and_says_where_it_is_complete(catalogue, parity):
    found = catalogue.spectrum((9.0, 16.0), resolution=9, k=20.0, parity=parity)
    assert found.length.tolist() == np.linspace(9, 16, 9).tolist()
    assert (found.k_max, found.parity, found.quantum) == (20.0, parity, None)
    assert found.complete_length == least_length(8, 1.6) / (1 if parity is None else 2)
    assert f"up to length {math.floor(found.complete_length * 100) / 100:.2f};" in found.notes()[0]
    frame = found.to_pandas()
    assert frame["length"].tolist() == found.length.tolist()
    assert frame["orbits_re"].tolist() == found.orbits.real.tolist()
    assert frame["quantum_re"].isna().all()
    of = "" if parity is None else f", parity='{parity}'"
    assert f"`catalogue.fill_levels(k=30, a=1.6{of})`" in found.notes()[-1]


def test_a_spectrum_is_complete_up_to_the_first_unfinished_period(own):
    for p, change in ((4, "unresolved = 1"), (3, "state = 'filling'")):
        alter(own, f"UPDATE fill SET {change} WHERE p = {p}")
        assert answer(own, read_orbits, Selection(1.6))[1] == p - 1


def test_a_spectrum_without_orbits_names_the_method_that_fills_them(catalogue):
    with pytest.raises(InputError, match=r"`catalogue\.fill\(p=11, a=3\)` finds some"):
        catalogue.spectrum((3, 4), a=3)


LIMITS = [
    ("lengths", [(0, 1), (99, 100)], [(-1e-9, 1), (99, 100.1), (2, 2), (3, 2), (1, 2, 3), (math.nan, 2)]),
    ("resolution", [2], [1, 100_001]),
    ("k", [1, (0, 3)], [0.999, 2000.1, math.nan, (3, 2), (1, 3), (0, 1, 2)]),
    ("parity", ["ee", "oo"], ["", "xx"]),
]


@pytest.mark.parametrize(("name", "inside", "outside"), LIMITS)
def test_options_of_a_spectrum_have_limits(catalogue, name, inside, outside):
    usual = {"lengths": (3, 4), "resolution": 3, "k": 3.0}
    for value in inside:
        catalogue.spectrum(**usual | {name: value})
    for value in outside:
        with pytest.raises(InputError):
            catalogue.spectrum(**usual | {name: value})


def test_peaks_name_orbits_of_their_length(catalogue):
    found = catalogue.spectrum((9.0, 16.0))
    peaks = [peak for peak in found.peaks(3) if peak.code != "02"]
    assert len({peak.length for peak in peaks}) > 3
    for peak in peaks:
        assert peak.total == pytest.approx(peak.repetitions * catalogue[peak.code].length)
        assert abs(peak.length - peak.total) < 2 * math.pi / found.k_max
    assert found.k_max == 30.0  # the default without levels


def test_bouncing_balls_of_the_four_parities_add_up_to_those_of_all_levels():
    stadium, k = Stadium(0.7), np.linspace(2, 9, 50)
    parts = sum(_density(family(stadium, k, 20.0, parity)) for parity in Parity)
    np.testing.assert_allclose(parts, _density(family(stadium, k, 20.0)), atol=1e-12)


def _density(balls):
    return sum(wave.real for _, wave in balls)


def test_a_peak_is_the_transform_of_its_cosine(classes):
    terms = orbit_terms(classes, 14.0)
    some = terms.rows(np.arange(3))
    k, weights = np.polynomial.legendre.leggauss(800)
    k, weights = (k + 1) * 10, weights * 10
    density = (some.amplitude * np.exp(1j * k[:, None] * some.length)).real.sum(axis=1)
    window = weights * np.sin(math.pi * k / 20) ** 4
    known = np.exp(1j * X[:, None] * k) @ (window * density)
    np.testing.assert_allclose(of_terms(some, X, 0.0, 20.0), known, atol=1e-9)


@pytest.mark.parametrize("times", [1, 2, 3])
def test_edge_corrections_are_traces_of_a_map_with_half_a_parabola(times):
    """The traces are those of matrices on a grid with a soft edge, extrapolated to a hard edge."""

    def trace(soft):
        reach = math.sqrt(18 / soft)
        step = 0.9 * math.pi / reach
        s = step * (np.arange(-round(reach / step), round(reach / step)) + 0.5)
        drift = np.exp(0.25j * (s[:, None] - s) ** 2 - soft * s**2) * step / np.sqrt(4j * math.pi)
        kicked = drift * np.exp(-1j * s**2 * (s > 0))
        return sum(
            sign * np.trace(np.linalg.matrix_power(each, times))
            for sign, each in ((1, kicked), (-0.5, drift))
        )

    rough, fine = trace(0.08), trace(0.04)
    assert abs(2 * fine - rough - edges(8)[times - 1]) < 3e-3


def test_edge_corrections_have_the_two_known_values():
    first, second = edges(2)
    assert first == pytest.approx(-0.25j, abs=1e-12)
    real = -1 / (2 * math.pi) + math.sqrt(2) * math.log(1 + math.sqrt(2)) / (4 * math.pi)
    assert second == pytest.approx(real - 0.125j * math.sqrt(2), abs=1e-12)


def test_edge_corrections_vary_smoothly_with_the_repetitions_and_do_not_end():
    some, many = edges(8), edges(50)
    np.testing.assert_allclose(many[:8], some, atol=1e-11)  # another range of the quadrature
    rise = np.diff(many)
    for part in (-rise.real, rise.imag):
        assert (part > 0).all()
        assert (np.diff(part) < 0).all()
        assert (part[2:] / part[1:-1] > 0.5).all()
    amplitude = [abs(wave[0]) for _, wave in family(Stadium(1.6), np.array([30.0]), 40.0, Parity.OO)]
    assert (np.diff(amplitude) < 0).all()  # no jump at length 18


@pytest.mark.slow
def test_levels_show_the_orbits_and_the_bouncing_balls(catalogue):
    every = levels(1.6, 16.0)
    found = {parity: every.k[every.parity == str(parity)] for parity in Parity}
    k, stadium = every.k, Stadium(1.6)
    shown = catalogue.spectrum((9.5, 11.2), resolution=60, levels=k)
    assert shown.misfit < 0.2
    for parity, part in found.items():
        assert catalogue.spectrum((3.4, 5.0), resolution=40, levels=part, parity=str(parity)).misfit < 0.04
    at = np.array([4.0])
    balls = of_family(stadium, at, 0.0, 16.0)
    assert abs(of_levels(k, at, 0.0, 16.0, stadium) - balls)[0] < 0.02 * abs(balls[0])
    (strongest,) = catalogue.spectrum((3.0, 5.0), levels=k).peaks(1)
    assert strongest.code == "02"
    assert strongest.strength == pytest.approx(strongest.height, rel=0.02)


WORDS = ["13", "1232131", "0103155", "1155", "013", "0201232", "11335"]


def _foci(word: str, a: float) -> int:
    """Follow a wavefront bounce by bounce; return the number of foci in one traversal of the orbit."""
    points = there(solve_word(word, a).points)
    path = np.roll(points, -1, axis=0) - points
    distance = np.hypot(*path.T)
    curvature, foci = 0.5, 0
    for bounce in range(40 * len(word)):
        n = bounce % len(word)
        if word[n] in "1345":
            centre = np.array([math.copysign(a, points[n, 0]), 0.0])
            cosine = abs((points[n] - centre) @ path[n]) / distance[n]
            curvature -= 2 / cosine
        behind = 1 + curvature * distance[n]
        foci += behind < 0 and bounce >= 39 * len(word)
        curvature /= behind
    return foci


@pytest.mark.parametrize("word", WORDS)
@pytest.mark.parametrize("a", [0.8, 1.6])
def test_the_maslov_index_is_the_number_of_foci_plus_two_per_bounce(word, a):
    orbit = solve_word(word, a)
    if orbit.coordinates is None:
        assert orbit.amplitude(10.0) is None
    else:
        assert orbit.maslov == 2 * len(word) + _foci(word, a)


@pytest.mark.parametrize("word", ["13", "013", "0103155"])
@pytest.mark.parametrize("repetitions", [1, 2, 3])
def test_the_amplitude_follows_from_the_monodromy_matrix(word, repetitions):
    orbit, k = solve_word(word, 1.6), 7.3
    length = there(orbit.length)
    matrices = bounce_matrices(Stadium(1.6), from_strings([word]), there(orbit.coordinates)[None])[0]
    whole = np.eye(2)
    for matrix in matrices:
        whole = matrix @ whole
    root = math.sqrt(abs(2 - np.trace(np.linalg.matrix_power(whole, repetitions))))
    phase = repetitions * (k * length - there(orbit.maslov) * math.pi / 2)
    assert orbit.amplitude(k, repetitions) == pytest.approx(length * math.cos(phase) / math.pi / root)


def test_an_amplitude_needs_at_least_one_repetition():
    with pytest.raises(ValueError, match="1 or more"):
        solve_word("13", 1.6).amplitude(3.0, 0)


def test_the_terms_of_a_quarter_stadium_have_half_lengths_and_signs(tmp_path):
    catalogue = Catalogue.create(tmp_path / "orbits.db", 1.0)
    catalogue.fill("2-6")
    spectrum = catalogue.spectrum((0, 5.1), resolution=2, parity="oo")
    rows = spectrum.term_rows()
    assert {len(row) for row in rows} == {len(TERMS)}
    first = {code: (times, index, sign) for code, _, times, _, _, index, sign, *_ in reversed(rows)}
    assert first["0123"] == (1, 5, 1)  # half is closed by the half turn
    assert first["0103"] == (1, 5, -1)  # half is closed by a mirror
    assert [row[6] for row in rows if row[:3] == ("13", 2, 1)] == [-1, 1]  # on the axis, one for each side
    lengths = {row[0]: row[3] for row in rows if row[2] == 1}
    assert lengths["011255"] == pytest.approx(4.889431983, abs=1e-9)
    assert [row[0] for row in rows[-2:]] == ["02", "02"]
    assert rows[-1][4:7] == (None, None, None)
    for code, p, times, length, lyapunov, index, sign, real, imaginary in rows[:-2]:
        amplitude = complex(real, imaginary)
        assert amplitude == pytest.approx(sign * abs(amplitude) * (-1j) ** index)
        orbit = catalogue[code]
        assert (p, index) == (len(code), times * there(orbit.quarter_maslov))
        assert length == pytest.approx(times * there(orbit.quarter_length))
        assert lyapunov == pytest.approx(times * there(orbit.quarter_lyapunov))
        roots = [2 * root(lyapunov / 2) for root in (math.sinh, math.cosh)]
        weights = [length / times / math.pi / each for each in roots]
        assert min(abs(abs(amplitude) - each * share) for each in weights for share in (1, 0.5)) < 1e-12
    of_0123 = next(complex(*row[-2:]) for row in rows if row[0] == "0123")
    assert abs(of_0123) == pytest.approx(0.450158, abs=1e-6)


@pytest.mark.parametrize("r", [1, 2, 3])
@pytest.mark.parametrize("parity", [*Parity])
def test_an_own_trace_formula_is_a_line_over_the_columns_of_the_quarter(catalogue, classes, parity, r):
    """Each class is one orbit of the quarter; only 13, on an axis, has terms of another kind."""
    c, k = catalogue.select(status="orbit", where="representative <> '13'", classes=True), 7.3
    sign, length, half = c.quarter_signs[:, [*Parity].index(parity)], c.quarter_length, c.quarter_lyapunov / 2
    odd = (c.quarter_maslov + c.p // np.where(c.half == "", 1, 2) + np.isin(c.half, ["x", "y"])) % 2
    root = np.where(r * odd % 2, np.cosh(r * half), np.sinh(r * half))
    phase = r * (k * length - c.quarter_maslov * np.pi / 2)
    own = c.quarter_orientations * sign**r * length / (2 * np.pi * root) * np.cos(phase)

    terms = orbit_terms(classes, 999.0, parity)
    terms = terms.rows(terms.repetitions == r)
    codes = there(classes.representative)[terms.orbit]
    density = (terms.amplitude * np.exp(1j * k * terms.length)).real
    known = dict(zip(codes.tolist(), density.tolist(), strict=True))
    np.testing.assert_allclose(
        own, [known[code] for code in c.representative.tolist()], rtol=1e-9, atol=1e-15
    )
    assert len(c) == len(known) - 1 > 200


def test_the_signs_and_orientations_of_an_orbit_are_those_of_its_row(catalogue):
    names = ("code", "quarter_signs", "quarter_orientations", "reverse")
    for code, signs, orientations, reverse in catalogue.rows(p="2-5", status="orbit", columns=names):
        orbit = catalogue[code]
        assert (orbit.quarter_signs, orbit.quarter_orientations) == (signs, orientations)
        assert reverse == least_rotation(orbit.reverse().code)
        assert orientations == 1 or orbit.time_reversal == "pair"
        assert (reverse == code) == (orbit.time_reversal == "self")


@pytest.mark.parametrize("parity", [None, *Parity])
def test_terms_of_longer_periods_are_below_the_bound_on_what_may_be_missing(filled, classes, parity):
    """Those of periods 6 to 8 are to a catalogue of periods 2 to 5 what it may lack."""
    new = classes.rows(classes.p > 5)
    terms = orbit_terms(new, 16.0, parity)
    bound = largest_amplitude(least_exponent(5, 1.6), 16.0, parity)
    assert bound / 30 < np.abs(terms.amplitude).max() <= bound
    found = Catalogue(filled).spectrum((9.0, 16.0), parity=parity)
    assert found.missing == largest_amplitude(least_exponent(8, 1.6), 16.0, parity)
    assert f"an amplitude of at most {float(upwards(found.missing)):g} up to length 16" in found.notes()[0]
