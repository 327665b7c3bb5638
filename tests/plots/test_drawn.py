"""Every figure shows just the numbers that it is given: read back from its axes, and computed plainly."""

import math
from bisect import bisect_left, bisect_right
from collections import Counter
from itertools import pairwise

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import LogNorm, to_hex
from matplotlib.figure import Figure

from orbitdb import Stadium
from orbitdb.benchmarks.work_precision import WorkPrecision
from orbitdb.billiard.stability import birkhoff
from orbitdb.plots import axes, births, curves, paths, quantum, style, work_precision
from orbitdb.quantum.amplitudes import Terms
from orbitdb.quantum.spectrum import Spectrum

A = np.geomspace(0.02, 9.0, 50)


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(1)


@pytest.fixture
def ax():
    with style.figure(6.4, 4.2) as made:
        yield made.add_subplot()


def legend(ax) -> list[str]:
    """Return what a legend of the axes says; its lines can be told apart by colour, dash and marker."""
    named = dict(zip(*ax.get_legend_handles_labels()[::-1], strict=True))
    lines = [each for each in named.values() if hasattr(each, "get_marker")]
    looks = {(to_hex(each.get_color()), each.get_linestyle(), each.get_marker()) for each in lines}
    assert len(looks) == len(lines)
    return [*named]


def named(ax, label: str) -> np.ndarray:
    """Return the points of a line, shape (2, n)."""
    (found,) = (each for each in ax.lines if str(each.get_label()).startswith(label))
    return np.array(found.get_data(), dtype=float)


def heights(filled) -> set[float]:
    """Return all heights of the edge of a band."""
    return set(filled.get_paths()[0].vertices[:, 1].round(9).tolist())


def texts(ax) -> dict[str, tuple]:
    return {each.get_text(): each.xy for each in ax.texts if each.get_text()}


def over_a(ax, label: str) -> None:
    assert (ax.get_xscale(), ax.get_xlim(), ax.get_ylabel()) == ("log", (A[0], A[-1]), label)


def test_births_and_deaths(rng):
    shares, entropies, changes = Figure().subplots(3)
    periods, places, shown = {}, {}, []
    for p in range(5, 11):
        born, died = np.sort(rng.choice(A, 9)), np.sort(rng.choice(A[25:], 4))
        words, gone = 8 * rng.integers(5, 9, 9), rng.integers(1, 9, 4)
        periods[p], places[p] = births.Steps.of(born, died, words, gone), np.concatenate([born, died])
        some = np.array([words[born <= at].sum() - gone[died <= at].sum() for at in A])
        np.testing.assert_array_equal(periods[p].at(A), some)  # those at a, too
        assert periods[p].words == words.sum() - gone.sum()
        assert (np.diff(periods[p].a) >= 0).all()
        shown.append(some / periods[p].words)
    births.draw_shares(shares, periods, A)
    over_a(shares, r"$N_c(p; a)\,/\,N_t(p)$")
    assert legend(shares) == [f"$p = {p}$" for p in periods]
    assert len({each.get_linestyle() for each in shares.lines[:4]}) == 4
    for p, share in zip(periods, shown, strict=True):
        np.testing.assert_allclose(named(shares, f"$p = {p}$"), [A, share])
    assert shares.get_ylim() == (0, 1.03)
    births.draw_entropies(entropies, dict(zip(periods, shown, strict=True)), A, 1.2)
    over_a(entropies, "topological entropy")
    assert legend(entropies) == [*(f"$h({p}; a)$" for p in periods), "bound at every $a$"]
    np.testing.assert_array_equal([each.get_ydata() for each in entropies.lines[:-1]], shown)
    assert entropies.lines[-1].get_ydata() == [1.2, 1.2]
    births.draw_changes(changes, {4: np.zeros(0), **places}, A)
    over_a(changes, "share of births and deaths")
    assert [each.get_label() for each in changes.patches] == [f"$p = {p}$" for p in (4, *periods)][:6]
    for each, at in zip(changes.patches, ([], *places.values()), strict=False):
        share, edges, _ = each.get_data()
        np.testing.assert_allclose(np.diff(np.log(edges)), math.log(9 / 0.02) / 60)
        bins = Counter(min(bisect_right(edges, place) - 1, 59) for place in at)  # an edge: the bin behind
        assert share.tolist() == [bins[k] / max(len(at), 1) for k in range(60)]


def test_a_number_of_one_orbit_over_a(ax, rng):
    values = np.where(A > 1, rng.uniform(size=50), np.nan)
    births.draw_followed(ax, A, values, "length", [1.0, 3.0], style.GREEN)
    over_a(ax, "length")
    np.testing.assert_array_equal(ax.lines[0].get_data(), [A, values])
    assert to_hex(ax.lines[0].get_color()) == style.GREEN
    assert [each.get_xdata() for each in ax.lines[1:]] == [[1, 1], [3, 3]]
    assert legend(ax) == ["birth or death"]


