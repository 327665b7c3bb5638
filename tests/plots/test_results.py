"""`plot()` of the objects that the library returns, on new and on given axes."""

import matplotlib
import numpy as np
import pytest

from orbitdb import Catalogue, Stadium
from orbitdb.quantum.levels import Levels, LevelWindow
from orbitdb.quantum.weyl import Parity, wavenumber, weyl

matplotlib.use("agg")
from matplotlib import pyplot


@pytest.fixture(scope="module")
def catalogue(tmp_path_factory):
    made = Catalogue.create(tmp_path_factory.mktemp("plots") / "c.db")
    made.fill("2-6")
    return made


@pytest.fixture(autouse=True)
def closed():
    yield
    pyplot.close("all")


def curve(ax, label):
    (found,) = (line for line in ax.get_lines() if str(line.get_label()).startswith(label))
    return np.array(found.get_xdata()), np.array(found.get_ydata())


def test_a_result_draws_the_averages_that_it_has(catalogue):
    found = catalogue.entropy(p="2-6")
    ax = found.plot()
    np.testing.assert_array_equal(curve(ax, "$K_0")[1], found["K_0"])
    assert ax.get_title() == found.selection.describe()
    assert len(ax.get_legend().get_texts()) == 3
    mine = pyplot.figure().subplots()
    lyapunov = catalogue.lyapunov(p="2-6")
    assert lyapunov.plot(ax=mine) is mine
    np.testing.assert_array_equal(curve(mine, "average over")[1], lyapunov["lambda_d"])
    other = lyapunov.plot("lambda_c")
    assert "per length" in other.get_ylabel()
    np.testing.assert_array_equal(curve(other, "sum rules")[1], lyapunov["lambda_c_sum_rule"])


def test_a_subset_without_proved_bounds_draws_its_entropy(catalogue):
    ax = catalogue.select(p="2-6", status="orbit").entropy().plot()
    assert [text.get_text()[:4] for text in ax.get_legend().get_texts()] == ["$h(p", "$K_0"]


def test_a_result_without_averages_to_draw_says_what_it_has(catalogue):
    with pytest.raises(ValueError, match=r"^this result has no averages to draw"):
        catalogue.table(p="2-6").plot()
    with pytest.raises(ValueError, match="'entropy': this result has lyapunov, lambda_d, lambda_c"):
        catalogue.lyapunov(p="2-6").plot("entropy")


def test_a_spectrum_draws_its_orbits_downwards_and_has_a_short_repr(catalogue):
    found = catalogue.spectrum((4, 9), points=60)
    np.testing.assert_array_equal(curve(found.plot(), "orbits")[1], -np.abs(found.orbits))
    assert repr(found) == "<length spectrum at a = 1.6: orbits, x = 4 to 9, k below 30>"


@pytest.mark.parametrize("low", [0.0, 3.0])
def test_levels_draw_their_staircase(low):
    parts = {}
    for parity in (Parity.EE, Parity.OO):
        smooth = weyl(Stadium(1.6), parity)
        k = np.array([wavenumber(smooth, n - 0.5) for n in range(1, 9)])
        k = k[(low <= k) & (k < 6.0)]
        parts[parity] = [LevelWindow(1.6, parity, low, 6.0, 0, k, k * 1e-12)]
    found = Levels.joined(1.6, low, 6.0, parts)
    ax = found.plot()
    k, count = curve(ax, "levels")
    np.testing.assert_array_equal(k, [low, *found.k, 6.0])
    np.testing.assert_array_equal(count, [*range(len(found) + 1), len(found)])
    assert abs(curve(ax, "Weyl")[1][-1] - len(found)) < 2


def test_births_draw_the_number_of_orbits_at_each_a(tmp_path):
    catalogue = Catalogue.create(tmp_path / "c.db")
    catalogue.fill_births("4-5")
    births = catalogue.births(5)
    ax = births.plot()
    a, orbits = ax.get_lines()[0].get_data()
    for at in (0.3, 1.0, 1.6):
        counted = catalogue.counts(a=at, p=5).tallies[5].n_c
        assert np.asarray(orbits)[np.searchsorted(np.asarray(a), at, side="right") - 1] == counted
    assert len(births.to_pandas()) == len(births)
    with pytest.raises(ValueError, match="no births"):
        catalogue.births(7).plot()
