"""Paths in the stadium: an orbit, its reverse, labels and arrows, and bounces in phase space."""

import math
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from figures import paths_of, says, texts
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_hex
from matplotlib.text import Annotation
from numpy.typing import NDArray
from there import there

from orbitdb import Stadium, solve_word
from orbitdb.billiard.stability import birkhoff
from orbitdb.plots import lengths, orbits, paths, phase_space, style
from orbitdb.plots.style import BLUE, ORANGE


def arrows(ax) -> list[NDArray[np.float64]]:
    """Return the directions of the arrows on the axes."""
    tips = [each for each in ax.texts if isinstance(each, Annotation) and each.arrow_patch is not None]
    return [np.subtract(each.xy, each.xyann) for each in tips]


@pytest.mark.parametrize(("word", "same"), [("010232", True), ("1232131", False)])
def test_the_reverse_is_drawn_backwards(word, same):
    orbit = solve_word(word, 1.6)
    points = there(orbit.points)
    made = orbits.reverse(orbit)
    above, below = made.axes
    ((forth, colour),) = paths_of(above, orbit.p)
    ((back, other),) = paths_of(below, orbit.p)
    assert np.array_equal(forth, points)
    assert np.array_equal(back, points[::-1])
    assert (colour, other) == (BLUE, BLUE if same else ORANGE)
    ahead = np.diff(points, axis=0)[0]
    assert np.dot(arrows(above)[0], ahead) > 0 > np.dot(arrows(below)[-2], ahead)
    caption = f"{word},  $a = 1.6$,  $L = {orbit.length:.4f}\\,R$,  $\\lambda = {orbit.lyapunov:.4f}$"
    kind = "the same orbit: it retraces its path" if same else "another orbit, counted separately"
    assert above.get_title() == f"(a) {caption}"
    reverse = below.get_title().removeprefix("(b) Its time reverse ").removesuffix(f": {kind}")
    np.testing.assert_allclose(there(solve_word(reverse, 1.6).points), back, atol=1e-12)
    alone = orbits.orbit(orbit)
    assert alone.axes[0].get_title() == caption
    assert np.array_equal(paths_of(alone.axes[0], orbit.p)[0][0], points)


def test_titles_abbreviate_long_words():
    assert style.short("1" * 29 + "3") == "1" * 29 + "3"
    assert style.short("1" * 30 + "3") == "1^30 3"
    assert style.short("0102031323" * 4 + "3") == "0102031323" * 2 + "0102031..."


@pytest.mark.parametrize(("p", "a"), [(2, 1.6), (12, 20), (13, 19), (24, 0.1), (25, 50), (60, 0.6), (61, 1)])
def test_a_path_has_arrows_and_numbers_unless_it_is_long(ax, rng, p, a):
    stadium = Stadium(a)
    points = stadium.outline()[rng.permutation(128)[:p]]
    symbols = "".join(rng.permutation([*"012345" * 11])[:p])
    paths.draw_orbit(ax, stadium, points, symbols, style.ORANGE)
    closed = np.concatenate([points, points[:1]]).tolist()
    assert [each.get_xydata().tolist() for each in ax.lines].count(closed) == 1
    first = [each for each in ax.lines if to_hex(str(each.get_markerfacecolor())) == "#ffffff"]
    assert [each.get_xydata().tolist() for each in first] == [points[:1].tolist()] * (p <= 24)
    dots = [each for each in ax.lines if each.get_marker() == "o" and each not in first]
    assert [each.get_xydata().tolist() for each in dots] == [points.tolist()] * (p <= 60)
    arrows = [each for each in ax.texts if not each.get_text()]
    ahead = (np.roll(points, -1, axis=0) - points)[: p if p <= 12 else 1]
    np.testing.assert_allclose([each.xy for each in arrows], points[: len(ahead)] + 0.65 * ahead)
    labels: Any = [each for each in ax.texts if each.get_text() not in ("", "not to scale")]
    assert (len(labels) < sum(bool(each.get_text()) for each in ax.texts)) == (a >= 20)
    assert bool(labels) == (p <= 24)
    for symbol, point in zip(symbols, points, strict=True) if labels else ():
        nearest = min(labels, key=lambda label: math.dist(label.xy, point))
        assert math.dist(nearest.xy, point) < 0.2
        assert symbol in nearest.get_text().split(", ")