def says(ax, x: str, y: str) -> None:
    assert (ax.get_xlabel(), ax.get_ylabel()) == (x, y)


def by_period(ax, label: str) -> None:
    says(ax, "period $p$ (bounces)", label)
    assert all(tick == round(tick) for tick in ax.get_xticks())


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
    assert texts(ax) == {"↓ 0.1000": (2, pytest.approx(low))}  # what lies below is told
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
    dots = curves.draw_phase_space(ax, stadium, *values)
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
    drawn = curves.draw_density(other, p, length, count)
    edges = np.linspace(length.min() - 0.5, length.max() + 0.5, 121)
    np.testing.assert_allclose(drawn.get_coordinates()[0, :, 0], edges)
    np.testing.assert_array_equal(drawn.get_coordinates()[:, 0, 1], [1.5, 2.5, 3.5, 4.5])
    for period, row in zip((2, 3, 4), drawn.get_array(), strict=True):
        orbits = Counter()
        for each, some in zip(length[p == period], count[p == period], strict=True):
            orbits[bisect_right(edges, each) - 1] += int(some)
        assert row.filled(0) * (edges[1] - edges[0]) == pytest.approx([orbits[k] for k in range(120)])
        assert row.mask.tolist() == [not orbits[k] for k in range(120)]
    assert (isinstance(drawn.norm, LogNorm), drawn.get_cmap().name) == (True, "viridis")
    says(other, "length $L/R$", "period $p$ (bounces)")
    assert all(tick == round(tick) for tick in other.get_yticks())


def test_bounds_over_a(ax, rng):
    lower, upper = np.sort(rng.uniform(0.2, 1.1, (2, 50)), axis=0)
    drawn = {p: rng.uniform(0.5, 1, (2, 9)) for p in (5, 6)}
    births.draw_entropy_over_a(ax, A, lower, upper, drawn, 1.2)
    assert heights(ax.collections[0]) == {*lower.round(9).tolist(), *upper.round(9).tolist()}
    ((_, caps, (bars,)),) = ax.containers
    np.testing.assert_allclose([each[:, 1] for each in bars.get_segments()], np.stack([lower, upper], axis=1))
    np.testing.assert_array_equal([each[:, 0] for each in bars.get_segments()], np.stack([A, A], axis=1))
    assert len(caps) == 2
    by = [f"$h({p}; a)$, from births" for p in drawn]
    assert sorted(legend(ax)) == [*by, "bound at every $a$", "proved bounds"]
    assert all(np.array_equal(named(ax, f"$h({p}; a)$"), values) for p, values in drawn.items())
    assert named(ax, "bound at")[1].tolist() == [1.2, 1.2]
    assert ax.get_ylim() == pytest.approx((lower.min() - 0.02, 1.22))
    assert ax.get_xscale() == "log"
    says(ax, "$a$", "topological entropy (per bounce)")


@pytest.mark.parametrize(("p", "a"), [(2, 1.6), (12, 20), (13, 19), (24, 0.1), (25, 50), (60, 0.6), (61, 1)])
def test_a_path_with_its_arrows_and_numbers(ax, rng, p, a):
    stadium = Stadium(a)
    points = stadium.outline()[rng.permutation(128)[:p]]
    paths.draw_orbit(ax, stadium, points, style.ORANGE)
    closed = np.concatenate([points, points[:1]]).tolist()
    (path,) = (each for each in ax.lines if each.get_xydata().tolist() == closed)
    dots = [each for each in ax.lines if each.get_marker() == "o"]
    assert [each.get_xydata().tolist() for each in dots] == [points.tolist()] * (p <= 60)
    assert (path.get_linewidth() > 1) == (p <= 60)
    assert {to_hex(each.get_color()) for each in (path, *dots)} == {style.ORANGE}
    arrows = [each for each in ax.texts if not each.get_text()]
    ahead = (np.roll(points, -1, axis=0) - points)[: p if p <= 12 else 1]
    np.testing.assert_allclose([each.xy for each in arrows], points[: len(ahead)] + 0.65 * ahead)
    tails = np.array([np.subtract(each.xy, each.xyann) for each in arrows])
    np.testing.assert_allclose(tails, 1e-3 * ahead / np.hypot(*ahead.T)[:, None], atol=1e-9)
    numbers = [int(number) for text in texts(ax) for number in text.split(", ")]
    assert sorted(numbers) == ([*range(1, p + 1)] if p <= 24 else [])
    for text, where in texts(ax).items():
        assert math.dist(points[int(text.split(",")[0]) - 1], where) < 0.2
    circles = [each.get_xydata() for each in ax.lines if len(each.get_xydata()) == 200]
    for centre, circle in zip((-a, a), circles, strict=True):
        np.testing.assert_allclose(np.hypot(*(circle - [centre, 0]).T), 1)
        assert np.ptp(circle, axis=0) == pytest.approx([2, 2], abs=1e-3)
    outline = next(each for each in ax.lines if np.array_equal(each.get_xydata(), stadium.outline()))
    levels = [each.get_zorder() for each in (ax.collections[0], outline, path, *dots)]
    assert levels == sorted({*levels})
    (left, right), (low, high) = ax.get_xlim(), ax.get_ylim()
    assert left == -right < -a - 1
    assert low == -high < -1
    walls = ax.collections[0].get_segments()
    assert [each.tolist() for each in walls] == [[[left, y], [right, y]] for y in (-1, 1)]
    assert (ax.get_aspect(), ax.get_yticks().tolist()) == (1 if a < 20 else "auto", [-1, 0, 1])
    says(ax, "$x/R$", "$y/R$")


