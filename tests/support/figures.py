"""Read the contents of figures back from their axes."""

from itertools import combinations
from typing import Any
from unittest.mock import patch

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.text import Text
from matplotlib.transforms import Bbox

from orbitdb.arrays import Floats
from orbitdb.plots.style import BLUE, FAINT, GREEN, GREY, INK, ORANGE, PURPLE

COLOURS = {BLUE, ORANGE, GREEN, PURPLE, INK, GREY, FAINT}


def named(ax: Axes, label: str) -> Floats:
    """Return the points of the line whose label starts with `label`, shape (2, n)."""
    (found,) = (each for each in ax.lines if str(each.get_label()).startswith(label))
    return np.array(found.get_data(), dtype=float)


def legend(ax: Axes) -> list[str]:
    """Return the texts of the legend; check that its lines differ in colour, dash or marker."""
    named = dict(zip(*ax.get_legend_handles_labels()[::-1], strict=True))
    lines = [each for each in named.values() if hasattr(each, "get_marker")]
    looks = {(to_hex(each.get_color()), each.get_linestyle(), each.get_marker()) for each in lines}
    assert len(looks) == len(lines)
    return [*named]


def paths_of(ax: Axes, count: int) -> list[tuple[Floats, str]]:
    """Return the closed paths with `count` bounces, and their colours."""
    points = [(np.asarray(each.get_xydata()), to_hex(each.get_color())) for each in ax.lines]
    return [
        (each[:-1], colour)
        for each, colour in points
        if len(each) == count + 1 and np.array_equal(each[0], each[-1])
    ]


def heights(filled: Any) -> set[float]:
    """Return all heights on the edge of a band."""
    return set(filled.get_paths()[0].vertices[:, 1].round(9).tolist())


def texts(ax: Axes) -> dict[str, tuple[float, float]]:
    written: Any = ax.texts
    return {each.get_text(): each.xy for each in written if each.get_text()}


def says(ax: Axes, x: str, y: str) -> None:
    """Check the labels of the axes, and that lines use the package's colours."""
    assert (ax.get_xlabel(), ax.get_ylabel()) == (x, y)
    assert {to_hex(each.get_color()) for each in ax.lines} <= COLOURS


def by_period(ax: Axes, label: str) -> None:
    says(ax, "period $p$ (bounces)", label)
    assert all(tick == round(tick) for tick in ax.get_xticks())


def extents_of_texts(made: Figure) -> dict[Text, Bbox]:
    """Draw a figure; return where it has texts, without those that stay undrawn, such as ticks outside."""
    shown, draw = dict[Text, Bbox](), Text.draw

    def note(text: Text, renderer: Any) -> None:
        if text.get_visible() and text.get_text().strip():
            shown[text] = text.get_window_extent(renderer)
        draw(text, renderer)

    canvas: Any = FigureCanvasAgg(made)
    canvas.draw()  # which settles the layout
    with patch.object(Text, "draw", note):
        canvas.draw()
    return shown


def texts_are_readable(made: Figure) -> None:
    """Check that each text has 7 points or more, is inside the figure and does not overlap another."""
    extents, box = extents_of_texts(made), made.bbox.padded(1)
    for text, extent in extents.items():
        assert float(text.get_fontsize()) >= 7 - 1e-9, text
        assert box.x0 <= extent.x0 <= extent.x1 <= box.x1, text
        assert box.y0 <= extent.y0 <= extent.y1 <= box.y1, text
    for (one, extent), (other, beside) in combinations(extents.items(), 2):
        assert not extent.padded(-0.5).overlaps(beside.padded(-0.5)), (one, other)
