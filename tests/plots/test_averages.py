"""Figures of averages: integer periods, legends that cover nothing, and only what stands."""

import numpy as np
import pytest
from drawing import draw
from matplotlib.backends.backend_agg import FigureCanvasAgg
from quick import slow_but

from orbitdb import Catalogue
from orbitdb.store.asking.criteria import choose

KINDS = ("entropy", "lyapunov")


def drawn(catalogue, kind, **criteria):
    """Draw a figure of a subset and lay it out."""
    made = draw(kind, catalogue, choose(status="orbit", **criteria), 0)
    FigureCanvasAgg(made).draw()
    return made


def zeta_points(made):
    """Return the periods at which a zeta value is drawn, of each of the axes that has one."""
    found = []
    for ax in made.axes:
        lines = [line for line in ax.lines if line.get_marker() == "s"]
        points = np.concatenate([line.get_xydata() for line in lines])
        found.append(points[np.isfinite(points).all(axis=1), 0].tolist())
    return found


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("p", [None, "4", "3,5-6"])
def test_ticks_are_periods_and_no_legend_covers_a_point(filled, kind, p):
    made = drawn(Catalogue(filled), kind, p=p)
    boxes = [legend.get_window_extent() for legend in [*made.legends, *(ax.get_legend() for ax in made.axes)]
             if legend is not None]  # fmt: skip
    assert boxes
    for ax in made.axes:
        assert all(tick == round(tick) for tick in ax.get_xticks())
        assert any(ax.get_xlim()[0] <= tick <= ax.get_xlim()[1] for tick in ax.get_xticks())
        for box in boxes:
            assert not box.overlaps(ax.get_window_extent())
            for line in ax.lines:
                points = ax.transData.transform(np.ma.masked_invalid(line.get_xydata()).filled(-1e9))
                assert not any(box.contains(*point) for point in points)


@pytest.mark.slow
@pytest.mark.parametrize("kind", slow_but([*KINDS][:1], KINDS))
def test_only_zeta_values_that_stand_are_drawn(filled, kind):
    catalogue = Catalogue(filled)
    assert not any(zeta_points(drawn(catalogue, kind, p="3-6")))
    for points in zeta_points(drawn(catalogue, kind, p="2-6,8")):
        assert 6 in points
        assert 8 not in points


@pytest.mark.slow
def test_no_line_is_drawn_across_a_period_that_is_not_there(filled):
    made = drawn(Catalogue(filled), "lyapunov", p="3,5,7")
    p, values = made.axes[0].lines[0].get_xydata().T
    assert p[np.isfinite(values)].tolist() == [3, 5, 7]
    assert p.tolist() == [3, 4, 5, 6, 7]