@pytest.mark.slow
def test_as_many_wall_labels_are_shown_as_fit_without_touching(ax):
    counts = set()
    for a in np.geomspace(0.02, 50, 30).tolist():
        ax.clear()
        paths.draw_orbit(ax, Stadium(a), Stadium(a).outline()[:3], "010")
        ax.figure.draw_without_rendering()
        labels = [label.get_window_extent() for label in ax.get_xticklabels()]
        assert all(right.x0 - left.x1 > 3 for left, right in pairwise(labels)), a
        counts.add(len(labels))
        (begin, _), (end, _) = ax.transData.transform([(0, 0), (min(a, 1), 0)])
        assert len(labels) == 5 or end - begin < 1.5 * max(label.width for label in labels), a
        assert (ax.get_xticks()[0], ax.get_xticks()[-1]) == (-a - 1, a + 1)
    assert counts == {3, 5}


@pytest.mark.slow
def test_pictures_use_given_axes_or_make_new_ones(ax, rng):
    from matplotlib import pyplot  # importing it takes as long as ten tests

    given = paths.draw_titled(
        paths.draw_orbit, (Stadium(1.6), Stadium(1.6).outline()[:3], "010"), "$5 or $6", ax
    )
    assert (given, given.get_title()) == (ax, r"\$5 or \$6")
    words, x, colour = (
        rng.integers(0, 4, (5, 3)).astype(np.uint8),
        rng.uniform(-1, 1, (5, 3)),
        rng.uniform(size=5),
    )
    what = Stadium(1.6), [(words, x, colour), (words[:, :2], x[:, :2], colour)]
    cloud = paths.draw_titled(phase_space.draw_phase_space, what, "orbits", None)
    (dots,) = cloud.collections
    both = [birkhoff(Stadium(1.6), words[:, :p], x[:, :p]) for p in (3, 2)]
    np.testing.assert_array_equal(
        dots.get_offsets(), np.concatenate([np.reshape(each, (2, -1)).T for each in both])
    )
    assert there(dots.get_array()).tolist() == [c for p in (3, 2) for c in colour for _ in range(p)]
    pyplot.gcf().draw_without_rendering()
    names = [text.get_window_extent().y1 for text in cloud.texts]
    assert cloud.title.get_window_extent().y0 > max(names, default=math.inf)
    steps: Any = paths.draw_titled(
        lengths.draw_lengths, (np.array([4.0, 2.0, 3.0]), np.ones(3)), "all the orbits " * 12, None
    )
    assert steps.lines[0].get_xydata().tolist() == [[2, 1], [3, 2], [4, 3]]
    assert len({ax.figure, cloud.figure, steps.figure}) == 3
    assert len(steps.get_title().splitlines()) == 3
    FigureCanvasAgg(steps.figure).draw()
    assert steps.title.get_window_extent().width <= steps.get_window_extent().width
    pyplot.close("all")


@pytest.mark.parametrize(("count", "size"), [(100, 12), (20_000, 3), (210_000, 0.3)])
def test_phase_space_shows_all_bounces_and_names_the_walls(ax, rng, count, size):
    stadium, (x, colour) = Stadium(0.7), rng.uniform(-1, 1, (2, count // 2, 2))
    words = rng.integers(0, 4, x.shape).astype(np.uint8)
    dots: Any = phase_space.draw_phase_space(ax, stadium, [(words, x, colour[:, 0])]).drawn
    places = np.reshape(birkhoff(stadium, words, x), (2, count))
    np.testing.assert_array_equal(dots.get_offsets().T, places)
    colours = np.repeat(colour[:, 0], 2)
    np.testing.assert_array_equal(dots.get_array(), colours)
    assert dots.get_clim() == pytest.approx(np.quantile(colours, [0.02, 0.98]))
    assert (dots.get_sizes(), dots.get_linewidth(), dots.get_cmap().name) == ([size], [0], "viridis")
    assert dots.get_rasterized()
    ends = [0, 1.4, 1.4 + math.pi, 2.8 + math.pi, 2.8 + 2 * math.pi]
    assert [each.get_xdata()[0] for each in ax.lines] == pytest.approx(ends[1:4])
    middles = [(x + y) / 2 for x, y in pairwise(ends)]
    assert [where[0] for where in texts(ax).values()] == pytest.approx(middles)
    assert [*texts(ax)] == ["0: bottom", "3, 5: right", "2: top", "1, 4: left"]
    assert all(where[1] > 1 for where in texts(ax).values())
    assert (ax.get_xlim(), ax.get_ylim()) == ((0, pytest.approx(ends[-1])), (-1, 1))
    says(ax, "arc length $s/R$", r"$\sin\alpha$")
