"""The figure of the symbol plane shows every point, the fronts, and what they and the rules forbid."""

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from figures import legend, named
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_hex
from there import there

from orbitdb import Catalogue, PruningFront, Selection
from orbitdb.errors import InputError
from orbitdb.orbits.status import Status
from orbitdb.plots import symbol_plane as figures
from orbitdb.plots.registry import EmptyFigureError
from orbitdb.plots.style import BLUE, ORANGE, sized
from orbitdb.plots.symbol_plane import symbol_plane

CHOSEN = Selection(1.6, periods=((2, 6),))
CURVED = {"0": False, "2": False, **dict.fromkeys("1345", True)}


def bounces(known: Catalogue) -> dict[bool, dict[str, np.ndarray]]:
    """Return the points of the bounces on walls and on semicircles, by the status of their words."""
    found: dict[bool, dict[str, list[Any]]] = {
        curved: {"orbit": [], "dynamical": []} for curved in (False, True)
    }
    for orbit in known.select(CHOSEN):
        if orbit.status in ("orbit", "dynamical"):
            for symbol, point in zip(orbit.code, there(orbit.symbol_plane), strict=True):
                found[CURVED[symbol]][orbit.status].append(point)
    return {curved: {name: np.array(each) for name, each in part.items()} for curved, part in found.items()}


def cell(image: Any, point: np.ndarray) -> str:
    """Return the colour of the image at a point of the plane."""
    colours = image.get_array()
    column, row = (np.array(point) * len(colours)).astype(int)
    return to_hex(colours[row, column])


@pytest.mark.slow
def test_every_point_is_drawn_in_the_colour_of_its_word(known):
    made: Any = symbol_plane(known, CHOSEN)
    front, expected = PruningFront(1.6), bounces(known)
    for ax, curved in zip(made.axes, (False, True), strict=True):
        (image,) = ax.images
        assert [*image.get_extent()] == [0, 1, 0, 1]
        points = expected[curved]
        allowed = front.allows_points(points["dynamical"], np.full(len(points["dynamical"]), curved))
        beyond = points["dynamical"][~allowed]
        assert len(beyond) > 0
        assert {cell(image, point) for point in beyond} == {ORANGE}
        assert {cell(image, point) for point in points["orbit"]} <= {BLUE, ORANGE}
        filled = {tuple(place) for place in np.argwhere(image.get_array()[..., 3] > 0).tolist()}
        every = np.concatenate([*points.values()])
        size = len(image.get_array())
        assert filled == {tuple(place[::-1]) for place in (every * size).astype(int).tolist()}
        assert ax.get_xlim() == ax.get_ylim() == (0, 1)
    words = ["pruned, inside", "orbits", "pruned, beyond"]
    assert legend(made.axes[0]) == ["pruning front", *words]
    assert made.get_suptitle() == "Orbits and dynamically pruned words of period 2 to 6 at $a = 1.6$"


@pytest.mark.slow
def test_the_drawn_front_separates_points_as_the_front_does(known):
    """Points near the line aside. Where the front of walls jumps, rules 4 and 6 forbid what is below it."""
    made: Any = symbol_plane(known, CHOSEN)
    rng, front = np.random.default_rng(1), PruningFront(1.6)
    for ax, each in zip(made.axes, (front.walls, front.semicircles), strict=True):
        gamma, delta = named(ax, "pruning front")
        (area, _) = (patch for patch in ax.patches if len(patch.get_path().vertices) > 10)
        assert (gamma[-1], delta[0]) == (1, 1)
        points = rng.random((2000, 2))
        shaded = area.get_path().contains_points(points)
        curve = np.stack([gamma, delta], axis=1)
        far = np.abs(points[:, None] - curve).max(axis=-1).min(axis=-1) > 0.05
        ruled_out = (points > 0.5).all(axis=1) & (points < 0.74).all(axis=1) & (not each.curved)
        told = far & ~ruled_out
        np.testing.assert_array_equal(shaded[told], ~each.below(*points[told].T))
        assert told.sum() > 1000
        assert not shaded[ruled_out & (points < 0.72).all(axis=1)].any()


