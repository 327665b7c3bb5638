"""Every figure shows just the numbers that it is given: read back from its axes, and computed plainly."""

import math
from bisect import bisect_left, bisect_right
from collections import Counter
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from figures import by_period, heights, legend, named, says, texts
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure

from orbitdb import Stadium
from orbitdb.benchmarks.work_precision import WorkPrecision
from orbitdb.plots import curves, paths
from orbitdb.quantum.amplitudes import Terms
from orbitdb.quantum.spectrum import Spectrum


def test_the_entropy_by_period(ax, rng):
    p = np.arange(2, 10)
    k_0 = np.array([0.1, *rng.uniform(0.9, 1.1, 7)])
    h = np.array([2.0, *rng.uniform(0.95, 1.05, 6), np.nan])
    curves.draw_entropy(ax, p, k_0, h, (0.8, 1.3))
    by_period(ax, "topological entropy (per bounce)")
    low, high = 0.8 - 0.12 * 0.5, 1.3 + 0.12 * 0.5
    assert ax.get_ylim() == pytest.approx((low, high))
    assert ax.get_xlim() == (1.3, 9.5)
    assert legend(ax)[1:] == ["$h(p)$, zero of the zeta function to order $p$", r"$K_0(p) = \ln N(p)\,/\,p$"]
    np.testing.assert_array_equal(named(ax, "$h(p)$"), [p[1:-1], h[1:-1]])
    np.testing.assert_array_equal(named(ax, "$K_0"), [p, k_0])
    assert {told: [*at] for told, at in texts(ax).items()} == {
        "↓ 0.1000": pytest.approx([2, low])
    }  # what lies below is told
    (band,) = ax.patches
    assert (band.get_y(), band.get_height()) == pytest.approx((0.8, 0.5))


def test_limits_leave_room_where_all_values_are_one(ax):
    curves.draw_entropy(ax, np.array([2, 3]), np.ones(2), np.ones(2), (1.0, 1.0))
    assert ax.get_ylim() == pytest.approx((0.9, 1.1))


def test_exponents_by_period(ax, rng):
    p, (plain, pair, zeta, rule, error) = np.arange(3, 9), rng.uniform(0.1, 1, (5, 6))
    names = ("lambda_d", *(f"lambda_d_{end}" for end in ("pair", "zeta", "sum_rule", "sum_rule_error")))
    rows = dict(zip(names, (plain, pair, zeta, rule, error), strict=True))
    curves.draw_lyapunov(ax, p, rows, "lambda_d", "an exponent", (0.5, 0.01))
    by_period(ax, "an exponent")
    labels = ("average over fixed points", "mean of $p - 1$", "zeta function to order $p$", "sum rules")
    assert [any(each.startswith(label) for each in legend(ax)) for label in labels] == [True] * 4
    for label, values in zip(labels, (plain, pair, zeta, rule), strict=True):
        np.testing.assert_array_equal(named(ax, label), [p, values])
    assert heights(ax.collections[0]) == {*np.concatenate([rule - error, rule + error]).round(9).tolist()}
    assert named(ax, r"random trajectories (band: $\pm 2$ errors)")[1].tolist() == [0.5, 0.5]
    (band,) = ax.patches
    assert (band.get_y(), band.get_height()) == pytest.approx((0.48, 0.04))


@pytest.mark.parametrize(("count", "size"), [(100, 12), (20_000, 3), (210_000, 0.3)])
def test_phase_space(ax, rng, count, size):
    stadium, values = Stadium(0.7), rng.uniform(-1, 1, (3, count))
    dots = paths.draw_phase_space(ax, stadium, *values)
    np.testing.assert_array_equal(dots.get_offsets().T, values[:2])
    np.testing.assert_array_equal(dots.get_array(), values[2])
    assert dots.get_clim() == pytest.approx(np.quantile(values[2], [0.02, 0.98]))
    assert (dots.get_sizes(), dots.get_linewidth(), dots.get_cmap().name) == ([size], [0], "viridis")
    assert dots.get_rasterized()
    ends = [0, 1.4, 1.4 + math.pi, 2.8 + math.pi, 2.8 + 2 * math.pi]
    assert [each.get_xdata()[0] for each in ax.lines] == pytest.approx(ends[1:4])
    middles = [(x + y) / 2 for x, y in pairwise(ends)]
    assert [where[0] for where in texts(ax).values()] == pytest.approx(middles)
    assert [*texts(ax)] == ["0: bottom", "3, 5: right", "2: top", "1, 4: left"]
    assert all(where[1] > 1 for where in texts(ax).values())
    assert (ax.get_xlim(), ax.get_ylim()) == ((0, pytest.approx(ends[-1])), (-1, 1))
    says(ax, "$s/R$", r"$\sin\,\varphi$")


