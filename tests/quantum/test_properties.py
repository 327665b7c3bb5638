"""Cells, windows, Weyl's law and peaks compared with their definitions, for any a, parity and range."""

import math
from collections import Counter
from contextlib import nullcontext
from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st

from orbitdb import InputError, Stadium, levels, weyl_number
from orbitdb.quantum.bouncing_balls import family, family_count, family_terms
from orbitdb.quantum.elements import grid, nodes, quarter_disc, quarter_stadium
from orbitdb.quantum.exact_levels import LevelTask, LevelWindow, level_tasks, ranges_not_stored
from orbitdb.quantum.length_spectrum import SPECTRUM_COLUMNS, Spectrum, of_terms, peak_of_each
from orbitdb.quantum.trace_formula import Terms
from orbitdb.quantum.weyl import Parity, check_levels, wavenumber, weyl

PARITIES = st.sampled_from([None, *Parity])
EDGE = np.linspace(0, 1, 200)


def outline(cell) -> list[np.ndarray]:
    """Return the four edges of a cell, in order around the cell, each as a chain of points."""
    nothing, whole = np.zeros(200), np.ones(200)
    sides = ((EDGE, nothing), (whole, EDGE), (EDGE[::-1], whole), (nothing, EDGE[::-1]))
    return [cell.points(s, t) for s, t in sides]


@pytest.mark.parametrize(("a", "size", "layers"), [(1.6, 0.35, 2), (0.05, 0.2, 1), (3.0, 2.0, 3)])
def test_cells_fill_the_quarter_and_share_entire_edges(a, size, layers):
    cells = [outline(cell) for cell in quarter_stadium(a, size, layers)]
    ends: Counter[tuple[tuple[float, ...], ...]] = Counter()
    area, lengths = 0.0, []
    for sides in cells:
        x, y = np.concatenate(sides).T
        own = (x * np.roll(y, -1) - y * np.roll(x, -1)).sum() / 2
        area += abs(own)  # the lower part of the disc is mirrored
        for side in sides:
            ends[tuple(sorted(tuple(at) for at in side[[0, -1]].round(9).tolist()))] += 1
            lengths.append(np.hypot(*np.diff(side, axis=0).T).sum())
    assert area == pytest.approx(a + math.pi / 4, abs=1e-5)
    for (one, other), count in ends.items():
        middle = np.add(one, other) / 2
        on_axis = not middle.all()
        on_wall = all(abs(math.hypot(max(x - a, 0.0), y) - 1) < 1e-8 for x, y in (one, other))
        assert count == (1 if on_axis or on_wall else 2)
    joint = np.array([a, 1.0])
    places = np.array([side[0] for sides in cells for side in sides])
    plain = np.array([side[0] for cell in quarter_stadium(a, size, 0) for side in outline(cell)])
    nearest, undivided = (np.unique(np.hypot(*(at - joint).T).round(9))[1] for at in (places, plain))
    assert nearest == pytest.approx(0.15**layers * undivided, rel=1e-6)
    on_floor = np.unique(places[(places[:, 1] == 0) & (places[:, 0] <= a), 0].round(9))
    assert np.diff([*on_floor]).max() <= min(size, 1.0) + 1e-9
    assert max(lengths) < max(1.7 * min(size, 0.4), min(size, 1.0) + 1e-9)


@pytest.mark.parametrize("order", [6, 18, 20])
def test_derivatives_are_those_at_the_nodes_as_rounded(order):
    """Compared with fractions. The derivatives of nodes that are slightly off would shift the levels."""
    rounded, _, matrix = nodes(order)
    x = [Fraction(each) for each in rounded.tolist()]
    products = [math.prod(one - other for other in x if other != one) for one in x]
    exact = [
        [float(products[i] / products[j] / (x[i] - x[j])) if i != j else matrix[i, i] for j in range(len(x))]
        for i in range(len(x))
    ]
    np.testing.assert_allclose(matrix, exact, rtol=4e-15)


def test_functions_have_the_right_energy_and_mass():
    """The exact integrals of f^2 and |grad f|^2 are over a quarter disc around (0.3, 0), where r is 0."""
    made = grid(quarter_disc(0.3, 0.5), 10)
    assert made.energy(np.ones((1, *made.node.shape))).sum() < 1e-20
    x, y = np.moveaxis(made.points - [0.3, 0.0], -1, 0)
    for f, mass, energy in (
        (x, math.pi / 16, math.pi / 4),
        (y, math.pi / 16, math.pi / 4),
        (x * y, math.pi / 96, math.pi / 8),
        (x**2 - y**2, math.pi / 24, math.pi / 2),
        (3 * x**2 * y - y**3, math.pi / 32, 3 * math.pi / 4),
    ):
        assert (made.weight * f**2).sum() == pytest.approx(mass, rel=1e-7)
        assert made.energy(f[None]).sum() == pytest.approx(energy, rel=1e-7)


