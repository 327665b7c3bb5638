"""Spectra judged by the orbits: levels from orbits, missing levels, and the fitted radius."""

import math
from itertools import pairwise

import numpy as np
import pytest
from contents import answer
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import eigs
from there import there

from orbitdb import Catalogue, InputError
from orbitdb.answers.stadium_levels import levels_from_orbits, read_orbits, stored_counterparts
from orbitdb.billiard.stadium import Stadium
from orbitdb.quantum.bouncing_balls import family
from orbitdb.quantum.comparison import CUTOFF
from orbitdb.quantum.exact_levels import levels
from orbitdb.quantum.levels_from_orbits import CUTOFFS, reliable_end, staircase
from orbitdb.quantum.missing_levels import assess, without_twins
from orbitdb.quantum.trace_formula import orbit_terms
from orbitdb.quantum.weyl import Parity, weyl
from orbitdb.selection import Selection


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
    return staircase(Stadium(1.6), classes, 17.0, Parity.OO, (CUTOFF,))


@pytest.mark.slow
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
    known = exact if parity is Parity.OO else levels(1.6, 16.0, parity=[parity]).k
    found = catalogue.levels(16.0, parity=parity, method="orbits")
    assert len(found) == len(known)
    off = np.abs(found.k - known)
    density = weyl(Stadium(1.6), parity).deriv()(known)
    assert math.sqrt(np.mean((off * density) ** 2)) < 0.15
    assert np.mean(off < found.error) >= 0.9
    assert np.median(found.error * density) < 0.5
    assert f"X = {CUTOFFS[0]:g} to" in found.basis


def test_levels_from_orbits_end_where_they_become_unreliable(catalogue):
    found = answer(catalogue.path, levels_from_orbits, 1.6, parity=(Parity.OO, Parity.EE))
    assert 15 < found.high < 25
    ends = [reliable_end(Stadium(1.6), parity) for parity in (Parity.OO, Parity.EE)]
    assert ends[0] - found.high > 0.1 > ends[1] - found.high >= 0  # the lower one
    assert "above k" not in found.basis
    assert "above k = 20" in catalogue.levels(25, parity="oo", method="orbits").basis
    with pytest.raises(InputError, match="method 'magic'"):
        catalogue.levels(method="magic")


@pytest.mark.slow
def test_stored_levels_are_paired_by_number(catalogue, tmp_path):
    own = Catalogue.create(tmp_path / "orbits.db", 1.6)
    own.fill("2-8")
    own.fill_levels((5, 7), parity=["oo", "ee"])
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
    assert whole.missing == pytest.approx(0, abs=0.1)
    assert (whole.spurious, whole.gaps) == (0, [])
    of = f"{len(exact)} levels with k from 0 to {exact[-1]:.4g}"
    said = f"none of {of} is missing (P {whole.whole:.3g}; a = 1.6, oo; misfit {whole.misfit:.2f})"
    assert whole.verdict() == said
    assert whole.whole > 0.9
    assert whole.fits
    assert whole.misfit < 0.5
    assert np.abs(whole.excess).max() < 0.3
    assert whole.number.tolist() == list(range(1, len(exact) + 1))
    for n in range(0, len(exact) - 1, 4):
        found = assess(np.delete(exact, n), orbits, Stadium(1.6), Parity.OO)
        (gap,) = found.gaps
        assert (gap.missing, gap.spurious, found.total) == (1, 0, len(exact))
        assert gap.probability > 0.5
        assert (gap.after or 0) <= exact[n] <= gap.before
        spacing = 1 / weyl(Stadium(1.6), Parity.OO).deriv()(exact[n])
        assert found.places == pytest.approx([exact[n]], abs=1.5 * spacing)


@pytest.fixture
def window(catalogue, exact):
    """Levels from k = 8 on, the number of those below, and a function that assesses some of them."""
    k = exact[exact > 8]

    def assessed(levels, **more):
        return catalogue.assess(levels, parity="oo", window=True, **more)

    return k, len(exact) - len(k), assessed


def test_a_window_begins_with_the_right_number_and_nothing_is_missing(window):
    k, below, assessed = window
    whole = assessed(k)
    assert (whole.first, whole.total, whole.gaps, whole.spurious) == (below + 1, len(k), [], 0)
    assert whole.notes == ()
    assert whole.number.tolist() == list(range(below + 1, below + 1 + len(k)))
    assert whole.first_probability > 0.95
    begins = (
        f"the list begins with level {below + 1} (P {whole.first_probability:.3g}); none of {len(k)} levels"
    )
    assert whole.verdict().startswith(begins)


def test_a_missing_level_of_a_window_is_found_in_its_place(window):
    k, below, assessed = window
    for n in range(2, len(k) - 2, 6):
        found = assessed(np.delete(k, n))
        assert found.first == below + 1
        (gap,) = found.gaps
        assert (gap.missing, gap.spurious) == (1, 0)
        assert there(gap.after) <= k[n] <= there(gap.before)