@pytest.mark.parametrize(("count", "columns"), [(6, 3), (7, 3), (1, 1)])
def test_a_sheet_holds_all_that_is_on_it(ax, rng, count, columns):
    stadium = Stadium(0.7)
    drawn = [stadium.outline()[rng.permutation(128)[:4]] for _ in range(count)]
    paths.draw_sheet(ax, stadium, drawn, [str(k) for k in range(count)], columns)
    walls, closed = (each.get_segments() for each in ax.collections)
    centres = np.array([(wall.min(axis=0) + wall.max(axis=0)) / 2 for wall in walls])
    places = centres - centres[0]
    wide, high = 2 * 1.7 + 0.6, 3.1
    np.testing.assert_allclose(places, [(k % columns * wide, -(k // columns) * high) for k in range(count)])
    for path, each, centre in zip(drawn, closed, centres, strict=True):
        np.testing.assert_allclose(each - centre, [*path, path[0]], atol=1e-12)
    np.testing.assert_allclose(ax.lines[0].get_xydata(), np.concatenate([each[:-1] for each in closed]))
    np.testing.assert_allclose([*texts(ax).values()], centres - [0, 1.12])
    assert ax.get_xlim() == pytest.approx((-wide / 2, (columns - 0.5) * wide))
    assert ax.get_ylim() == pytest.approx((centres[-1, 1] - 1.75, 1.25))
    assert (ax.get_aspect(), ax.axison) == (1, False)


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
    quantum.draw_spectrum(ax, found, lambda code: f"<{code}>")
    side = 1 if levels else -1
    missing = ["orbits may be missing"] if complete < 9 else []
    assert legend(ax) == [*["levels"] * levels, "orbits, downwards", *missing]
    np.testing.assert_allclose(named(ax, "orbits"), [found.length, -np.abs(found.orbits)])
    if levels:
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
    quantum.draw_level_count(above, below, k, at, smooth, family, orbits, 11)
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
    work_precision.draw_work_precision(ax, rows)
    assert len(legend(ax)) == 4
    for method, label in zip(methods, ("ball arithmetic", "Newton", "relaxation", "scipy"), strict=True):
        mine = [(row.coordinates_max, row.seconds_per_sequence) for row in rows if row.method == method]
        assert named(ax, label).T.tolist() == [[*each] for each in mine]
    assert ax.lines[-1].get_xdata() == [np.finfo(float).eps / 2] * 2
    assert texts(ax) == {"double": (np.finfo(float).eps / 2, 0)}
    assert (ax.get_xscale(), ax.get_yscale()) == ("log", "log")
    says(ax, "largest error of a coordinate (units of $R$, rad)", "run time per word (s)")


@pytest.mark.slow
def test_axes_are_the_given_ones_or_new_ones(ax, rng):
    from matplotlib import pyplot  # it takes as long as ten tests

    given = axes.orbit_axes("1" * 41, Stadium(1.6), Stadium(1.6).outline()[:3], ax)
    assert (given, given.get_title()) == (ax, "1" * 37 + "...")
    words, x, colour = (
        rng.integers(0, 4, (5, 3)).astype(np.uint8),
        rng.uniform(-1, 1, (5, 3)),
        rng.uniform(size=5),
    )
    cloud = axes.phase_space_axes(
        "orbits", Stadium(1.6), [(words, x, colour), (words[:, :2], x[:, :2], colour)], None
    )
    (dots,) = cloud.collections
    both = [birkhoff(Stadium(1.6), words[:, :p], x[:, :p]) for p in (3, 2)]
    np.testing.assert_array_equal(
        dots.get_offsets(), np.concatenate([np.reshape(each, (2, -1)).T for each in both])
    )
    assert dots.get_array().tolist() == [c for p in (3, 2) for c in colour for _ in range(p)]
    steps = axes.lengths_axes("all the orbits " * 12, np.array([4.0, 2.0, 3.0]), None)
    assert steps.lines[0].get_xydata().tolist() == [[2, 1], [3, 2], [4, 3]]
    assert len({ax.figure, cloud.figure, steps.figure}) == 3
    assert len(steps.get_title().splitlines()) == 3
    FigureCanvasAgg(steps.figure).draw()
    assert steps.title.get_window_extent().width <= steps.get_window_extent().width
    pyplot.close("all")
