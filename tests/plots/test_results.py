"""`plot()` of the objects that the library returns, on new and on given axes."""

from typing import Any

import matplotlib
import numpy as np
import pytest

from orbitdb import Catalogue, Stadium, waves
from orbitdb.plots import statistics
from orbitdb.plots.style import titled
from orbitdb.quantum.exact_levels import Levels, LevelWindow
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


@pytest.mark.slow
def test_a_result_draws_the_averages_that_it_has(catalogue):
    found = catalogue.entropy(p="2-6")
    ax = found.plot()
    np.testing.assert_array_equal(curve(ax, "$K_0")[1], found["K_0"])
    assert ax.get_title() == titled(found.selection.describe())
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
    p, k_0 = curve(catalogue.entropy(p="2-3,5-6").plot(), "$K_0")
    assert (p.tolist(), np.isnan(k_0).tolist()) == ([2, 3, 4, 5, 6], [False, False, True, False, False])


def test_a_result_without_averages_to_draw_says_what_it_has(catalogue):
    with pytest.raises(ValueError, match=r"^this result has no averages to draw"):
        catalogue.table(p="2-6").plot()
    with pytest.raises(ValueError, match="'entropy': use lyapunov, lambda_d, lambda_c"):
        catalogue.lyapunov(p="2-6").plot("entropy")


def test_a_spectrum_draws_its_orbits_downwards_and_has_a_short_repr(catalogue):
    found = catalogue.spectrum((4, 9), resolution=60)
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
        (counted,) = catalogue.table(a=at, p=5)["N_c"]
        assert np.asarray(orbits)[np.searchsorted(np.asarray(a), at, side="right") - 1] == counted
    assert len(births.to_pandas()) == len(births)
    with pytest.raises(ValueError, match="no births"):
        catalogue.births(7).plot()


def levels_at(x, parity=Parity.EE):
    """Return the levels k whose unfolded values are x."""
    smooth = weyl(Stadium(1.6), parity)
    return np.array([wavenumber(smooth, float(number)) for number in x])


def test_equally_spaced_levels_have_the_rigidity_of_a_picket_fence():
    parts = {parity: levels_at(np.arange(1, 25) - 0.5, parity) for parity in (Parity.EE, Parity.OO)}
    _, (left, right) = pyplot.subplots(1, 2)
    statistics.draw_rigidity(left, 1.6, parts, "delta3")
    statistics.draw_rigidity(right, 1.6, parts, "variance")
    length, rigidity = curve(left, "levels")
    assert rigidity[length >= 4] == pytest.approx(1 / 12, abs=0.003)
    length, variance = curve(right, "levels")
    assert variance[length % 1 == 0] == pytest.approx(0, abs=1e-9)
    assert variance[length % 1 == 0.5] == pytest.approx(0.25, abs=1e-9)
    for ax in (left, right):
        assert ax.get_xlim()[0] == 0
        assert 11 <= ax.get_xlim()[1] <= 11.5  # half of what the levels span
        labels = ax.get_legend_handles_labels()[1]
        assert len(labels) == 4
        np.testing.assert_allclose(curve(ax, "levels")[0], np.arange(0.5, ax.get_xlim()[1] + 0.25, 0.5))
    assert curve(right, "uncorrelated")[1].tolist() == curve(right, "uncorrelated")[0].tolist()


def test_spacings_have_the_errors_of_counts():
    gaps = np.random.default_rng(3).exponential(size=400)
    k = levels_at(np.cumsum(gaps) + 1.0)
    ax = pyplot.figure().subplots()
    statistics.draw_spacings(ax, 1.6, {Parity.EE: k})
    density, edges = np.histogram(gaps[1:], np.arange(0, 4.1, 0.2), density=False)
    patches: Any = ax.patches
    bars = [bar for bar in patches if bar.get_height()]
    assert [bar.get_height() for bar in bars] == pytest.approx(density[density > 0] / (399 * 0.2))
    ((_, _, (marks,)),) = [each for each in ax.containers if len(each) == 3 and hasattr(each, "has_yerr")]
    half = [(high - low) / 2 for (_, low), (_, high) in marks.get_segments()]
    share = np.diff(-np.exp(-edges))  # of Poisson's law, by which these were drawn
    expected = np.sqrt(share * (1 - share) / 399) / 0.2
    assert np.array(half[:8]) == pytest.approx(expected[:8], rel=0.35)


@pytest.mark.slow
def test_levels_and_waves_draw_all_their_figures():
    k = levels_at(np.arange(1, 40) - 0.5)
    found = Levels.joined(1.6, 0.0, 20.0, {Parity.EE: [LevelWindow(1.6, Parity.EE, 0.0, 20.0, 0, k, k * 0)]})
    assert found.plot("spacings").get_xlabel() == "spacing (in units of the mean)"
    assert found.plot("rigidity").get_ylabel() == r"$\Delta_3(L)$"
    with pytest.raises(ValueError, match="'wave': use staircase, spacings, rigidity"):
        found.plot("wave")


@pytest.mark.slow
def test_a_wave_draws_psi_squared_and_its_husimi_function_in_units_of_their_means():
    wave = next(iter(waves(1.6, (3.0, 6.0), "ee")))
    (image,) = wave.plot().images
    shown = np.asarray(image.get_array())
    y, x = (np.linspace(-1, 1, n, endpoint=False) + 1 / n for n in shown.shape)
    across, up = np.meshgrid(2.6 * x, y)
    inside = np.hypot(np.maximum(np.abs(across) - 1.6, 0), up) < 1
    assert shown[inside].mean() == pytest.approx(1, abs=0.02)
    n, m = np.argwhere(inside)[1234]
    exact = Stadium(1.6).area * wave.psi(across[n, m], up[n, m]) ** 2
    assert shown[n, m] == pytest.approx(float(exact), rel=1e-6)
    husimi = wave.plot("husimi")
    (image,) = husimi.images
    assert np.asarray(image.get_array()).mean() == pytest.approx(1)
    assert [text.get_text() for text in husimi.texts] == ["0: bottom", "3, 5: right", "2: top", "1, 4: left"]
