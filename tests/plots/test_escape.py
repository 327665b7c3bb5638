"""The figure of survival in an open stadium: the sample, the exponential through it, and the tail."""

import matplotlib
import numpy as np
import pytest
from figures import legend
from matplotlib.patches import Rectangle

from orbitdb import Catalogue, Selection, escape, solve_word
from orbitdb.open_stadium import rates
from orbitdb.plots.escape import escape as draw
from orbitdb.plots.orbits import orbit as draw_path
from orbitdb.plots.phase_space import phase_space
from orbitdb.plots.registry import EmptyFigureError

matplotlib.use("agg")


@pytest.fixture(autouse=True)
def coarse(monkeypatch):
    monkeypatch.setattr(rates, "GRIDS", (40, 60))


def test_survival_is_drawn_with_its_exponential_and_its_tail():
    found = escape(1.6, "top:-0.3:0.3", trajectories=5000)
    bounces, time = draw(found).axes
    assert legend(bounces) == ["exponential", "tail", "sampled"]
    for ax, rate, tail in (
        (bounces, found.rate_bounce, found.columns()["tail"]),
        (time, found.rate_time, found.columns("time")["tail"]),
    ):
        lines = {str(line.get_label()): line for line in ax.get_lines()}
        decay, dashed = lines["exponential"], lines["tail"]
        x, y = map(np.asarray, decay.get_data())
        assert -np.polyfit(x, np.log(y), 1)[0] == pytest.approx(rate)
        assert dashed.get_linestyle() == "--"
        assert np.asarray(dashed.get_ydata()).tolist() == tail
    assert bounces.get_xscale() == bounces.get_yscale() == "log"


def test_without_a_rate_only_the_tail_is_drawn_and_without_a_sample_nothing():
    found = escape(1.6, "right:-0.1:0.1", trajectories=5000)
    assert legend(found.plot()) == ["tail", "sampled"]
    assert found.plot("escape-time").get_xlabel() == "time $t$ (radius / speed)"
    with pytest.raises(EmptyFigureError, match="survival was not sampled"):
        escape(1.6, "top::", trajectories=0).plot()


def test_openings_are_gaps_in_the_wall_and_strips_in_phase_space(filled_once):
    (ax,) = draw_path(solve_word("1232131", 1.6), "top:-0.3:0.3").axes
    parts = [patch for patch in ax.patches if patch.get_zorder() == 2]
    drawn = np.concatenate([patch.get_path().vertices for patch in parts])
    assert all(patch.get_path().codes is None for patch in parts)  # open, unlike the whole boundary
    on_top = drawn[np.isclose(drawn[:, 1], 1) & (np.abs(drawn[:, 0]) < 1.6), 0]
    assert np.abs(on_top).min() == pytest.approx(0.3)
    catalogue = Catalogue(filled_once)
    chosen = Selection.from_criteria(p="2-5", status="orbit", opening="right:0:0.5")
    ax = phase_space(catalogue, chosen).axes[0]
    (strip,) = (patch for patch in ax.patches if isinstance(patch, Rectangle))
    assert (strip.get_x(), strip.get_width()) == pytest.approx((3.2 + np.pi / 2, 0.5))
