"""The figure of `assess`."""

import numpy as np
import pytest
from figures import extents_of_texts, texts_are_readable

from orbitdb import Catalogue, Selection
from orbitdb.plots import assess, style
from orbitdb.quantum.weyl import Parity


@pytest.mark.slow
@pytest.mark.parametrize("window", [False, True])
def test_missing_levels_are_steps_at_integers_and_their_gaps_are_shaded(filled_once, exact_once, window):
    k = exact_once[(exact_once < 12) & (exact_once > (6 if window else 0))]
    few = np.delete(k, [5, 11])
    found = Catalogue(filled_once).assess(few, parity="oo", window=window)
    assert len(found.gaps) == 2
    ax = found.plot()
    assert len(ax.patches) == len(found.gaps)
    (steps,) = [line for line in ax.lines if line.get_label() == "levels missing below $k$"]
    at, heights = (np.asarray(values, float) for values in steps.get_data())
    assert set(heights[~np.isnan(heights)]) == {0, 1, 2}
    (points,) = [line for line in ax.lines if str(line.get_label()).startswith("$N")]
    k, excess = (np.asarray(values, float) for values in points.get_data())
    assert np.abs(excess - np.interp(k, at, np.nan_to_num(heights))).mean() < 0.3
    assert all(float(tick).is_integer() for tick in ax.get_yticks())
    assert [text.get_text().split()[0] for text in ax.texts] == ["+1", "+1"]


@pytest.mark.slow
def test_a_window_is_drawn_from_its_first_level(filled_once, exact_once):
    k = exact_once[exact_once > 13]
    ax = assess.assess(Catalogue(filled_once), Selection(1.6), k, Parity.OO, window=True).axes[0]
    (points,) = [line for line in ax.lines if str(line.get_label()).startswith("$N")]
    drawn, excess = np.array(points.get_data(), dtype=float)
    assert set(drawn) <= set(k.tolist())
    assert np.abs(excess).max() < 0.5


@pytest.mark.slow
@pytest.mark.parametrize("width", [3.39, 7.0])
def test_the_names_of_gaps_are_clear_of_the_points(filled_once, exact_once, width):
    few = np.delete(exact_once[exact_once < 12], [5, 11])
    few = np.sort(np.append(few, few[2] + 0.1))
    found = Catalogue(filled_once).assess(few, parity="oo")
    with style.sized((width, None)), style.figure(7.2, 4.2, found.verdict()) as made:
        assess.draw_assess(made.add_subplot(), found)
    texts_are_readable(made)
    (ax,) = made.axes
    extents = extents_of_texts(made)
    assert len(ax.texts) == 3
    points = [ax.transData.transform(line.get_xydata()) for line in ax.lines if line.get_marker() == "."]
    for name in ax.texts:
        assert not extents[name].count_contains(np.concatenate(points))
