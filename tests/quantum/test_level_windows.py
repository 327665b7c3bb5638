"""Windows of levels, above all published ones near k = 770: judged, and used for statistics and spectra."""

import numpy as np
import pytest
from calibration import PUBLIC
from quick import fuzz_but
from there import there

from orbitdb import Catalogue, InputError, Stadium, levels, read_levels
from orbitdb.quantum.level_statistics import delta3, number_variance
from orbitdb.quantum.weyl import Parity, weyl


@pytest.fixture(scope="module")
def published(tmp_path_factory):
    """A catalogue at a = 1 and the published levels near k = 770, the first of which is number 83 898."""
    catalogue = Catalogue.create(tmp_path_factory.mktemp("published") / "orbits.db", 1.0)
    catalogue.fill("2-10")
    return catalogue, read_levels(PUBLIC)


def test_a_window_at_776_is_judged_though_its_gaps_have_no_names(published):
    catalogue, k = published
    window = k[(k > 776.4) & (k < 777)]
    found = catalogue.assess(window, parity="oo", window=True)
    assert (len(window), found.first, found.gaps, found.resolved) == (134, 85301, [], 45)
    assert found.net == pytest.approx(0, abs=0.5)
    lost = np.delete(window, range(20, 120, 12))
    cells = catalogue.assess(lost, parity="oo", window=True)
    assert cells.fits
    assert cells.net == pytest.approx(9, abs=2 * max(cells.net_error, 0.5))
    for cell in cells.gaps:
        assert (cell.spurious, cell.gaps) == (None, [])
        assert cell.levels >= 10
        assert cell.place().startswith(f"{cell.missing:+d} among the {cell.levels} ")
    assert f"levels are missing among these {len(lost)}" in cells.verdict()
    assert "the orbits tell their number to within about 23 levels" in cells.verdict()
    assert "its neighbours are possible): " in cells.verdict()
    assert "with this many levels missing, a list from another stadium might fit as well" in cells.notes
    assert any("0.05 %" in note for note in cells.notes)


@pytest.mark.slow
def test_a_list_is_never_refused_because_it_is_short(published):
    catalogue, k = published
    for count in (1, 5, 30):
        found = catalogue.assess(k[:count], parity="oo", window=True)
        assert (found.short, found.gaps) == (True, [])
        assert found.verdict() == "too short to be tested: the orbits resolve 44 levels here (a = 1, oo)"
        fitted = catalogue.assess(k[:count], parity="oo", window=True, fit_radius=True)
        assert (fitted.verdict(), fitted.scale) == (found.verdict(), 1)


@pytest.mark.slow
def test_a_radius_is_not_fitted_where_too_many_would_fit(published):
    catalogue, k = published
    with pytest.raises(InputError, match=r"too many radii fit .* at most 0\.008 %"):
        catalogue.assess(k[:50], parity="oo", window=True, fit_radius=True)
    known = catalogue.assess(k[:50], parity="oo", window=True, fit_radius=True, radius_error=2e-6)
    assert known.fits
    assert known.scale == pytest.approx(1, abs=8e-6)


@pytest.mark.slow
def test_lists_that_cannot_fit_at_770_are_refused_with_a_sentence(published):
    catalogue, k = published
    for wrong, parity in ((np.random.default_rng(2).uniform(770, 778, 1700), "oo"), (k, "ee")):
        found = catalogue.assess(wrong, parity=parity, window=True)
        assert not found.fits
        assert found.notes[-1].startswith("so high up, too many radii fit")


@pytest.mark.slow
def test_random_numbers_do_not_fit_a_stadium_with_many_more_levels(tmp_path):
    catalogue = Catalogue.create(tmp_path / "orbits.db", 1.0)
    catalogue.fill("2-10")
    catalogue.fill("2-10", a=1.4)
    k = np.sort(np.random.default_rng(4).uniform(150, 158.7, 400))
    found = catalogue.assess(k, parity="oo", window=True)
    assert not found.fits
    assert not any("they fit a =" in note for note in found.notes)