@given(a=st.floats(0.05, 20), parity=PARITIES, number=st.floats(5, 20_000))
def test_weyls_law_adds_up_edges_and_corners(a, parity, number):
    """Walls and odd axes are Dirichlet edges, even axes are Neumann edges. A corner joins two edges."""
    smooth, stadium = weyl(Stadium(a), parity), Stadium(a)
    if parity is None:
        area, edge, constant = 4 * a + math.pi, 4 * a + 2 * math.pi, 1 / 6
    else:
        on_y, on_x = (-1 if letter == "e" else 1 for letter in str(parity))  # the axes x = 0 and y = 0
        area, edge = a + math.pi / 4, a + math.pi / 2 + on_y + on_x * (a + 1)
        constant = 1 / 24 + (on_y + on_x * on_y + on_x) / 16
    at = np.array([0.0, 1.0, 30.0])
    np.testing.assert_allclose(
        smooth(at), constant - edge * at / (4 * math.pi) + area * at**2 / (4 * math.pi)
    )
    assert smooth(wavenumber(smooth, number)) == pytest.approx(number, rel=1e-9)
    assert stadium.area == pytest.approx(4 * a + math.pi)


@given(a=st.floats(0.05, 20), parity=st.sampled_from(list(Parity)), low=st.floats(3, 30),
       whole=st.integers(1, 3), rest=st.floats(0.1, 47.9))  # fmt: skip
@example(1.6, Parity.OE, 5.0, 2, 11.9)
@example(1.6, Parity.OE, 5.0, 2, 12.1)
def test_windows_cut_a_range_evenly(a, parity, low, whole, rest):
    """Each window has 48 levels by Weyl's law; a remainder of at least 12 levels is a separate window."""
    smooth = weyl(Stadium(a), parity)
    first = max(smooth(low), 0.0)
    high = wavenumber(smooth, first + 48 * whole + rest)
    assume(abs(rest - 12) > 0.01)
    found = list(level_tasks(Stadium(a), parity, low, high))
    assert all((each.a, each.parity) == (a, parity) for each in found)
    assert [each.low for each in found] == [low, *(each.high for each in found[:-1])]
    assert found[-1].high == high
    sizes = [smooth(each.high) - max(smooth(each.low), 0.0) for each in found]
    expected = [48] * whole + [rest] if rest > 12 else [48] * (whole - 1) + [48 + rest]
    assert sizes == pytest.approx(expected, abs=1e-6)


ENDS = st.floats(0, 9)


@given(cuts=st.lists(ENDS, max_size=9, unique=True).map(sorted), low=ENDS, high=ENDS)
@example([1.0, 2.0, 3.0], 1.0, 2.0)
@example([1.0, 2.0], 2.0, 3.0)
@example([1.0, 2.0], 0.0, 1.0)
def test_missing_levels_are_in_the_ranges_that_no_window_covers(cuts, low, high):
    """Every other interval between cuts, and the last interval, is a window."""
    none = np.zeros(0)
    windows = [pair for n, pair in enumerate(pairwise(cuts)) if n % 2 == 0 or n == len(cuts) - 2]
    known = [LevelWindow(1.6, Parity.EE, *window, 0, none, none, 0.0) for window in windows]
    found = list(ranges_not_stored(known, low, high))
    assert all(one < other for one, other in found)
    for one, other in pairwise(sorted({*cuts, low, high})):
        missing = low <= one < high and (one, other) not in windows
        covered = any(window[0] <= one and other <= window[1] for window in windows)
        assert any(gap[0] <= one and other <= gap[1] for gap in found) == (missing and not covered)


@pytest.mark.parametrize("parity", Parity)
def test_levels_are_between_those_of_two_rectangles(parity):
    """One rectangle is inside the quarter, the other around it; a Dirichlet function can be extended by 0."""
    found = LevelTask(1.3, parity, 3.0, 6.0).solved(8, 1)
    number, k = found.below, found.k
    quarters = np.array([0.5 if letter == "e" else 1.0 for letter in str(parity)])
    m = np.stack(np.meshgrid(range(20), range(20)), axis=-1) + quarters
    above, below = (np.sort(np.hypot(*(m * math.pi / [width, 1]).reshape(-1, 2).T)) for width in (1.3, 2.3))
    assert len(k) >= 3
    assert (above < 3).sum() <= number <= (below < 3).sum()
    assert (above < 6).sum() <= number + len(k) <= (below < 6).sum()
    own = slice(number, number + len(k))
    assert (below[own] <= k).all()
    assert (k <= above[own]).all()


@given(a=st.floats(0.05, 20), parity=PARITIES, k_max=st.floats(5, 100))
def test_bouncing_ball_terms_are_right_in_the_middle_of_the_window(a, parity, k_max):
    k, longest = np.array([k_max / 2]), 22.0
    terms, waves = (
        family_terms(Stadium(a), (0.0, k_max), longest, parity),
        family(Stadium(a), k, longest, parity),
    )
    once = 4 if parity is None else 2  # up and down, in the whole or a quarter
    assert terms.length.tolist() == [*range(once, 23, once)]
    assert terms.repetitions.tolist() == [*range(1, len(terms.length) + 1)]
    assert set(terms.orbit) == {-1}
    turning = terms.amplitude * np.exp(1j * k * terms.length)
    np.testing.assert_allclose(turning, [wave[0] for _, wave in waves], rtol=1e-9)
    if parity is None:
        behind = family_count(Stadium(a), k, longest)[0]
        assert behind == pytest.approx((turning.imag / terms.length).sum(), rel=1e-9, abs=1e-12)