def test_lengths(ax, rng):
    length, count, p = rng.uniform(5, 20, 300).round(1), rng.integers(1, 9, 300), rng.integers(2, 5, 300)
    curves.draw_staircase(ax, length, count, 9.8765)
    steps, end = ax.lines
    at, below = steps.get_data()
    assert steps.get_drawstyle() == "steps-post"
    assert at.tolist() == sorted(length)
    last = [bisect_right(at, place) - 1 for place in at]  # of several steps at one place the last one stands
    assert below[last].tolist() == [count[length <= place].sum() for place in at]
    assert (end.get_xdata(), end.get_label()) == ([9.87] * 2, "complete, by proof, up to $L = 9.87\\,R$")
    assert ax.get_yscale() == "log"
    says(ax, "length $L/R$", "orbits not longer than $L$")
    other = Figure().add_subplot()
    drawn: Any = curves.draw_density(other, p, length, count)
    edges = np.linspace(length.min() - 0.5, length.max() + 0.5, 121)
    np.testing.assert_allclose(drawn.get_coordinates()[0, :, 0], edges)
    np.testing.assert_array_equal(drawn.get_coordinates()[:, 0, 1], [1.5, 2.5, 3.5, 4.5])
    for period, row in zip((2, 3, 4), drawn.get_array(), strict=True):
        orbits: Counter[int] = Counter()
        for each, some in zip(length[p == period], count[p == period], strict=True):
            orbits[bisect_right(edges, each) - 1] += int(some)
        assert row.filled(0) * (edges[1] - edges[0]) == pytest.approx([orbits[k] for k in range(120)])
        assert row.mask.tolist() == [not orbits[k] for k in range(120)]
    assert (isinstance(drawn.norm, LogNorm), drawn.get_cmap().name) == (True, "viridis")
    says(other, "length $L/R$", "period $p$ (bounces)")
    assert all(tick == round(tick) for tick in other.get_yticks())


def spectrum(rng, quantum: bool, complete: float) -> Spectrum:
    """Return a length spectrum of some terms that lie far apart."""
    x, length = np.linspace(3, 9, 400), np.array([4.0, 6.0, 8.0])
    strength = rng.uniform(1, 2, 3) * np.exp(1j * rng.uniform(0, 6, 3))
    waves = (strength * np.exp(-20 * (x[:, None] - length) ** 2)).sum(axis=1)
    terms, codes = Terms(length, strength, np.array([1, 0, -1]), np.ones(3, int)), np.array(["0", "13"])
    return Spectrum(1.6, None, 30.0, x, waves, 2j * waves if quantum else None, complete, terms, codes)


@pytest.mark.parametrize(("levels", "complete"), [(True, 5.0), (True, 2.0), (False, 9.0), (False, 8.9)])
def test_the_length_spectrum(ax, rng, levels, complete):
    found = spectrum(rng, levels, complete)
    curves.draw_spectrum(ax, found, lambda code: f"<{code}>")
    side = 1 if levels else -1
    missing = ["orbits may be missing"] if complete < 9 else []
    assert legend(ax) == [*["levels"] * levels, "orbits, downwards", *missing]
    np.testing.assert_allclose(named(ax, "orbits"), [found.length, -np.abs(found.orbits)])
    if found.quantum is not None:
        np.testing.assert_allclose(named(ax, "levels"), [found.length, np.abs(found.quantum)])
    for band in ax.patches:
        assert (band.get_x(), band.get_x() + band.get_width()) == pytest.approx((max(3, complete), 9))
    tops = np.abs(found.terms.amplitude) * (2 if levels else 1)
    for code, at, top in zip(("<13>", "<0>", "<02>"), (4, 6, 8), tops, strict=True):
        assert texts(ax)[code] == pytest.approx((at, side * top), abs=0.02)
    assert all(np.sign(each.xyann[1]) == side for each in ax.texts)
    assert {each.get_va() for each in ax.texts} == {"bottom" if levels else "top"}
    low, high = -np.abs(found.orbits).max(), tops.max() if levels else 0
    assert ax.get_xlim() == (3, 9)
    assert ax.get_ylim() == pytest.approx((low - 0.25 * (high - low), high + 0.25 * (high - low)), abs=0.02)
    says(ax, "length $x/R$", r"$|F(x)|$")


def test_the_number_of_levels(rng):
    above, below = Figure().subplots(2)
    k, at = np.sort(rng.uniform(0, 9, 40)), np.linspace(0.5, 9, 30)
    smooth, family, orbits = rng.uniform(-1, 1, (3, 30))
    curves.draw_level_count(above, below, k, at, smooth, family, orbits, 11)
    (steps, weyl), (rest, balls, both) = above.lines, below.lines
    assert steps.get_drawstyle() == "steps-post"
    np.testing.assert_array_equal(steps.get_data(), [[0, *k], range(41)])
    np.testing.assert_array_equal(weyl.get_data(), [at, smooth])
    np.testing.assert_allclose(rest.get_data(), [at, [bisect_left(k, each) for each in at] - smooth])
    np.testing.assert_array_equal(balls.get_data(), [at, family])
    np.testing.assert_allclose(both.get_data(), [at, family + orbits])
    assert legend(above) == ["levels", "Weyl's law"]
    part = "bouncing balls and orbits to $p = 11$, a partial sum"
    assert legend(below) == ["levels, less Weyl's law", "bouncing balls", part]
    says(above, "", "levels below $k$")
    says(below, "$kR$", "fluctuation")


def test_run_time_against_error(ax, rng):
    methods = ("balls", "newton", "relaxation", "root")
    rows = [
        WorkPrecision(method, 0.0, 1, 0.0, seconds, 0, error, *[0.0] * 5)
        for method in methods
        for error, seconds in rng.uniform(1e-16, 1e-3, (3, 2)).tolist()
    ]
    curves.draw_work_precision(ax, rows)
    assert len(legend(ax)) == 4
    for method, label in zip(methods, ("ball arithmetic", "Newton", "relaxation", "scipy"), strict=True):
        mine = [(row.coordinates_max, row.seconds_per_sequence) for row in rows if row.method == method]
        assert named(ax, label).T.tolist() == [[*each] for each in mine]
    assert ax.lines[-1].get_xdata() == [np.finfo(float).eps / 2] * 2
    assert texts(ax) == {"double": (np.finfo(float).eps / 2, 0)}
    assert (ax.get_xscale(), ax.get_yscale()) == ("log", "log")
    says(ax, "largest error of a coordinate (units of $R$, rad)", "run time per word (s)")