@pytest.mark.slow
def test_the_published_levels_near_770_are_complete_and_have_the_known_statistics(published):
    catalogue, k = published
    found = catalogue.assess(k, parity="oo", window=True)
    assert (found.first, found.gaps, found.sure_of_first) == (83898, [], True)
    statistics = catalogue.level_statistics({Parity.OO: k}, window=True).to_pandas().iloc[0]
    assert statistics["gap_ratio"] == pytest.approx(0.5213, abs=5e-4)
    assert statistics["spacing_variance"] == pytest.approx(0.299, abs=1e-3)
    assert statistics["variance_1"] == pytest.approx(0.458, abs=1e-3)
    assert statistics["variance_5"] == pytest.approx(0.871, abs=1e-3)
    assert statistics["missing"] == 0
    spectrum = catalogue.spectrum((3, 13), levels=k, window=True, parity="oo")
    assert (spectrum.k_min, spectrum.k_max) == (k[0], k[-1])
    assert there(spectrum.misfit) < 0.15
    part = catalogue.spectrum((3, 13), levels=k, window=True, parity="oo", k=(771, 777))
    assert (part.k_min, part.k_max, there(part.misfit) < 0.15) == (771, 777, True)
    for refused in ((760, 777), (771, 779)):
        with pytest.raises(InputError, match=r"the levels have k from 770\.001 to 777\.999"):
            catalogue.spectrum(levels=k, window=True, parity="oo", k=refused)


@pytest.mark.slow
def test_the_page_says_what_the_published_levels_give(tmp_path):
    catalogue = Catalogue.create(tmp_path / "orbits.db", 1.0)
    catalogue.fill("2-12")
    k = read_levels(PUBLIC)
    found = catalogue.assess(k, parity="oo", window=True)
    misfit = there(catalogue.spectrum((3, 13), levels=k, window=True, parity="oo").misfit)
    page = " ".join((PUBLIC.parents[2] / "docs" / "spectrum.md").read_text(encoding="utf-8").split())
    assert f"begin with level 83 898 (P {found.first_probability:.3g}), and none is missing" in page
    assert (found.first, found.gaps) == (83898, [])
    assert f"|quantum − orbits| / |quantum| of {misfit:.3f} (periods up to 12)" in page


@pytest.mark.slow
def test_statistics_allow_for_missing_levels():
    rng = np.random.default_rng(1)
    k = read_levels(PUBLIC)
    x = weyl(Stadium(1.0), Parity.OO)(k)
    whole = number_variance(x, 20.0), delta3(x, 20.0)
    thin = [x[rng.random(len(x)) > 0.1] for _ in range(8)]
    corrected = np.mean(
        [[there(of(each, 20.0, 0.1)) for of in (number_variance, delta3)] for each in thin], axis=0
    )
    raw = np.mean([[there(of(each, 20.0)) for of in (number_variance, delta3)] for each in thin], axis=0)
    assert raw[0] > 3 * there(whole[0])
    assert corrected == pytest.approx(whole, rel=0.25)


@pytest.mark.slow
@pytest.mark.parametrize(("low", "high"), fuzz_but([(20, 40)], [(20, 40), (40, 60)]))
def test_errors_of_levels_from_orbits_hold_for_nine_in_ten(published, low, high):
    catalogue, _ = published
    found = catalogue.levels(float(high), parity="oo", method="orbits")
    known = levels(1.0, float(high), parity="oo").k
    own = known > low
    count = min(len(known), len(found.k))
    off = np.abs(found.k[:count] - known[:count])
    assert np.mean((off < found.error[:count])[own[:count]]) >= 0.9


def test_lists_are_read_in_python_as_in_the_shell(tmp_path):
    path = tmp_path / "k.csv"
    path.write_text("k,parity\n3.5,oo\n2.5,ee\n1.5,oo\n")
    assert read_levels(path).tolist() == [1.5, 2.5, 3.5]
    assert read_levels(path, parity="oo").tolist() == [1.5, 3.5]
    path.write_text("1\n4\n")
    assert read_levels(path, energies=True).tolist() == [1, 2]
    assert read_levels(path, frequency="GHz", radius=0.2)[0] == pytest.approx(4.1917, abs=1e-4)
    with pytest.raises(InputError, match="frequencies need"):
        read_levels(path, frequency="GHz")
    with pytest.raises(InputError, match="nowhere"):
        read_levels("nowhere")
