"""Every figure shows just the numbers that it is given: read back from its axes, and computed plainly."""

import math
from itertools import pairwise

import numpy as np
import pytest
from figures import legend, named, says, texts

from orbitdb import Stadium
from orbitdb.benchmarks.work_precision import WorkPrecision
from orbitdb.billiard.stability import birkhoff
from orbitdb.cli.figures.work_precision import draw_work_precision
from orbitdb.plots import paths


@pytest.mark.parametrize(("count", "size"), [(100, 12), (20_000, 3), (210_000, 0.3)])
def test_phase_space(ax, rng, count, size):
    stadium, (x, colour) = Stadium(0.7), rng.uniform(-1, 1, (2, count // 2, 2))
    words = rng.integers(0, 4, x.shape).astype(np.uint8)
    dots = paths.draw_phase_space(ax, stadium, [(words, x, colour[:, 0])])
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
    says(ax, "$s/R$", r"$\sin\,\varphi$")


def test_run_time_against_error(rng):
    methods = ("balls", "newton", "relaxation", "root")
    rows = [
        WorkPrecision(method, 0.0, 1, 0.0, seconds, 0, error, *[0.0] * 5)
        for method in methods
        for error, seconds in rng.uniform(1e-16, 1e-3, (3, 2)).tolist()
    ]
    made = draw_work_precision(rows, "p = 4")
    (ax,) = made.axes
    assert ax.get_title() == "run time against error, p = 4"
    assert len(made.legends[0].get_texts()) == 4
    assert len(legend(ax)) == 4
    for method, label in zip(methods, ("ball arithmetic", "Newton", "relaxation", "scipy"), strict=True):
        mine = [(row.coordinates_max, row.seconds_per_sequence) for row in rows if row.method == method]
        assert named(ax, label).T.tolist() == [[*each] for each in mine]
    assert ax.lines[-1].get_xdata() == [np.finfo(float).eps / 2] * 2
    assert texts(ax) == {"double": (np.finfo(float).eps / 2, 0)}
    assert (ax.get_xscale(), ax.get_yscale()) == ("log", "log")
    says(ax, "largest error of a coordinate (units of $R$, rad)", "run time per word (s)")
