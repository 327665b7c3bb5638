"""Spectra judged by the orbits: levels from orbits, missing levels, and the fitted radius."""

import math
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from contents import answer
from hypothesis import given
from hypothesis import strategies as st
from there import there

from orbitdb import Catalogue, InputError
from orbitdb.answers.levels import assess_levels, levels_from_orbits, read_orbits, stored_counterparts
from orbitdb.billiard.stadium import Stadium
from orbitdb.quantum.level_numbers import MISSING, SPURIOUS, numbered, smoothed
from orbitdb.quantum.levels import levels
from orbitdb.quantum.levels_from_orbits import CUTOFFS, Staircase, staircase
from orbitdb.quantum.missing_levels import CUTOFF, WIDEST, assess
from orbitdb.quantum.trace_formula import family, orbit_terms
from orbitdb.quantum.weyl import Parity, wavenumber, weyl
from orbitdb.store.selection import Selection


@pytest.fixture(scope="module")
def catalogue(tmp_path_factory):
    """A catalogue with p = 2..10 at a = 1.6."""
    made = Catalogue.create(tmp_path_factory.mktemp("judging") / "orbits.db", 1.6)
    made.fill("2-10")
    return made


@pytest.fixture
def exact(exact_once):
    return exact_once


@pytest.fixture(scope="module")
def orbits(catalogue):
    classes, _ = answer(catalogue.path, read_orbits, Selection(1.6))
    return staircase(Stadium(1.6), classes, 16.0 * WIDEST + 0.1, Parity.OO, (CUTOFF,))


def test_the_staircase_is_the_sum_of_its_terms(catalogue):
    classes, _ = answer(catalogue.path, read_orbits, Selection(1.6))
    stadium, cutoffs = Stadium(1.6), (6.0, 9.0)
    for parity in (None, Parity.EO):
        made = staircase(stadium, classes, 30.0, parity, cutoffs)
        some = slice(None, None, 97)
        k = made.k[some]
        terms = orbit_terms(classes, 2.5 * 9, parity)
        for row, cutoff in zip(made.count, cutoffs, strict=True):
            weights = np.exp(-((terms.length / cutoff) ** 2) / 2) / terms.length
            waves = (terms.amplitude * np.exp(1j * k[:, None] * terms.length)).imag @ weights
            balls = sum(
                wave.imag / length * math.exp(-((length / cutoff) ** 2) / 2)
                for length, wave in family(stadium, k, 2.5 * 9, parity)
            )
            expected = weyl(stadium, parity)(k) + waves + balls
            np.testing.assert_allclose(row[some], expected, atol=1e-7)


@pytest.mark.parametrize("parity", [Parity.OO, pytest.param(Parity.EE, marks=pytest.mark.slow)])
def test_levels_from_orbits_agree_with_exact_levels_within_their_errors(catalogue, exact, parity):
    known = exact if parity is Parity.OO else levels(1.6, 16.0, parities=[parity]).k
    found = catalogue.levels(16.0, parity=parity, method="orbits")
    assert len(found) == len(known)
    off = np.abs(found.k - known)
    density = weyl(Stadium(1.6), parity).deriv()(known)
    assert math.sqrt(np.mean((off * density) ** 2)) < 0.15
    assert np.mean(off < found.error) >= 0.9
    assert np.median(found.error * density) < 0.5
    assert f"X = {CUTOFFS[0]:g} to" in found.basis


def test_levels_from_orbits_end_where_they_become_unreliable(catalogue):
    found = catalogue.levels(parity="oo", method="orbits")
    assert 15 < found.high < 25
    assert "above k" not in found.basis
    assert "above k = 20" in catalogue.levels(25, parity="oo", method="orbits").basis
    with pytest.raises(InputError, match="method 'magic'"):
        catalogue.levels(method="magic")


@pytest.mark.slow
def test_stored_levels_are_paired_by_number(catalogue, tmp_path):
    own = Catalogue.create(tmp_path / "orbits.db", 1.6)
    own.fill("2-8")
    own.fill_levels(5, 7, parities=["oo", "ee"])
    found = own.levels(9, method="orbits")
    known = answer(own.path, stored_counterparts, found)
    stored = {(k, parity) for k, parity in zip(own_rows(own), ["oo"] * 99, strict=False)}
    assert stored
    pairs = [(k, value) for k, value in zip(found.k.tolist(), known, strict=True) if value is not None]
    assert len(pairs) > 5
    assert all(abs(k - value) < 0.3 for k, value in pairs)
    assert all(value is None for value, parity in zip(known, found.parity, strict=True) if parity == "oe")


def own_rows(catalogue):
    from contents import ask

    return [k for (k,) in ask(catalogue.path, "SELECT k FROM level WHERE parity = 'oo' ORDER BY k")]