@pytest.mark.slow
def test_axes_name_the_next_and_the_previous_bounce(known):
    """Every orbit has the next symbol that the interval of its gamma names, and the previous one of delta."""
    made: Any = symbol_plane(known, CHOSEN)
    for orbit in known.select(p=6, status="orbit"):
        code, points = orbit.code, there(orbit.symbol_plane)
        for n, symbol in enumerate(code):
            if symbol in "03" or (symbol == "5" and "5" in (code[n - 1], code[(n + 1) % 6])):
                ax = made.axes[CURVED[symbol]]
                beside = (code[(n + 1) % 6], ax.get_xticklabels()), (code[n - 1], ax.get_yticklabels())
                for value, (symbol_there, labels) in zip(points[n], beside, strict=True):
                    name, symbols = labels[int(value * len(labels))].get_text().split("\n")
                    assert symbol_there in symbols.split(", "), (code, n, name)


@pytest.mark.slow
def test_several_a_give_their_fronts_alone(known):
    made = symbol_plane(known, Selection(0.5), Selection(1.6))
    for ax, kind in zip(made.axes, ("walls", "semicircles"), strict=True):
        assert legend(ax) == ["$a = 0.5$", "$a = 1.6$"]
        for a in (0.5, 1.6):
            gamma, delta = named(ax, f"$a = {a}$")
            front = getattr(PruningFront(a), kind)
            gap = np.abs(gamma - front.gamma[:, None]) + np.abs(delta - front.delta[:, None])
            assert gap.min(axis=1).max() < 2.5e-3
        assert not ax.images
    assert made.get_suptitle() == "Pruning fronts at $a = 0.5$, 1.6"


def test_a_front_can_be_plotted():
    front = PruningFront(1.6).semicircles
    ax = front.plot()
    assert ax.get_title() == "Pruning front at $a = 1.6$"
    assert len(named(ax, "pruning front")[0]) > 100


def test_words_without_points_are_refused(known, monkeypatch):
    with pytest.raises(InputError, match="have points: `status='orbit,dynamical'`"):
        symbol_plane(known, Selection(1.6, statuses=(Status.GEOMETRIC,)))
    with pytest.raises(EmptyFigureError, match="nothing to draw"):
        symbol_plane(known, Selection(1.6, periods=((2, 3),), where="length > 99"))
    monkeypatch.setattr(figures, "MOST_WORDS", 10)
    with pytest.raises(InputError, match="draw at most 10"):
        symbol_plane(known, CHOSEN)


@pytest.mark.slow
def test_the_command_draws_points_at_one_a_and_fronts_at_several(cli, known, tmp_path):
    target = tmp_path / "plane.svg"
    done = cli("plot", "symbol-plane", "--p", "2-4", "--db", str(known.path), "-o", str(target))
    told = done.err.splitlines()[0]
    assert told.endswith(f"orbits and dynamically pruned words of period 2 to 4 at a = 1.6, in {target}")
    several = ("plot", "symbol-plane", "--a", "1", "--a", "2", "--db", str(known.path))
    done = cli(*several, "-o", str(tmp_path / "fronts.svg"))
    assert done.code == 0
    assert "<image" not in (tmp_path / "fronts.svg").read_text()
    refused = cli(*several, "--p", "3", "-o", str(tmp_path / "x.svg"))
    assert refused.code == 2
    assert "leave out the options that choose words" in refused.err


@pytest.mark.slow
def test_a_figure_higher_than_wide_has_one_plane_below_the_other(known):
    for size, places in (((7.2, 4.8), [False, True]), ((3.4, 7.4), [True, False])):
        with sized(size):
            made = symbol_plane(known, Selection(1.6), Selection(2.0))
        FigureCanvasAgg(made).draw()
        first, second = (ax.get_window_extent() for ax in made.axes)
        assert [first.y0 > second.y1, first.x1 < second.x0] == places
        assert first.width == pytest.approx(second.width, abs=1)


@pytest.mark.slow
@pytest.mark.parametrize("size", [(3.39, 2.6), (3.39, 4.24), (7.01, 4.2)])
def test_names_titles_and_legend_keep_apart(known, size):
    with sized(size):
        made = symbol_plane(known, CHOSEN)
    FigureCanvasAgg(made).draw()
    for ax in made.axes:
        for axis, side in ((ax.xaxis, "x"), (ax.yaxis, "y")):
            ends = [getattr(each.get_window_extent(), f"interval{side}") for each in axis.get_ticklabels()]
            assert all(one[1] < following[0] for one, following in pairwise(ends))
        around: Any = ax.get_tightbbox()
        assert made.bbox.x0 <= around.x0 < around.x1 <= made.bbox.x1
        assert made.legends[0].get_window_extent().y1 < around.y0
        (title,) = (text for text in made.texts if text.get_text() == made.get_suptitle())
        assert around.y1 < title.get_window_extent().y0