def test_probabilities_of_gaps_add_up_and_numbers_follow_the_gaps(window):
    k, _, assessed = window
    found = assessed(np.sort([*np.delete(k, [5, 6, 15]), 12.5]))
    for gap in found.gaps:
        assert 0 < gap.probability <= 0.999
        between = (found.k > there(gap.after)) & (found.k < there(gap.before))
        assert gap.levels == between.sum()
        edges = np.concatenate([[gap.after], found.k[between], [gap.before]])
        assert [(one.after, one.before) for one in gap.gaps] == list(pairwise(edges))
        assert all(sum(one.missing.values()) == pytest.approx(1, abs=0.03) for one in gap.gaps)
    true = found.number[found.number > 0]
    assert (np.diff(true) > 0).all()
    assert true[-1] - true[0] + 1 - len(true) == sum(gap.missing for gap in found.gaps) == len(found.places)
    assert found.spurious == sum(gap.spurious for gap in found.gaps)


def test_a_short_window_says_how_uncertain_its_first_number_is(window):
    k, below, assessed = window
    found = [assessed(np.delete(k[n : n + 13], 4)) for n in range(0, len(k) - 13, 4)]
    right = np.array([each.first == below + 1 + 4 * n for n, each in enumerate(found)])
    said = np.array([each.first_probability for each in found])
    assert right[said > 0.95].all()
    assert right.mean() >= 0.75


def test_a_list_without_its_lowest_levels_is_told_that_it_may_be_a_window(catalogue, window):
    k, below, _ = window
    notes = catalogue.assess(k, parity="oo", a=1.6).notes
    assert len(notes) == 1
    assert notes[0].startswith(f"the {below} lowest levels are missing: ")
    assert "`catalogue.assess(k, window=True)`" in notes[0]
    with pytest.raises(InputError, match=r"`catalogue\.assess\(k, window=True\)`"):
        catalogue.assess(k[k > 13.5], parity="oo")
    with pytest.raises(InputError, match="needs its levels"):
        catalogue.assess(parity="oo", window=True)