def test_a_complete_list_passes_and_every_removed_level_is_found(orbits, exact):
    whole = assess(exact, orbits, Stadium(1.6), Parity.OO)
    assert (whole.missing, whole.spurious, whole.gaps) == (0, 0, [])
    of = f"{len(exact)} levels with k from 0 to {exact[-1]:.4g}"
    assert whole.verdict() == f"none of {of} is missing (a = 1.6, oo; scatter {whole.scatter:.2f})"
    assert whole.fits
    assert whole.scatter < 0.15
    assert np.abs(whole.excess).max() < 0.3
    for n in range(len(exact) - 1):
        found = assess(np.delete(exact, n), orbits, Stadium(1.6), Parity.OO)
        assert (found.missing, found.spurious) == (1, 0)
        (gap,) = found.gaps
        spacing = 1 / weyl(Stadium(1.6), Parity.OO).deriv()(exact[n])
        assert (gap.after or 0) - 1.5 * spacing < exact[n] < gap.before + 1.5 * spacing


@pytest.fixture
def window(catalogue, exact):
    """Levels from k = 8 on, the number of those below, and a function that assesses some of them."""
    k = exact[exact > 8]

    def assessed(levels):
        return catalogue.assess(levels, parity="oo", window=True)

    return k, len(exact) - len(k), assessed


def test_a_window_begins_with_the_right_number_and_nothing_is_missing(window):
    k, below, assessed = window
    whole = assessed(k)
    assert (whole.first, whole.total, whole.gaps, whole.spurious) == (below + 1, len(k), [], 0)
    assert whole.number.tolist() == list(range(below + 1, below + 1 + len(k)))
    begins = f"the list begins with level {below + 1}; none of {len(k)} levels with k from"
    assert whole.verdict().startswith(begins)


def test_a_missing_level_of_a_window_is_found_in_its_place(window):
    k, below, assessed = window
    spacing = 1 / weyl(Stadium(1.6), Parity.OO).deriv()(k)
    for n in range(2, len(k) - 2, 3):
        found = assessed(np.delete(k, n))
        assert found.first == below + 1
        (gap,) = found.gaps
        assert gap.missing == 1
        assert there(gap.after) - 1.5 * spacing[n] < k[n] < there(gap.before) + 1.5 * spacing[n]