@pytest.fixture
def terms():
    rng = np.random.default_rng(5)
    amplitude = rng.uniform(0.5, 3, 40) * np.exp(1j * rng.uniform(0, 6, 40))
    return Terms(rng.uniform(2, 12, 40), amplitude, rng.integers(-1, 9, 40), rng.integers(1, 4, 40),
                 rng.integers(1, 3, 40), rng.integers(0, 9, 40), rng.uniform(1, 9, 40))  # fmt: skip


@pytest.mark.parametrize("levelled", [True, False])
def test_peaks_are_all_maxima_with_their_strongest_terms(terms, levelled):
    x = np.linspace(2, 12, 500)
    orbits = of_terms(terms, x, 0.0, 30.0)
    found = Spectrum(
        1.6,
        None,
        0.0,
        30.0,
        x,
        orbits,
        0.9 * orbits if levelled else None,
        9.0,
        terms,
        np.arange(9).astype(str),
    )
    height = np.abs(orbits) * (0.9 if levelled else 1)
    tops = [
        n
        for n in range(1, 499)
        if height[n - 1] < height[n] >= height[n + 1] and height[n] > height.max() / 20
    ]
    expected = []
    for n in tops:
        near = [j for j in range(40) if abs(terms.length[j] - x[n]) < 2 * math.pi / 30]
        alone = {j: abs(peak_of_each(terms.rows(np.array([j])), x[n : n + 1], 0.0, 30.0)[0, 0]) for j in near}
        for j in sorted(near, key=lambda j: -alone[j])[:2]:
            code = "02" if terms.orbit[j] < 0 else str(terms.orbit[j])
            expected.append(
                (x[n], height[n], code, terms.repetitions[j] / terms.parts[j], terms.length[j], alone[j])
            )
    peaks = list(found.peaks(2))
    assert len(peaks) == len(expected) > 5
    for peak, row in zip(peaks, expected, strict=True):
        assert (peak.code, peak.repetitions) == row[2:4]
        assert (peak.length, peak.height, peak.total, peak.strength) == pytest.approx((*row[:2], *row[4:]))
    assert found.misfit == (pytest.approx(1 / 9) if levelled else None)
    values = found.rows()[3]
    parts = (orbits[3].real, orbits[3].imag)
    assert values == pytest.approx((x[3], *(0.9 * np.array(parts) if levelled else (None, None)), *parts))
    assert [name for name, value in zip(SPECTRUM_COLUMNS, values, strict=True) if value is None] == (
        [] if levelled else ["quantum_re", "quantum_im"]
    )


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (lambda k: k, None),
        (lambda k: k[:10], None),
        (lambda k: np.insert(k, 7, k[7]), None),  # two levels may coincide
        (lambda k: k[:9], "only 9 levels"),
        (lambda k: np.where(k == k[3], np.inf, k), "above 0"),
        (lambda k: np.where(k == k[3], np.nan, k), "above 0"),
        (lambda k: k - k[0], "above 0"),
        (lambda k: k - 2 * k[0], "above 0"),
        (lambda k: k[[0, 1, 3, 2, *range(4, 60)]], None),
        (lambda k: 1.6 * k, "Weyl's law"),
        (lambda k: k / 1.3, "Weyl's law"),
    ],
)
@pytest.mark.parametrize("parity", [None, Parity.OE])
def test_lists_that_contradict_weyls_law_are_refused(parity, change, told):
    smooth = weyl(Stadium(1.6), parity)
    k = change(np.array([wavenumber(smooth, n) for n in range(1, 61)]))
    with nullcontext() if told is None else pytest.raises(InputError, match=told) as refused:
        assert (check_levels(k, Stadium(1.6), parity) == np.sort(k)).all()
    if told == "Weyl's law":
        of = "all parities" if parity is None else "parity oe"
        assert f" of {of} at a = 1.6" in str(refused)


def test_weyl_number_counts_computed_levels():
    """The smooth number lies within a few of the number of levels, and the four parities add up to all."""
    k = np.array([4.0, 8.0])
    for parity in "ee", "oo":
        found = levels(1.0, (0, 8), parity).k
        assert np.abs(np.searchsorted(found, k) - weyl_number(k, 1, parity)).max() < 2
    of_parities = sum(weyl_number(k, 1, parity) for parity in ("ee", "eo", "oe", "oo"))
    assert of_parities == pytest.approx(weyl_number(k, 1))
    area, perimeter = 4 + np.pi, 4 + 2 * np.pi
    assert weyl_number(8, 1) == pytest.approx((area * 64 - perimeter * 8) / (4 * np.pi) + 1 / 6)


@pytest.mark.parametrize("k", [-1, float("nan"), [1, float("inf")], "many"])
def test_weyl_number_refuses_what_is_no_wavenumber(k):
    with pytest.raises(InputError, match="k"):
        weyl_number(k, 1)