def test_a_list_that_lacks_a_third_of_its_levels_is_judged(orbits, exact):
    lost = np.random.default_rng(3).choice(len(exact) - 1, len(exact) // 3, replace=False)
    found = assess(np.delete(exact, lost), orbits, Stadium(1.6), Parity.OO)
    assert found.fits
    assert found.missing == pytest.approx(len(lost), abs=1.5)


def test_a_list_in_which_every_level_stands_twice_is_merged(catalogue, exact):
    twice = np.sort(np.concatenate([exact, exact + 1e-4]))
    assessment = catalogue.assess(twice, parity="oo", a=1.6)
    assert assessment.notes == ("the list has every level twice: each pair counts as one level",)
    assert (len(assessment), assessment.gaps) == (len(exact), [])
    once, pairs = without_twins(exact, Stadium(1.6), Parity.OO)
    assert (len(once), pairs) == (len(exact), 0)
    poisson = np.sort(np.random.default_rng(1).uniform(5, 30, 800))
    assert without_twins(poisson, Stadium(1.6), None)[1] == 0


@pytest.mark.slow
@pytest.mark.parametrize(
    "change",
    [lambda k: k * 1.01, lambda k: k + 0.15, lambda k: np.sqrt(k**2 + 9)],
)
def test_a_list_of_another_stadium_does_not_fit(catalogue, exact, change):
    found = catalogue.assess(change(exact), parity="oo")
    assert not found.fits
    said = f"the list does not fit a = 1.6, oo: misfit {found.misfit:.2f}; lists that fit have less than 1"
    assert found.verdict() == said


@pytest.mark.slow
def test_the_fit_of_a_radius_that_is_too_wrong_fails(catalogue, exact):
    failed = catalogue.assess(exact * 1.02, parity="oo", fit_radius=True)
    assert failed.at_limit or not failed.fits


def test_the_last_level_after_a_missing_one_is_not_spurious(orbits, exact):
    found = assess(np.delete(exact, -2), orbits, Stadium(1.6), Parity.OO)
    assert (sum(gap.missing for gap in found.gaps), found.spurious) == (1, 0)


def test_a_duplicate_level_is_spurious(orbits, exact):
    for n in (10, 30):
        found = assess(np.sort([*exact, exact[n] + 1e-3]), orbits, Stadium(1.6), Parity.OO)
        (gap,) = found.gaps
        assert (gap.missing, gap.spurious) == (0, 1)
        assert gap.after < exact[n] < gap.before
        assert (found.spurious, found.whole < 0.1) == (1, True)
        assert "1 is spurious or duplicate" in found.verdict()


@pytest.mark.slow
@pytest.mark.parametrize("off", [-0.003, 0.0021])
def test_the_radius_is_found_from_the_levels(orbits, exact, off):
    found = assess(exact[:-1] * (1 + off), orbits, Stadium(1.6), Parity.OO, fit_scale=True)
    assert abs(found.scale * (1 + off) - 1) < 4 * found.scale_error < 4e-3
    assert found.gaps == []


@pytest.mark.slow
def test_the_radius_that_is_found_does_not_depend_on_the_one_given(orbits, exact):
    given = np.array([1, 1.0001])
    found = [assess(exact * one, orbits, Stadium(1.6), Parity.OO, fit_scale=True) for one in given.tolist()]
    fitted = given * [each.scale for each in found]
    assert fitted[0] == pytest.approx(fitted[1], abs=found[0].scale_error / 5)


@pytest.mark.slow
def test_the_radius_of_a_window_is_found_with_and_without_its_error(window):
    k, below, assessed = window
    wrong = 0.002
    for error in (None, 0.001):
        found = assessed(k * (1 + wrong), fit_radius=True, radius_error=error)
        assert abs(found.scale * (1 + wrong) - 1) < 4 * found.scale_error < 4e-3
        assert found.first == below + 1 or found.first_probability < 0.9
    with pytest.raises(InputError, match="relative error of the radius"):
        assessed(k, fit_radius=True, radius_error=0.1)


def test_the_scatter_of_the_levels_can_be_stated(orbits, exact):
    spacing = 1 / weyl(Stadium(1.6), Parity.OO).deriv()(exact)
    noisy = np.sort(exact + 0.15 * spacing * np.random.default_rng(2).normal(size=len(exact)))
    found = assess(np.delete(noisy, 20), orbits, Stadium(1.6), Parity.OO, noise=0.15)
    assert found.fits
    assert found.missing == pytest.approx(1, abs=1)
    (gap,) = found.gaps
    assert gap.after < exact[20] < gap.before


def test_a_catalogue_assesses_levels_and_refuses_bad_lists(catalogue, exact):
    few = np.delete(exact, [7, 21])
    found = catalogue.assess(few[::-1], parity="oo")
    assert repr(found).startswith("<2.0 +- 0.")
    assert f" of 40 levels with k from 0 to {exact[-1]:.4g} are missing" in repr(found)
    frame = found.to_pandas()
    assert frame["missing"].tolist() == [1, 1]
    assert list(frame) == ["after", "before", "levels", "missing", "spurious", "probability"]
    refused = {"energies": exact**2, "Weyl": np.sqrt(exact), "above 0": -exact}
    for told, k in [*refused.items(), ("above 0", [*exact, math.nan])]:
        with pytest.raises(InputError, match=told):
            catalogue.assess(k, parity="oo")
    with pytest.raises(InputError, match="noise"):
        catalogue.assess(exact, parity="oo", noise=0.7)
    with pytest.raises(InputError, match="no orbits at a = 2"):
        catalogue.assess(exact, parity="oo", a=2)
    with pytest.raises(InputError, match="no levels of parity oo are stored"):
        catalogue.assess(parity="oo")


def test_too_few_periods_are_refused(tmp_path):
    own = Catalogue.create(tmp_path / "orbits.db", 1.6)
    own.fill("2-6")
    with pytest.raises(InputError, match=r"complete only up to 6 .* `catalogue\.fill\(p=12, a=1\.6\)`"):
        own.levels(method="orbits")
    with pytest.raises(InputError, match="half length from"):
        answer(own.path, levels_from_orbits, 50.0)


def five_point(a, h, count):
    """Return levels oo from the five-point Laplacian, with unequal arms at the arc (Shortley and Weller)."""
    inside = {
        (i, j)
        for i in range(1, math.ceil((a + 1) / h) + 1)
        for j in range(1, round(1 / h))
        if i * h <= a or (i * h - a) ** 2 + (j * h) ** 2 < 1 - 1e-12
    }
    index = {point: n for n, point in enumerate(sorted(inside))}
    entries = []
    for (i, j), n in index.items():
        x, y = i * h, j * h
        east = h if (i + 1, j) in index else a + math.sqrt(1 - y * y) - x
        north = h if (i, j + 1) in index else math.sqrt(1 - max(x - a, 0.0) ** 2) - y
        for arm, (di, dj) in ((east, (1, 0)), (north, (0, 1))):
            entries.append((n, n, 2 / (h * arm)))
            for own, other, sign in ((arm, h, 1), (h, arm, -1)):
                neighbour = index.get((i + sign * di, j + sign * dj))
                if neighbour is not None:
                    entries.append((n, neighbour, -2 / (own * (own + other))))
    rows, columns, values = zip(*entries, strict=True)
    matrix = csc_matrix((values, (rows, columns)))
    return np.sort(np.sqrt(eigs(matrix, count, sigma=0, return_eigenvectors=False).real))


@pytest.mark.slow
def test_levels_of_finite_differences_are_too_low_by_a_known_amount_and_recognised(catalogue, exact):
    h = 1 / 25
    k = five_point(1.6, h, len(exact))
    off = (k - exact) / (-(exact**3) * h**2 / 32)
    assert off[5:].mean() == pytest.approx(1, abs=0.08)
    found = catalogue.assess(k, parity="oo")
    assert not found.fits
    (hint,) = found.notes
    assert hint.startswith("finite differences with h = 0.04? ")