@pytest.mark.parametrize("seed", [3, 7, 8])
def test_missing_levels_are_placed_although_the_orbits_are_wrong_near_the_perimeter(seed):
    """A made-up list of all parities; the staircase from the orbits is exact but for three waves."""
    stadium, cutoff, rng = Stadium(1.6), 10.0, np.random.default_rng(seed)
    smooth = weyl(stadium, None)
    every = np.array([wavenumber(smooth, n) for n in np.cumsum(rng.exponential(size=900))])
    grid = np.linspace(0, every[-1], 20_000)
    waves = sum(0.15 * np.cos((stadium.perimeter + off) * grid) for off in (-1.0, 0.6, 2.6))
    count = smoothed(grid, every, cutoff) + waves
    orbits = Staircase(grid, count[None], (cutoff,), smooth(grid))
    whole = every[(every > 15) & (every < 22)]
    lost = np.sort(rng.choice(np.arange(3, len(whole) - 3), len(whole) // 20, replace=False))
    found = assess(np.delete(whole, lost), orbits, stadium, window=True)
    assert (found.first, found.missing) == (int(np.searchsorted(every, 15)) + 1, len(lost))
    places = [n for n, gap in enumerate(np.diff(found.number)) for _ in range(gap - 1)]
    assert np.abs(lost - np.arange(len(lost)) - 1 - places).max() <= 1


def test_a_list_without_its_lowest_levels_is_told_that_it_may_be_a_window(catalogue, window):
    k, below, assessed = window
    _, hints = answer(catalogue.path, partial(assess_levels, a=1.6, k=k, parity="oo"))
    assert hints == [f"the {below} lowest levels are missing: a list that begins higher up is a window"]
    with pytest.raises(InputError, match="use --window"):
        catalogue.assess(k[k > 12], parity="oo")
    with pytest.raises(InputError, match="the list has only 9 levels"):
        assessed(k[:9])
    with pytest.raises(InputError, match="with the radius known"):
        catalogue.assess(k, parity="oo", window=True, fit_radius=True)


def test_where_the_orbits_cannot_tell_they_say_so(orbits):
    """Levels crowded within the resolution of the orbits, and a list shorter than that resolution."""
    stadium, smooth = Stadium(1.6), weyl(Stadium(1.6), Parity.OO)
    for first, told in (
        (100_000, "levels lie within their resolution"),
        (40_000, "with which level a list of 40 levels"),
    ):
        k = np.array([wavenumber(smooth, n) for n in range(first, first + 40)])
        between = replace(orbits, k=k, count=smooth(k)[None], smooth=smooth(k))
        with pytest.raises(InputError, match=told):
            assess(k, between, stadium, Parity.OO, window=True)


def test_a_list_of_another_stadium_does_not_fit(catalogue, exact):
    found = catalogue.assess(exact * 1.01, parity="oo")
    assert not found.fits
    assert found.verdict().startswith("the list does not fit a = 1.6, oo: scatter 0.")
    failed = catalogue.assess(exact * 1.02, parity="oo", fit_radius=True)
    assert failed.at_limit or not failed.fits


def test_the_last_level_after_a_missing_one_is_not_spurious(orbits, exact):
    found = assess(np.delete(exact, -2), orbits, Stadium(1.6), Parity.OO)
    assert (found.missing, found.spurious) == (1, 0)


def test_a_duplicate_level_is_spurious(orbits, exact):
    for n in (10, 30):
        found = assess(np.sort([*exact, exact[n] + 1e-3]), orbits, Stadium(1.6), Parity.OO)
        (gap,) = found.gaps
        assert gap.missing == -1
        assert gap.after <= exact[n] + 0.3
        assert found.spurious == 1
        assert "1 is spurious or duplicate" in found.verdict()


@pytest.mark.parametrize("off", [-0.003, 0.0021])
def test_the_radius_is_found_from_the_levels(orbits, exact, off):
    found = assess(exact[:-1] * (1 + off), orbits, Stadium(1.6), Parity.OO, fit_scale=True)
    assert abs(found.scale * (1 + off) - 1) < 4 * found.scale_error < 4e-3
    assert found.missing == 0


@given(st.data())
def test_the_cheapest_assignment_is_found(data):
    """The reference tries all assignments of a few levels."""
    places = st.floats(0, 5)
    expected = np.sort(np.array(data.draw(st.lists(places, min_size=1, max_size=4))))
    sigma, free = data.draw(st.floats(0.1, 1)), data.draw(st.booleans())
    numbers, cost = numbered(expected, np.full(len(expected), sigma), free)
    tried = [_cost(expected, sigma, free, each) for each in _every(len(expected), 7)]
    assert cost == pytest.approx(min(tried))
    assert _cost(expected, sigma, free, numbers.tolist()) == pytest.approx(min(tried))


def _every(count, most, least=0):
    """Yield all assignments of true numbers to levels: 0 for a spurious level, otherwise increasing."""
    if count == 0:
        yield []
        return
    for first in (0, *range(least + 1, most + 1)):
        for rest in _every(count - 1, most, max(first, least)):
            yield [first, *rest]


def _cost(expected, sigma, free, numbers):
    """Return the cost of an assignment, in which numbers after the last level do not count as missing."""
    true = [number for number in numbers if number]
    below = min(true, default=1) - 1 if free else 0
    cost = MISSING * (max(true, default=0) - below - len(true)) + SPURIOUS * numbers.count(0)
    return cost + sum((x - n) ** 2 / (2 * sigma**2) for x, n in zip(expected, numbers, strict=True) if n)


def test_a_catalogue_assesses_levels_and_refuses_bad_lists(catalogue, exact):
    few = np.delete(exact, [7, 21])
    found = catalogue.assess(few[::-1], parity="oo")
    assert found.missing == 2
    assert repr(found).startswith("<2 of 40 levels with k from 0 to")
    assert found.to_pandas()["missing"].tolist() == [1, 1]
    refused = {"energies": exact**2, "Weyl": np.sqrt(exact), "only 5 levels": exact[:5], "above 0": -exact}
    assert catalogue.assess([8.0] * 10, parity="oo").first == 1  # one level again and again is no error
    for told, k in [*refused.items(), ("above 0", [*exact, math.nan])]:
        with pytest.raises(InputError, match=told):
            catalogue.assess(k, parity="oo")
    with pytest.raises(InputError, match="no orbits at a = 2"):
        catalogue.assess(exact, parity="oo", a=2)
    with pytest.raises(InputError, match="no levels of parity oo are stored"):
        catalogue.assess(parity="oo")


def test_too_few_periods_are_refused(tmp_path):
    own = Catalogue.create(tmp_path / "orbits.db", 1.6)
    own.fill("2-6")
    with pytest.raises(InputError, match=r"complete only up to 6 .* 'orbitdb fill --p 12 --a 1\.6'"):
        own.levels(method="orbits")
    with pytest.raises(InputError, match="half length from"):
        answer(own.path, levels_from_orbits, 50.0)
